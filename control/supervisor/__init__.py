"""Layer three: how much of a correction may act."""
