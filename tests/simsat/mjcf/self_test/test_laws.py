"""The self-test: what a wrong model breaks is seen with every list of refusals switched off."""

from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from simsat.control.ground.errors import ModelError
from simsat.mjcf import Model, interpret, reader
from simsat.mjcf.rotors import read_rotor
from simsat.mjcf.self_test.bench import Bench
from simsat.mjcf.self_test.laws import flown_otherwise
from simsat.mjcf.shipped import find_model, shipped_models
from tests.reference_cases import spacecraft_xml
from tests.simsat.mjcf.edits import (
    BUS,
    FREE,
    ROTOR_X,
    WORLD,
    at_end,
    attributes,
    behind,
    joint_x,
    motor_x,
    read,
    text,
)

NAMES = [name for name in shipped_models() if find_model(name).parent.name == name]
LISTS = ("foreign_settings", "wrong_options", "wrong_joints", "wrong_rotors", "unseen_turns",
         "unseen_swings", "unseen_nutation", "wrong_timestep")  # fmt: skip


@pytest.fixture
def no_lists(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is refused for what it is, only for how it flies."""

    def nothing(*_: object) -> Iterator[str]:
        return iter(())

    for name in LISTS:
        monkeypatch.setattr(reader, name, nothing)


FIXED = """<tendon><fixed stiffness="1"><joint joint="wheel_x" coef="1"/></fixed></tendon>"""
SITES = (
    behind(WORLD, '<site name="ws" pos="1 0 0"/>'),
    behind(BUS, '<site name="bs" pos="0.2 0.1 0"/>'),
)
TENDON = """<tendon><spatial name="t" stiffness="10" springlength="0.1"><site site="ws"/>
<site site="bs"/></spatial></tendon>"""
LUMP = """<body name="l" pos="0 0.01 0">
<inertial pos="0 0 0" mass="0.01" diaginertia="1e-6 1e-6 1e-6"/></body>"""


def held(**settings: str) -> tuple[str, str]:
    return FREE, f'<joint name="bus_free" type="free" {attributes(settings)}/>'


def flag(name: str) -> tuple[str, str]:
    return at_end(f'<option><flag {name}="disable"/></option>')


def tied(tag: str, settings: str) -> tuple[str, str]:
    return at_end(f"<equality><{tag} {settings}/></equality>")


@pytest.mark.usefixtures("no_lists")
@pytest.mark.parametrize(
    ("edits", "message"),
    [
        ([tied("weld", 'body1="bus"')], "coasting the total momentum changes"),
        ([tied("connect", 'body1="bus" anchor="0 0 0"')], "momentum changes"),
        ([*SITES, at_end(TENDON)], "the total linear momentum changes by"),
        ([tied("joint", 'joint1="wheel_x"')], "the rotor of 'wheel_x' gains"),
        ([tied("joint", 'joint1="wheel_x" joint2="wheel_y"')], "rotor of 'wheel"),
        ([motor_x(armature="0.01")], "momentum of a turning 'wheel_x' is off by 87 %"),
        ([joint_x(armature="1e-5")], "the momentum of a turning 'wheel_x' is off by 0.69 %"),
        ([motor_x(damping="0.01")], "coasting the rotor of 'wheel_x' gains"),
        ([motor_x(delay="0.1", nsample="20")], "under torque the rotor of 'wheel_x' gains"),
        ([joint_x(damping="0 1e-7 0")], "coasting the rotor of 'wheel_x' gains"),
        ([joint_x(stiffness="0.01")], "coasting the rotor of 'wheel_x' gains"),
        ([held(damping="0.1")], "coasting the total momentum changes"),
        ([held(damping="0 0.1 0.1")], "coasting the total momentum changes"),
        ([held(stiffness="1")], "coasting the total linear momentum changes"),
        ([held(frictionloss="1e-3")], "coasting the total momentum changes"),
        ([held(armature="1")], "J is off by"),
        ([joint_x(frictionloss="1e-3"), flag("frictionloss")], "off what motor and friction give"),
        ([joint_x(damping="1e-3"), flag("damper")], "coasting the rotor of 'wheel_x' gains"),
        ([flag("actuation")], "motors at their limits the force"),
        ([at_end('<option actuatorgroupdisable="0"/>')], "the force on joint 'wheel_x' is off"),
        ([at_end('<option gravity="0 0 -1e-6"/>')], "the total linear momentum changes"),
        ([at_end('<option density="1e-3"/>')], "coasting the total momentum changes"),
        ([at_end('<option integrator="Euler"/>')], "coasting the total momentum changes"),
        ([at_end('<option integrator="implicitfast"/>')], "coasting the total momentum changes"),
        ([behind(ROTOR_X, LUMP)], "coasting the total momentum changes .* is too long"),
        ([at_end(FIXED)], "the rotor of 'wheel_x' gains"),
    ],
)
def test_a_broken_law_is_seen(edits: list[tuple[str, str]], message: str) -> None:
    with pytest.raises(
        ModelError, match=f"MuJoCo does not fly this file as it was read: .*{message}"
    ):
        read(*edits)


CUBE = spacecraft_xml(
    "cube", 2e-3 * np.eye(3), np.eye(3), np.array(2e-4), np.array(1.2e-4), step=0.05
)


def cube(limit_rpm: float, step: float) -> mujoco.MjModel:
    """A cubesat whose wheels hold much: at 3000 rpm they make it nutate at 40 rad/s."""
    limit = f'<custom><numeric name="speed_limit_rpm" data="{limit_rpm}"/></custom></mujoco>'
    xml = CUBE.replace("</mujoco>", limit).replace('"0.05"', f'"{step}"')
    return mujoco.MjModel.from_xml_string(xml)


@pytest.mark.usefixtures("no_lists")
def test_nutation_that_the_step_damps_away_is_seen_though_momentum_is_kept() -> None:
    with pytest.raises(ModelError) as refusal:
        interpret(cube(3000.0, 0.05), "cube")
    assert "the body rates are" in str(refusal.value)
    assert "off those with half the step; <option timestep='0.05'> is too long" in str(
        refusal.value
    )
    assert "momentum" not in str(refusal.value)


def test_nutation_at_a_twentieth_of_a_turn_per_step_is_flown() -> None:
    with pytest.raises(ModelError, match=r"nutates at 48\.6 rad/s.* must be at most 0\.00646 s"):
        interpret(cube(3000.0, 0.05), "cube")
    assert interpret(cube(3000.0, 0.00646), "cube").spacecraft.wheels == 3


def test_a_wrong_reading_is_seen(two_wheel: Model) -> None:
    """The same laws judge the reader: numbers that are not the model's are named."""
    rotors = [read_rotor(two_wheel.mj, wheel.joint) for wheel in two_wheel.wheels]
    craft = two_wheel.spacecraft

    def found(**wrong: object) -> str:
        read_wrongly = replace(craft, **wrong)  # type: ignore[arg-type]
        m, free = two_wheel.to_step(), two_wheel.free_joint
        return " ".join(flown_otherwise(m, free, two_wheel.wheels, rotors, read_wrongly))

    assert found() == ""
    assert "J is off by 0.00062 %" in found(J=craft.J + 1e-5 * np.diag([0.0, 1.0, 0.0]))
    assert "momentum of a turning 'wheel_y' is off by 0.1 %" in found(Js=craft.Js * [1.0, 1.001])
    assert "momentum of a turning 'wheel_x' is off by" in found(A=-craft.A)
    assert "the rotor of 'wheel_x' gains" in found(viscous=np.array([1e-7, 0.0]))
    assert "the rotor of 'wheel_y' gains" in found(coulomb=np.array([0.0, 1e-6]))


def test_a_rotor_that_is_not_as_round_as_believed_is_seen_once_it_has_turned(
    two_wheel: Model,
) -> None:
    """Its J is right at the reference, and moves with its angle."""
    spec = mujoco.MjSpec.from_string(text(at_end('<option timestep="0.0004"/>')))
    inertia = 0.001432394487827058
    spec.body("rotor_x").inertia = [inertia, 0.7 * inertia, 0.709 * inertia]
    model = interpret(spec, "flat")
    rotors = [read_rotor(two_wheel.mj, wheel.joint) for wheel in two_wheel.wheels]
    m, free, craft = model.to_step(), model.free_joint, model.spacecraft
    faults = " ".join(flown_otherwise(m, free, model.wheels, rotors, craft))
    assert "coasting J w + A Js Omega misses" in faults
    assert "total momentum" not in faults


def test_mujoco_s_own_warnings_break_a_flight_off(two_wheel: Model) -> None:
    rotors = [read_rotor(two_wheel.mj, wheel.joint) for wheel in two_wheel.wheels]
    bench = Bench(two_wheel.to_step(), two_wheel.free_joint, two_wheel.wheels, rotors,
                  two_wheel.spacecraft)  # fmt: skip
    bench.start(np.zeros(two_wheel.mj.nv))
    bench.step()
    assert bench.breakdown() == ""
    bench.start(np.full(two_wheel.mj.nv, 1e11))
    bench.step()
    assert bench.breakdown() not in ("", "a rate is not finite")


def test_a_torque_that_the_file_s_own_limits_take_away_is_seen(two_wheel: Model) -> None:
    model = read(motor_x(forcerange="-0.03 0.03"))
    assert model.spacecraft.torque_max[0] == 0.03
    rotors = [read_rotor(model.mj, wheel.joint) for wheel in model.wheels]
    stronger = replace(model.spacecraft, torque_max=np.array([0.05, 0.05]))
    faults = " ".join(
        flown_otherwise(model.to_step(), model.free_joint, model.wheels, rotors, stronger)
    )
    assert "the force on joint 'wheel_x' is off by 0.02 Nm" in faults


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("power", [-6, -3, 3, 6])
def test_honest_spacecraft_of_any_size_pass(name: str, power: int) -> None:
    """Masses, torques, springs and friction by powers of ten: the same flight, other numbers."""
    factor = 10.0**power
    spec = mujoco.MjSpec.from_file(str(find_model(name)))
    for body in spec.bodies[1:]:
        body.mass, body.inertia = body.mass * factor, body.inertia * factor
        body.fullinertia = body.fullinertia * factor
    for geom in spec.geoms:
        geom.mass = geom.mass * factor
    for joint in spec.joints:
        joint.stiffness, joint.damping = joint.stiffness * factor, joint.damping * factor
        joint.frictionloss = joint.frictionloss * factor
    for actuator in spec.actuators:
        actuator.actrange = np.array(actuator.actrange) * factor
        actuator.ctrlrange = np.array(actuator.ctrlrange) * factor
    scaled, plain = interpret(spec.compile(), name), interpret(_plain(name), name)
    J = factor * plain.spacecraft.J
    np.testing.assert_allclose(scaled.spacecraft.J, J, rtol=1e-9, atol=1e-14 * J.max())
    np.testing.assert_allclose(scaled.spacecraft.torque_max, factor * plain.spacecraft.torque_max)


def _plain(name: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(find_model(name)))


def test_a_spring_that_starts_out_of_its_rest_is_flown() -> None:
    panel = """<body name="p" pos="0 0.3 0">
    <joint name="h" axis="1 0 0" stiffness="1" springref="0.5" range="-1 1"/>
    <geom type="box" size="0.2 0.3 0.005" pos="0 0.3 0" mass="5"/></body>"""
    assert read(behind(FREE, panel)).passive_joints == ("h",)


def test_friction_that_stops_a_wheel_at_once_is_flown() -> None:
    """It holds more than the motor pushes: an odd wheel, but flown as it was read."""
    assert read(joint_x(frictionloss="5")).spacecraft.coulomb[0] == 5.0


def test_the_text_of_the_file_is_all_that_counts() -> None:
    first, second = interpret(_text(), "a"), interpret(_text(), "a")
    np.testing.assert_array_equal(first.spacecraft.J, second.spacecraft.J)
    assert first.spacecraft.fingerprint == second.spacecraft.fingerprint


def _text() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(text())
