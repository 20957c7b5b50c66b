"""The recording of a flight for the rerun viewer."""
