"""The spacecraft in MuJoCo, between control instants."""
