"""The prediction model: against momentum balance, MuJoCo, and the order of its integrator."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Vector3
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.dynamics import build_dynamics, rk4_step
from simsat.control.model.ramp import mean_ramped_torque
from simsat.mjcf import Model
from simsat.plant.plant import Plant

J = np.array([[1.62, 0.06, -0.05], [0.06, 1.488, 0.07], [-0.05, 0.07, 1.272]])
Q0 = attitude.from_axis_angle(np.array([0.3, -0.5, 0.8]), 1.1)
OMEGA0 = np.array([0.06, -0.09, 0.12])  # rad/s
TAU = np.array([2e-3, -1e-3, 3e-3])  # Nm


def craft(A: Array, Js: float = 1.4e-3) -> Spacecraft:
    m = A.shape[1]
    each = np.ones(m)
    return Spacecraft(
        name="test",
        mass=50.0,
        J=J,
        wheel_names=tuple(f"wheel_{i}" for i in range(m)),
        A=A,
        Js=Js * each,
        torque_max=0.05 * each,
        torque_rate_max=0.4 * each,
        speed_max=628.0 * each,
        viscous=2e-5 * each,
        coulomb=1e-3 * each,
    )


TWO = craft(np.eye(3)[:, :2])
SKEWED = craft(attitude.normalized(np.array([[1.0, 0.2, -0.3], [0.1, 1.0, 0.6], [0.2, -0.4, 1.0]])))


def stepped(spacecraft: Spacecraft, s: Array, u: Array, step: float, steps: int) -> Array:
    """The model's state after so many RK4 steps under constant torque."""
    derivative = build_dynamics(spacecraft)
    state = ca.SX.sym("s", len(s))
    one = ca.Function("one", [state], [rk4_step(lambda at: derivative(at, u, TAU), state, step)])
    return np.array(one.mapaccum(steps)(s))[:, -1]


def exact(spacecraft: Spacecraft, s: Array, u: Array, t_end: float) -> Array:
    """The same motion from momentum balance in inertial axes: H' = R(q) tau, h' = u per rotor."""
    A, Js = spacecraft.A, spacecraft.Js

    def rates(q: Array, H_N: Array, h: Array) -> Vector3:
        H_B = attitude.rotation_matrix(attitude.normalized(q)).T @ H_N
        return np.asarray(np.linalg.solve(spacecraft.J_hub, H_B - A @ h), float)

    def slope(t: float, y: Array) -> Array:
        q, H_N, h = y[:4], y[4:7], y[7:]
        q_dot = 0.5 * attitude.multiply(q, np.array([0.0, *rates(q, H_N, h)]))
        torque_N = attitude.rotation_matrix(attitude.normalized(q)) @ TAU
        return np.concatenate([q_dot, torque_N, u + 0.0 * h])

    h0 = Js * (s[7:] + A.T @ s[4:7])
    H0 = attitude.rotation_matrix(s[:4]) @ spacecraft.angular_momentum(s[4:7], s[7:])
    start = np.concatenate([s[:4], H0, h0])
    y = solve_ivp(slope, (0.0, t_end), start, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    omega = rates(y[:4], y[4:7], y[7:])
    return np.concatenate([y[:4], omega, y[7:] / Js - A.T @ omega])


@pytest.mark.parametrize("spacecraft", [TWO, SKEWED], ids=["two wheels", "three skewed"])
def test_motion_agrees_with_momentum_balance(spacecraft: Spacecraft) -> None:
    """Ten seconds with wheel bias, torque on wheels and body, against an independent integration in
    other variables."""
    m = spacecraft.wheels
    s = np.concatenate([Q0, OMEGA0, np.array([300.0, -200.0, 150.0])[:m]])
    u = np.array([0.03, -0.02, 0.01])[:m]
    got, truth = stepped(spacecraft, s, u, 0.01, 1000), exact(spacecraft, s, u, 10.0)
    np.testing.assert_allclose(got[:4], truth[:4], atol=1e-9)
    np.testing.assert_allclose(got[4:7], truth[4:7], atol=1e-9)  # rad/s
    np.testing.assert_allclose(got[7:], truth[7:], atol=1e-6)  # rad/s of some hundred


def test_the_step_is_of_fourth_order() -> None:
    """Halving the step divides the error by 16; third order would give 8, fifth 32."""
    s, u = np.concatenate([Q0, 2.0 * OMEGA0, [300.0, -200.0]]), np.array([0.05, -0.05])
    truth = exact(TWO, s, u, 4.0)
    errors = [np.linalg.norm((stepped(TWO, s, u, 4.0 / n, n) - truth)[:7]) for n in (8, 16, 32)]
    assert errors[2] > 1e-11  # above round-off, or the ratios mean nothing
    assert 13.0 < errors[0] / errors[1] < 19.0
    assert 13.0 < errors[1] / errors[2] < 19.0


def test_motion_agrees_with_mujoco(two_wheel: Model) -> None:
    """The same spacecraft in MuJoCo, wheels biased, torque ramped by the plant: 10 s, 1e-6."""
    spacecraft, command = two_wheel.spacecraft, np.array([0.04, -0.04])
    plant = Plant(two_wheel, 0.05, 200)
    s = np.concatenate([Q0, OMEGA0, [300.0, -200.0]])
    plant.reset(s[:4], s[4:7], s[7:])
    plant.advance(command, 200)
    derivative = build_dynamics(spacecraft)
    state, u, tau_d = ca.SX.sym("s", 9), ca.SX.sym("u", 2), np.zeros(3)
    step = ca.Function("s", [state, u], [rk4_step(lambda s: derivative(s, u, tau_d), state, 5e-3)])
    t = 5e-3 * (np.arange(2000) + 0.5)
    torque = np.clip(np.outer(spacecraft.torque_rate_max[:1] * t, [1, -1]), -0.04, 0.04).T
    got = np.array(step.mapaccum(2000)(s, torque))[:, -1]
    assert attitude.error_angle(got[:4], plant.attitudes[-1]) < 1e-6
    np.testing.assert_allclose(got[4:7], plant.rates[-1], atol=1e-6)
    np.testing.assert_allclose(got[7:], plant.wheel_speeds[-1], atol=1e-4)


def test_friction_brakes_the_wheels_and_leaks_no_momentum() -> None:
    s = np.concatenate([Q0, np.zeros(3), [300.0, -200.0]])
    slope = np.array(build_dynamics(TWO, friction=True)(s, np.zeros(2), np.zeros(3))).ravel()
    assert slope[7] < 0.0 < slope[8]
    torque = np.array([2e-5 * 300.0 + 1e-3, -2e-5 * 200.0 - 1e-3])  # Nm, from the data sheet
    np.testing.assert_allclose(TWO.Js * (slope[7:] + TWO.A.T @ slope[4:7]), -torque, rtol=1e-9)
    leak = TWO.angular_momentum(slope[4:7], slope[7:])
    np.testing.assert_allclose(leak, 0.0, atol=1e-15)  # Nm


def test_a_residual_torque_follows_the_predicted_motion() -> None:
    """tau_d acts on the body as a whole; a learned one is a function of rates, speeds, inputs."""
    gain = np.array([[0.1, 0.0], [0.0, -0.2], [0.05, 0.02]])
    s, u = np.concatenate([Q0, OMEGA0, [30.0, -20.0]]), np.array([0.03, -0.02])
    learned = build_dynamics(TWO, residual=lambda omega, speed, torque: ca.DM(gain) @ torque)
    plain = build_dynamics(TWO)
    np.testing.assert_allclose(
        np.array(learned(s, u, TAU)), np.array(plain(s, u, TAU + gain @ u)), atol=1e-15
    )
    change = np.array(plain(s, u, TAU) - plain(s, u, np.zeros(3))).ravel()
    np.testing.assert_allclose(TWO.angular_momentum(change[4:7], change[7:]), TAU, atol=1e-15)


@pytest.mark.parametrize("change", [0.07, -0.1, 0.004])
def test_mean_torque_is_that_of_the_ramp(change: float) -> None:
    t = np.linspace(0.0, 0.5, 100_001)
    ramp = 0.01 + np.sign(change) * np.minimum(0.4 * t, abs(change))  # Nm
    mean = float(mean_ramped_torque(TWO, 0.01 + change, 0.01, 0.5)[0])
    assert mean == pytest.approx(np.trapezoid(ramp, t) / 0.5, abs=1e-6)


def test_without_a_rate_limit_the_torque_does_not_ramp() -> None:
    instant = replace(TWO, torque_rate_max=np.full(2, np.inf))
    torque = np.array(
        mean_ramped_torque(instant, np.array([0.05, -0.05]), np.zeros(2), 0.5)
    ).ravel()
    np.testing.assert_array_equal(torque, [0.05, -0.05])
