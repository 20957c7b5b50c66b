"""The same spacecraft at another size: inertia times a factor, time times another."""

from dataclasses import replace

import mujoco
import numpy as np

from simsat.control.ground.spacecraft import Spacecraft
from simsat.mjcf.shipped import find_model


def scaled_model(name: str, inertia: float, time: float, damping: float = 0.0) -> mujoco.MjSpec:
    """A shipped rigid spacecraft made `inertia` times as heavy and `time` times as slow, after its
    wheels were given viscous friction of `damping` (Nms/rad)."""
    torque = inertia / time**2
    spec = mujoco.MjSpec.from_file(str(find_model(name)))
    spec.option.timestep *= time
    for body in spec.bodies[1:]:
        body.mass, body.inertia = body.mass * inertia, body.inertia * inertia
        body.fullinertia = body.fullinertia * inertia
    for geom in spec.geoms:
        geom.mass = geom.mass * inertia
    for joint in spec.joints[1:]:
        joint.damping = np.array([damping, 0.0, 0.0]) * torque * time
        joint.frictionloss = joint.frictionloss * torque
    for actuator in spec.actuators:
        actuator.actrange = np.array(actuator.actrange) * torque
        actuator.ctrlrange = np.array(actuator.ctrlrange) * torque / time
    speed = next(numeric for numeric in spec.numerics if numeric.name == "speed_limit_rpm")
    speed.data = np.array(speed.data) / time
    return spec


def scaled_numbers(craft: Spacecraft, inertia: float, time: float) -> Spacecraft:
    """The same of the numbers alone, by no code of the project."""
    torque = inertia / time**2
    return replace(
        craft,
        J=craft.J * inertia,
        Js=craft.Js * inertia,
        torque_max=craft.torque_max * torque,
        torque_rate_max=craft.torque_rate_max * torque / time,
        speed_max=craft.speed_max / time,
        viscous=craft.viscous * torque * time,
        coulomb=craft.coulomb * torque,
    )
