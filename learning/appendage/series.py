"""Flights as series of the appendages' momentum, from the law of angular momentum alone.

    c = R'h_N - J omega - A (Js * Omega)

A training flight starts at rest with nothing swinging, so that c = 0 there gives h_N at the start;
from then on an external torque tau, fixed in inertial axes, is fitted to each flight: h_N = h_0 +
tau t. What swings would pass for torque, so that tau is held to what an orbit can bring. Both are
linear in J, hence so is c, and the inertia can be learned along with the weights:

    J = J_0 + sum_a d_a D_a,    c = c_0 + sum_a d_a c_a

Along the unactuated axis n, momentum near zero shows n'J only up to a factor: n'Jn stays as it is
believed (see `control.learned.estimation.prior`), and no D_a changes it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from simsat.control.ground.arrays import Array, Matrix3, Vector3
from simsat.control.ground.attitude import IDENTITY, rotation_matrix
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.learned.estimation.samples import integrate_back
from simsat.control.model.momentum import spin_momentum

from ..correction.windows import Telemetry

TORQUE_PRIOR = 1e-6  # Nm, 1 sigma: gravity gradient, drag and sunlight in low orbit
MEMORY = 1.0  # s: how long c keeps its sign, about; it counts as one measurement of tau


@dataclass(frozen=True)
class Series:
    """F flights of K control periods: c at J_0, and its slope by the a numbers of J."""

    c: Array
    """At the control instants, body axes, Nms, shape (F, K + 1, 3)."""
    c_slope: Array
    """Shape (F, K + 1, 3, a)."""
    mean: Array
    """Over the periods, Nms, shape (F, K, 3)."""
    mean_slope: Array
    """Shape (F, K, 3, a)."""
    torque: Array
    """Commanded over the periods, Nm, shape (F, K, m)."""
    spin: Array
    """Spin momenta of the rotors, means over the periods, Nms, shape (F, K, m)."""
    square: Array
    """Sum over all samples of c_a'c_b, shape (F, a, a), for least squares of J."""
    product: Array
    """Sum over all samples of c_a'c_0, shape (F, a)."""

    @property
    def flights(self) -> int:
        """Number of flights, F."""
        return len(self.c)

    def pick(self, index: Array) -> "Series":
        """Some of the flights."""
        return Series(**{name: getattr(self, name)[index] for name in ARRAYS})


ARRAYS = tuple(Series.__dataclass_fields__)


def joined(parts: list[Series]) -> Series:
    """The flights of several series, which must be equally long."""
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAYS
    }
    return Series(**arrays)


def inertia_directions(n: Vector3 | None) -> Array:
    """Symmetric matrices D_a, orthonormal, that span all changes of J, shape (6, 3, 3); with an
    unactuated axis n those that leave n'Jn alone, shape (5, 3, 3)."""
    basis = []
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
        D = np.zeros((3, 3))
        D[i, j] = D[j, i] = 1.0 if i == j else np.sqrt(0.5)
        basis.append(D)
    directions = np.array(basis)
    if n is None:
        return directions
    own = np.einsum("i,aij,j->a", n, directions, n)
    rest = np.linalg.svd(own[None])[2][1:]
    return np.einsum("ba,aij->bij", rest, directions)


def build_series(
    flights: list[Telemetry],
    spacecraft: Spacecraft,
    J_0: Matrix3,
    period: float,
    swing: float = 0.0,
) -> Series:
    """The series of flights of equal length that start at rest; J of the spacecraft isn't used.

    `swing` (Nms, RMS of c) is how much of the momentum is to be expected to swing: with 0 all that
    can be called an external torque is.
    """
    directions = inertia_directions(spacecraft.unactuated)
    parts = [_series(flight, spacecraft, J_0, directions, period, swing) for flight in flights]
    return Series(**{name: np.stack([part[name] for part in parts]) for name in ARRAYS})


def swing_of(series: Series) -> float:
    """Root mean square of c, Nms, for the inertia that least squares gives."""
    return float(np.sqrt(np.mean((series.c + series.c_slope @ fit_inertia(series)) ** 2)))


def fit_inertia(series: Series) -> Array:
    """The numbers d that leave the least c over all samples: shape (a,).

    What swings averages out over a flight; what is left over the training corrects.
    """
    d: Array = -np.linalg.solve(series.square.sum(axis=0), series.product.sum(axis=0))
    return d


def _series(
    flight: Telemetry,
    craft: Spacecraft,
    J_0: Matrix3,
    directions: Array,
    period: float,
    swing: float,
) -> dict[str, Array]:
    ticks = round(period / flight.sample)
    t: Array = flight.sample * np.arange(len(flight.omega), dtype=np.float64)
    # Inertial axes are those of the body at the flight's end: any serve.
    R = rotation_matrix(integrate_back(IDENTITY, t, flight.omega))
    body = flight.omega @ J_0.T + (flight.wheel_speed * craft.Js) @ craft.A.T
    shrinkage = MEMORY / flight.sample * (swing / TORQUE_PRIOR) ** 2
    c = unexplained(R, t, body, shrinkage)
    slope = np.stack(
        [unexplained(R, t, flight.omega @ D.T, shrinkage) for D in directions], axis=-1
    )
    return {
        "c": c[::ticks],
        "c_slope": slope[::ticks],
        "mean": period_means(c, ticks),
        "mean_slope": period_means(slope, ticks),
        "torque": flight.torque,
        "spin": period_means(spin_momentum(craft, flight.omega, flight.wheel_speed), ticks),
        "square": np.einsum("tia,tib->ab", slope, slope),
        "product": np.einsum("tia,ti->a", slope, c),
    }


def unexplained(R: Array, t: Array, momentum_B: Array, shrinkage: float = 0.0) -> Array:
    """R'h_N - momentum, body axes, shape (k, 3): h_N = h_0 + tau t through the first sample, tau
    the least squares over all, with `shrinkage` (s^2) added to the sum of t^2. Linear in the
    momentum.
    """
    momentum_N = np.einsum("kij,kj->ki", R, momentum_B)
    change = momentum_N - momentum_N[0]
    tau = t @ change / (t @ t + shrinkage)
    left: Array = np.einsum("kji,kj->ki", R, t[:, None] * tau - change)
    return left


def period_means(values: Array, ticks: int) -> Array:
    """Means over periods of `ticks` (even) intervals, by Simpson's rule; first axis is time."""
    weights = np.ones(ticks + 1)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    weights /= 3.0 * ticks
    periods = (len(values) - 1) // ticks
    rows = ticks * np.arange(periods)[:, None] + np.arange(ticks + 1)
    means: Array = np.tensordot(values[rows], weights, axes=(1, 0))
    return means
