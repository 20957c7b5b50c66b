"""The two-wheel spacecraft's file with its text edited, as a user would."""

import mujoco

from simsat.mjcf import Model, interpret
from tests.places import MODELS

FOLDER = MODELS / "two_wheel"

JOINT_X = '<joint name="wheel_x" class="wheel" axis="1 0 0"/>'
MOTOR_X = '<general name="motor_x" class="wheel" joint="wheel_x"/>'
BUS = '<body name="bus">'
FREE = '<freejoint name="bus_free"/>'
WORLD = "<worldbody>"
END = "</mujoco>"
ROTOR_X = '<geom name="rotor_x_mark" class="mark" euler="0 1.5707963267948966 0"/>'
"""The last line of the rotor's body: what is put behind it hangs on the rotor."""


def text(*edits: tuple[str, str]) -> str:
    """The file after replacements, each of a place that it has once."""
    xml = (FOLDER / "two_wheel.xml").read_text().replace('file="../', f'file="{MODELS}/')
    for old, new in edits:
        assert xml.count(old) == 1, f"{xml.count(old)} places like {old}"
        xml = xml.replace(old, new)
    return xml


def read(*edits: tuple[str, str]) -> Model:
    """The edited file, read."""
    return interpret(mujoco.MjModel.from_xml_string(text(*edits)), "edited")


def behind(old: str, new: str) -> tuple[str, str]:
    """An edit that puts something behind a place."""
    return old, old + new


def at_end(new: str) -> tuple[str, str]:
    """An edit that puts something before the end of the file."""
    return END, new + END


def motor_x(**settings: str) -> tuple[str, str]:
    """An edit that gives the motor of wheel x some attributes."""
    return MOTOR_X, MOTOR_X.replace("/>", " " + attributes(settings) + "/>")


def joint_x(**settings: str) -> tuple[str, str]:
    """An edit that gives the joint of wheel x some attributes."""
    return JOINT_X, JOINT_X.replace("/>", " " + attributes(settings) + "/>")


def unused(*names: str) -> tuple[str, str]:
    """An edit that declares actuators unused."""
    data = " ".join(names)
    return at_end(f'<custom><text name="unused_actuators" data="{data}"/></custom>')


def attributes(settings: dict[str, str]) -> str:
    """As they stand in a tag."""
    return " ".join(f'{name}="{value}"' for name, value in settings.items())
