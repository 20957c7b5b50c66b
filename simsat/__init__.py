"""Fly an underactuated spacecraft in MuJoCo, and believe the numbers."""
