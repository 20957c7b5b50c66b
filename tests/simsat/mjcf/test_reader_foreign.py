"""The allow-list: what nobody interprets is refused, whatever MuJoCo calls it, now or later."""

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from simsat.control.ground.errors import ModelError
from simsat.mjcf import Model, interpret
from simsat.mjcf.refusals.allowed import ALLOWED, GROUPS
from simsat.mjcf.refusals.foreign import fields, foreign_settings, not_finite
from tests.simsat.mjcf.edits import BUS, FREE, WORLD, at_end, behind, joint_x, motor_x, read, text

SITES = (
    behind(WORLD, '<site name="ws" pos="1 0 0"/>'),
    behind(BUS, '<site name="bs" pos="0.2 0.1 0"/>'),
)
FIXED = '<tendon><fixed name="t" {}><joint joint="wheel_x" coef="1"/></fixed></tendon>'
SPATIAL = '<tendon><spatial name="t" {}><site site="ws"/><site site="bs"/></spatial></tendon>'
CONNECT = '<equality><connect name="pin" body1="bus" anchor="0.1 0 0"/></equality>'
LOCK = '<equality><joint joint1="wheel_x" polycoef="0 0 0 0 0"/></equality>'
COUPLE = '<equality><joint name="gears" joint1="wheel_x" joint2="wheel_y"/></equality>'
FLEX = '<flexcomp name="sail" type="grid" count="3 3 1" spacing=".1 .1 .1" radius=".01" mass="1"/>'
TREAD = '<geom size="0.01" mass="0" surfacevel="1 0 0 0 0 0"/>'
STIFF = """<body name="p" pos="0 .3 0"><joint name="hinge" axis="1 0 0" stiffness="1e4"/>
<geom type="box" size=".2 .3 .005" pos="0 .3 0" mass="1"/></body>"""
FLAT = 'springlength="0.1"'


@pytest.mark.parametrize(
    ("edits", "message"),
    [
        (
            [at_end('<equality><weld body1="bus"/></equality>')],
            "number 1 would hold the spacecraft",
        ),
        ([at_end(CONNECT)], "'pin' would hold the spacecraft or tie its parts"),
        ([at_end(LOCK)], "equality constraint number 1 would hold the spacecraft"),
        ([at_end(COUPLE)], "equality constraint 'gears' would hold the spacecraft"),
        ([*SITES, at_end(SPATIAL.format(f'stiffness="10" {FLAT}'))], "'t' has stiffness 10"),
        ([*SITES, at_end(SPATIAL.format('damping="1"'))], "'t' has damping 1; tendons that"),
        ([*SITES, at_end(SPATIAL.format('range="0 0.2"'))], "'t' has limited 1"),
        ([at_end(FIXED.format('stiffness="0 1 0"'))], "'t' has stiffnesspoly 1 0"),
        ([at_end(FIXED.format('frictionloss="1"'))], "'t' has frictionloss 1"),
        ([at_end(FIXED.format('armature="1"'))], "'t' has armature 1"),
        ([motor_x(armature="0.01")], "actuator 'motor_x' has armature 0.01.*reaction on the bus"),
        ([motor_x(damping="0.01")], "actuator 'motor_x' has damping 0.01; friction is read from"),
        ([motor_x(damping="0 0 1")], "actuator 'motor_x' has damping 0 1"),
        ([motor_x(delay="0.1", nsample="10")], "actuator 'motor_x' has a delay"),
        ([motor_x(nsample="10")], "actuator 'motor_x' has a delay.*nsample"),
        ([motor_x(actearly="true")], "actuator 'motor_x': actuator_actearly is 1"),
        ([motor_x(gear="1 2 0 0 0 0")], "actuator 'motor_x': actuator_gear is 2 0 0 0 0"),
        ([motor_x(biasprm="0 1")], "actuator 'motor_x': actuator_biasprm is 0 1 0"),
        ([joint_x(armature="0.001")], "joint 'wheel_x' has armature 0.001"),
        ([joint_x(stiffness="0 1 1")], "joint 'wheel_x' has a damping or stiffness.*polynomial"),
        ([joint_x(damping="0 1 1")], "joint 'wheel_x' has a damping or stiffness.*polynomial"),
        ([joint_x(stiffness="1", springyield="0.1")], "joint 'wheel_x' has a springyield"),
        ([joint_x(solreffriction="0.5 1")], "joint 'wheel_x' has a solreffriction"),
        ([(FREE, '<joint name="free" type="free" damping="0 .1 .1"/>')], "'free' has a damping or"),
        ([(FREE, '<joint name="free" type="free" stiffness="0 1 1"/>')], "'free' has a damping or"),
        ([(BUS, '<body name="bus" gravcomp="1">')], "gravcomp: there is no gravity to compensate"),
        ([at_end('<option actuatorgroupdisable="0"/>')], "<option actuatorgroupdisable>"),
        ([at_end('<option noslip_iterations="3"/>')], "<option noslip_iterations='3'>"),
        ([behind(FREE, TREAD)], "geom number 1 has a surfacevel, adhesion or fluidshape"),
        ([behind(WORLD, FLEX)], r"flexible bodies \(<flex>"),
    ],
)
def test_what_is_not_interpreted_is_refused(edits: list[tuple[str, str]], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read(*edits)


def test_every_fault_of_a_file_is_in_one_message() -> None:
    with pytest.raises(ModelError) as refusal:
        read(
            motor_x(armature="0.01", ctrlrange="-0.4 0.3", forcerange="-1 2"),
            joint_x(stiffness="0 1 1", damping="-1"),
            at_end('<equality><weld body1="bus"/></equality><option gravity="0 0 -9.81"/>'),
            at_end('<custom><numeric name="drag_coefficient_" data="3"/></custom>'),
            behind(FREE, STIFF),
        )
    message = str(refusal.value)
    for part in (
        "9 faults:", "'hinge' swings at",
        "has armature 0.01", "ctrlrange -0.4 0.3", "forcerange -1 2", "polynomial",
        "damping -1", "would hold the spacecraft", "gravity='0 0 -9.81'",
        "mean 'drag_coefficient'?",
    ):  # fmt: skip
        assert part in message
    assert len(message.splitlines()) == 10


def test_one_sentence_names_all_elements_of_a_cause() -> None:
    y = '<joint name="wheel_y" class="wheel"'
    with pytest.raises(ModelError, match=r"^joints 'wheel_x', 'wheel_y' have armature 0\.001, wh"):
        read(joint_x(armature="0.001"), (y, y + ' armature="0.001"'))


# Every field of the compiled model


class Copy:
    """A compiled model's numbers, to be changed without a compiler's leave."""

    def __init__(self, m: mujoco.MjModel, **changed: Any):
        self._m, self._changed = m, changed

    def __getattr__(self, name: str) -> Any:
        return self._changed[name] if name in self._changed else getattr(self._m, name)

    def __dir__(self) -> list[str]:
        return sorted({*dir(self._m), *self._changed})


FULL = text(
    *SITES,
    at_end(SPATIAL.format("")),
    at_end('<equality><weld body1="bus" active="false"/></equality>'),
)
MODEL = mujoco.MjModel.from_xml_string(FULL)


def test_the_file_with_one_of_everything_is_flown() -> None:
    model = interpret(MODEL, "full")
    assert model.ignored == ("tendon 't'", "inactive equality (1)")


@pytest.mark.parametrize(
    "field",
    [f for f in fields(MODEL) if f not in ALLOWED and not GROUPS.fullmatch(f) and "opt." not in f],
)
def test_a_field_that_is_on_no_list_must_be_as_mujoco_leaves_it(field: str) -> None:
    """Every one of them is changed once: a number more, or a row that an empty table lacks."""
    value = fields(MODEL)[field]
    changed = value + 3 if value.size else np.full((1, *value.shape[1:]), 3.0)
    assert list(foreign_settings(MODEL)) == []
    assert len(list(foreign_settings(Copy(MODEL, **{field: changed})))) == 1


@pytest.mark.parametrize(
    ("name", "value"),
    [("dof_warp", np.array([0.0] * 7 + [0.3])), ("nwarp", 2), ("flg_warp", True),
     ("warp_factor", np.ones((2, 3)))],
)  # fmt: skip
def test_a_setting_of_a_later_mujoco_is_refused(name: str, value: Any) -> None:
    with pytest.raises(StopIteration):
        next(foreign_settings(Copy(MODEL)))
    message = next(foreign_settings(Copy(MODEL, **{name: value})))
    assert f"{name} is" in message
    assert "not interpreted here" in message


def test_a_later_option_is_refused() -> None:
    known = {name: getattr(MODEL.opt, name) for name in dir(MODEL.opt) if name[0] != "_"}
    later = Copy(MODEL, opt=SimpleNamespace(**known, warp=1.0))
    message = next(foreign_settings(later))
    assert message.startswith("<option warp> is 1, which is not interpreted here")


def test_no_list_names_a_field_that_mujoco_does_not_have() -> None:
    assert fields(MODEL).keys() >= ALLOWED


# Numbers that are none


DRAG = '<numeric name="drag_coefficient" data="{}"/>'


@pytest.mark.parametrize("number", ["nan", "inf", "-inf"])
@pytest.mark.parametrize(
    ("edit", "field"),
    [
        (at_end('<option timestep="{}"/>'), "<option timestep>"),
        (joint_x(damping="{}"), "dof_damping"),
        (behind(BUS, '<body name="b" pos="{} 0 0"/>'), "body_pos"),
        ((DRAG.format("2.2"), DRAG), "numeric 'drag_coefficient' is"),
    ],
)
def test_no_number_is_nan_or_infinite(number: str, edit: tuple[str, str], field: str) -> None:
    with pytest.raises(ModelError, match=field):
        read((edit[0], edit[1].format(number)))


def test_a_nan_that_mujoco_replaces_is_refused_too(two_wheel: Model) -> None:
    warning = "XML contains a 'NaN'. Please check it carefully."
    assert list(not_finite(two_wheel.mj)) == []
    with pytest.raises(ModelError, match="given as 'nan', for which MuJoCo would take another"):
        interpret(two_wheel.mj, "replaced", (warning,))
