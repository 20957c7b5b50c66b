"""The way to the target: shortest manoeuvre, exact arrival, hold."""
