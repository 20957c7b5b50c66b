"""Magnetic rods in flight: the law, the momentum they bring, limits, and a law of one's own."""

from typing import Any

import numpy as np
import pytest

import simsat
from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternion, Vector3
from simsat.control.ground.errors import DivergedError, PluginError, SettingsError
from simsat.control.ground.magnetorquers import Magnetorquers
from simsat.control.interface.plan import Plan
from simsat.environment import EnvironmentSettings, OrbitSettings, build_environment
from simsat.flight.loop import Ending
from simsat.mjcf import Model, read_model
from simsat.plant.plant import Plant
from tests.places import MODELS

TICK = 0.05
Q0 = attitude.from_axis_angle(np.array([0.3, -0.5, 0.8]), 1.1)
OMEGA0, SPEED0 = np.array([0.006, -0.009, 0.012]), np.array([300.0, -200.0])
FIELD_N = (2.1e-5, -3.3e-5, 1.7e-5)  # T


@pytest.fixture(scope="module")
def rodded() -> Model:
    return read_model(MODELS / "two_wheel_rods" / "two_wheel_rods.xml")


def test_the_torque_is_that_of_currents_in_a_field() -> None:
    """Each rod as a loop of 400 wires, each pushed by I dl x B at its place (Lorentz's law)."""
    axes = attitude.normalized(np.array([[1.0, 0.2, 0.0], [0.0, 1.0, -0.4], [0.5, 0.5, 1.0]])).T
    rods = Magnetorquers(("a", "b", "c"), axes, np.ones(3))
    dipole, field = np.array([0.2, -0.1, 0.05]), np.array(FIELD_N)
    expected = sum(loop_torque(*rod, field) for rod in zip(axes.T, dipole, strict=True))
    np.testing.assert_allclose(rods.torque(dipole, field), expected, atol=1e-11)  # Nm of 8e-6
    assert rods.torque(dipole, field) @ field == pytest.approx(0.0, abs=1e-20)


def loop_torque(axis: Vector3, dipole: float, field: Vector3, wires: int = 400) -> Array:
    radius = 0.05
    across = attitude.normalized(np.cross(axis, [0.3, 0.1, 0.9]))
    other = np.cross(axis, across)
    angle = np.linspace(0.0, 2.0 * np.pi, wires + 1)[:, None]
    places = np.array([0.4, -0.2, 0.1]) + radius * (np.cos(angle) * across + np.sin(angle) * other)
    middle, wire = (places[1:] + places[:-1]) / 2.0, np.diff(places, axis=0)
    area = 0.5 * wires * radius**2 * np.sin(2.0 * np.pi / wires)
    return np.cross(middle, dipole / area * np.cross(wire, field)).sum(axis=0)


def test_momentum_is_the_sum_of_what_rods_and_surroundings_pushed(rodded: Model) -> None:
    """A tumble of 200 s with every torque on and random dipoles."""
    craft = rodded.spacecraft
    environment = build_environment(
        craft, OrbitSettings(), EnvironmentSettings(solar_pressure=True, magnetic=True)
    )
    pushed = np.zeros(3)

    def external(t: float, q: Quaternion) -> Vector3:
        nonlocal pushed
        torque = environment.torque(t, q)
        pushed = pushed + TICK * attitude.rotation_matrix(q) @ torque
        return torque

    plant = Plant(rodded, TICK, 4000, external, environment.field)
    plant.reset(Q0, OMEGA0, SPEED0)
    rng = np.random.default_rng(5)
    for _ in range(400):
        plant.advance(rng.uniform(-0.01, 0.01, 2), 10, rng.uniform(-0.2, 0.2, 3))
    by_rods = TICK * plant.rod_torques_N.sum(axis=0)
    assert np.linalg.norm(by_rods) > 1e-5  # Nms
    H = plant.momentum_N()
    np.testing.assert_allclose(H[-1] - H[0], by_rods + pushed, atol=1e-11)  # Nms


def test_the_log_tells_dipole_and_torque_as_they_acted(rodded: Model) -> None:
    plant = Plant(rodded, TICK, 30, field=lambda t: FIELD_N)
    plant.reset(Q0)
    dipoles = [np.array([0.2, 0.0, -0.1]), None, np.array([0.0, 0.1, 0.0])]
    for dipole in dipoles:
        plant.advance(np.zeros(2), 10, dipole)
    stated = np.array([np.zeros(3) if dipole is None else dipole for dipole in dipoles])
    np.testing.assert_array_equal(plant.dipoles[1:], np.repeat(stated, 10, axis=0))
    np.testing.assert_array_equal(plant.dipoles[0], np.zeros(3))
    R = attitude.rotation_matrix(plant.attitudes[1:])
    expected = np.cross(np.einsum("kij,kj->ki", R, plant.dipoles[1:]), FIELD_N)
    np.testing.assert_allclose(plant.rod_torques_N[1:], expected, atol=1e-12)  # half a tick apart
    assert not plant.rod_torques_N[11:21].any()


def test_rods_that_are_off_change_no_bit(rodded: Model, two_wheel: Model) -> None:
    commands = np.random.default_rng(3).uniform(-0.05, 0.05, (20, 2))
    logs = []
    for model in (rodded, two_wheel):
        environment = build_environment(model.spacecraft, OrbitSettings(), EnvironmentSettings())
        plant = Plant(model, TICK, 200, environment.torque, environment.field)
        plant.reset(Q0, OMEGA0, SPEED0)
        for torque in commands:
            plant.advance(torque, 10)
        logs.append(plant.log.qvel)
    np.testing.assert_array_equal(logs[0], logs[1])


def test_a_dipole_that_is_no_number_stops_the_flight(rodded: Model) -> None:
    plant = Plant(rodded, TICK, 20, field=lambda t: FIELD_N)
    plant.reset(Q0)
    with pytest.raises(DivergedError, match=r"at t = 0.00 s: the commanded dipole \[nan"):
        plant.advance(np.zeros(2), 10, np.array([np.nan, 0.0, 0.0]))
    without = Plant(rodded, TICK, 20)
    without.reset(Q0)
    with pytest.raises(SettingsError, match="rods push against a magnetic field"):
        without.advance(np.zeros(2), 10, np.array([0.1, 0.0, 0.0]))


class BDot:
    """m = -k dB/dt in body axes (Stickler and Alfriend, 1976): rods alone stop a tumble."""

    def __init__(self, brief: Any):
        self._rods, self._last = brief.nominal.rods, None

    def __call__(self, now: Any) -> Plan:
        change = np.zeros(3) if self._last is None else (now.field_B - self._last) / 0.5
        self._last = now.field_B
        assert now.dipole.shape == (self._rods.count,)
        return Plan(np.zeros(2), dipole=-4e6 * self._rods.axes.T @ change)


def test_a_law_of_one_s_own_stops_a_tumble_by_rods_alone() -> None:
    """B-dot leaves a craft that turns with the field, twice an orbit; wheels are braked first."""
    result = simsat.fly(
        "two_wheel_rods", controller=BDot, duration_s=3000.0,
        start={"omega_deg_s": (0.9, -0.6, 0.7)}, environment={"drag": False},
    )  # fmt: skip
    rate = np.degrees(np.linalg.norm(result.flight.plant.rates, axis=1))
    assert rate[0] > 1.2  # deg/s
    assert rate[-1] < 0.5 * rate[0]
    dipoles = result.flight.plant.dipoles
    assert np.abs(dipoles).max() == 0.2  # A m^2: cut at the limit, which the law asks beyond
    column = result.steps["dipole_rod_x"].to_numpy()
    np.testing.assert_array_equal(column, dipoles[1::10, 0])
    assert result.table.column_names[-9:] == [
        "field_B_x", "field_B_y", "field_B_z", "dipole_rod_x", "dipole_rod_y", "dipole_rod_z",
        "rod_torque_N_x", "rod_torque_N_y", "rod_torque_N_z",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("model", "dipole", "message"),
    [
        ("two_wheel_rods", [0.1, 0.1], r"dipoles of shape \(2,\): the spacecraft has 3 magnetic r"),
        ("two_wheel", [0.1] * 3, r"dipoles of shape \(3,\): the spacecraft has 0 magnetic rods"),
        ("two_wheel_rods", [0.1, np.nan, 0.0], r"answered the dipole \[0.1 nan 0. \] A m\^2: it"),
        ("two_wheel_rods", [0.1, np.inf, 0.0], "must be finite"),
        ("two_wheel_rods", "north", "could not convert string to float"),
    ],
)
def test_dipoles_that_do_not_fit_end_the_flight_with_a_sentence(
    model: str, dipole: Any, message: str
) -> None:
    result = simsat.fly(
        model, controller=lambda brief: lambda now: Plan(np.zeros(2), dipole=dipole), duration_s=1.0
    )
    assert result.flight.ending is Ending.PLUGIN_FAILED
    with pytest.raises(PluginError, match=message):
        raise PluginError(result.flight.reason)
