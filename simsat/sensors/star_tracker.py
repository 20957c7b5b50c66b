"""A star tracker: attitudes with a time stamp, late, noisier about the boresight than across it.

None is found while the body turns faster than the stars may smear, or while the Sun or the Earth
stands too close to the boresight. Before the flight it had time: the attitude at t = 0 is always
found, with the noise of any other, and is there at t = 0.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simsat.control.ground.arrays import Array, Matrix3, Quaternion, Vector3
from simsat.control.ground.attitude import rotation_matrix
from simsat.control.ground.turn import turned
from simsat.control.interface.measurement import Fix
from simsat.plant.plant import Plant
from simsat.sensors.sheets import StarTrackerSheet
from simsat.sensors.sky import Sky, angles, unit
from simsat.sensors.suite import Rows
from simsat.sensors.units import ARCSECOND

LOOK_BACK = 256  # samples searched at once for the attitude told last


@dataclass(frozen=True)
class StarTracker:
    """A tracker with its errors drawn beforehand."""

    sheet: StarTrackerSheet
    sky: Sky
    tick: float
    """s between samples."""
    error: Array
    """Turn in body axes, outliers included, rad, shape (rows, 3)."""

    @property
    def boresight(self) -> Vector3:
        """Unit vector, body axes."""
        return unit(self.sheet.boresight)

    @property
    def latency(self) -> int:
        """In samples."""
        return round(self.sheet.latency_s / self.tick)

    @property
    def covariance(self) -> Matrix3:
        """Of the error, rad^2, body axes, outliers apart."""
        along = np.outer(self.boresight, self.boresight)
        across, about = self.sheet.across_arcsec, self.sheet.about_arcsec
        return ARCSECOND**2 * (across**2 * (np.eye(3) - along) + about**2 * along)

    def fixes(self, plant: Plant, rows: Rows) -> tuple[Fix, ...]:
        """What is delivered at these samples."""
        taken = rows - self.latency
        taken = np.unique(np.concatenate([taken[taken > 0], rows[rows == 0]]))
        found = taken[self.finds(plant, taken)]
        return tuple(
            Fix(float(plant.log.t[k]), self._seen(plant, k), self.covariance) for k in found
        )

    def attitude(self, plant: Plant, row: int) -> Quaternion:
        """The attitude delivered last."""
        last = max(row - self.latency, 0)
        while last > 0:
            taken = np.arange(max(last - LOOK_BACK, 0), last) + 1
            found = taken[self.finds(plant, taken)]
            if len(found):
                return self._seen(plant, int(found[-1]))
            last -= LOOK_BACK
        return self._seen(plant, 0)

    def finds(self, plant: Plant, rows: Rows) -> NDArray[np.bool_]:
        """Whether an exposure at these samples finds an attitude, shape (k,)."""
        return (rows == 0) | (self.exposes(rows) & self.sees(plant, rows))

    def exposes(self, rows: Rows) -> NDArray[np.bool_]:
        """Whether there is an exposure: `rate_hz` of them a second, or one a sample."""
        per_sample = self.sheet.rate_hz * self.tick
        slack = 1e-9  # a rate that divides the samples' is met exactly
        return np.floor(rows * per_sample + slack) > np.floor((rows - 1) * per_sample + slack)

    def sees(self, plant: Plant, rows: Rows) -> NDArray[np.bool_]:
        """Whether stars stand still and nothing dazzles."""
        rate = np.linalg.norm(plant.rates[rows], axis=-1)
        t, sheet = plant.log.t[rows], self.sheet
        boresight_N = rotation_matrix(plant.attitudes[rows]) @ self.boresight
        from_sun = angles(boresight_N, self.sky.sun_N)
        from_limb = self.sky.from_limb(boresight_N, t)
        dark = ~self.sky.lit(t) | (from_sun > math.radians(sheet.sun_exclusion_deg))
        still = rate <= math.radians(sheet.rate_limit_deg_s)
        return still & dark & (from_limb > math.radians(sheet.earth_exclusion_deg))

    def _seen(self, plant: Plant, row: int) -> Quaternion:
        return turned(plant.attitudes[row], self.error[row])


def build_star_tracker(
    sheet: StarTrackerSheet, sky: Sky, rows: int, tick: float, rng: np.random.Generator
) -> StarTracker:
    """A tracker of this kind for a flight of so many samples, `tick` (s) apart."""
    noise = ARCSECOND * rng.standard_normal((rows, 3))
    boresight = unit(sheet.boresight)
    about = np.outer(noise @ boresight, boresight)
    error = sheet.across_arcsec * (noise - about) + sheet.about_arcsec * about
    axis = rng.standard_normal((rows, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    wrong = rng.random(rows) < sheet.outlier_share
    wrong[0] = False  # it had time before the flight
    turn = math.radians(sheet.outlier_deg) * rng.random(rows) * wrong
    return StarTracker(sheet, sky, tick, error + turn[:, None] * axis)
