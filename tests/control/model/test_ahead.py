"""The state ahead is where the equations of motion lead: SciPy's integrator says the same."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import error_angle, multiply, normalized
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.ahead import Motion, motion_ahead
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS


def craft(name: str) -> Spacecraft:
    return read_model(MODELS / name / f"{name}.xml").spacecraft


def motion(ship: Spacecraft, rate_deg_s: float = 16.0) -> Motion:
    q = normalized(np.array([0.3, -0.5, 0.7, 0.2]))
    omega = np.radians(rate_deg_s) * np.array([0.6, -0.48, 0.64])
    m = ship.wheels
    return Motion(q, omega, np.linspace(-200.0, 300.0, m), np.linspace(0.03, -0.03, m))


def integrated(
    ship: Spacecraft, now: Motion, pending: list[tuple[float, Array]], friction: Array
) -> tuple[Array, Array, Array]:
    """Euler's equations and the rotors', with the ramps as they are, at a tolerance of 1e-12."""
    A, Js, J = ship.A, ship.Js, ship.J
    hub = np.linalg.inv(J - (A * Js) @ A.T)

    def rates(_: float, x: Array, target: Array) -> Array:
        q, w, speed, u = x[:4], x[4:7], x[7 : 7 + len(Js)], x[7 + len(Js) :]
        acting = u - friction
        H = J @ w + A @ (Js * speed)
        wdot = hub @ (-np.cross(w, H) - A @ acting)
        speeding = acting / Js - wdot @ A
        return np.concatenate(
            [0.5 * multiply(q, np.array([0.0, *w])), wdot, speeding, np.zeros_like(u)]
        )

    x = np.concatenate([now.q, now.omega, now.wheel_speed, now.torque])
    m = len(Js)
    for seconds, target in pending:
        ends = np.abs(target - x[-m:]) / ship.torque_rate_max
        times = np.unique(np.concatenate([[0.0, seconds], ends[ends < seconds]]))
        first = x[-m:].copy()

        def slewed(t: float, x: Array, target: Array = target, first: Array = first) -> Array:
            reach = ship.torque_rate_max * t
            x = x.copy()
            x[-m:] = first + np.clip(target - first, -reach, reach)
            return rates(t, x, target)

        for a, b in pairwise(times):
            x = solve_ivp(slewed, (a, b), x, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        reach = ship.torque_rate_max * seconds
        x[-m:] = first + np.clip(target - first, -reach, reach)
    return x[:4], x[4:7], x[7 : 7 + m]


@pytest.mark.parametrize("name", ["two_wheel", "three_wheel", "pyramid"])
@pytest.mark.parametrize("seconds", [0.1, 0.5, 0.75])
def test_it_leads_where_an_integrator_leads(name: str, seconds: float) -> None:
    ship = craft(name)
    now, m = motion(ship), ship.wheels
    friction = np.full(m, 1e-3)
    pending = [(0.4 * seconds, np.linspace(0.05, -0.05, m)), (0.6 * seconds, np.full(m, -0.04))]
    then = motion_ahead(ship, ship.J, now, pending, friction)
    q, omega, speed = integrated(ship, now, pending, friction)
    assert error_angle(then.q, q) < 2e-7  # rad
    np.testing.assert_allclose(then.omega, omega, atol=2e-7)
    np.testing.assert_allclose(then.wheel_speed, speed, atol=1e-4)  # rad/s of hundreds


def test_the_step_is_of_fourth_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Halving it takes the error down sixteenfold."""
    ship = craft("pyramid")
    now = replace(motion(ship, 100.0), torque=np.zeros(4))
    pending = [(1.6, np.zeros(4))]
    q, _, _ = integrated(ship, now, pending, np.zeros(4))
    errors = []
    for step in (0.4, 0.2, 0.1):
        monkeypatch.setattr("simsat.control.model.ahead.STEP", step)
        then = motion_ahead(ship, ship.J, now, pending, np.zeros(4))
        errors.append(float(error_angle(then.q, q)))
    assert errors[0] / errors[1] > 11.0
    assert errors[1] / errors[2] > 11.0


def test_nothing_pending_changes_nothing() -> None:
    ship = craft("two_wheel")
    now = motion(ship)
    then = motion_ahead(ship, ship.J, now, [], np.zeros(2))
    np.testing.assert_array_equal(then.q, now.q)
    np.testing.assert_allclose(then.omega, now.omega, atol=1e-15)
    np.testing.assert_allclose(then.wheel_speed, now.wheel_speed, atol=1e-11)


def test_torques_beyond_the_limits_are_cut_as_the_motors_cut_them() -> None:
    ship = craft("two_wheel")
    now = replace(motion(ship), torque=np.zeros(2))
    huge = motion_ahead(ship, ship.J, now, [(0.5, np.full(2, 9.0))], np.zeros(2))
    largest = motion_ahead(ship, ship.J, now, [(0.5, ship.torque_max)], np.zeros(2))
    np.testing.assert_array_equal(huge.q, largest.q)


def test_a_craft_without_a_rate_limit_steps_at_once() -> None:
    ship = replace(craft("two_wheel"), torque_rate_max=np.full(2, np.inf))
    now = replace(motion(ship, 0.0), wheel_speed=np.zeros(2), torque=np.zeros(2))
    then = motion_ahead(ship, ship.J, now, [(0.5, np.array([0.02, -0.01]))], np.zeros(2))
    p = ship.Js * (then.wheel_speed + then.omega @ ship.A)
    np.testing.assert_allclose(p, [0.01, -0.005], atol=1e-12)
