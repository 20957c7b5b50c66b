"""Magnetorquers (magnetic torque rods): coils that push against the Earth's magnetic field."""

from dataclasses import dataclass

import numpy as np

from .arrays import RodAxes, Rods, RodVector, Vectors3


@dataclass(frozen=True)
class Magnetorquers:
    """k rods fixed in the bus, of any number and on any axes.

    Their torque is m x B wherever in the bus they sit: it has no part along B.
    """

    names: tuple[str, ...]
    axes: RodAxes
    """Unit vector along which each positive dipole points, body axes, one per column, (3, k)."""
    dipole_max: RodVector
    """Largest dipole of each rod either way, A m^2."""

    @property
    def count(self) -> int:
        """Number of rods, k."""
        return len(self.names)

    def moment(self, dipole: Rods) -> Vectors3:
        """m_B, the dipole of all rods together, A m^2, body axes; `dipole` (A m^2) per rod."""
        return dipole @ self.axes.T

    def torque(self, dipole: Rods, field_B: Vectors3) -> Vectors3:
        """tau_B = m_B x B_B, Nm, body axes; `field_B` in T, body axes. Batches in the leading axes.

        Source: Wertz, Spacecraft Attitude Determination and Control, eq. 19-1.
        """
        return np.cross(self.moment(dipole), field_B)


NO_AXES: RodAxes = np.array([[], [], []])
NO_RODS = Magnetorquers((), NO_AXES, np.zeros(0))
