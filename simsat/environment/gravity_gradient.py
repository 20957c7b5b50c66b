"""Gravity-gradient torque."""

from simsat.control.ground.arrays import Matrix3
from simsat.environment.components import Triple, applied, cross, rows, scaled
from simsat.environment.earth import MU
from simsat.environment.orbit import Orbit
from simsat.environment.scene import Scene, TorqueModel


def gravity_gradient(J: Matrix3, orbit: Orbit) -> TorqueModel:
    """tau_B = (3 mu / R^3) r x J r, r the local vertical in body axes.

    J (kg m^2) is the whole spacecraft's about its centre of mass, rotors included: dropping the
    rotors loses their share of the torque. Order R^-4 and the Earth's oblateness (1e-3 of this)
    are left out. Source: Wertz, Spacecraft Attitude Determination and Control, eq. 17-31.
    """
    J_rows = rows(J)

    def torque(scene: Scene) -> Triple:
        r_B = applied(scene.to_body, scene.up_N)
        factor = 3.0 * MU / orbit.radius_at(scene.t) ** 3
        return scaled(factor, cross(r_B, applied(J_rows, r_B)))

    return torque
