"""Fly an underactuated spacecraft in MuJoCo, and believe the numbers."""

from simsat.starting import begin_command

begin_command()
