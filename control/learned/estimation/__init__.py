"""What is estimated in flight: inertia, momentum, external torque, friction, with covariances."""
