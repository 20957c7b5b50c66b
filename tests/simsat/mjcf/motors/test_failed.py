"""Wheels that a file declares failed: MuJoCo flies their rotors as part of the bus."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from simsat.control.ground.errors import ModelError
from simsat.mjcf import Model, interpret, read_compiled, read_model
from simsat.mjcf.motors.failed import with_failed_locked
from simsat.mjcf.shipped import find_model
from simsat.mjcf.travel import copy_model
from simsat.plant.plant import Plant
from simsat.results.summary import describe
from tests.simsat.mjcf.edits import JOINT_X, MOTOR_X, ROTOR_X, at_end, text

START = np.array([0.5, -0.5, 0.5, 0.5]), np.array([0.03, -0.05, 0.04])


def failed(*names: str) -> tuple[str, str]:
    return at_end(f'<custom><text name="failed_wheels" data="{" ".join(names)}"/></custom>')


def read(*edits: tuple[str, str]) -> Model:
    return interpret(mujoco.MjSpec.from_string(text(*edits)), "edited")


def flown(model: Model) -> Plant:
    plant = Plant(model, 0.05, 200)
    plant.reset(*START, np.array([200.0]))
    for k in range(20):
        plant.advance(np.array([0.03 * np.cos(k)]), 10)
    return plant


def test_it_flies_as_a_file_without_the_joint_bit_for_bit() -> None:
    """The rotor is then a body welded to the bus, which is MuJoCo's own way to say so."""
    welded = read((JOINT_X, ""), (MOTOR_X, ""))
    locked = read(failed("wheel_x"))
    assert locked.failed_wheels == ("wheel_x",)
    assert locked.passive_joints == ()
    assert locked.spacecraft.wheel_names == ("wheel_y",)
    np.testing.assert_array_equal(flown(locked).log.qpos, flown(welded).log.qpos)


def test_one_rigid_body_is_left_and_turns_as_euler_says() -> None:
    """J w' = -w x (J w + A Js Omega) - A u with J of the whole, the locked rotor in it."""
    model = read(failed("wheel_x"))
    craft = model.spacecraft
    plant = Plant(model, 0.01, 2)
    plant.reset(*START, np.array([200.0]))
    plant.advance(np.zeros(1), 2)
    w, speed = plant.rates[1], plant.wheel_speeds[1]
    H = craft.angular_momentum(w, speed)
    expected = -np.linalg.solve(craft.J_hub, np.cross(w, H))
    measured = (plant.rates[2] - plant.rates[0]) / 0.02
    np.testing.assert_allclose(measured, expected, rtol=1e-5)
    both = read().spacecraft
    np.testing.assert_allclose(craft.J, both.J, rtol=1e-14)
    # a coasting rotor would not have been carried along about its axis:
    coasting = read((MOTOR_X, ""))
    assert coasting.passive_joints == ("wheel_x",)
    assert np.abs(flown(coasting).rates - flown(model).rates).max() > 1e-5  # rad/s


def test_a_variant_is_its_craft_with_wheels_locked() -> None:
    kepler = read_model(find_model("kepler")).spacecraft
    two = read_model(find_model("kepler_two_wheel"))
    assert two.failed_wheels == ("wheel_2", "wheel_4")
    np.testing.assert_allclose(two.spacecraft.J, kepler.J, rtol=1e-12, atol=1e-9)
    np.testing.assert_array_equal(two.spacecraft.A, kepler.A[:, [0, 2]])
    assert two.spacecraft.unactuated is not None
    np.testing.assert_allclose(np.abs(two.spacecraft.unactuated), [1.0, 0.0, 0.0], atol=1e-12)
    assert "  wheels failed, their rotors fixed to the bus: wheel_2, wheel_4" in describe(
        two, two.spacecraft
    )
    assert two.ignored == ()  # the limits of the failed ones are theirs, not nobody's


def test_what_looks_at_the_joint_goes_with_it() -> None:
    model = read(
        failed("wheel_x"),
        at_end('<sensor><jointvel joint="wheel_x"/><actuatorfrc actuator="motor_x"/></sensor>'),
        at_end('<keyframe><key qpos="0 0 0 1 0 0 0 1 2"/></keyframe>'),
    )
    assert model.ignored == ()


def test_a_rotor_of_the_hull_s_group_stays_inside() -> None:
    outer = ROTOR_X + '<geom type="box" size="1 1 1" mass="0" group="0"/>'
    faces = read((ROTOR_X, outer), failed("wheel_x")).spacecraft.surface.area
    np.testing.assert_array_equal(faces, read().spacecraft.surface.area)


def test_the_spec_itself_is_left_as_it_was() -> None:
    spec = mujoco.MjSpec.from_string(text(failed("wheel_x")))
    with_failed_locked(spec)
    assert spec.joint("wheel_x") is not None
    assert read_compiled(spec).failed_wheels == ("wheel_x",)


def test_a_copy_elsewhere_is_the_same_model(tmp_path: Path) -> None:
    path = find_model("kepler_two_wheel")
    model = read_model(path)
    copied = copy_model(model, path, tmp_path / "files")
    assert copied.suffix == ".xml"
    assert read_model(copied).identity == model.identity
    kept = copy_model(model, Path("nowhere.xml"), tmp_path / "kept")
    assert kept.suffix == ".mjb"
    assert read_model(kept).failed_wheels == ("wheel_2", "wheel_4")


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            failed("wheel_z"),
            "names 'wheel_z', but the wheels' joints are 'wheel_x', 'wheel_y'; did",
        ),
        (failed("motor_x"), "names 'motor_x', but the wheels' joints are"),
        (failed("wheel_x", "wheel_y"), "the file has no wheel"),
        (
            at_end('<custom><text name="failed_wheel" data="x"/></custom>'),
            "did you mean 'failed_wh",
        ),
        (at_end('<custom><text name="locked_wheels" data="x"/></custom>'), "write 'failed_wheels'"),
    ],
)
def test_wrong_names_are_refused(edit: tuple[str, str], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read(edit)


def test_a_compiled_model_can_lose_no_joint() -> None:
    m = mujoco.MjModel.from_xml_string(text(failed("wheel_x")))
    with pytest.raises(ModelError, match="a compiled model can't lose a joint"):
        read_compiled(m)


def test_a_joint_that_a_tendon_needs_is_named() -> None:
    tendon = '<tendon><fixed name="t"><joint joint="wheel_x" coef="1"/></fixed></tendon>'
    with pytest.raises(ModelError, match=r"wheel_x.*not found in tendon"):
        read(failed("wheel_x"), at_end(tendon))
