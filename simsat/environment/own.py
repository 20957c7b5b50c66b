"""An external torque of the user's own."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from simsat.control.ground.arrays import Array, Quaternion
from simsat.control.ground.errors import PluginError
from simsat.environment.components import Triple
from simsat.environment.scene import Scene, TorqueModel
from simsat.flight.plugins import named

OwnTorque: TypeAlias = Callable[[float, Quaternion], Array]
"""(t in s, attitude body -> inertial) -> torque about the centre of mass, body axes, Nm, three
numbers."""


def own_torque(name: str, function: OwnTorque) -> TorqueModel:
    """The function as a torque model; it is asked for one instant at a time.

    The model raises `PluginError` if it fails, or on an answer that isn't three finite numbers.
    """

    def at(t: float, q: tuple[float, ...]) -> tuple[float, float, float]:
        with named(f"torque '{name}'"):
            answer = np.asarray(function(float(t), np.array(q, float)), float)
        if answer.shape != (3,) or not np.isfinite(answer).all():
            raise PluginError(
                f"the torque '{name}' answered {answer.tolist()} at t = {t:g} s: it must be three "
                "finite numbers in Nm, body axes"
            )
        x, y, z = answer.tolist()
        return x, y, z

    def model(scene: Scene) -> Triple:
        if isinstance(scene.t, float):
            return at(scene.t, scene.q)  # type: ignore[arg-type]  # floats, as t is one
        rows = np.column_stack([np.broadcast_to(part, scene.t.shape) for part in scene.q])
        torque = np.array([at(t, tuple(q)) for t, q in zip(scene.t, rows, strict=True)])
        return torque[:, 0], torque[:, 1], torque[:, 2]

    return model
