"""The baseline planner: the paper's nonlinear MPC."""
