"""Layer two: a learned torque on the wheels."""
