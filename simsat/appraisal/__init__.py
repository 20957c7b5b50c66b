"""Judging a flight: beforehand by its times and momentum, afterwards why it did not settle."""
