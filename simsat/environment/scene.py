"""What every torque model is shown: the time, the orbit's directions and the attitude."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from simsat.environment.components import Number, Rows, Triple


class Scene(NamedTuple):
    """One instant, or an array of them."""

    t: Number
    """Time, s."""
    up_N: Triple
    """Unit vector from the Earth's (or the Sun's) centre to the spacecraft, inertial axes."""
    ahead_N: Triple
    """Unit vector along the inertial velocity, inertial axes."""
    to_body: Rows
    """Maps inertial components to body ones."""
    q: tuple[Number, Number, Number, Number]
    """Attitude, body -> inertial, scalar first."""


TorqueModel: TypeAlias = Callable[[Scene], Triple]
"""Torque about the centre of mass, Nm, body axes."""
