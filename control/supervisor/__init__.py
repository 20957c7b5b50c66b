"""Supervisors: how much of a learned torque may act, with a reason for each verdict."""
