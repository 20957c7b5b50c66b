"""Data, features, network and training of the learned residual torque."""
