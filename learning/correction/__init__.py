"""Training of the network that corrects the torque on the wheels."""
