"""What a controller is: what it is told, what it answers, and the three layers it is made of."""
