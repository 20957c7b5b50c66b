"""Free-molecular drag torque on the outer faces."""

from simsat.control.ground.spacecraft import Surface
from simsat.environment.atmosphere import Density
from simsat.environment.components import Number, Triple, applied, cross, scaled
from simsat.environment.earth import ROTATION_RATE
from simsat.environment.faces import caught, summed
from simsat.environment.orbit import Orbit
from simsat.environment.scene import Scene, TorqueModel


def drag(surface: Surface, density: Density, orbit: Orbit, corotation: bool) -> TorqueModel:
    """tau_B = -1/2 rho Cd sum_i A_i max(n_i . v, 0) c_i x v over the windward faces.

    v is the velocity (m/s) relative to the air, which stands still in inertial space or, with
    `corotation`, turns with the Earth; c_i the face's centre from the centre of mass. Gas
    molecules come as a beam (oxygen at 1000 K: speed ratio 7.5) and each face catches its own
    share. Source: Wertz, Spacecraft Attitude Determination and Control, eq. 17-57.
    """
    area_normal = surface.area[:, None] * surface.normal_B
    half_coefficient = -0.5 * surface.drag_coefficient
    air_rate = ROTATION_RATE if corotation else 0.0

    def torque(scene: Scene) -> Triple:
        v_B = applied(scene.to_body, _air_velocity(scene, orbit, air_rate))
        lever = summed(caught(area_normal, v_B), surface.centre_B)
        return scaled(half_coefficient * density(scene.t), cross(lever, v_B))

    return torque


def _air_velocity(scene: Scene, orbit: Orbit, air_rate: float) -> Triple:
    """v - w_air x r with w_air along the pole, inertial axes, m/s."""
    x, y, z = scaled(orbit.speed_at(scene.t), scene.ahead_N)
    east: Number = orbit.radius_at(scene.t) * air_rate
    return x + east * scene.up_N[1], y - east * scene.up_N[0], z
