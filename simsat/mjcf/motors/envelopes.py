"""Torque-speed envelopes of wheels, from a file's <custom>.

    <numeric name="wheel_x.torque_envelope_rpm" data="0 0.05  4000 0.05  6000 0.01"/>

Pairs of speed and driving torque (Nm); without WHEEL. it is every wheel's, `_rad_s` likewise.
"""

import mujoco
import numpy as np

from simsat.control.ground.envelope import TorqueEnvelope
from simsat.control.ground.errors import ModelError
from simsat.mjcf.custom import ENVELOPES, numbers, stated_once
from simsat.mjcf.motors.speeds import stated_speed


def read_envelope(m: mujoco.MjModel, wheel: str) -> TorqueEnvelope | None:
    """The envelope of a wheel, None without one.

    Raises `ModelError` on numbers that are none.
    """
    stated = stated_once(m, wheel, ENVELOPES, numbers)
    return None if stated is None else _envelope(*stated)


def _envelope(name: str, values: np.ndarray) -> TorqueEnvelope:
    speeds, torques = values[::2], values[1::2]
    if len(values) < 4 or len(speeds) != len(torques):
        raise ModelError(
            f"numeric '{name}' has {len(values)} numbers: give pairs of speed and torque, two at "
            "least"
        )
    if speeds[0] != 0.0 or not np.all(np.diff(speeds) > 0.0):
        raise ModelError(f"numeric '{name}': its speeds must ascend from 0")
    if not torques[0] > 0.0 or np.any(np.diff(torques) > 0.0) or torques[-1] < 0.0:
        raise ModelError(
            f"numeric '{name}': its torques must start above zero, not rise, and stay at zero or "
            "above"
        )
    points = zip(speeds, torques, strict=True)
    return TorqueEnvelope(tuple((stated_speed(name, s) if s else 0.0, float(t)) for s, t in points))
