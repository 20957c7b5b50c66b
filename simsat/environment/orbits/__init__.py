"""Orbits from files of elements."""
