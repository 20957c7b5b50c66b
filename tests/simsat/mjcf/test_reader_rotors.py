"""What a wheel's rotor is: on the bus, one rigid body, in balance; and what flies as such."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from simsat.control.ground.attitude import IDENTITY, error_angle
from simsat.control.ground.errors import ModelError
from simsat.mjcf import interpret
from simsat.mjcf.refusals.timestep import ROUND
from simsat.mjcf.rotors import read_rotor
from simsat.plant.plant import Plant
from tests.simsat.mjcf.edits import FREE, ROTOR_X, WORLD, at_end, behind, joint_x, read, unused

ROTOR = """<body name="rotor_z" {pos}><inertial pos="0 0 0" mass="0.8"
diaginertia="0.0014 0.0014 0.0014"/>
<joint name="wheel_z" class="wheel" axis="0 0 1"/>{more}</body>"""
MOTOR = '<actuator><general name="motor_z" class="wheel" joint="wheel_z"/></actuator>'
ON_A_PANEL = """<body name="panel"><inertial pos="0 1 0" mass="1" diaginertia="1 1 1"/>
<joint name="hinge" axis="1 0 0"/>{rotor}</body>"""
BRACKET = '<body name="bracket" pos="0 0 0.1" euler="0.3 0.2 0.1">{rotor}</body>'
DRIVEN_PANEL = """<mujoco><option integrator="RK4" timestep="0.0005" gravity="0 0 0"
tolerance="1e-15"/><option><flag contact="disable" autoreset="disable"/></option>
<worldbody><body name="bus"><freejoint/><geom type="box" size="0.5 0.5 0.5" mass="200"/>
<body name="panel" pos="0.5 0 0"><joint name="drive" axis="0 1 0"/>{panel}</body>
<body name="r1"><joint name="w1" axis="0 0 1"/>
<geom type="cylinder" size="0.1 0.02" mass="3" group="2"/></body></body></worldbody>
<actuator><motor name="sada" joint="drive"/><motor name="w1" joint="w1"/></actuator></mujoco>"""

JS = 0.001432394487827058  # kg m^2
JOINT_NEXT = '\n        <joint name="wheel_x"'
ROUND_ROTOR = f'diaginertia="{JS} {JS} {JS}"/>{JOINT_NEXT}'


def rotor(pos: str = "", more: str = "") -> str:
    return ROTOR.format(pos=f'pos="{pos}"' if pos else "", more=more)


def offset(metres: float, step: float = 0.0005) -> tuple[tuple[str, str], tuple[str, str]]:
    """Rotor x with its centre of mass off its axis."""
    old = '<body name="rotor_x" pos="0.09 -0.06 -0.12">\n        <inertial pos="0 0 0"'
    return (old, old.replace("0 0 0", f"0 {metres!r} 0")), at_end(f'<option timestep="{step}"/>')


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (behind(WORLD, rotor("3 0 0")), "'wheel_z' hangs on the world, not on the spacecraft 'b"),
        (behind(WORLD, f'<body name="pillar">{rotor()}</body>'), "'wheel_z' hangs on the world"),
        (behind(ROTOR_X, rotor()), "'wheel_z' hangs on 'rotor_x', which moves by joint 'wheel_x'"),
        (behind(ROTOR_X, rotor()), "rotor of wheel 'wheel_x' carries joint 'wheel_z'"),
        (behind(FREE, ON_A_PANEL.format(rotor=rotor())), "'wheel_z' hangs on 'panel', which moves"),
        (behind(FREE, ON_A_PANEL.format(rotor=BRACKET.format(rotor=rotor()))), "joint 'hinge'; a"),
        (behind(FREE, rotor(more='<joint name="j" axis="1 0 0"/>')), "has 2 joints; a rotor has"),
    ],
)  # fmt: skip
def test_a_rotor_hangs_rigidly_on_the_bus(edit: tuple[str, str], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read(edit, at_end(MOTOR))


def test_wheels_that_are_all_on_the_world_are_refused() -> None:
    with pytest.raises(ModelError, match="'wheel_z' hangs on the world"):
        read(
            behind(WORLD, rotor("3 0 0")),
            at_end(MOTOR),
            unused("motor_x", "motor_y"),
        )


def test_a_rotor_on_a_fixed_bracket_is_a_wheel_with_the_axis_that_it_has() -> None:
    craft = read(behind(FREE, BRACKET.format(rotor=rotor())), at_end(MOTOR)).spacecraft
    R = np.zeros(9)
    quat = np.zeros(4)
    mujoco.mju_euler2Quat(quat, np.array([0.3, 0.2, 0.1]), "xyz")
    mujoco.mju_quat2Mat(R, quat)
    np.testing.assert_allclose(craft.A[:, 2], R.reshape(3, 3)[:, 2], atol=1e-12)


LUMP = """<body name="lump" pos="{}"><inertial pos="{}" mass="0.1" diaginertia="1e-5 1e-5 1e-5"/>
{}</body>"""
FLAP = '<joint name="flap" axis="0 0 1"/>'


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (behind(ROTOR_X, LUMP.format("0.02 0.05 0", "0 0 0", "")),
         "'rotor_x' is 0.00556 m off its hinge, 13 % of its radius of gyration.*less than 1 %"),
        (behind(ROTOR_X, LUMP.format("0 0.05 0", "0 0.02 0", FLAP)),
         "rotor of wheel 'wheel_x' carries joint 'flap'; a rotor turns as one"),
        (behind(ROTOR_X, LUMP.format("0.02 1e-4 0", "0 0 0", "")),
         "'wheel_x' is imbalanced.*else <option timestep='0.01'> must be at most 0.0005 s"),
        (behind(ROTOR_X, f'<body><body>{LUMP.format("0 0.05 0", "0 0 0", "")}</body></body>'),
         "'rotor_x' is 0.00556 m off its hinge"),
    ],
)  # fmt: skip
def test_imbalance_counts_in_everything_that_turns(edit: tuple[str, str], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read(edit)


def test_masses_that_balance_each_other_are_in_balance() -> None:
    places = ("0.02 0.05 0", "0.02 -0.05 0", "0.02 0 0.05", "0.02 0 -0.05")
    lumps = [
        LUMP.format(place, "0 0 0", "").replace("lump", f"lump_{k}")
        for k, place in enumerate(places)
    ]
    model = read(behind(ROTOR_X, "".join(lumps)))
    turning = 0.001432394487827058 + 4 * (1e-5 + 0.1 * 0.05**2)
    assert model.spacecraft.Js[0] == pytest.approx(turning, rel=1e-12)


def test_the_border_between_a_rotor_and_a_panel() -> None:
    """1 % of the radius of gyration, 0.0423 m here, whatever the time step; stated in the guide."""
    read(*offset(0.99 * 4.23e-4, 1e-4))
    with pytest.raises(ModelError, match=r"'wheel_x' is imbalanced.*1 % of its radius of gyration"):
        read(*offset(1.01 * 4.232e-4, 1e-4))


@pytest.mark.parametrize(
    ("tensor", "what"),
    [
        ("1.4e-3 8e-4 8e-4 1.4e-9 0 0", "no principal axis"),
        ("1.4e-3 8e-4 8.001e-4 0 0 0", "across the axis differ"),
    ],
)
def test_a_millionth_out_of_balance_is_not_round(tensor: str, what: str) -> None:
    """At 6000 rpm and 10 ms a product of 1e-6 spin inertias leaks 2e-4 Nm, more than drag."""
    edit = ROUND_ROTOR, f'fullinertia="{tensor}"/>{JOINT_NEXT}'
    with pytest.raises(ModelError, match=f"'wheel_x' is imbalanced.*{what}.*at most 0.0005 s"):
        read(edit)
    read(edit, at_end('<option timestep="0.0005"/>'))


@pytest.mark.parametrize("step", [5e-4, 4e-4, 2.5e-4, 1e-4])
def test_a_step_shorter_than_it_must_be_is_no_worse(step: float) -> None:
    """Within a turn the momentum of an unbalanced rotor errs, to and fro."""
    read(*offset(0.99 * 4.23e-4, step))


def test_what_is_taken_for_round_flies_as_a_round_rotor_does() -> None:
    """100 s at 6000 rpm, turning, in the usual step: 0.002 deg, what a gravity gradient costs that
    is held over a sample. A product of inertia of ten times the border leaves ten times that."""
    ends = []
    for product in (0.0, 0.99 * ROUND):
        tensor = " ".join(map(repr, [JS, JS, JS, product * JS, 0.0, 0.0]))
        model = read((ROUND_ROTOR, f'fullinertia="{tensor}"/>{JOINT_NEXT}'))
        plant = Plant(model, 0.05, 2000)
        plant.reset(IDENTITY, np.radians([1.0, -2.0, 1.5]), np.array([628.0, -600.0]))
        plant.advance(np.zeros(2), 2000)
        ends.append(plant.attitudes[-1])
    apart_deg = np.degrees(error_angle(ends[0], ends[1]))
    assert 1e-4 < apart_deg < 2e-3


@pytest.mark.parametrize(("limit_rpm", "step"), [("6000", 5e-4), ("1200", 2.5e-3), ("28000", 1e-4)])
def test_a_rotor_out_of_balance_turns_a_twentieth_a_step_at_most(
    limit_rpm: str, step: float
) -> None:
    limit = at_end(f'<custom><numeric name="wheel_x.speed_limit_rpm" data="{limit_rpm}"/></custom>')
    read(*offset(1e-5, step), limit)
    with pytest.raises(ModelError, match=r"'wheel_x' is imbalanced.*m off its hinge.*at most"):
        read(*offset(1e-5, 1.1 * step), limit)


@pytest.mark.parametrize(
    ("panel", "message"),
    [
        ('<geom type="box" size="1 0.4 0.02" pos="1 0 0" mass="8"/>',
         "the centre of mass of 'panel' is 1 m off its hinge, 87 % of its radius of gyration"),
        ('<geom type="box" size="1 0.4 0.02" pos="0.1 0 0" mass="8"/>', "'panel' is 0.1 m off its"),
        ('<geom type="box" size="1 0.4 0.02" mass="8"/>', "across the axis differ by 1e\\+02 %"),
        ('<geom type="box" size="1 0.4 0.02" euler="0 0 30" mass="8"/>', "is no principal axis"),
    ],
)  # fmt: skip
def test_a_driven_panel_is_no_wheel(panel: str, message: str) -> None:
    line = "<text name='unused_actuators' data='sada'/>"
    with pytest.raises(ModelError, match=f"wheel 'drive' is imbalanced.*{message}.*{line}"):
        interpret(mujoco.MjModel.from_xml_string(DRIVEN_PANEL.format(panel=panel)), "panel")


def test_the_refusal_s_advice_can_be_followed(tmp_path: Path) -> None:
    panel = '<geom type="box" size="1 0.4 0.02" pos="1 0 0" mass="8"/>'
    declared = '<custom><text name="unused_actuators" data="sada"/></custom></mujoco>'
    xml = DRIVEN_PANEL.format(panel=panel).replace("</mujoco>", declared)
    model = interpret(mujoco.MjModel.from_xml_string(xml), "panel")
    assert model.passive_joints == ("drive",)
    assert model.unused_actuators == ("sada",)
    assert model.spacecraft.wheel_names == ("w1",)


def test_a_rotor_s_numbers_are_those_of_its_parts_put_together() -> None:
    """Two point-like masses on a bar: J = sum m (r x r), by hand."""
    xml = """<mujoco><worldbody><body><freejoint/><geom size="1"/>
    <body name="r"><joint name="j" pos="0.5 0 0.5" axis="0 0 2"/>
    <inertial pos="1 0 0" mass="2" diaginertia="1e-9 1e-9 1e-9"/>
    <body pos="0 0 1" euler="0 0 90"><inertial pos="3 0 0" mass="1" diaginertia="1e-9 1e-9 1e-9"/>
    </body></body></body></worldbody></mujoco>"""
    rotor = read_rotor(mujoco.MjModel.from_xml_string(xml), 1)
    assert rotor.mass == 3.0
    centre = (2 * np.array([1.0, 0, 0]) + np.array([0, 3.0, 1.0])) / 3
    np.testing.assert_allclose(rotor.offset, [centre[0] - 0.5, centre[1], 0.0], atol=1e-12)
    assert rotor.spin_inertia == pytest.approx(2 * 0.5**2 + 0.5**2 + 3**2, rel=1e-8)
    assert rotor.eccentricity == pytest.approx(np.hypot(1 / 6, 1.0) / np.sqrt(9.75 / 3), rel=1e-8)
    # products about the centre of mass: sum m z x, z y with z = -1/3, 2/3
    x, y = 2 * (-1 / 3) * (1 / 3) + (2 / 3) * (-2 / 3), 2 * (-1 / 3) * (-1) + (2 / 3) * 2
    assert rotor.product == pytest.approx(np.hypot(x, y), rel=1e-8)


def test_a_wheel_spins_freely() -> None:
    with pytest.raises(ModelError, match=r"'wheel_x' has stiffness 0\.1; a rotor spins freely"):
        read(joint_x(stiffness="0.1"))


@pytest.mark.parametrize("what", ["damping", "frictionloss", "stiffness"])
def test_nothing_feeds_motion(what: str) -> None:
    with pytest.raises(ModelError, match=f"joint 'wheel_x' has {what} -0.001, which feeds motion"):
        read(joint_x(**{what: "-0.001"}))
