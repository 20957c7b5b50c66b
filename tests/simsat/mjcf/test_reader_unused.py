"""Actuators that are no wheel's: declared unused they give no force, and everyone is told."""

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.ground.errors import ModelError
from simsat.mjcf import Model, read_compiled
from simsat.plant.plant import Plant
from simsat.results.summary import describe
from tests.simsat.mjcf.edits import BUS, FREE, at_end, behind, motor_x, read, unused

NOZZLE = behind(BUS, '<site name="nozzle" pos="0.2 0.1 0"/><site name="ref"/>')
PANEL = behind(FREE, """<body name="panel" pos="0 0.3 0"><joint name="hinge" axis="1 0 0"/>
<inertial pos="0 0.3 0" mass="1" diaginertia="0.03 0.013 0.043"/></body>""")  # fmt: skip
FIRST = ("<actuator>", '<actuator><{} name="spare" {}/>')
"""Before the wheels' motors, so that every index of theirs moves."""


def before_the_wheels(tag: str, attributes: str) -> tuple[str, str]:
    return FIRST[0], FIRST[1].format(tag, attributes)


def flown(model: Model) -> Plant:
    plant = Plant(model, 0.05, 100)
    plant.reset(attitude.IDENTITY, np.array([0.01, 0.02, -0.03]))
    for k in range(10):
        plant.advance(np.array([0.01, -0.02]) * np.cos(k), 10)
    return plant


THRUSTERS = [
    ("motor", 'site="nozzle" gear="0 0 1 0 0 0"'),
    ("position", 'site="nozzle" refsite="ref" kp="10"'),
    ("general", 'site="nozzle" dyntype="filter" dynprm="0.1" biastype="affine" biasprm="1"'),
    ("orientation", 'site="nozzle" refsite="ref" kp="2"'),
    ("adhesion", 'body="bus" gain="1" ctrlrange="0 1"'),
    ("motor", 'joint="bus_free" gear="0 0 0 1 0 0" delay="0.1" nsample="10"'),
    ("position", 'joint="wheel_x" kp="5"'),
    ("dcmotor", 'joint="wheel_x" resistance="1" motorconst="0.1"'),
]  # fmt: skip


@pytest.mark.parametrize(("tag", "attributes"), THRUSTERS)
def test_undeclared_they_are_refused_with_the_line_that_keeps_them(
    tag: str, attributes: str
) -> None:
    line = "<custom><text name='unused_actuators' data='spare'/></custom>"
    with pytest.raises(ModelError, match=f"'spare'.*({line}|both drive joint)"):
        read(NOZZLE, before_the_wheels(tag, attributes))


def test_a_servo_is_refused_once_as_a_whole() -> None:
    with pytest.raises(ModelError, match=r"^actuator 'spare' is no torque motor: use <motor>"):
        read(PANEL, before_the_wheels("position", 'joint="hinge" kp="5" kv="1"'))


@pytest.mark.parametrize(("tag", "attributes"), THRUSTERS)
def test_declared_they_change_no_bit_of_a_flight(
    two_wheel: Model, tag: str, attributes: str
) -> None:
    model = read(NOZZLE, before_the_wheels(tag, attributes), unused("spare"))
    assert model.unused_actuators == ("spare",)
    assert model.passive_joints == ()
    plain, beside = flown(two_wheel), flown(model)
    np.testing.assert_array_equal(beside.log.qpos, plain.log.qpos)
    np.testing.assert_array_equal(beside.log.torque, plain.log.torque)
    assert "  actuators declared unused, held at zero: spare" in describe(model, model.spacecraft)


def test_a_wheel_s_gear_is_its_own_behind_an_actuator_of_several_outputs() -> None:
    three = before_the_wheels("orientation", 'site="nozzle" refsite="ref" kp="2"')
    geared = read(NOZZLE, three, unused("spare"), motor_x(gear="2 0 0 0 0 0"))
    np.testing.assert_allclose(geared.spacecraft.torque_max, [0.1, 0.05])


@pytest.mark.parametrize("tag", ["position", "velocity", "intvelocity", "motor"])
def test_a_deployment_motor_s_joint_is_a_passive_one(tag: str) -> None:
    """A servo would hold the hinge; declared unused it lets go, as if it were not there."""
    free = flown(read(PANEL))
    model = read(PANEL, before_the_wheels(tag, 'joint="hinge"'), unused("spare"))
    assert model.passive_joints == ("hinge",)
    np.testing.assert_array_equal(flown(model).log.qpos, free.log.qpos)


def test_several_names_stand_in_one_line() -> None:
    model = read(
        NOZZLE,
        PANEL,
        behind("<actuator>", '<motor name="a" site="nozzle"/><motor name="b" joint="hinge"/>'),
        unused("b", "a", "motor_y"),
    )
    assert model.unused_actuators == ("a", "b", "motor_y")
    assert model.spacecraft.wheel_names == ("wheel_x",)
    assert model.passive_joints == ("hinge", "wheel_y")


def test_a_name_that_no_actuator_has_is_refused() -> None:
    with pytest.raises(
        ModelError,
        match="names 'motor_z', but the file's actuators are 'motor_x', 'motor_y'; did you mean",
    ):
        read(unused("motor_z"))


@pytest.mark.parametrize("name", ["unused_actuator", "Unused_Actuators", "unused-actuators"])
def test_a_misspelt_line_is_refused(name: str) -> None:
    entry = f'<custom><text name="{name}" data="motor_x"/></custom>'
    with pytest.raises(ModelError, match=f"text '{name}' is not known; did you mean 'unused_act"):
        read(at_end(entry))


@pytest.mark.parametrize("what", ["armature", "damping"])
def test_what_acts_without_a_command_is_refused_even_so(what: str) -> None:
    with pytest.raises(ModelError, match=f"actuator 'spare' has {what} 0.1"):
        read(PANEL, before_the_wheels("motor", f'joint="hinge" {what}="0.1"'), unused("spare"))


def test_a_file_whose_motors_are_all_unused_has_no_wheel() -> None:
    with pytest.raises(ModelError, match="the file has no wheel"):
        read(unused("motor_x", "motor_y"))


def test_the_compiled_model_is_left_as_it_was() -> None:
    """They are switched off in the copy that is stepped: the model itself can be read again."""
    model = read(NOZZLE, before_the_wheels("motor", 'site="nozzle"'), unused("spare"))
    group = int(model.to_step().actuator("spare").group[0])
    assert model.to_step().opt.disableactuator == 1 << group
    assert group not in (model.mj.actuator(name).group[0] for name in ("motor_x", "motor_y"))
    again = read_compiled(model.mj)
    assert again.identity == model.identity
    assert again.unused_actuators == ("spare",)
