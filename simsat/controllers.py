"""The controllers that can be flown, by name: which planner, corrector and supervisor each has.

A controller of your own is one function here: it takes a `Brief` and returns a `Pilot`.
"""

from collections.abc import Callable
from dataclasses import dataclass

from control.layers import Pilot
from control.nmpc import build_nmpc
from simsat.arrays import Quaternion
from simsat.environment import Environment
from simsat.errors import SettingsError
from simsat.settings import FlightSettings
from simsat.spacecraft import Spacecraft


@dataclass(frozen=True)
class Brief:
    """What a controller is built from."""

    nominal: Spacecraft
    """What it may believe."""
    settings: FlightSettings
    target: Quaternion
    truth: Spacecraft
    """The spacecraft as it is: for oracles in studies only."""
    environment: Environment
    """The environment as it is: likewise."""


def nmpc(brief: Brief) -> Pilot:
    """The paper's baseline: NMPC on the nominal model."""
    return Pilot(build_nmpc(brief.nominal, brief.settings.nmpc, brief.target))


CONTROLLERS: dict[str, Callable[[Brief], Pilot]] = {
    "nmpc": nmpc,
}


def build_pilot(brief: Brief) -> Pilot:
    """The pilot that the settings name.

    Raises `SettingsError` that lists the names that exist.
    """
    name = brief.settings.controller
    if name not in CONTROLLERS:
        raise SettingsError(f"no controller '{name}'; there are: {', '.join(CONTROLLERS)}")
    return CONTROLLERS[name](brief)
