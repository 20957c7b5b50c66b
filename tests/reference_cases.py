"""The reference trajectories (tests/reference) and a spacecraft file for each of them."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.environment import EnvironmentSettings, OrbitSettings
from tests.places import REFERENCE

FOLDER = REFERENCE
NAMES = ("a_diag_2rw", "b_full_2rw", "c_gg_2rw", "d1_viscous", "f_bias_2rw")
NO_TORQUE = EnvironmentSettings(gravity_gradient=False, drag=False)
GRAVITY_GRADIENT = EnvironmentSettings(gravity_gradient=True, drag=False)

SPACECRAFT = """
<mujoco model="{name}">
  <option integrator="RK4" timestep="{step}" gravity="0 0 0" tolerance="1e-15">
    <flag contact="disable" autoreset="disable"/>
  </option>
  <worldbody>
    <body name="bus">
      <freejoint name="free"/>
      <inertial pos="0 0 0" mass="48" fullinertia="{hub}"/>
{rotors}
    </body>
  </worldbody>
  <actuator>
{motors}
  </actuator>
</mujoco>
"""

ROTOR = """      <body name="rotor_{i}" quat="{quat}">
        <inertial pos="0 0 0" mass="1" diaginertia="{Jt!r} {Jt!r} {Js!r}"/>
        <joint name="wheel_{i}" type="hinge" axis="0 0 1" damping="{damping!r}"/>
      </body>"""

MOTOR = '    <motor name="motor_{i}" joint="wheel_{i}" gear="1"/>'


@dataclass(frozen=True)
class Case:
    """One reference trajectory."""

    name: str
    path: Path
    data: dict[str, Array]
    orbit: OrbitSettings
    environment: EnvironmentSettings
    xml: str


def load_case(name: str) -> Case:
    path = FOLDER / f"{name}.npz"
    with np.load(path) as archive:
        data = {key: archive[key] for key in archive.files if key != "meta"}
        meta = json.loads(str(archive["meta"]))
    orbit, environment = OrbitSettings(), NO_TORQUE
    if meta["orbit"] is not None:
        o = meta["orbit"]
        orbit = OrbitSettings(o["alt_km"], o["inc_deg"], o["raan_deg"], o["u0_deg"])
        environment = GRAVITY_GRADIENT
    friction = meta["friction"] or {"cv": 0.0}
    xml = spacecraft_xml(name, data["J_hub"], data["g"], data["Js"], data["Jt"], friction["cv"])
    return Case(name, path, data, orbit, environment, xml)


def spacecraft_xml(
    name: str,
    J_hub: Array,
    axes: Array,
    Js: Array,
    Jt: Array,
    viscous: float = 0.0,
    step: float = 0.01,
) -> str:
    """A file with rotors at the centre of mass: `axes` one per row, `J_hub` without the rotors."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = J_hub.tolist()
    hub = " ".join(map(repr, (xx, yy, zz, xy, xz, yz)))
    wheels = range(len(axes))
    rotors = [
        ROTOR.format(i=i, quat=_row(_onto(axes[i])), Js=float(Js), Jt=float(Jt), damping=viscous)
        for i in wheels
    ]
    motors = [MOTOR.format(i=i) for i in wheels]
    return SPACECRAFT.format(
        name=name, step=step, hub=hub, rotors="\n".join(rotors), motors="\n".join(motors)
    )


def _onto(axis: Array) -> Array:
    """Quaternion that turns z onto an axis (not -z)."""
    half = np.array([1.0 + axis[2], -axis[1], axis[0], 0.0])
    return half / np.linalg.norm(half)


def _row(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def angle_deg(q: Array, q_reference: Array) -> Array:
    """Angle between attitudes of either sign, degrees, accurate to 1e-14."""
    sign = np.where(np.sum(q * q_reference, axis=1) < 0.0, -1.0, 1.0)[:, None]
    apart = np.linalg.norm(q - sign * q_reference, axis=1)
    together = np.linalg.norm(q + sign * q_reference, axis=1)
    return np.degrees(4.0 * np.arctan2(apart, together))
