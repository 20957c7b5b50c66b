"""The trajectory to the target: minimum-time slew, exact arrival, hold."""
