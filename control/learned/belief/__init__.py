"""What is known of the spacecraft: identified in flight, with its uncertainty."""
