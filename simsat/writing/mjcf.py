"""The text of a spacecraft file."""

from collections.abc import Iterable, Iterator

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.writing.bus import Body, without
from simsat.writing.figures import BoxFigures, Figures, WheelFigures

HEAD = """\
<mujoco model="{name}">
  <!-- Free space: models/README.md says why each of these lines. -->
  <option integrator="RK4" timestep="{timestep}" gravity="0 0 0" tolerance="1e-15"/>
  <option><flag contact="disable" autoreset="disable"/></option>
  <compiler angle="radian"/>

  <custom>
{custom}
  </custom>

  <worldbody>
    <body name="bus">
      <freejoint name="bus_free"/>
      <!-- the bus without its rotors: with them it weighs {mass} kg, J about the centre of mass is
           xx yy zz xy xz yz {inertia} kg m^2 -->
      <inertial mass="{bus_mass}" pos="{bus_centre}"
                fullinertia="{bus_inertia}"/>
{bodies}
    </body>
  </worldbody>

  <actuator>
{motors}
  </actuator>
</mujoco>
"""


def spacecraft_file(figures: Figures) -> str:
    """The MJCF file of a spacecraft.

    Raises `ModelError` if nothing that exists is left of it without its rotors.
    """
    bus = without(figures.whole, [wheel.rotor for wheel in figures.wheels])
    box = [] if figures.box is None else [_box(figures.box)]
    return HEAD.format(
        name=escaped(figures.name),
        timestep=repr(figures.timestep),
        custom="\n".join(_custom(figures)),
        mass=_shown([figures.whole.mass]),
        inertia=_shown(_products(figures.whole)),
        bus_mass=_exact([bus.mass]),
        bus_centre=_exact(bus.centre),
        bus_inertia=_exact(_products(bus)),
        bodies="\n".join([*box, *map(_rotor, figures.wheels)]),
        motors="\n".join(map(_motor, figures.wheels)),
    )


def escaped(name: str) -> str:
    """A name as it may stand in an attribute."""
    return "".join(f"&#{ord(c)};" if c in "&<>\"'" else c for c in name)


def _custom(figures: Figures) -> Iterator[str]:
    factors = figures.nominal_inertia_factors
    if factors is not None:
        yield "    <!-- what the designer believes of the inertia: factors on its diagonal -->"
        yield f'    <numeric name="nominal_inertia_factors" data="{_exact(factors)}"/>'
    for wheel in figures.wheels:
        if (limit := wheel.speed_limit_rpm) is not None:
            name = escaped(f"{wheel.name}.speed_limit_rpm")
            yield f'    <numeric name="{name}" data="{_exact([limit])}"/>'
        if wheel.torque_envelope_rpm:
            name, data = escaped(f"{wheel.name}.torque_envelope_rpm"), wheel.torque_envelope_rpm
            yield f'    <numeric name="{name}" data="{_exact(data)}"/>'


def _box(box: BoxFigures) -> str:
    half = [0.5 * length for length in box.size]
    return (
        f'      <geom name="hull" type="box" size="{_exact(half)}" pos="{_exact(box.position)}" '
        'mass="0" rgba="0.55 0.58 0.65 0.35"/>'
    )


def _rotor(wheel: WheelFigures) -> str:
    friction = _attributes(damping=wheel.viscous, frictionloss=wheel.coulomb)
    radius = float(np.sqrt(2.0 * wheel.Js / wheel.mass))  # of a disc with this inertia
    name = escaped(wheel.name)
    return f"""\
      <body name="{name}_rotor" pos="{_exact(wheel.position)}" zaxis="{_exact(wheel.direction)}">
        <inertial pos="0 0 0" mass="{_exact([wheel.mass])}" diaginertia="{_exact(wheel.moments)}"/>
        <joint name="{name}" type="hinge" axis="0 0 1"{friction}/>
        <geom type="cylinder" size="{_shown([radius, 0.2 * radius])}" mass="0" group="2"
              rgba="0.85 0.65 0.2 1"/>
      </body>"""


def _motor(wheel: WheelFigures) -> str:
    name = escaped(wheel.name)
    torque, rate = (_range(limit) for limit in (wheel.torque, wheel.torque_rate))
    if rate is None:
        limit = "" if torque is None else f' ctrllimited="true" ctrlrange="{torque}"'
        return f'    <motor name="{name}_motor" joint="{name}"{limit}/>'
    limit = "" if torque is None else f' actlimited="true" actrange="{torque}"'
    return (
        f'    <general name="{name}_motor" joint="{name}" dyntype="integrator" gainprm="1"'
        f' ctrllimited="true" ctrlrange="{rate}"{limit}/>'
    )


def _range(limit: float | None) -> str | None:
    return None if limit is None else _exact([-limit, limit])


def _attributes(**values: float) -> str:
    return "".join(f' {name}="{_exact([value])}"' for name, value in values.items() if value)


def _products(body: Body) -> Array:
    """xx yy zz xy xz yz."""
    return body.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def _exact(values: Iterable[float]) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)


def _shown(values: Iterable[float]) -> str:
    return " ".join(f"{value:g}" for value in values)
