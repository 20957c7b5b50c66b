"""Nominal model, NMPC and supervisor: pure functions of numbers (no engine, file or clock)."""
