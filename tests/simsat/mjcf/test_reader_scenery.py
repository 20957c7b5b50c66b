"""Only the spacecraft counts: the world is scenery, rotors are no hull, the rest is said."""

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.ground.errors import ModelError
from simsat.environment import EnvironmentSettings, OrbitSettings, build_environment
from simsat.mjcf import Model
from simsat.plant.plant import Plant
from simsat.results.summary import describe
from tests.simsat.mjcf.edits import BUS, FREE, MOTOR_X, ROTOR_X, WORLD, at_end, behind, read, unused

EARTH = '<geom name="earth" type="sphere" size="1" pos="10 0 0"/>'
PILLAR = """<body name="pillar" pos="0 3 0" mocap="true"><geom size="0.5" mass="1000"/>
<body name="top" pos="0 0 1"><geom name="lamp" size="0.2" mass="10"/></body></body>"""
DISC = '<geom type="cylinder" size="0.06 0.012" mass="0" group="0"/>'
BRACE = f"""<body name="brace" pos="0.01 0 0">{DISC}
<inertial pos="0 0 0" mass="1e-6" diaginertia="1e-9 1e-9 1e-9"/></body>"""


def flown(model: Model) -> Plant:
    """Ten seconds in drag and gravity gradient under some torques."""
    environment = build_environment(model.spacecraft, OrbitSettings(), EnvironmentSettings())
    plant = Plant(model, 0.05, 200, environment.torque)
    plant.reset(attitude.normalized(np.array([0.9, 0.1, -0.3, 0.2])), np.array([0.01, 0.02, -0.03]))
    for k in range(20):
        plant.advance(np.array([0.01, -0.02]) * np.cos(k), 10)
    return plant


@pytest.mark.parametrize("scenery", [EARTH, PILLAR, EARTH + PILLAR])
def test_scenery_changes_no_bit_of_a_flight(two_wheel: Model, scenery: str) -> None:
    model = read(behind(WORLD, scenery))
    plain, beside = flown(two_wheel), flown(model)
    np.testing.assert_array_equal(beside.log.qpos, plain.log.qpos)
    np.testing.assert_array_equal(beside.log.qvel, plain.log.qvel)
    assert model.spacecraft.mass == two_wheel.spacecraft.mass
    assert len(model.spacecraft.surface.area) == len(two_wheel.spacecraft.surface.area)
    assert model.spacecraft.fingerprint == two_wheel.spacecraft.fingerprint


@pytest.mark.parametrize("turning", [DISC, BRACE])
def test_what_turns_with_a_rotor_is_no_hull(two_wheel: Model, turning: str) -> None:
    surface = read(behind(ROTOR_X, turning)).spacecraft.surface
    np.testing.assert_array_equal(surface.area, two_wheel.spacecraft.surface.area)


@pytest.mark.parametrize("lost", [(MOTOR_X, ""), unused("motor_x")])
def test_a_rotor_without_a_motor_still_is_no_hull(two_wheel: Model, lost: tuple[str, str]) -> None:
    model = read(behind(ROTOR_X, DISC), lost)
    assert model.passive_joints == ("wheel_x",)
    surface = model.spacecraft.surface
    np.testing.assert_array_equal(surface.area, two_wheel.spacecraft.surface.area)


def test_a_panel_on_a_hinge_is_hull() -> None:
    panel = """<body name="panel" pos="0 0.3 0"><joint name="hinge" axis="1 0 0" stiffness="1"/>
    <geom type="box" size="0.2 0.3 0.005" pos="0 0.3 0" mass="1"/></body>"""
    assert len(read(behind(FREE, panel)).spacecraft.surface.area) == 12


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (behind(WORLD, '<body name="b"><joint name="swing"/><geom size="1"/></body>'),
         "joint 'swing' moves a body that hangs on the world, not on the spacecraft"),
        (behind(WORLD, '<body name="b"><freejoint/><geom size="1"/></body>'), "2 free bodies"),
        (behind(WORLD, '<body><body><joint name="j"/><geom size="1"/></body></body>'),
         "joint 'j' moves a body that hangs on the world"),
    ],
)  # fmt: skip
def test_scenery_stands_still(edit: tuple[str, str], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read(edit)


def test_what_has_no_effect_is_said(two_wheel: Model) -> None:
    model = read(
        behind(WORLD, EARTH),
        behind(BUS, '<site name="imu"/><camera name="eye"/><light name="sun"/>'),
        behind(FREE, '<geom name="hull" type="mesh" mesh="tetra" mass="0"/>'),
        at_end('<sensor><gyro name="gyro" site="imu"/><gyro site="imu"/></sensor>'),
        at_end('<keyframe><key name="home"/></keyframe>'),
        at_end('<tendon><fixed name="string"><joint joint="wheel_x" coef="1"/></fixed></tendon>'),
        at_end('<equality><weld name="dock" body1="bus" active="false"/></equality>'),
        at_end('<contact><pair geom1="bus_box" geom2="earth"/></contact>'),
        at_end(
            '<custom><numeric name="budget_eur" data="3"/><text name="note" data="hi"/></custom>'
        ),
        at_end('<asset><mesh name="tetra" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'),
    )
    assert model.ignored == (
        "sensor (2)",
        "keyframe 'home'",
        "tendon 'string'",
        "inactive equality 'dock'",
        "contact pair (1)",
        "scenery 'earth'",
        "no faces for drag and sunlight on 'hull'",
        "numeric 'budget_eur'",
        "text 'note'",
    )
    said = describe(model, model.spacecraft)
    assert "  without effect here: sensor (2), keyframe 'home', tendon 'string'" in said
    assert "without effect here" not in describe(two_wheel, two_wheel.spacecraft)
    np.testing.assert_array_equal(flown(model).log.qpos, flown(two_wheel).log.qpos)
