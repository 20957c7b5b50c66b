"""Wheels that fail in flight: noticed by what their rotors do, and flown without."""
