"""An estimator of the user's own in the place of the shipped network."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from simsat.control.correction.corrector import Estimator, NetworkEstimator
from simsat.control.correction.network import Network
from simsat.control.ground.arrays import WheelVector
from simsat.control.ground.errors import PluginError
from simsat.control.interface.measurement import Measurement
from simsat.flight.plugins import named

Estimate = Callable[[Measurement, WheelVector, WheelVector], Any]


@dataclass(frozen=True)
class OwnEstimator:
    """Asks a function (measurement, torque commanded now, previous estimate) -> torque, Nm (m)."""

    function: Estimate
    name: str
    wheels: int

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """Its answer. Raises `PluginError` if it fails or doesn't fit the wheels."""
        with named(f"network '{self.name}'"):
            answer = np.asarray(self.function(measurement, torque, previous), float)
        if answer.shape != (self.wheels,):
            raise PluginError(
                f"network '{self.name}' answered torques of shape {answer.shape}: the spacecraft "
                f"has {self.wheels} wheels"
            )
        return answer


def own_estimator(make: Callable[..., Any], name: str, brief: Any, wheels: int) -> Estimator:
    """The estimator that the user's function or class makes of the brief: a `Network`, an object
    with `estimate`, or a function (measurement, torque, previous) -> torque on the wheel axes, Nm.

    Raises `PluginError` if it fails or returns none of these.
    """
    with named(f"network '{name}'"):
        made = make(brief)
    if isinstance(made, Network):
        return OwnEstimator(NetworkEstimator(made, brief.nominal.J).estimate, name, wheels)
    function = getattr(made, "estimate", made)
    if not callable(function):
        raise PluginError(
            f"network '{name}' made a {type(made).__name__}: it must be a Network, have a method "
            "'estimate', or be a function (measurement, torque, previous) -> Nm"
        )
    return OwnEstimator(function, name, wheels)
