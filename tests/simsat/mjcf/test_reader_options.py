"""Time steps, flags and solver settings: their bounds, and that within them a file is flown."""

import re

import mujoco
import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.ground.errors import ModelError
from simsat.mjcf import interpret
from simsat.plant.plant import Plant
from tests.simsat.mjcf.edits import FREE, MOTOR_X, at_end, attributes, behind, joint_x, read, text

PANEL = """<body name="panel" pos="0 0.2 0"><joint name="hinge" axis="1 0 0" {}/>
<inertial pos="0 0.3 0" mass="1" diaginertia="0.03 0.013 0.043"/></body>"""


def option(**settings: str) -> tuple[str, str]:
    return at_end(f"<option {attributes(settings)}/>")


def plain_motor(**settings: str) -> tuple[str, str]:
    return MOTOR_X, f'<motor name="motor_x" joint="wheel_x" {attributes(settings)}/>'


def flag(name: str, state: str) -> tuple[str, str]:
    return at_end(f'<option><flag {name}="{state}"/></option>')


@pytest.mark.parametrize("step", ["0", "-0.01"])
def test_a_step_is_a_time(step: str) -> None:
    with pytest.raises(ModelError, match=rf"'{step}'>: it must be above zero, usually 0.01 s"):
        read(option(timestep=step))


@pytest.mark.parametrize("step", ["5e-9", "9e-6", "0.051", "1e6"])
def test_a_step_has_bounds(step: str) -> None:
    with pytest.raises(
        ModelError, match=rf"'{re.escape(f'{float(step):g}')}'>: .* from 1e-05 to 0.05 s"
    ):
        read(option(timestep=step))


@pytest.mark.parametrize("step", ["1e-5", "0.05"])
def test_the_bounds_themselves_are_flown(step: str) -> None:
    assert read(option(timestep=step)).mj.opt.timestep == float(step)


@pytest.mark.parametrize(
    ("name", "state", "does"),
    [
        ("frictionloss", "disable", "act here as the file states them"),
        ("constraint", "disable", "act here as the file states them"),
        ("limit", "disable", "act here as the file states them"),
        ("spring", "disable", "act here as the file states them"),
        ("damper", "disable", "act here as the file states them"),
        ("clampctrl", "disable", "act here as the file states them"),
        ("actuation", "disable", "act here as the file states them"),
        ("equality", "disable", "act here as the file states them"),
        ("warmstart", "disable", "act here as the file states them"),
        ("refsafe", "disable", "act here as the file states them"),
        ("override", "enable", "not interpreted here"),
        ("sleep", "enable", "not interpreted here"),
        ("diagexact", "enable", "not interpreted here"),
        ("fwdinv", "enable", "not interpreted here"),
        ("invdiscrete", "enable", "not interpreted here"),
    ],
)
def test_flags_that_change_a_flight_are_refused(name: str, state: str, does: str) -> None:
    with pytest.raises(ModelError, match=f"^<flag {name}='{state}'>: .*{does}"):
        read(flag(name, state))


@pytest.mark.parametrize(
    "flags",
    [
        "gravity",
        "sensor",
        "filterparent",
        "midphase",
        "nativeccd",
        "multiccd",
        "eulerdamp",
        "island",
    ],
)
def test_flags_without_effect_are_flown(flags: str) -> None:
    read(flag(flags, "disable"))


def test_computing_the_energy_harms_nobody() -> None:
    read(flag("energy", "enable"))


def test_a_flag_nobody_has_a_name_for_is_refused_by_its_number() -> None:
    m = read().mj
    m.opt.disableflags |= 1 << 27
    with pytest.raises(ModelError, match="<flag number 27='disable'>"):
        interpret(m, "later")


@pytest.mark.parametrize("iterations", ["1", "99", "1001", "2000000000"])
def test_the_solver_gets_the_iterations_that_friction_needs(iterations: str) -> None:
    with pytest.raises(ModelError, match=rf"iterations='{iterations}'>.*100 \(MuJoCo's"):
        read(option(iterations=iterations))


def test_the_solver_is_not_told_to_end_early() -> None:
    with pytest.raises(ModelError, match=r"<statistic meaninertia='1e\+12'>.*own mean is 19.2979"):
        read(at_end('<statistic meaninertia="1e12"/>'))


@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast", "discrete"])
def test_only_runge_kutta_keeps_an_attitude(integrator: str) -> None:
    with pytest.raises(ModelError, match=f"integrator='{integrator.upper()}'.*use 'RK4'"):
        read(option(integrator=integrator))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            'stiffness="1e4"',
            "joint 'hinge' swings at .* rad/s: <option timestep='0.01'> must be at",
        ),
        (
            'damping="50"',
            "joint 'hinge' is braked at .* rad/s: <option timestep='0.01'> must be at",
        ),
    ],
)
def test_a_spring_or_damper_too_fast_for_the_step_is_refused(settings: str, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read(behind(FREE, PANEL.format(settings)))


def test_a_bearing_that_brakes_too_fast_for_the_step_is_refused() -> None:
    with pytest.raises(ModelError, match=r"'wheel_x' is braked at 699 rad/s.*most 0\.000449"):
        read(joint_x(damping="1"))


def test_at_the_longest_step_for_a_spring_it_keeps_its_swing() -> None:
    """RK4 damps by x^6 / 144 a step, x = 2 pi / 20: 0.3 % in 20 turns."""
    with pytest.raises(ModelError) as refusal:
        read(behind(FREE, PANEL.format('stiffness="1e4"')))
    longest = float(str(refusal.value).rpartition("must be at most ")[2].removesuffix(" s"))
    step = 0.01 / np.ceil(0.01 / longest)
    loaded = behind(FREE, PANEL.format('stiffness="1e4" springref="0.01"'))
    model = read(loaded, option(timestep=f"{step}"))
    plant = Plant(model, step, 400)
    plant.reset(attitude.IDENTITY)
    plant.advance(np.zeros(2), 400)
    angle = plant.log.qpos[:, model.mj.joint("hinge").qposadr[0]] - 0.01
    assert np.std(angle[:100]) == pytest.approx(0.01 / np.sqrt(2.0), rel=0.02)  # it does swing
    assert np.std(angle[-100:]) == pytest.approx(np.std(angle[:100]), rel=5e-3)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (joint_x(range="3 1"), "joint 'wheel_x': range 3 1 holds nothing"),
        (joint_x(actuatorfrcrange="1 -1"), "joint 'wheel_x': actuatorfrcrange 1 -1 holds nothing"),
        (plain_motor(ctrlrange="0.1 -0.1"), "'motor_x': ctrlrange 0.1 -0.1 holds nothing"),
        (plain_motor(forcerange="0.1 -0.1"), "'motor_x': forcerange 0.1 -0.1 holds nothing"),
        (plain_motor(ctrlrange="0.1 0.1"), "'motor_x': ctrlrange 0.1 0.1 holds nothing"),
    ],
)
def test_a_limit_written_backwards_is_not_left_out(edit: tuple[str, str], message: str) -> None:
    with pytest.raises(ModelError, match=f"{message}, MuJoCo would leave the limit out"):
        interpret(mujoco.MjSpec.from_string(text(edit)), "backwards")


def with_contact(xml: str) -> mujoco.MjModel:
    """The bare file of a bus and a rotor, contacts left on."""
    bare = """<mujoco><option integrator="RK4" gravity="0 0 0"><flag autoreset="disable"/></option>
    <worldbody><body name="bus"><freejoint/><geom name="hull" size="0.2" {0}/>
    <body pos="0.3 0 0"><joint name="w" axis="1 0 0"/><geom name="disc" size="0.2" {0}/></body>
    </body></worldbody><actuator><motor joint="w"/></actuator>{1}</mujoco>"""
    mute = 'contype="0" conaffinity="0"'
    return mujoco.MjModel.from_xml_string(bare.format("" if xml == "loud" else mute, xml[4:]))


@pytest.mark.parametrize(
    "xml", ["loud", 'mute<contact><pair geom1="hull" geom2="disc"/></contact>']
)
def test_contacts_are_off_where_anything_could_touch(xml: str) -> None:
    with pytest.raises(ModelError, match="<flag contact>: geoms of rotors and bus would collide"):
        interpret(with_contact(xml), "contact")


def test_geoms_that_touch_nothing_need_no_flag() -> None:
    assert interpret(with_contact("mute"), "contact").spacecraft.wheels == 1


@pytest.mark.parametrize("bounds", ["-0.05 0.04", "0 0.05", "-0.05 0"])
@pytest.mark.parametrize("name", ["ctrlrange", "forcerange"])
def test_limits_are_symmetric_and_leave_a_torque(name: str, bounds: str) -> None:
    edit = plain_motor(**{name: bounds})
    with pytest.raises(
        ModelError, match=f"{name} {bounds} must be symmetric about zero and not em"
    ):
        read(edit)


def test_a_limit_of_nothing_leaves_no_wheel() -> None:
    """MuJoCo compiles no such range; a model edited in code may have one."""
    m = read().mj
    m.actuator_actrange[0] = 0.0
    with pytest.raises(ModelError, match="actrange 0 0 must be symmetric about zero and not empty"):
        interpret(m, "empty")


def test_a_limit_behind_a_gear_that_turns_the_other_way_is_its_size() -> None:
    motor = (
        MOTOR_X,
        """<general name="motor_x" joint="wheel_x" gear="-2 0 0 0 0 0" gainprm="-3"
    forcerange="-0.1 0.1" ctrlrange="-1 1"/>""",
    )
    model = read(motor)
    assert model.spacecraft.torque_max[0] == pytest.approx(0.2)
    assert model.wheels[0].gain == pytest.approx(6.0)


def test_two_joints_that_move_alike_are_refused() -> None:
    again = '<joint name="again" axis="1 0 0"/>'
    panel = PANEL.format("").replace('axis="1 0 0" />', f'axis="1 0 0"/>{again}')
    with pytest.raises(
        ModelError, match="joints 'hinge', 'again' move the same bodies in the same"
    ):
        read(behind(FREE, panel))


@pytest.mark.parametrize("far", ["1e9 0.000209489 4.59718", "0 1 1e9"])
def test_inertias_that_rounding_has_eaten_are_refused(far: str) -> None:
    """A part a million km away: of the bus's moments nothing is left, or less than nothing."""
    part = (
        f'<body pos="{far}"><inertial pos="0 0.4968 0.822754" mass="0.488" diaginertia="1 1 1"/>'
        "</body>"
    )
    with pytest.raises(
        ModelError, match=r"rounding leaves joint '.*' the inertia -?[0-9.e-]+: the"
    ):
        read(behind(FREE, part))
