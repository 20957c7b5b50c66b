"""The plant: conservation, order, limits, and an independent integration."""

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from simsat.control.ground import attitude
from simsat.control.ground.errors import DivergedError, SettingsError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.mjcf import Model
from simsat.plant.plant import Plant, whole_steps

Edited = Callable[[Callable[[mujoco.MjSpec], None]], Model]

TICK = 0.05
Q0 = attitude.from_axis_angle(np.array([0.3, -0.5, 0.8]), 1.1)
OMEGA0 = np.array([0.06, -0.09, 0.12])  # rad/s
SPEED0 = np.array([300.0, -200.0])  # rad/s: a momentum bias, so that gyroscopics count


def with_timestep(dt: float) -> Callable[[mujoco.MjSpec], None]:
    return lambda spec: setattr(spec.option, "timestep", dt)


def flown(model: Model, commands: np.ndarray, ticks: int = 10) -> Plant:
    plant = Plant(model, TICK, len(commands) * ticks)
    plant.reset(Q0, OMEGA0, SPEED0)
    for torque in commands:
        plant.advance(torque, ticks)
    return plant


def exact(craft: Spacecraft, torque: Callable[[float], np.ndarray], t_end: float) -> np.ndarray:
    """(q, omega, wheel speed) at t_end by DOP853 from the equations of motion, written anew."""

    def slope(t: float, state: np.ndarray) -> np.ndarray:
        q, w, speed = state[:4], state[4:7], state[7:]
        u = torque(t)
        H = craft.J @ w + craft.A @ (craft.Js * speed)
        w_dot = np.linalg.solve(craft.J - (craft.A * craft.Js) @ craft.A.T,
                                -craft.A @ u - np.cross(w, H))  # fmt: skip
        q_dot = 0.5 * attitude.multiply(q, np.array([0.0, *w]))
        return np.concatenate([q_dot, w_dot, u / craft.Js - craft.A.T @ w_dot])

    start = np.concatenate([Q0, OMEGA0, SPEED0])
    return solve_ivp(slope, (0.0, t_end), start, "DOP853", rtol=1e-12, atol=1e-14, max_step=0.01).y[
        :, -1
    ]


def test_momentum_and_energy_stay_with_wheel_bias(two_wheel: Model) -> None:
    """Torque-free flight for 100 s: |H| about 1 Nms, neither momentum nor energy may leak."""
    plant = flown(two_wheel, np.zeros((200, 2)))
    momentum, craft = plant.momentum_N(), two_wheel.spacecraft
    assert np.linalg.norm(momentum[0]) > 0.5  # Nms: the test has gyroscopics in it
    np.testing.assert_allclose(momentum, momentum[:1].repeat(len(momentum), axis=0), atol=1e-9)
    w, speed = plant.rates, plant.wheel_speeds
    spin = craft.Js * (speed + w @ craft.A)  # momentum of each rotor about its axis
    energy = 0.5 * np.einsum("ki,ij,kj->k", w, craft.J_hub, w) + 0.5 * (spin**2 / craft.Js).sum(1)
    np.testing.assert_allclose(energy, energy[0], atol=1e-9)  # J
    formula = np.einsum("kij,kj->ki", attitude.rotation_matrix(plant.attitudes),
                        craft.angular_momentum(w, speed))  # fmt: skip
    np.testing.assert_allclose(momentum, formula, atol=1e-12)


def test_flight_agrees_with_an_independent_integration(two_wheel: Model) -> None:
    """The torque ramps at 0.4 Nm/s inside each period, linear within each 10 ms physics step;
    DOP853 integrates that same torque."""
    commands = np.random.default_rng(3).uniform(-0.05, 0.05, (20, 2))
    plant = flown(two_wheel, commands)
    held = np.concatenate([np.zeros((1, 2)), commands])

    def torque(t: float) -> np.ndarray:
        k = min(int(t / 0.5), len(commands) - 1)
        nodes = 0.01 * np.arange(51)
        change = held[k + 1] - held[k]
        ramp = held[k] + np.clip(change, -0.4 * nodes[:, None], 0.4 * nodes[:, None])
        return np.array([np.interp(t - 0.5 * k, nodes, ramp[:, i]) for i in range(2)])

    truth = exact(two_wheel.spacecraft, torque, 10.0)
    error = attitude.error_angle(plant.attitudes[-1], attitude.normalized(truth[:4]))
    assert np.degrees(error) < 1e-6  # deg
    np.testing.assert_allclose(plant.wheel_speeds[-1], truth[7:], atol=1e-6)  # rad/s of 600


def test_free_flight_agrees_with_an_independent_integration(two_wheel: Model) -> None:
    plant = flown(two_wheel, np.zeros((20, 2)))
    truth = exact(two_wheel.spacecraft, lambda t: np.zeros(2), 10.0)
    error = attitude.error_angle(plant.attitudes[-1], attitude.normalized(truth[:4]))
    assert np.degrees(error) < 1e-8
    np.testing.assert_allclose(plant.rates[-1], truth[4:7], atol=1e-11)


def test_the_integrator_is_of_fourth_order(edited: Edited) -> None:
    """Halving a coarse step divides the error by about 16; order 3 would give 8, order 5 32."""
    truth = exact(edited(lambda spec: None).spacecraft, lambda t: np.zeros(2), 10.0)
    errors = []
    for dt in (0.05, 0.025):
        plant = flown(edited(with_timestep(dt)), np.zeros((20, 2)))
        errors.append(np.linalg.norm(plant.rates[-1] - truth[4:7]))
    assert 12.0 < errors[0] / errors[1] < 22.0


def test_torque_ramps_at_the_rate_limit_and_stops_at_the_torque_limit(two_wheel: Model) -> None:
    plant = Plant(two_wheel, 0.01, 60)
    plant.reset(attitude.IDENTITY)
    plant.advance(np.array([0.08, -0.03]), 60)  # Nm; the first beyond the limit of 0.05
    ramp = np.minimum(0.4 * plant.log.t, 0.05)
    np.testing.assert_allclose(plant.torques[:, 0], ramp, atol=1e-12)
    np.testing.assert_allclose(
        plant.torques[:, 1], -np.minimum(0.4 * plant.log.t, 0.03), atol=1e-12
    )
    # Impulse of the ramp; its last physics step is linear, which costs up to rate dt^2 / 8.
    gained = two_wheel.spacecraft.Js[0] * (plant.wheel_speeds + plant.rates[:, :2])[-1, 0]
    assert gained == pytest.approx(0.05 * 0.6 - 0.5 * 0.05**2 / 0.4, abs=1.01 * 0.4 * 0.01**2 / 8)


def test_a_wheel_stops_at_its_speed_limit_and_comes_back(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    plant = Plant(two_wheel, TICK, 800)
    plant.reset(attitude.IDENTITY)
    for _ in range(40):  # 20 s; the limit comes at 18
        plant.advance(np.array([0.05, 0.0]), 10)
    assert np.abs(plant.wheel_speeds).max() < craft.speed_max[0] * (1 + 1e-7)
    assert plant.wheel_speeds[-1, 0] == pytest.approx(craft.speed_max[0], rel=1e-6)
    assert abs(plant.torques[-1, 0]) < 1e-4  # Nm: saturated, no torque to give
    before = plant.momentum_N()[-1]
    for _ in range(40):
        plant.advance(np.array([-0.05, 0.0]), 10)
    assert plant.wheel_speeds[-1, 0] < 0.1 * craft.speed_max[0]
    np.testing.assert_allclose(plant.momentum_N()[-1], before, atol=1e-9)


def test_a_wheel_that_starts_too_fast_is_braked_to_its_limit(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    plant = Plant(two_wheel, TICK, 100)
    plant.reset(attitude.IDENTITY, wheel_speed=1.05 * craft.speed_max)
    plant.advance(np.zeros(2), 100)
    assert (plant.wheel_speeds[-1] <= craft.speed_max * (1 + 1e-6)).all()


def test_logged_torque_is_what_mujoco_applies(two_wheel: Model) -> None:
    """The log's torque against MuJoCo's own joint force, at a tick in the middle of a ramp."""
    plant = Plant(two_wheel, TICK, 40)
    plant.reset(attitude.IDENTITY)
    plant.advance(np.array([0.05, -0.02]), 2)
    d = plant._d
    mujoco.mj_forward(plant._m, d)
    applied = d.qfrc_actuator[[wheel.dof for wheel in two_wheel.wheels]]
    np.testing.assert_allclose(plant.torques[-1], applied, atol=1e-15)
    assert plant.torques[-1, 0] == pytest.approx(0.04)


def test_external_torque_turns_the_craft_as_newton_says(two_wheel: Model) -> None:
    torque = np.array([2e-3, -1e-3, 3e-3])
    plant = Plant(two_wheel, TICK, 20, lambda t, q: torque)
    plant.reset(attitude.IDENTITY)
    plant.advance(np.zeros(2), 20)
    # The rotors are free to stay behind: about their axes only the hub is accelerated.
    rate = np.linalg.solve(two_wheel.spacecraft.J_hub, torque)
    np.testing.assert_allclose(plant.rates[-1], rate, rtol=1e-3)
    np.testing.assert_allclose(plant.momentum_N()[-1], torque, rtol=1e-3)  # 1 s


def test_a_torque_that_is_not_a_number_ends_in_a_sentence(two_wheel: Model) -> None:
    calls = []

    def torque(t: float, q: np.ndarray) -> np.ndarray:
        calls.append(t)
        return np.full(3, np.nan if t > 0.5 else 0.0)

    plant = Plant(two_wheel, TICK, 40, torque)
    plant.reset(attitude.IDENTITY)
    with pytest.raises(DivergedError, match=r"diverged at t = 0\.55 s: the rates of bus_free"):
        plant.advance(np.zeros(2), 40)
    assert np.isfinite(plant.attitudes).all()
    assert plant.log.t[-1] == pytest.approx(0.5)
    assert calls[:2] == pytest.approx([0.025, 0.075])  # evaluated in the middle of each tick


def test_rates_that_do_not_divide_are_refused_with_both_numbers(two_wheel: Model) -> None:
    with pytest.raises(SettingsError, match=r"0\.025 s is not a whole number of 0\.01 s"):
        Plant(two_wheel, 0.025, 10)
    assert whole_steps(0.5, 0.05, "any") == 10


def test_two_flights_are_identical_to_the_last_bit(two_wheel: Model) -> None:
    commands = np.random.default_rng(5).uniform(-0.05, 0.05, (10, 2))
    first, second = flown(two_wheel, commands), flown(two_wheel, commands)
    np.testing.assert_array_equal(first.log.qpos, second.log.qpos)


def test_a_step_that_fits_infinitely_often_is_refused() -> None:
    with pytest.raises(SettingsError, match=r"100 s is not a whole number of 4\.94066e-324 s"):
        whole_steps(100.0, 5e-324, "flight")
