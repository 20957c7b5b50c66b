"""What the file says of a motor beyond its actuator: speeds, torque-speed envelopes, failures."""
