"""Speed limits of wheels, from a file's <custom>."""

import math

import mujoco

from simsat.control.ground.errors import ModelError
from simsat.mjcf.custom import SPEED_LIMITS, number, stated_once

RPM = 2.0 * math.pi / 60.0  # rad/s


def read_speed_limit(m: mujoco.MjModel, wheel: str) -> float:
    """Speed limit (rad/s) from <custom><numeric name='[WHEEL.]speed_limit_rpm' data='...'/>."""
    stated = stated_once(m, wheel, SPEED_LIMITS, number)
    return math.inf if stated is None else stated_speed(*stated)


def stated_speed(name: str, value: float) -> float:
    """A speed that a numeric states, rad/s. Raises `ModelError` if it is none."""
    speed = value * (RPM if name.endswith("rpm") else 1.0)
    if not speed > 0.0:
        raise ModelError(f"numeric '{name}' is {value:g}, it must be above zero")
    return speed
