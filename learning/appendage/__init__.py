"""Training of the network that predicts what bends or swings."""
