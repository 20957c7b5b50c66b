"""What breaks in the plant breaks by the laws: momentum is conserved, to round-off."""

from collections.abc import Callable

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.model.momentum import spin_momentum
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS
from simsat.plant.damage import Event, Workings, add_friction, scale_inertia, seize, weaken
from simsat.plant.plant import Plant

TICK, BREAKS, END = 0.05, 40, 200
ZOO = ("three_wheel", "pyramid", "two_wheel", "two_wheel_friction", "flexible_panels", "slosh")


def flown(name: str, *events: Event, torque: float = 0.01) -> Plant:
    """Ten seconds of tumbling, torques held, without any torque from outside."""
    model = read_model(MODELS / name / f"{name}.xml")
    plant = Plant(model, TICK, END, events=events)
    m = model.spacecraft.wheels
    q = attitude.from_axis_angle(np.array([0.3, -0.8, 0.5]), 2.0)
    plant.reset(q, np.array([0.05, -0.08, 0.06]), np.linspace(100.0, 60.0 + 40.0 * m, m))
    for _ in range(END // 10):
        plant.advance(np.resize(np.array([torque, -torque]), m), 10)
    return plant


def broken(name: str, happen: Callable[[Workings], None], **changes: float) -> Plant:
    return flown(name, Event(BREAKS, happen), **changes)


@pytest.mark.parametrize("name", ZOO)
def test_a_rotor_that_seizes_hands_its_momentum_to_the_hub(name: str) -> None:
    plant = broken(name, seize(1))
    h = plant.momentum_N()
    leak = np.abs(h - h[0]).max() / np.linalg.norm(h[0])
    assert leak < 1e-9  # of the momentum; two_wheel_friction and slosh leak 1e-10 unbroken
    before, after = plant.wheel_speeds[: BREAKS + 1, 1], plant.wheel_speeds[BREAKS + 1 :, 1]
    assert np.abs(before).min() > 50.0
    assert np.abs(after).max() < 1e-6
    assert np.linalg.norm(plant.rates[BREAKS + 1] - plant.rates[BREAKS]) > 1e-3


@pytest.mark.parametrize("name", ["three_wheel", "pyramid", "two_wheel"])
def test_the_jolt_is_that_of_the_momentum_theorem(name: str) -> None:
    """Rigid craft: H = J w + A Js Omega before and after, the other rotors keep their spin
    momenta, the locked one turns with the hub."""
    plant = broken(name, seize(0), torque=0.0)
    craft = plant.model.spacecraft
    w0, speed = plant.rates[BREAKS], plant.wheel_speeds[BREAKS]
    p = spin_momentum(craft, w0, speed)
    A, J = craft.A[:, 1:], craft.J
    J_left = J - (A * craft.Js[1:]) @ A.T
    expected = np.linalg.solve(J_left, craft.angular_momentum(w0, speed) - A @ p[1:])
    step = float(plant.model.mj.opt.timestep)
    at_once = Plant(plant.model, step, 2, events=[Event(0, seize(0))])
    at_once.reset(plant.attitudes[BREAKS], w0, speed)
    at_once.advance(np.zeros(craft.wheels), 2)
    just_after = 2.0 * at_once.rates[1] - at_once.rates[2]  # drawn back by a step
    np.testing.assert_allclose(just_after, expected, atol=2e-5)
    held = spin_momentum(craft, plant.rates, plant.wheel_speeds)[BREAKS:, 1:]
    np.testing.assert_allclose(held, np.broadcast_to(held[0], held.shape), atol=1e-9)


def test_a_locked_rotor_is_a_part_of_the_body() -> None:
    """Torques of the other wheels turn J less their rotors, the locked rotor included: as the
    same craft flies whose third wheel was never turned."""
    model = read_model(MODELS / "three_wheel" / "three_wheel.xml")
    plant = Plant(model, TICK, END, events=[Event(0, seize(2))])
    plant.reset(attitude.IDENTITY)
    plant.advance(np.array([0.02, 0.0, 0.0]), END)
    craft = model.spacecraft
    A = craft.A[:, :2]
    J = craft.J - (A * craft.Js[:2]) @ A.T
    p = spin_momentum(craft, plant.rates, plant.wheel_speeds)[:, :2]
    expected = -np.linalg.solve(J, (p @ A.T).T).T  # zero momentum throughout
    np.testing.assert_allclose(plant.rates, expected, atol=1e-9)


@pytest.mark.parametrize("name", ["three_wheel", "two_wheel_friction"])
def test_a_dead_wheel_coasts(name: str) -> None:
    plant = broken(name, weaken(0, 0.0))
    assert (plant.torques[BREAKS + 1 :, 0] == 0.0).all()
    assert np.abs(plant.torques[BREAKS, 0]) > 0.0
    p = spin_momentum(plant.model.spacecraft, plant.rates, plant.wheel_speeds)[BREAKS:, 0]
    if name == "three_wheel":
        np.testing.assert_allclose(p, p[0], atol=1e-9)
    else:
        assert (np.diff(np.abs(p)) < 0.0).all()


def test_a_weak_wheel_gives_its_share_and_is_well_again() -> None:
    plant = flown("three_wheel", Event(BREAKS, weaken(1, 0.3)), Event(120, weaken(1, 1.0)))
    given = plant.torques[:, 1] / -0.01
    np.testing.assert_allclose(given[[BREAKS - 1, 100, 160]], [1.0, 0.3, 1.0], atol=1e-12)
    np.testing.assert_allclose(plant.torques[20:, 0], 0.01, atol=1e-12)


@pytest.mark.parametrize("name", ["three_wheel", "two_wheel_friction"])
def test_grown_friction_takes_from_the_rotor_and_nothing_from_the_whole(
    name: str,
) -> None:
    grown = flown(name, Event(BREAKS, add_friction(0, 0.004)), torque=0.0)
    plain = flown(name, torque=0.0)
    h = grown.momentum_N()
    assert np.abs(h - h[0]).max() / np.linalg.norm(h[0]) < 1e-9
    craft, span = grown.model.spacecraft, TICK * (END - BREAKS)
    p, p_plain = (spin_momentum(craft, f.rates, f.wheel_speeds)[:, 0] for f in (grown, plain))
    taken = (p_plain[-1] - p[-1]) / span
    assert taken == pytest.approx(0.004, rel=0.02)
    mended = flown(name, Event(BREAKS, add_friction(0, 0.004)), Event(60, add_friction(0, -0.004)),
                   torque=0.0)  # fmt: skip
    p = spin_momentum(craft, mended.rates, mended.wheel_speeds)[:, 0]
    assert p_plain[-1] - p[-1] == pytest.approx(0.004 * TICK * 20, rel=0.05)


@pytest.mark.parametrize("name", ["three_wheel", "flexible_panels"])
@pytest.mark.parametrize("factors", [(1.3,), (0.9, 1.0, 1.1)])
def test_an_inertia_that_changes_changes_no_momentum(name: str, factors: tuple[float, ...]) -> None:
    plant = broken(name, scale_inertia(factors), torque=0.0)
    craft = plant.model.spacecraft
    p = spin_momentum(craft, plant.rates, plant.wheel_speeds)
    np.testing.assert_allclose(p, np.broadcast_to(p[0], p.shape), atol=1e-9)
    assert np.linalg.norm(plant.rates[BREAKS + 1] - plant.rates[BREAKS]) > 1e-3
    if name == "three_wheel":  # the whole body turns as one: H by hand, inertia and all
        bus = plant.model.mj.body_inertia[plant.model.bus]
        added = np.diag((np.array(factors) - 1.0) * bus)
        J = np.where(np.arange(END + 1)[:, None, None] <= BREAKS, craft.J, craft.J + added)
        H_B = np.einsum("kij,kj->ki", J, plant.rates) + (plant.wheel_speeds * craft.Js) @ craft.A.T
        H_N = np.einsum("kij,kj->ki", attitude.rotation_matrix(plant.attitudes), H_B)
        frame = plant.model.mj.body_iquat[plant.model.bus]
        if np.allclose(np.abs(frame), [1.0, 0.0, 0.0, 0.0], atol=1e-9):
            np.testing.assert_allclose(H_N, np.broadcast_to(H_N[0], H_N.shape), atol=1e-8)


def test_without_events_nothing_is_different() -> None:
    plain, late = flown("pyramid"), flown("pyramid", Event(END + 5, seize(0)))
    np.testing.assert_array_equal(plain.log.qvel, late.log.qvel)
