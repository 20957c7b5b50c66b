"""The state of the filter: 27 unknowns of the spacecraft, their mean and covariance.

J (6)             inertia
h_N (3)           total angular momentum
field (15)        external torque, as in `external_torque`
c (3)             appendage momentum: what panels or propellant carry beside J omega
"""

from dataclasses import dataclass, field

import numpy as np

from ...ground.arrays import Array, Matrix3, Quaternion, Vector3
from .external_torque import SYMMETRIC, torque_map

INERTIA, MOMENTUM, FIELD, APPENDAGE = slice(0, 6), slice(6, 9), slice(9, 24), slice(24, 27)
UNKNOWNS = 27

# Times 1.6 kg m^2 it is 5e-5 Nms: what 6e-7 Nm, the gravity gradient on the panels, gives in 80 s.
HIDES_TORQUE = 3e-5  # rad/s: a c this large over the inertia hides torque of the size of drift


@dataclass(frozen=True)
class ModelEstimate:
    """Mean and covariance of the unknowns at one time."""

    mean: Array
    covariance: Array
    t: float
    """Time of the last sample processed, s."""
    torque_map: Array
    """d tau_N / d field at that time, shape (3, 15)."""
    flexibility: float = 0.0
    """Allowance for flexibility: standard deviation of c over the mean inertia, rad/s."""
    restarts: int = 0
    """How often the filter was re-initialised."""
    deflection: Vector3 = field(default_factory=lambda: np.array([0.0, 0.0, 0.0]))
    """Rotation of the hub (rad, body axes) that the appendages' deflection makes: it will go by
    itself, and is nothing to steer against."""
    outside: float = 1.0
    """Size of the torque from outside that is to be expected over the inertia, as a share of what
    it is in low orbit in SI: in a slow craft's own units it is larger, by its own second squared.
    The constants about it hold for 1."""

    @property
    def J(self) -> Matrix3:
        """Inertia, kg m^2."""
        return np.einsum("a,aij->ij", self.mean[INERTIA], SYMMETRIC)

    @property
    def h_N(self) -> Vector3:
        """Total angular momentum, inertial axes, Nms."""
        return self.mean[MOMENTUM]

    @property
    def appendage_momentum(self) -> Vector3:
        """c, body axes, Nms."""
        return self.mean[APPENDAGE]

    @property
    def appendage_deviation(self) -> float:
        """Steady-state standard deviation of c, Nms."""
        return self.flexibility * float(np.trace(self.J)) / 3.0

    @property
    def torque_confidence(self) -> float:
        """How far the estimated external torque can be relied upon, 0 to 1: a vibration is no white
        noise and passes for torque."""
        return 1.0 / (1.0 + (self.flexibility / (HIDES_TORQUE * self.outside)) ** 2)

    def external_torque(self, q: Quaternion) -> Vector3:
        """External torque to expect at attitude q, inertial axes, Nm."""
        return torque_map(q, self.J) @ self.mean[FIELD]
