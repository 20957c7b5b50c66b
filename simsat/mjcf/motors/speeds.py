"""Speed limits of wheels, from a file's <custom>."""

import math

import mujoco

from simsat.control.ground.errors import ModelError
from simsat.mjcf.custom import SPEED_LIMITS, number

SPEED_SUSPICIOUS = 3000.0  # rad/s, 28,600 rpm: no reaction wheel turns faster
RPM = 2.0 * math.pi / 60.0  # rad/s


def read_speed_limit(m: mujoco.MjModel, wheel: str) -> float:
    """Speed limit (rad/s) from <custom><numeric name='[WHEEL.]speed_limit_rpm' data='...'/>."""
    for prefix in (f"{wheel}.", ""):
        stated = {
            name: value
            for name in (prefix + quantity for quantity in SPEED_LIMITS)
            if (value := number(m, name)) is not None
        }
        if len(stated) > 1:
            raise ModelError(f"numerics {' and '.join(map(repr, stated))}: give one of them")
        for name, value in stated.items():
            return believed_speed(name, value, wheel)
    return math.inf


def believed_speed(name: str, value: float, wheel: str) -> float:
    """A speed that a numeric states, rad/s. Raises `ModelError` if no wheel turns like that."""
    speed = value * (RPM if name.endswith("rpm") else 1.0)
    if not speed > 0.0:
        raise ModelError(f"numeric '{name}' is {value:g}, it must be above zero")
    if speed > SPEED_SUSPICIOUS:
        raise ModelError(
            f"numeric '{name}' = {value:g} means {speed / RPM:,.0f} rpm for '{wheel}'; "
            f"at most {SPEED_SUSPICIOUS / RPM:,.0f} rpm is believed: is the unit right?"
        )
    return speed
