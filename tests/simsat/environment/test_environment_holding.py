"""Holding the environment's torque over 50 ms ticks costs nothing that anyone could see."""

from collections.abc import Callable

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Quaternion, Vector3, WheelVector
from simsat.environment import EnvironmentSettings, OrbitSettings, build_environment
from simsat.mjcf import Model
from simsat.plant.plant import Plant

SECONDS = 100.0
TUMBLES = [
    (np.array([0.0, 0.0, 0.0]), np.zeros(2)),
    (np.array([0.05, -0.10, 0.08]), np.array([100.0, -200.0])),  # 8 deg/s
]


def end(
    model: Model,
    tick: float,
    torque: Callable[[float, Quaternion], Vector3] | None,
    start: tuple[Vector3, WheelVector],
) -> Quaternion:
    """Attitude after a free flight with torque updates every tick."""
    ticks = round(SECONDS / tick)
    plant = Plant(model, tick, ticks, torque)
    plant.reset(np.array([0.5, 0.5, 0.5, 0.5]), *start)
    plant.advance(np.zeros(2), ticks)
    return plant.state().q


@pytest.mark.parametrize("start", TUMBLES)
def test_holding_error_is_far_below_a_ten_thousandth_of_a_degree(
    two_wheel: Model, start: tuple[Vector3, WheelVector]
) -> None:
    env = build_environment(
        two_wheel.spacecraft,
        OrbitSettings(),
        EnvironmentSettings(solar_pressure=True, magnetic=True),
    )
    held, fine = (end(two_wheel, tick, env.torque, start) for tick in (0.05, 0.01))
    assert np.degrees(attitude.error_angle(held, fine)) < 1e-6  # degrees; 1e-4 is asked
    free = end(two_wheel, 0.05, None, start)
    assert np.degrees(attitude.error_angle(fine, free)) > 0.01  # the torques do act


def test_the_start_of_the_tick_would_not_do(two_wheel: Model) -> None:
    """The predicted mid-tick attitude is what makes it so: one half tick late is seen."""
    env = build_environment(two_wheel.spacecraft, OrbitSettings(), EnvironmentSettings())

    def at_start(t: float, q_mid: Quaternion) -> Vector3:
        back = attitude.from_axis_angle(
            TUMBLES[1][0], -0.025 * float(np.linalg.norm(TUMBLES[1][0]))
        )
        return env.torque(t - 0.025, attitude.multiply(q_mid, back))

    start = TUMBLES[1]
    held, fine = end(two_wheel, 0.05, at_start, start), end(two_wheel, 0.01, env.torque, start)
    assert np.degrees(attitude.error_angle(held, fine)) > 1e-5  # degrees
