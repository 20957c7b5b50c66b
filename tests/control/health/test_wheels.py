"""Rotors that don't follow their motors are noticed, and no others."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.ground.envelope import TorqueEnvelope
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.health.planner import MonitoredPlanner
from simsat.control.health.reduced import narrowed, reduced, widened
from simsat.control.health.wheels import Fate, all_sound, watched
from simsat.control.interface.measurement import History, Measurement
from simsat.flight.mission import prepare
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS
from simsat.settings import FlightSettings

PERIOD = 0.5


def craft(name: str) -> Spacecraft:
    return read_model(MODELS / name / f"{name}.xml").spacecraft


def period(
    ship: Spacecraft, gained: Array, torque: Array, before: Array | None = None,
    omega: Array | None = None,
) -> Measurement:  # fmt: skip
    """A measurement after a period in which the rotors' spin momenta gained so much, Nms."""
    before = np.full(ship.wheels, 100.0) if before is None else before
    omega = np.zeros((11, 3)) if omega is None else omega
    p = ship.Js * (before + omega[0] @ ship.A)
    speeds = np.linspace(p, p + gained, 11) / ship.Js - omega @ ship.A
    t = np.linspace(0.0, PERIOD, 11)
    q = np.array([1.0, 0.0, 0.0, 0.0])
    return Measurement(PERIOD, q, omega[-1], speeds[-1], torque, History(t, omega, speeds))


SHIP = craft("three_wheel")
FULL = np.full(3, SHIP.torque_max[0])


def after(*periods: tuple[Array, Array], ship: Spacecraft = SHIP) -> tuple[Fate | None, ...]:
    """Fates after periods of (share of the impulse gained, torque)."""
    monitor = all_sound(ship.wheels)
    for share, torque in periods:
        before = monitor.torque_before
        ramp = np.abs(torque - before) / ship.torque_rate_max
        impulse = PERIOD * torque - (torque - before) * ramp / 2.0
        monitor = watched(monitor, period(ship, share * impulse, torque), ship, PERIOD)
    return monitor.fates


def test_a_wheel_that_follows_is_sound() -> None:
    assert after((np.ones(3), FULL), (np.ones(3), -FULL), (np.ones(3), FULL)) == (None,) * 3


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_two_strong_impulses_missed_running_are_a_failure(share: float) -> None:
    lazy = np.array([1.0, share, 1.0])
    assert after((lazy, FULL)) == (None, None, None)
    assert after((lazy, FULL), (np.ones(3), FULL), (lazy, FULL)) == (None, None, None)
    assert after((lazy, FULL), (lazy, FULL)) == (None, Fate.COASTS, None)
    assert after((lazy, FULL), (lazy, FULL), (np.ones(3), FULL)) == (None, Fate.COASTS, None)


def test_weak_commands_tell_nothing() -> None:
    assert after(*[(np.zeros(3), 0.2 * FULL)] * 6) == (None,) * 3


def test_the_body_turning_is_no_torque_of_a_motor() -> None:
    """Speeds relative to the hub change, spin momenta don't."""
    turning = np.linspace(0.0, 0.3, 11)[:, None] * np.array([1.0, -1.0, 0.5])
    monitor = all_sound(3)
    for _ in range(4):
        told = period(SHIP, PERIOD * FULL, FULL, omega=turning)
        monitor = watched(replace(monitor, torque_before=FULL), told, SHIP, PERIOD)
    assert monitor.fates == (None,) * 3


def test_a_leap_to_rest_is_a_lock_at_once() -> None:
    gained = np.array([0.0, -SHIP.Js[1] * 200.0, 0.0])
    told = period(SHIP, gained, np.zeros(3), before=np.array([50.0, 200.0, -80.0]))
    assert watched(all_sound(3), told, SHIP, PERIOD).fates == (None, Fate.LOCKED, None)


def test_a_leap_that_ends_at_speed_is_no_lock() -> None:
    gained = np.array([0.0, -SHIP.Js[1] * 200.0, 0.0])
    told = period(SHIP, gained, np.zeros(3), before=np.array([50.0, 400.0, -80.0]))
    assert watched(all_sound(3), told, SHIP, PERIOD).fates == (None,) * 3


def test_at_the_speed_limit_the_drive_cuts_the_torque() -> None:
    monitor = all_sound(3)
    for _ in range(4):
        told = period(SHIP, np.zeros(3), FULL, before=SHIP.speed_max)
        monitor = watched(monitor, told, SHIP, PERIOD)
    assert monitor.fates == (None,) * 3


def test_a_history_with_a_gap_tells_nothing() -> None:
    monitor = all_sound(3)
    for _ in range(4):
        told = period(SHIP, np.zeros(3), FULL)
        h = told.history
        told = replace(told, history=History(h.t[3:], h.omega[3:], h.wheel_speed[3:]))
        monitor = watched(monitor, told, SHIP, PERIOD)
    assert monitor.fates == (None,) * 3


@pytest.mark.parametrize("name", ["pyramid", "three_wheel"])
@pytest.mark.parametrize("fate", Fate)
def test_the_reduced_craft_has_the_momentum_of_the_whole(name: str, fate: Fate) -> None:
    """Of what the wheels that are left can take up; and the same rates for the same momentum."""
    ship = craft(name)
    m = ship.wheels
    fates = (None,) * (m - 1) + (fate,)
    rng = np.random.default_rng(0)
    omega, speed = 0.1 * rng.standard_normal(3), 200.0 * rng.standard_normal(m)
    if fate is Fate.LOCKED:
        speed[-1] = 0.0
    told = narrowed(period(ship, np.zeros(m), np.zeros(m), speed, np.tile(omega, (11, 1))),
                    ship, fates)  # fmt: skip
    left = reduced(ship, fates)
    lost = ship.angular_momentum(omega, speed) - left.angular_momentum(omega, told.wheel_speed)
    span = left.A @ np.linalg.pinv(left.A)
    np.testing.assert_allclose(span @ lost, 0.0, atol=1e-12)
    if name == "pyramid":
        np.testing.assert_allclose(lost, 0.0, atol=1e-12)
    assert left.wheels == m - 1
    assert told.history.wheel_speed.shape == (11, m - 1)
    np.testing.assert_allclose(told.history.wheel_speed[-1], told.wheel_speed, atol=1e-12)


def test_torques_go_to_the_wheels_they_are_meant_for() -> None:
    fates = (None, Fate.COASTS, None, Fate.LOCKED)
    np.testing.assert_array_equal(widened(np.array([1.0, 2.0]), fates), [1.0, 0.0, 2.0, 0.0])


def test_planners_of_single_failures_are_there_before_the_flight() -> None:
    mission = prepare(FlightSettings(model=Path("three_wheel"), reconfigure=True))
    assert mission.pilot is not None
    planner: Any = mission.pilot.planner
    assert isinstance(planner, MonitoredPlanner)
    assert len(planner.prepared) == 6
    wheels = {p.planner.spacecraft.wheels for p in planner.prepared.values()}  # type: ignore[attr-defined]
    assert wheels == {2}


def test_the_wheels_left_keep_their_own_envelopes() -> None:
    weak = TorqueEnvelope(((0.0, 0.05), (600.0, 0.01)))
    ship = replace(SHIP, envelopes=(None, weak, None))
    assert reduced(ship, (Fate.LOCKED, None, None)).envelopes == (weak, None)
    assert reduced(SHIP, (Fate.LOCKED, None, None)).envelopes == ()
