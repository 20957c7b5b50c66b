"""Solar radiation pressure torque on the outer faces."""

import numpy as np

from simsat.control.ground.spacecraft import Surface
from simsat.environment.components import Number, Triple, added, applied, cross, dot, scaled
from simsat.environment.earth import AU, RADIUS, sun_direction
from simsat.environment.faces import caught, summed
from simsat.environment.orbit import Centre, Orbit
from simsat.environment.scene import Scene, TorqueModel

PRESSURE = 1361.0 / 299792458.0
"""N/m^2 at one astronomical unit: solar constant 1361 W/m^2 (Kopp and Lean, 2011) over c."""


def solar_pressure(surface: Surface, orbit: Orbit) -> TorqueModel:
    """tau_B = sum_i c_i x F_i,  F_i = -P A_i cos_i [(1 - rho) s + 2 rho cos_i n_i] on lit faces.

    s points to the Sun, cos_i = max(n_i . s, 0), rho is the share reflected like a mirror. Around
    the Earth the Sun stands still at its place at t = 0 (0.04 degrees an hour) and one astronomical
    unit away (+-3.4 % of pressure over a year); around the Sun s is the way back to it, P falls
    with the distance squared, and there is no shadow. Source: Wertz, Spacecraft Attitude
    Determination and Control, eq. 17-52 without its diffuse term.
    """
    normal, centre = surface.normal_B, surface.centre_B
    area_normal = surface.area[:, None] * normal
    arm = np.cross(centre, normal)
    sun_N = sun_direction(orbit.epoch_days)
    pressure = PRESSURE
    if orbit.centre is Centre.SUN:
        pressure *= (AU / float(orbit.radius_at(0.0))) ** 2
    absorbed, mirrored = -pressure * (1.0 - surface.reflectivity), -pressure * surface.reflectivity

    def push(scene: Scene, source_N: Triple) -> Triple:
        s_B = applied(scene.to_body, source_N)
        area_cos = caught(area_normal, s_B)
        along_beam = cross(summed(area_cos, centre), s_B)
        along_normals = summed(area_cos * caught(normal, s_B), arm)
        return added(scaled(absorbed, along_beam), scaled(2.0 * mirrored, along_normals))

    def around_the_earth(scene: Scene) -> Triple:
        return scaled(sunlit(scene.up_N, sun_N, orbit.radius_at(scene.t)), push(scene, sun_N))

    def around_the_sun(scene: Scene) -> Triple:
        return push(scene, scaled(-1.0, scene.up_N))

    return around_the_sun if orbit.centre is Centre.SUN else around_the_earth


def sunlit(up_N: Triple, sun_N: Triple, orbit_radius: Number) -> Number:
    """1 in sunlight, 0 in the Earth's shadow, taken as a cylinder (no penumbra)."""
    along = dot(up_N, sun_N)
    outside = orbit_radius**2 * (1.0 - along * along) > RADIUS**2
    lit = (along > 0.0) | outside
    return float(lit) if isinstance(lit, bool) else lit.astype(float)
