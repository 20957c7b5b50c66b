"""Fly an underactuated spacecraft in MuJoCo, and believe the numbers.

    flight = simsat.fly("pyramid", controller="nmpc-learned", angle_deg=75)
    flight.metrics["settling_time_s"], flight.table, flight.plot(), flight.save("runs/mine")

`fly` flies once, `prepare_mission` and `fly` as often as one likes, `compare` flies a campaign. A
controller of one's own is called with a `Brief` and answers each `Measurement` with a torque or a
`Plan`. Names are resolved when they are first asked for, so that the import costs nothing.
"""

import importlib
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

from simsat.starting import begin_command

if TYPE_CHECKING:
    from simsat.api import compare, fly, prepare_mission
    from simsat.control.ground.errors import SimsatError
    from simsat.control.interface.layers import Correction, Pilot
    from simsat.control.interface.measurement import Measurement
    from simsat.control.interface.plan import Plan
    from simsat.control.interface.verdict import Verdict
    from simsat.flight.controllers import CONTROLLERS, Brief
    from simsat.flight.mission import Mission
    from simsat.mjcf.shipped import shipped_models
    from simsat.results.flight_result import FlightResult
    from simsat.settings import FlightSettings

begin_command()

try:
    __version__ = version("simsat")
except PackageNotFoundError:  # a checkout that was never installed
    __version__ = "unknown"

_HOMES = {
    "compare": "simsat.api",
    "fly": "simsat.api",
    "prepare_mission": "simsat.api",
    "SimsatError": "simsat.control.ground.errors",
    "Correction": "simsat.control.interface.layers",
    "Pilot": "simsat.control.interface.layers",
    "Measurement": "simsat.control.interface.measurement",
    "Plan": "simsat.control.interface.plan",
    "Verdict": "simsat.control.interface.verdict",
    "CONTROLLERS": "simsat.flight.controllers",
    "Brief": "simsat.flight.controllers",
    "Mission": "simsat.flight.mission",
    "shipped_models": "simsat.mjcf.shipped",
    "FlightResult": "simsat.results.flight_result",
    "FlightSettings": "simsat.settings",
}

__all__ = [
    "CONTROLLERS",
    "Brief",
    "Correction",
    "FlightResult",
    "FlightSettings",
    "Measurement",
    "Mission",
    "Pilot",
    "Plan",
    "SimsatError",
    "Verdict",
    "compare",
    "fly",
    "prepare_mission",
    "shipped_models",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'simsat' has no attribute '{name}'")
    return getattr(importlib.import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
