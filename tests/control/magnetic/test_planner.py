from dataclasses import replace

import numpy as np
import pytest

from simsat.control.ground.arrays import Array, Vector3
from simsat.control.ground.attitude import from_axis_angle, multiply, rotation_matrix
from simsat.control.ground.magnetorquers import Magnetorquers
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.interface.belief import Belief
from simsat.control.interface.layers import Memory
from simsat.control.interface.measurement import History, Measurement
from simsat.control.interface.plan import Plan
from simsat.control.magnetic.dipoles import DipoleLaw
from simsat.control.magnetic.planner import RodMemory, RodPlanner
from simsat.control.magnetic.settings import RodSettings
from simsat.control.reference.reference import Curve, Inertial
from tests.learned_cases import TRUE_J, craft

B_N = np.array([2e-5, -1e-5, 3e-5])  # T
TARGET = from_axis_angle(np.array([1.0, -2.0, 0.5]), 0.8)
RODS = Magnetorquers(("x", "y", "z"), np.asarray(np.eye(3)), np.full(3, 0.2))
PERIOD = 0.5
STILL = np.array([0.0, 0.0, 0.0])


def rodded(A: Array | None = None) -> Spacecraft:
    return replace(craft(A=A), rods=RODS)


def law(spacecraft: Spacecraft, settings: RodSettings | None = None) -> DipoleLaw:
    return DipoleLaw(spacecraft, settings or RodSettings(), PERIOD, Inertial(TARGET))


def seen(
    spacecraft: Spacecraft, turn: Vector3, omega: Vector3 = STILL, speed: Array | None = None,
    field: bool = True,
) -> Measurement:  # fmt: skip
    """A measurement at an attitude turned from the target by a small rotation, rad, body axes."""
    angle = float(np.linalg.norm(turn))
    q = TARGET if angle == 0.0 else multiply(TARGET, from_axis_angle(turn, angle))
    speed = np.zeros(spacecraft.wheels) if speed is None else speed
    history = History(np.array([0.0]), omega[None], speed[None])
    field_B = rotation_matrix(q).T @ B_N if field else None
    return Measurement(
        0.0, q, omega, speed, np.zeros(spacecraft.wheels), history, np.zeros(3), field_B
    )


def torque_of(
    spacecraft: Spacecraft, now: Measurement, settings: RodSettings | None = None
) -> Vector3:
    """What the first period's dipoles do, Nm, body axes."""
    assert now.field_B is not None
    rods = RodPlanner(Coast(spacecraft), law(spacecraft, settings))
    plan, _ = rods.plan(now, None)
    assert plan.dipole is not None
    return spacecraft.rods.torque(plan.dipole, now.field_B)


class Coast:
    """A planner without torque, which knows the inertia."""

    def __init__(self, spacecraft: Spacecraft, external_N: Vector3 = STILL) -> None:
        self.plan_made = Plan(np.zeros(spacecraft.wheels), belief=Belief(TRUE_J, external_N))

    def plan(self, measurement: Measurement, memory: Memory) -> tuple[Plan, Memory]:
        return self.plan_made, (memory or 0) + 1


def test_near_the_target_the_third_axis_is_pushed_home_and_slowed() -> None:
    spacecraft = rodded()
    off = torque_of(spacecraft, seen(spacecraft, np.array([0.0, 0.0, 1e-4])))
    assert off[2] == pytest.approx(-1.272 * 0.1**2 * 1e-4, rel=3e-2)
    turning = torque_of(spacecraft, seen(spacecraft, STILL, np.array([0.0, 0.0, 1e-6])))
    assert turning[2] == pytest.approx(-1.272 * 2.0 * 0.9 * 0.1 * 1e-6, rel=3e-2)


def test_torque_expected_from_outside_is_opposed() -> None:
    spacecraft, external = rodded(), np.array([2e-6, -1e-6, 1.5e-6])
    rods = RodPlanner(Coast(spacecraft, external), law(spacecraft))
    now = seen(spacecraft, STILL)
    plan, _ = rods.plan(now, None)
    assert plan.dipole is not None
    assert now.field_B is not None
    given = spacecraft.rods.torque(plan.dipole, now.field_B)
    assert given[2] == pytest.approx(-(rotation_matrix(TARGET).T @ external)[2], rel=3e-2)


def test_what_turning_with_the_reference_does_to_the_third_axis_is_opposed() -> None:
    """Euler's equation along n: n'H' = n'tau - n'(omega x H), of momentum left in the wheels."""
    spacecraft, spin = rodded(), np.array([2e-4, -3e-4, 0.0])

    def spun(t: float | Array) -> Array:
        half = 0.5 * np.asarray(t)[..., None] * spin
        return multiply(TARGET, np.concatenate([np.ones((*np.shape(t), 1)), half], axis=-1))

    turning = Curve(spun, lambda t: multiply(TARGET, np.r_[0.0, 0.5 * spin]))
    rods = RodPlanner(Coast(spacecraft), replace(law(spacecraft), reference=turning))
    now = seen(spacecraft, STILL, spin, np.array([0.4, 0.6]))
    plan, _ = rods.plan(now, None)
    H = TRUE_J @ spin + spacecraft.A @ (spacecraft.Js * now.wheel_speed)
    assert plan.dipole is not None
    assert now.field_B is not None
    given = spacecraft.rods.torque(plan.dipole, now.field_B)
    # W = 10 trades some of it for the unloading.
    assert given[2] == pytest.approx(np.cross(spin, H)[2], rel=6e-2)


def test_what_is_left_of_the_rods_unloads_the_wheels_and_leaves_a_bias() -> None:
    spacecraft = rodded()
    field = rotation_matrix(TARGET).T @ B_N
    e2 = np.cross(field, [0.0, 0.0, 1.0])
    e2 /= np.linalg.norm(e2)
    stored = 1e-4 * e2
    now = seen(spacecraft, STILL, speed=stored[:2] / spacecraft.Js)
    assert torque_of(spacecraft, now) @ e2 == pytest.approx(-1e-4 / 100.0, rel=3e-2)
    keep = RodSettings(bias_momentum_Nms=(float(stored[0]), float(stored[1]), 0.0))
    assert torque_of(spacecraft, now, keep) == pytest.approx(np.zeros(3), abs=1e-15)


def test_on_the_way_the_momentum_that_allows_no_rest_goes_first() -> None:
    spacecraft = rodded()
    now = seen(spacecraft, np.array([0.9, -0.4, 0.3]), np.array([0.01, 0.02, -0.03]))
    n = rotation_matrix(now.q).T @ rotation_matrix(TARGET) @ np.array([0.0, 0.0, 1.0])
    excess = float(n @ (TRUE_J @ now.omega))
    assert np.sign(torque_of(spacecraft, now) @ n) == -np.sign(excess)
    assert now.field_B is not None
    most = np.abs(np.cross(now.field_B, n)) @ RODS.dipole_max
    assert abs(torque_of(spacecraft, now) @ n) == pytest.approx(most, rel=0.2)


def test_a_craft_that_wheels_turn_fully_is_unloaded_only() -> None:
    spacecraft = rodded(np.eye(3))
    assert torque_of(spacecraft, seen(spacecraft, np.array([0.0, 0.0, 1e-4]))) == pytest.approx(
        np.zeros(3), abs=1e-15
    )
    loaded = seen(spacecraft, STILL, speed=np.array([0.03, -0.05, 0.08]))
    assert loaded.field_B is not None
    wanted = -(spacecraft.Js * loaded.wheel_speed) / 100.0
    b = loaded.field_B / np.linalg.norm(loaded.field_B)
    assert torque_of(spacecraft, loaded) == pytest.approx(wanted - b * (b @ wanted), rel=1e-3)


def test_a_field_once_known_serves_until_it_is_known_again() -> None:
    spacecraft = rodded()
    rods = RodPlanner(Coast(spacecraft), law(spacecraft))
    away = np.array([0.0, 0.0, 1e-4])
    plan, memory = rods.plan(seen(spacecraft, away, field=False), None)
    assert plan.dipole is None
    known, memory = rods.plan(seen(spacecraft, away), memory)
    blind, memory = rods.plan(seen(spacecraft, away, field=False), memory)
    assert known.dipole is not None
    assert blind.dipole is not None
    assert blind.dipole == pytest.approx(known.dipole, rel=1e-2)
    assert memory.planner == 3


def test_without_a_measurement_the_rods_are_off_and_the_field_is_kept() -> None:
    spacecraft = rodded()
    rods = RodPlanner(Coast(spacecraft), law(spacecraft))
    _, memory = rods.plan(seen(spacecraft, STILL), None)
    plan, memory = rods.fly_on(np.zeros(2), memory)
    assert plan.dipole == pytest.approx(np.zeros(3))
    assert isinstance(memory, RodMemory)
    assert memory.field_N == pytest.approx(B_N)
