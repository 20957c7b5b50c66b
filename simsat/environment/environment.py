"""The torques that the surroundings put on the spacecraft, for the plant and for the log."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from simsat.control.ground.arrays import Array, Matrix3, Quaternion, Vector3
from simsat.control.ground.settings import Bounds, Settings
from simsat.control.ground.spacecraft import Spacecraft
from simsat.environment import earth
from simsat.environment.atmosphere import Density, density_of_altitude, nrlmsis_density
from simsat.environment.components import Triple, added, inertial_to_body
from simsat.environment.drag import drag
from simsat.environment.fields.dipole import dipole_field
from simsat.environment.fields.field import MagneticField
from simsat.environment.fields.igrf import igrf_field
from simsat.environment.gravity_gradient import gravity_gradient
from simsat.environment.magnetic import magnetic
from simsat.environment.orbit import Centre, Orbit, OrbitSettings, circular_orbit
from simsat.environment.orbits.tle import read_orbit
from simsat.environment.own import OwnTorque, own_torque
from simsat.environment.scene import Scene, TorqueModel
from simsat.environment.solar_pressure import solar_pressure

INDEX_MAX = 1000.0
"""More solar flux or geomagnetic activity than was ever recorded."""

AIR_TOP_KM = 2000.0
"""Where the density table ends being of use: the torque on a small satellite is below 1e-11 Nm."""

NAMES = ("gravity_gradient", "drag", "solar_pressure", "magnetic")

FieldModel = Literal["dipole", "igrf"]
Index = Annotated[float, Bounds(0.0, INDEX_MAX)]


@dataclass(frozen=True)
class EnvironmentSettings(Settings, group="environment"):
    """Which external torques act, and from what figures."""

    gravity_gradient: bool = True
    """Gravity-gradient torque of the whole spacecraft's inertia."""
    drag: bool = True
    """Free-molecular drag on the model's faces; none above 2000 km."""
    solar_pressure: bool = False
    """Solar radiation pressure on the model's faces, zero in the Earth's shadow: what is left far
    out."""
    magnetic: bool = False
    """Residual magnetic dipole in the Earth's field: 0.1 A m^2 outweighs drag at 500 km."""
    field: FieldModel = "dipole"
    """The Earth's field, for the residual dipole and for rods: a tilted dipole, or IGRF-14, from
    which the dipole is off by 23 percent in the mean at 500 km."""
    density_model: Literal["exponential", "nrlmsis"] = "exponential"
    """Air density: one value for the altitude (Vallado's table), or NRLMSIS 2.1 along the orbit."""
    corotation: bool = False
    """Let the air turn with the Earth, which bends the wind by up to 4 degrees at 500 km."""
    f107: Index = 150.0
    """Solar radio flux of the day before, solar flux units: for NRLMSIS, 70 quiet to 250 active."""
    f107a: Index = 150.0
    """Solar radio flux averaged over 81 days, solar flux units: for NRLMSIS."""
    ap: Index = 4.0
    """Geomagnetic index ap: for NRLMSIS, 4 quiet to 400 in a storm."""
    dipole_Am2: tuple[float, float, float] = (0.058, 0.058, 0.058)
    """Residual magnetic dipole in body axes, A m^2: a small spacecraft keeps about 0.1."""


@dataclass(frozen=True)
class Environment:
    """External torques about the centre of mass along an orbit, and the magnetic field there.

    Torques turn the spacecraft as one rigid body at its model file's configuration: panels that
    bend and liquid that moves change neither J nor the faces.
    """

    orbit: Orbit
    models: tuple[tuple[str, TorqueModel], ...]
    """Names and models of the torques that act; none makes the torque zero."""
    field: MagneticField
    """The Earth's magnetic field along the orbit, whether a torque comes from it or not."""
    left_out: tuple[str, ...] = ()
    """Torques that were asked for and do not reach so far out, each with the reason."""

    def torque(self, t: float, q: Quaternion) -> Vector3:
        """Total torque at time t (s) and attitude q, shape (3,), Nm, body axes.

        About 10 us. Held over a tick, evaluate it at the attitude predicted for mid-tick: the
        start's attitude costs 2e-3 degrees in 100 s, mid-tick's under 1e-4.
        """
        t = float(t)
        w, x, y, z = q.tolist()
        up, ahead = self.orbit.direction(t), self.orbit.velocity_direction(t)
        scene = Scene(t, up, ahead, inertial_to_body((w, x, y, z)), (w, x, y, z))
        total: Triple = (0.0, 0.0, 0.0)
        for _, model in self.models:
            total = added(total, model(scene))
        return np.array(total)

    def torques(self, t: Array, q: Quaternion) -> dict[str, Array]:
        """Each torque by name at k instants: t (k,), q (k, 4) to arrays (k, 3), Nm, body axes."""
        t = np.asarray(t, float)
        w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
        up, ahead = self.orbit.direction(t), self.orbit.velocity_direction(t)
        scene = Scene(t, up, ahead, inertial_to_body((w, x, y, z)), (w, x, y, z))
        return {name: _stacked(model(scene), t) for name, model in self.models}

    def field_N(self, t: Array) -> Array:
        """Magnetic field at k instants, T, inertial axes, shape (k, 3)."""
        t = np.asarray(t, float)
        return _stacked(self.field(t), t)

    def position(self, t: Array) -> Array:
        """Position from the centre that it goes around at k instants, m, inertial axes, (k, 3)."""
        t = np.asarray(t, float)
        return _stacked(self.orbit.position(t), t)

    def velocity(self, t: Array) -> Array:
        """Inertial velocity at k instants, m/s, inertial axes, shape (k, 3)."""
        t = np.asarray(t, float)
        return _stacked(self.orbit.velocity(t), t)


def build_environment(
    spacecraft: Spacecraft,
    orbit: OrbitSettings,
    settings: EnvironmentSettings,
    own: Mapping[str, OwnTorque] | None = None,
) -> Environment:
    """The environment of the true spacecraft (not of the controller's belief), `own` torques beside
    ours by their names."""
    path = build_orbit(orbit)
    surface = spacecraft.surface
    field = build_field(settings.field, path)
    models: list[tuple[str, TorqueModel]] = []
    far = dict(_out_of_reach(path, spacecraft.J))
    acting = {name for name in NAMES if getattr(settings, name)}
    if "gravity_gradient" in acting - far.keys():
        models.append(("gravity_gradient", gravity_gradient(spacecraft.J, path)))
    if "drag" in acting - far.keys():
        air = _density(path, settings)
        models.append(("drag", drag(surface, air, path, settings.corotation)))
    if "solar_pressure" in acting:
        models.append(("solar_pressure", solar_pressure(surface, path)))
    if "magnetic" in acting - far.keys():
        models.append(("magnetic", magnetic(np.array(settings.dipole_Am2), field)))
    models += [(name, own_torque(name, function)) for name, function in (own or {}).items()]
    left_out = (f"{name} ({why})" for name, why in far.items() if name in acting)
    return Environment(path, tuple(models), field, tuple(left_out))


def build_orbit(settings: OrbitSettings) -> Orbit:
    """The orbit that the settings describe, or that their file does. Raises `SettingsError`."""
    if settings.tle is None:
        return circular_orbit(settings)
    return read_orbit(settings.tle, settings.epoch_utc)


def build_field(model: FieldModel, orbit: Orbit) -> MagneticField:
    """A field model along the orbit. Raises `SettingsError` if it doesn't cover the epoch."""
    return igrf_field(orbit) if model == "igrf" else dipole_field(orbit)


def _out_of_reach(orbit: Orbit, J: Matrix3) -> Iterator[tuple[str, str]]:
    """(name of a torque, why it is none here) of each that an orbit is too far out for."""
    radius = float(orbit.radius_at(0.0))
    altitude_km = (radius - earth.RADIUS) / 1e3
    if orbit.centre is Centre.SUN:
        moments = np.linalg.eigvalsh(J)
        most = 1.5 * earth.MU_SUN / radius**3 * float(moments[-1] - moments[0])
        yield "gravity_gradient", f"the Sun's is {most:.1g} Nm at most"
        yield "drag", "there is no air"
        yield "magnetic", "the Earth's field is far away"
        return
    if altitude_km > AIR_TOP_KM:
        yield "drag", f"there is no air above {AIR_TOP_KM:g} km"
    if radius > earth.MAGNETOSPHERE:
        radii = earth.MAGNETOSPHERE / earth.RADIUS
        yield "magnetic", f"the Earth's field ends {radii:g} Earth radii from its centre"


def _density(orbit: Orbit, settings: EnvironmentSettings) -> Density:
    if settings.density_model == "nrlmsis":
        return nrlmsis_density(orbit, settings.f107, settings.f107a, settings.ap)
    return density_of_altitude(orbit)


def _stacked(vector: Triple, t: Array) -> Array:
    """Components to rows; a component that doesn't vary is repeated for every instant."""
    return np.stack([np.broadcast_to(component, t.shape) for component in vector], axis=-1)
