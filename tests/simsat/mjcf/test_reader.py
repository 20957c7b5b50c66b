"""Reading spacecraft from MJCF: the numbers, and every refusal with its message."""

from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from simsat.control.ground.errors import ModelError
from simsat.control.ground.spacecraft import nominal
from simsat.mjcf import Drive, Model, interpret, read_model
from tests.places import MODELS

Edited = Callable[[Callable[[mujoco.MjSpec], None]], Model]

BENCHMARK_J = np.array([[1.620, 0.060, -0.050], [0.060, 1.488, 0.070], [-0.050, 0.070, 1.272]])

HEAD = """<mujoco><option integrator="RK4" gravity="0 0 0"/>
<option><flag autoreset="disable" contact="disable"/></option>"""
BARE = (
    HEAD
    + """<worldbody><body name="bus"><freejoint/>
  <inertial pos="0.1 0 0" mass="40" diaginertia="1.5 1.6 1.7"/>
  <body name="r" pos="0 0.2 0" euler="0 0 90">
    <inertial pos="0 0 0" mass="1" diaginertia="2e-3 1.2e-3 1.2e-3"/>
    <joint name="spin" axis="1 0 0"/></body>
</body></worldbody><actuator>{actuator}</actuator></mujoco>"""
)


def bare(actuator: str = '<motor joint="spin"/>') -> Model:
    return interpret(mujoco.MjModel.from_xml_string(BARE.format(actuator=actuator)), "bare")


def test_two_wheel_is_the_benchmark_spacecraft(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    assert craft.mass == pytest.approx(50.0, abs=1e-12)
    np.testing.assert_allclose(craft.J, BENCHMARK_J, atol=1e-14)
    np.testing.assert_allclose(craft.A, np.eye(3)[:, :2], atol=1e-15)
    np.testing.assert_allclose(craft.Js, 0.9 / (6000 * 2 * np.pi / 60), rtol=1e-12)
    np.testing.assert_allclose(craft.torque_max, 0.05)
    np.testing.assert_allclose(craft.torque_rate_max, 0.4)
    np.testing.assert_allclose(craft.momentum_max, 0.9, rtol=1e-12)
    np.testing.assert_allclose(craft.spin_up_time, 18.0, rtol=1e-12)
    assert craft.unactuated is not None
    np.testing.assert_allclose(craft.unactuated, [0, 0, 1], atol=1e-15)
    assert [wheel.drive for wheel in two_wheel.wheels] == [Drive.RATE, Drive.RATE]
    box = np.array([0.37, 0.41, 0.47])
    assert craft.surface.area.sum() == pytest.approx(box.sum() ** 2 - (box**2).sum())
    centre = (craft.surface.area @ craft.surface.centre_B) / craft.surface.area.sum()
    np.testing.assert_allclose(centre, [0.012, -0.010, 0.012], atol=1e-15)


def test_nominal_is_the_stated_diagonal_and_mismatch_scales_it(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    np.testing.assert_allclose(nominal(craft).J, np.diag([1.5, 1.6, 1.2]), atol=1e-12)
    np.testing.assert_allclose(nominal(craft, mismatch=0.0).J, craft.J, atol=1e-15)
    twice = nominal(craft, mismatch=2.0).J
    np.testing.assert_allclose(twice - craft.J, 2 * (nominal(craft).J - craft.J), atol=1e-12)
    own = nominal(craft, np.array([1.0, 1.0, 1.0])).J
    np.testing.assert_allclose(own, np.diag(np.diag(craft.J)), atol=1e-15)


def test_a_bare_file_has_no_limits_no_faces_and_inertia_about_the_centre_of_mass() -> None:
    craft = bare().spacecraft
    assert np.isinf([craft.torque_max, craft.torque_rate_max, craft.speed_max]).all()
    assert len(craft.surface.area) == 0
    np.testing.assert_allclose(craft.A[:, 0], [0, 1, 0], atol=1e-15)  # turned with its body
    # Bus and rotor as two point masses 0.1 m, 0.2 m from the origin, plus their own inertias.
    d = np.array([0.1, -0.2, 0.0])
    reduced = 40.0 * 1.0 / 41.0
    own = np.diag([1.5, 1.6, 1.7]) + np.diag([1.2e-3, 2e-3, 1.2e-3])
    expected = own + reduced * (d @ d * np.eye(3) - np.outer(d, d))
    np.testing.assert_allclose(craft.J, expected, atol=1e-12)


def test_a_plain_motor_with_gear_and_limits() -> None:
    craft = bare('<motor joint="spin" gear="2" ctrllimited="true" ctrlrange="-.1 .1"/>').spacecraft
    np.testing.assert_allclose(craft.torque_max, 0.2)
    assert np.isinf(craft.torque_rate_max).all()


@pytest.mark.parametrize("servo", ['<position joint="spin" kp="1"/>', '<velocity joint="spin"/>'])
def test_a_servo_is_no_torque_motor(servo: str) -> None:
    with pytest.raises(ModelError, match="number 1 is no torque motor: use <motor>"):
        bare(servo)


@pytest.mark.parametrize(("motor", "torque"), [("-0.03 0.03", 0.03), ("-0.2 0.2", 0.05)])
def test_the_tightest_torque_limit_counts(edited: Edited, motor: str, torque: float) -> None:
    def edit(spec: mujoco.MjSpec) -> None:
        joint = spec.joint("wheel_x")
        joint.actfrclimited, joint.actfrcrange = True, [float(v) for v in motor.split()]

    assert edited(edit).spacecraft.torque_max[0] == pytest.approx(torque)


def test_an_axis_tilts_with_the_joint_and_n_follows(edited: Edited) -> None:
    def edit(spec: mujoco.MjSpec) -> None:
        spec.joint("wheel_y").axis = [0.0, 1.0, 1.0]

    craft = edited(edit).spacecraft
    np.testing.assert_allclose(craft.A[:, 1], np.array([0, 1, 1]) / np.sqrt(2), atol=1e-12)
    assert craft.unactuated is not None
    np.testing.assert_allclose(craft.unactuated @ craft.A, 0.0, atol=1e-12)
    assert craft.actuation_rank == 2


def test_a_wheels_own_speed_limit_beats_the_common_one(edited: Edited) -> None:
    def edit(spec: mujoco.MjSpec) -> None:
        spec.add_numeric(name="wheel_y.speed_limit_rad_s", data=[100.0])

    np.testing.assert_allclose(edited(edit).spacecraft.speed_max, [200 * np.pi, 100.0])


def _armature(spec: mujoco.MjSpec) -> None:
    spec.joint("wheel_x").armature = 1e-3


def _damped_bus(spec: mujoco.MjSpec) -> None:
    spec.joint("bus_free").damping = [1.0, 0.0, 0.0]


def _sliding_wheel(spec: mujoco.MjSpec) -> None:
    spec.joint("wheel_x").type = mujoco.mjtJoint.mjJNT_SLIDE


def _ball(spec: mujoco.MjSpec) -> None:
    panel = spec.body("bus").add_body(name="panel", mass=1.0, inertia=[1, 1, 1])
    panel.explicitinertial = True
    panel.add_joint(name="hinge", type=mujoco.mjtJoint.mjJNT_BALL)


def _no_actuator(spec: mujoco.MjSpec) -> None:
    for actuator in list(spec.actuators):
        spec.delete(actuator)


def _on_site(spec: mujoco.MjSpec) -> None:
    spec.body("bus").add_site(name="thruster")
    actuator = spec.actuators[0]
    actuator.trntype, actuator.target = mujoco.mjtTrn.mjTRN_SITE, "thruster"


def _two_motors(spec: mujoco.MjSpec) -> None:
    spec.actuators[1].target = "wheel_x"


def _friction(spec: mujoco.MjSpec) -> None:
    spec.joint("wheel_x").frictionloss = 1e-3
    spec.option.tolerance = 1e-8


def _rpm_as_rad_s(spec: mujoco.MjSpec) -> None:
    spec.add_numeric(name="wheel_x.speed_limit_rad_s", data=[6000.0])


def _stiff(spec: mujoco.MjSpec) -> None:
    spec.joint("wheel_x").stiffness = [0.1, 0.0, 0.0]


def _imbalanced(spec: mujoco.MjSpec) -> None:
    spec.body("rotor_x").ipos = [0.0, 1e-4, 0.0]


def _tilted_joint(spec: mujoco.MjSpec) -> None:
    spec.joint("wheel_x").axis = [0.9, 0.3, 0.3]
    spec.body("rotor_x").inertia = [1.4e-3, 8e-4, 8e-4]


def _range(spec: mujoco.MjSpec) -> None:
    joint = spec.joint("wheel_x")
    joint.limited, joint.range = True, [-1.0, 1.0]


def _pulling_air(spec: mujoco.MjSpec) -> None:
    spec.numeric("drag_coefficient").data = [-2.0]


def _lopsided(spec: mujoco.MjSpec) -> None:
    spec.actuators[0].actrange = [-0.05, 0.04]


def _option(name: str, value: object) -> Callable[[mujoco.MjSpec], None]:
    return lambda spec: setattr(spec.option, name, value)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (_no_actuator, "no wheel"),
        (_armature, "'wheel_x' has armature 0.001"),
        (_damped_bus, "'bus_free' has damping"),
        (_sliding_wheel, "'wheel_x', a slide joint; a wheel is a hinge"),
        (_ball, "'hinge' is a ball joint"),
        (_on_site, "'motor_x' drives no wheel"),
        (_two_motors, "both drive joint 'wheel_x'"),
        (_friction, "tolerance='1e-08'> with frictionloss leaks momentum"),
        (_rpm_as_rad_s, "means 57,296 rpm for 'wheel_x'.*is the unit right"),
        (_stiff, "'wheel_x' has stiffness 0.1"),
        (_imbalanced, "'wheel_x' is imbalanced.*at most 0.0005 s"),
        (_tilted_joint, "'wheel_x' is imbalanced.*no principal axis.*not its joint"),
        (_range, "'wheel_x' has a range"),
        (_pulling_air, "numeric 'drag_coefficient' is -2, it must be one number from 0 to 10"),
        (_lopsided, "actrange -0.05 0.04 must be symmetric"),
        (_option("integrator", mujoco.mjtIntegrator.mjINT_EULER), "integrator='EULER'.*use 'RK4'"),
        (_option("gravity", [0.0, 0.0, -9.81]), "gravity='0 0 -9.81'"),
        (_option("density", 1.2), "density"),
        (_option("disableflags", mujoco.mjtDisableBit.mjDSBL_CONTACT), "autoreset='disable'"),
        (_option("disableflags", mujoco.mjtDisableBit.mjDSBL_AUTORESET), "contact='disable'"),
    ],
)
def test_refusals(edited: Edited, edit: Callable[[mujoco.MjSpec], None], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        edited(edit)


def test_a_missing_file_and_a_broken_one_name_the_place(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"no model file at '.*absent\.xml'"):
        read_model(tmp_path / "absent.xml")
    broken = tmp_path / "broken.xml"
    broken.write_text("<mujoco>\n<worldbody>\n<boddy/>\n</worldbody></mujoco>")
    with pytest.raises(ModelError, match=r"broken\.xml'.*boddy.*line 3"):
        read_model(broken)


def test_seven_wheels_are_refused() -> None:
    rotor = (
        '<body name="r{0}"><inertial pos="0 0 0" mass="1" diaginertia="2e-3 1e-3 1e-3"/>'
        '<joint name="w{0}" axis="1 0 0"/></body>'
    )
    xml = (
        HEAD
        + '<worldbody><body name="bus"><freejoint/><inertial pos="0 0 0" mass="40" '
        + 'diaginertia="1 1 1"/>'
        + "".join(rotor.format(i) for i in range(7))
        + "</body></worldbody><actuator>"
        + "".join(f'<motor joint="w{i}"/>' for i in range(7))
        + "</actuator></mujoco>"
    )
    with pytest.raises(ModelError, match="7 wheels; 1 to 6"):
        interpret(mujoco.MjModel.from_xml_string(xml), "seven")


@pytest.mark.parametrize("bodies", [0, 2])
def test_one_free_body_exactly(bodies: int) -> None:
    inertial = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    body = f"<body><freejoint/>{inertial}</body>"
    fixed = f'<body>{inertial}<joint name="w"/></body>'
    world = f"<worldbody>{body * bodies}{fixed}</worldbody>"
    xml = f'{HEAD}{world}<actuator><motor joint="w"/></actuator></mujoco>'
    with pytest.raises(ModelError, match=f"{bodies} free bodies"):
        interpret(mujoco.MjModel.from_xml_string(xml), "free")


@pytest.mark.parametrize(
    ("geom", "area"),
    [
        ('type="sphere" size="0.5"', np.pi),
        ('type="cylinder" size="0.5 0.7"', 2 * np.pi * 0.25 + 2 * np.pi * 0.5 * 1.4),
        ('type="capsule" size="0.5 0.7"', np.pi + 2 * np.pi * 0.5 * 1.4),
        ('type="box" size="0.5 0.6 0.7"', 8 * (0.3 + 0.35 + 0.42)),
        ('type="ellipsoid" size="0.5 0.5 0.5"', np.pi),
    ],
)
def test_faces_close_and_have_the_areas_of_their_shapes(geom: str, area: float) -> None:
    """Outward area vectors of a closed body add up to zero, and enclose the right volume's sign."""
    xml = BARE.format(actuator='<motor joint="spin"/>').replace(
        "<freejoint/>", f'<freejoint/><geom {geom} mass="0" euler="20 30 40"/>'
    )
    surface = interpret(mujoco.MjModel.from_xml_string(xml), "faces").spacecraft.surface
    np.testing.assert_allclose(surface.area @ surface.normal_B, 0.0, atol=1e-12)
    assert surface.area.sum() == pytest.approx(area, rel=0.02)  # facets of a round geom
    assert np.einsum("k,ki,ki->", surface.area, surface.centre_B, surface.normal_B) > 0.0


def test_file_text_spec_and_compiled_model_are_read_alike(two_wheel: Model) -> None:
    path = MODELS / "two_wheel" / "two_wheel.xml"
    for source in (mujoco.MjSpec.from_file(str(path)), mujoco.MjModel.from_xml_path(str(path))):
        model = interpret(source, "two_wheel")
        np.testing.assert_array_equal(model.spacecraft.J, two_wheel.spacecraft.J)
        assert model.spacecraft.fingerprint == two_wheel.spacecraft.fingerprint
