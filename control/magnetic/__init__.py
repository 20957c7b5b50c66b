"""Magnetic rods: the dipoles that turn the axis which wheels can't, and unload the wheels."""
