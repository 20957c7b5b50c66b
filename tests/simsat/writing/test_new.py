"""A spacecraft file from figures: what the reader finds in it is what was asked for."""

import re
from pathlib import Path

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import ModelError, OutputError
from simsat.mjcf.shipped import find_model, shipped_models
from simsat.new import write_spacecraft
from simsat.writing.bus import Body, without
from simsat.writing.figures import read_figures
from tests.fuzz.commands import call, nothing_flies  # noqa: F401

WHEEL = "[[wheel]]\naxis = [0, 0, 2]\nmass = 0.1\nspin_inertia = 1e-4\n"
CRAFT = "mass = 10\ninertia = [0.2, 0.3, 0.25]\n"
FIGURED = [name for name in shipped_models() if find_model(name).with_suffix(".toml").exists()]


def figures(folder: Path, text: str) -> Path:
    path = folder / "craft.toml"
    path.write_text(text)
    return path


def moment(points: Array, masses: Array) -> Array:
    """sum m (r.r 1 - r r') about the centre of mass, point by point."""
    r = points - np.average(points, axis=0, weights=masses)
    square = np.einsum("ki,ki->k", r, r)
    return np.einsum(
        "k,kij->ij", masses, square[:, None, None] * np.eye(3) - r[:, :, None] * r[:, None, :]
    )


@pytest.mark.parametrize("seed", range(6))
def test_a_mass_table_comes_back_as_mass_J_A_and_Js(tmp_path: Path, seed: int) -> None:
    """Against a sum over points; from grams to tonnes, skewed axes, rotors anywhere inside."""
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-2.0, 1.0)
    points, masses = size * rng.normal(size=(20, 3)), size**3 * rng.uniform(0.5, 2.0, 20) * 100.0
    axes, places = rng.normal(size=(3, 3)), 0.5 * size * rng.normal(size=(3, 3))
    rotor_mass = 0.01 * float(masses.sum())
    Js = 1e-3 * masses.sum() * size**2 * rng.uniform(0.5, 1.0, 3)
    rows = ["name,mass,position"]
    rows += [f"part {k},{m!r},{p[0]!r} {p[1]!r} {p[2]!r}" for k, (m, p) in
             enumerate(zip(masses.tolist(), points.tolist(), strict=True))]  # fmt: skip
    (tmp_path / "parts.csv").write_text("\n".join(rows))
    text = "part = 'parts.csv'\n"
    for axis, place, inertia in zip(axes.tolist(), places.tolist(), Js.tolist(), strict=True):
        text += (
            f"[[wheel]]\naxis = {axis}\nposition = {place}\nmass = {rotor_mass!r}\n"
            f"spin_inertia = {inertia!r}\nspeed_rpm = 60\ntorque = 0.5\n"
        )
    craft = write_spacecraft(read_figures(figures(tmp_path, text)), tmp_path / "c.xml").spacecraft
    expected = moment(points, masses)
    assert craft.mass == pytest.approx(masses.sum(), rel=1e-12)
    np.testing.assert_allclose(craft.J, expected, rtol=1e-9, atol=1e-11 * expected.max())
    np.testing.assert_allclose(craft.Js, Js, rtol=1e-9)
    units = axes / np.linalg.norm(axes, axis=1)[:, None]
    np.testing.assert_allclose(craft.A, units.T, atol=1e-12)
    np.testing.assert_allclose(craft.torque_max, 0.5)
    np.testing.assert_allclose(craft.speed_max, 2.0 * np.pi)


def test_every_key_reaches_the_file(tmp_path: Path) -> None:
    (tmp_path / "wheels.csv").write_text(
        "name, axis, mass, momentum, speed_rpm, torque, torque_rate, viscous, coulomb, position\n"
        "wx, 1 0 0, 0.1, 0.2, 3000, 0.01, 0.08, 1e-6, 1e-4, 0.1 0 0\n"
        "w&y, 0 1 0, 0.1, 0.2, 3000, , , , , \n"
    )
    text = (
        "name = 'a craft'\nmass = 10\ninertia = [0.2, 0.3, 0.25, 0.01, -0.02, 0.03]\n"
        "centre_of_mass = [0.01, 0.02, 0.03]\nnominal_inertia_factors = [0.9, 1.1, 1]\n"
        "wheel = 'wheels.csv'\n[box]\nsize = [0.2, 0.3, 0.4]\nposition = [0.01, 0.02, 0.04]\n"
    )
    craft = write_spacecraft(read_figures(figures(tmp_path, text)), tmp_path / "c.xml").spacecraft
    expected = [[0.2, 0.01, -0.02], [0.01, 0.3, 0.03], [-0.02, 0.03, 0.25]]
    np.testing.assert_allclose(craft.J, expected, rtol=1e-10)
    assert craft.wheel_names == ("wx", "w&y")
    np.testing.assert_allclose(craft.Js, 0.2 / (3000.0 * 2.0 * np.pi / 60.0))
    np.testing.assert_allclose(craft.momentum_max, 0.2)
    assert craft.torque_max.tolist() == [0.01, np.inf]
    assert craft.torque_rate_max.tolist() == [0.08, np.inf]
    assert craft.viscous.tolist() == [1e-6, 0.0]
    assert craft.coulomb.tolist() == [1e-4, 0.0]
    assert craft.nominal_factors.tolist() == [0.9, 1.1, 1.0]
    assert sorted(craft.surface.area.tolist()) == pytest.approx(
        [0.06, 0.06, 0.08, 0.08, 0.12, 0.12]
    )
    np.testing.assert_allclose(craft.surface.centre_B.mean(axis=0), [0.0, 0.0, 0.01], atol=1e-12)


@pytest.mark.parametrize("name", FIGURED)
def test_the_zoo_s_files_are_made_of_their_figures(tmp_path: Path, name: str) -> None:
    path = find_model(name)
    made = tmp_path / path.name
    write_spacecraft(read_figures(path.with_suffix(".toml")), made)
    assert made.read_text() == path.read_text()


def test_a_rotor_that_weighs_all_leaves_no_bus() -> None:
    rotor = Body(1.0, np.array([0.0, 0.0, 0.0]), 1e-3 * np.eye(3))
    with pytest.raises(ModelError, match="the rotors weigh 3 kg, the whole spacecraft 3 kg"):
        without(Body(3.0, np.array([0.0, 0.0, 0.0]), np.eye(3)), [rotor] * 3)


WRONG = [
    (CRAFT, "there is no wheel"),
    (WHEEL, "give mass and inertia of the whole spacecraft, or its parts"),
    (CRAFT + WHEEL + "[[part]]\nmass = 1\n", "or its parts .*, not both"),
    ("mass = 10\n" + WHEEL, "the inertia of the whole spacecraft has 0 numbers: give xx yy zz"),
    ("inertia = [1, 1, 1]\n" + WHEEL, "the mass of the whole spacecraft is missing"),
    ("mass = -1\n" + WHEEL, "the spacecraft: mass is -1: give a finite number above 0"),
    ("mass = 10\ninertia = [1, 1, 2.1]\n" + WHEEL,
     "moments 1, 1, 2.1 kg m.2, but no body's largest exceeds the sum"),
    ("mass = 10\ninertia = [1, 1, 1, 2, 0, 0]\n" + WHEEL, "which must be above zero"),
    (CRAFT + WHEEL.replace("0.1", "9") + "position = [1, 0, 0]\n",
     "the bus, the whole without its rotors, would have the principal moments -"),
    (CRAFT + WHEEL.replace("0.1", "12"), "the rotors weigh 12 kg, the whole spacecraft 10 kg"),
    (CRAFT + WHEEL.replace("1e-4", "0.3"), "the bus, the whole without its rotors, would"),
    (CRAFT + WHEEL.replace("0, 0, 2", "0, 0, 0"), "wheel 1: axis is 0 0 0, which is no direction"),
    (CRAFT + WHEEL.replace("spin_inertia", "momentum"), "wheel 1: spin_inertia is missing"),
    (CRAFT + WHEEL + "torque_rate = -1\n", "wheel 1: torque_rate is -1: give a finite"),
    (CRAFT + WHEEL + "momentum = 1\nspeed_rpm = 9\n", "all given: leave one out"),
    (CRAFT + WHEEL + "torqe = 1\n", "no 'torqe'; did you mean torque"),
    (CRAFT + "wheel = 3\n", "'wheel' must be tables"),
    (CRAFT + "wheel = [3]\n", "wheel 1 must be a table of names and values"),
    (CRAFT + "wheel = 'nowhere.csv'\n", "no wheel at '.*nowhere.csv'"),
    (CRAFT + WHEEL + "speed_rpm = 4e4\n", "at most 28,648 rpm is believed"),
    (CRAFT + WHEEL + "name = 'a'\n" + WHEEL + "name = 'a'\n", "repeated name 'a"),
    (CRAFT + WHEEL + "[box]\nsize = [1, 1]\n", "the box: size is 1 1: give 3 values"),
    ("mass = [", "it is no TOML"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), WRONG)
@pytest.mark.usefixtures("nothing_flies")
def test_what_can_t_be_gets_one_sentence_and_leaves_no_file(
    tmp_path: Path, text: str, message: str
) -> None:
    path = figures(tmp_path, text)
    outcome = call("new", [str(path)])
    assert outcome.kind == "sentence"
    assert re.search(message, outcome.err), outcome.err
    assert sorted(file.name for file in tmp_path.iterdir()) == ["craft.toml"]


def test_a_file_is_never_overwritten(tmp_path: Path) -> None:
    path, out = figures(tmp_path, CRAFT + WHEEL), tmp_path / "sub" / "craft.xml"
    write_spacecraft(read_figures(path), out)
    before = out.read_text()
    with pytest.raises(OutputError, match=r"craft.xml' exists already; name a new file with --out"):
        write_spacecraft(read_figures(path), out)
    assert out.read_text() == before
    with pytest.raises(OutputError, match=r"can't write '/dev/null/x.xml'"):
        write_spacecraft(read_figures(path), Path("/dev/null/x.xml"))
