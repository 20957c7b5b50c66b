"""Network files: what they hold, whose they are, which are refused."""
