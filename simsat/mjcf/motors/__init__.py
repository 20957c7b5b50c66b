"""Wheels that are less than they were built: seized."""
