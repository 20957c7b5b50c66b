"""Torque of the spacecraft's residual magnetic dipole in the Earth's field."""

from simsat.control.ground.arrays import Vector3
from simsat.environment.components import Triple, applied, cross, triple
from simsat.environment.fields.field import MagneticField
from simsat.environment.scene import Scene, TorqueModel


def magnetic(dipole_B: Vector3, field: MagneticField) -> TorqueModel:
    """tau_B = m x B, m the residual dipole (A m^2, body axes).

    Source: Wertz, Spacecraft Attitude Determination and Control, eq. 17-68.
    """
    m_B = triple(dipole_B)

    def torque(scene: Scene) -> Triple:
        return cross(m_B, applied(scene.to_body, field(scene.t)))

    return torque
