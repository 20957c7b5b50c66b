"""Many flights: what to fly, where it is kept, who flies it."""
