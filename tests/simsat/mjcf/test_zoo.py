"""The spacecraft in models/: read, stepped under random torques, and true to their descriptions."""

import re
import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.mjcf import Model, read_model
from simsat.mjcf.shipped import MODELS, about, find_model, shipped_models
from simsat.plant.plant import Plant

ZOO = shipped_models()
SIZED = (
    "cubesat_1u", "cubesat_3u", "microsat_14kg", "smallsat_150kg", "satellite_750kg", "aura",
    "kepler", "hubble",
)  # fmt: skip
VARIANTS = tuple(f"{name}_two_wheel" for name in SIZED)
START = np.array([0.5, -0.5, 0.5, 0.5]), np.array([0.03, -0.05, 0.04])


def load(name: str, folder: Path | None = None) -> Model:
    return read_model(find_model(name) if folder is None else folder / name / f"{name}.xml")


def tumble(model: Model, seconds: float) -> Plant:
    """Body rates, wheel bias and half-second steps of random torque."""
    craft = model.spacecraft
    plant = Plant(model, 0.05, round(seconds / 0.05))
    plant.reset(*START, np.linspace(0.48, -0.32, craft.wheels) * craft.speed_max)
    rng = np.random.default_rng(0)
    for _ in range(round(seconds / 0.5)):
        plant.advance(craft.torque_max * rng.uniform(-1.0, 1.0, craft.wheels), 10)
    return plant


def test_the_zoo_is_whole() -> None:
    assert {
        "two_wheel", "two_wheel_friction", "two_wheel_imbalance", "two_wheel_skewed",
        "three_wheel", "pyramid", "flexible_panels", "slosh", *SIZED, *VARIANTS,
    } <= set(ZOO)  # fmt: skip


@pytest.mark.parametrize("name", ZOO)
def test_every_model_says_where_its_numbers_come_from(name: str) -> None:
    text = (find_model(name).parent / "README.md").read_text()
    assert "assum" in text
    assert about(name)
    assert name in (MODELS / "README.md").read_text()


@pytest.mark.parametrize("name", ZOO)
def test_nothing_inside_changes_the_angular_momentum(name: str) -> None:
    """Motors, bearings, bending panels and sloshing liquid only pass momentum around."""
    seconds = 20.0 if name == "two_wheel_imbalance" else 100.0
    model = load(name)
    plant = tumble(model, seconds)
    H, stored = plant.momentum_N(), float(model.spacecraft.momentum_max.max())
    assert np.linalg.norm(H[0]) > 0.4 * stored
    allowed = 1e-8 if name.startswith("cubesat") else 1e-9  # they turn fast: RK4's own error
    assert np.abs(H - H[0]).max() < allowed * stored


@pytest.mark.parametrize(
    ("speeds", "torque_max"),
    [((300.0, -200.0), 0.05), ((10.0, -5.0), 2e-3)],
    ids=["spinning", "sticking and slipping"],
)
def test_friction_leaks_no_momentum(speeds: tuple[float, float], torque_max: float) -> None:
    plant = Plant(load("two_wheel_friction"), 0.05, 2000)
    plant.reset(*START, np.array(speeds))
    rng = np.random.default_rng(0)
    for _ in range(200):
        plant.advance(rng.uniform(-torque_max, torque_max, 2), 10)
    H = plant.momentum_N()
    assert np.abs(H - H[0]).max() / 100.0 < 1e-12  # Nm of spurious external torque


def test_wheel_friction_brakes_as_stated() -> None:
    """Js (Omega' + A'w') = u - c Omega - d sign(Omega), from the log by differences."""
    model = load("two_wheel_friction")
    craft = model.spacecraft
    assert craft.viscous == pytest.approx([2e-6, 2e-6])
    assert craft.coulomb == pytest.approx([1e-3, 1e-3])
    plant = Plant(model, 0.05, 100)
    plant.reset(*START, np.array([300.0, -200.0]))
    plant.advance(np.zeros(2), 100)
    spin = craft.Js * (plant.wheel_speeds + plant.rates @ craft.A)
    braking = (spin[2:] - spin[:-2]) / 0.1
    speed = plant.wheel_speeds[1:-1]
    expected = -2e-6 * speed - 1e-3 * np.sign(speed)
    np.testing.assert_allclose(braking, expected, rtol=1e-4)


@pytest.mark.parametrize("name", ["two_wheel", "three_wheel", "two_wheel_skewed"])
def test_energy_is_kept_without_torque(name: str) -> None:
    craft = load(name).spacecraft
    plant = Plant(load(name), 0.05, 2000)
    plant.reset(*START, np.linspace(300.0, -200.0, craft.wheels))
    plant.advance(np.zeros(craft.wheels), 2000)
    w, spin = plant.rates, plant.wheel_speeds
    energy = 0.5 * np.einsum("ki,ij,kj->k", w, craft.J, w)
    energy += (0.5 * craft.Js * spin**2 + craft.Js * spin * (w @ craft.A)).sum(axis=1)
    assert np.abs(energy - energy[0]).max() < 1e-9  # J of 90


def test_pyramid_gives_every_axis_the_same_torque_and_survives_a_failed_wheel(
    tmp_path: Path,
) -> None:
    craft = load("pyramid").spacecraft
    np.testing.assert_allclose(craft.A @ craft.A.T, 4.0 / 3.0 * np.eye(3), atol=1e-12)
    shutil.copytree(MODELS, tmp_path / "models")
    path = tmp_path / "models" / "pyramid" / "pyramid.xml"
    path.write_text(re.sub(r".*motor_2.*\n", "", path.read_text()))
    failed = load("pyramid", tmp_path / "models")
    assert failed.spacecraft.wheels == 3
    assert failed.spacecraft.actuation_rank == 3
    assert failed.passive_joints == ("wheel_2",)
    path.write_text(re.sub(r".*motor_3.*\n", "", path.read_text()))
    twice = load("pyramid", tmp_path / "models").spacecraft
    assert twice.actuation_rank == 2
    assert twice.unactuated is not None
    np.testing.assert_allclose(twice.unactuated @ twice.A, 0.0, atol=1e-12)


def test_skewed_axes_are_neither_orthogonal_nor_on_the_body_axes() -> None:
    A = load("two_wheel_skewed").spacecraft.A
    angle_deg = np.degrees(np.arccos(A[:, 0] @ A[:, 1]))
    assert angle_deg == pytest.approx(69.6, abs=0.1)
    assert np.abs(A).max() < 0.95


@pytest.mark.parametrize(
    ("name", "joint", "frequency_Hz", "damping"),
    [("flexible_panels", "panel_py_hinge", 0.5, 0.005), ("slosh", "slosh_x", 0.25, 0.03)],
)
def test_hidden_oscillators_have_the_stated_frequency_and_damping(
    name: str, joint: str, frequency_Hz: float, damping: float
) -> None:
    model = load(name)
    m, d = model.mj, mujoco.MjData(model.mj)
    mujoco.mj_forward(m, d)
    M = np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, M)
    dof = int(m.joint(joint).dofadr[0])
    inertia, stiffness = M[dof, dof], float(m.joint(joint).stiffness[0])
    rate = np.sqrt(stiffness / inertia)  # rad/s with the bus held
    assert rate / (2.0 * np.pi) == pytest.approx(frequency_Hz, rel=0.01)
    assert m.dof_damping[dof] / (2.0 * inertia * rate) == pytest.approx(damping, rel=0.02)
    assert joint in model.passive_joints


@pytest.mark.parametrize("name", ["flexible_panels", "slosh"])
def test_hidden_oscillators_do_move(name: str) -> None:
    model = load(name)
    plant = tumble(model, 20.0)
    addresses = [int(model.mj.joint(joint).qposadr[0]) for joint in model.passive_joints]
    swing_deg = np.degrees(np.abs(plant.log.qpos[:, addresses]).max())
    assert 0.5 < swing_deg < 20.0


def test_imbalance_shakes_the_bus_as_the_rotating_masses_say() -> None:
    """J w + W (I_xz e + m r p x (g x e)) is constant over a turn, e turning with the rotor.

    p runs from the centre of mass to the rotor on the axis g, r is the offset of its mass m along
    e, I_xz its product of inertia. Slow nutation, a straight line over 0.2 s, is taken out.
    """
    model = load("two_wheel_imbalance")
    craft, m, speed = model.spacecraft, model.mj, 400.0
    plant = Plant(model, 0.0005, 400)
    plant.reset(attitude.IDENTITY, None, np.array([speed, 0.0]))
    plant.advance(np.zeros(2), 400)
    rotor, d = m.body("rotor_x").id, mujoco.MjData(m)
    mujoco.mj_forward(m, d)
    p = d.xpos[rotor] - d.subtree_com[model.bus]
    e, g_x_e = d.xmat[rotor].reshape(3, 3).T[:2]
    c, s = np.cos(speed * plant.log.t)[:, None], np.sin(speed * plant.log.t)[:, None]
    turning = 1e-6 * (c * e + s * g_x_e) + 0.8 * 1.25e-5 * np.cross(p, c * g_x_e - s * e)
    expected = -speed * turning @ np.linalg.inv(craft.J).T
    line = np.stack([np.ones_like(plant.log.t), plant.log.t], axis=1)
    off = plant.rates - expected
    off -= line @ np.linalg.lstsq(line, off, rcond=None)[0]
    assert 1e-4 < np.abs(expected).max() < 1e-3  # rad/s
    assert np.abs(off).max() < 0.02 * np.abs(expected).max()


def test_the_shared_bus_is_the_two_wheel_spacecraft_s() -> None:
    own, shared = load("two_wheel").mj, load("two_wheel_skewed").mj
    bus_own, bus_shared = own.body("bus"), shared.body("bus")
    for name in ("mass", "inertia", "ipos", "iquat"):
        np.testing.assert_array_equal(getattr(bus_own, name), getattr(bus_shared, name))
    for geom in ("bus_box", "telescope", "cells_px", "cells_mx"):
        for name in ("size", "pos", "quat"):
            np.testing.assert_array_equal(
                getattr(own.geom(geom), name), getattr(shared.geom(geom), name)
            )
