"""Identification in flight: inertia, stored momentum and external torque, from gyro and wheels.

The law of angular momentum holds at every instant and is linear in everything unknown:

    J omega + A (Js * Omega) = R(q)' h_N        h_N' = R(q) tau_B

No derivative of a measurement is needed, and bearing friction, being internal, drops out. The
external torque is learned as a field of 15 numbers (see `field`). A spacecraft that is not rigid
carries momentum beside J omega in what is loose (panels that bend, propellant that swings): c,
added on the left, which comes and goes (a first-order Gauss-Markov process of standard deviation
`doubt`; Bar-Shalom, Li and Kirubarajan, section 8.2). Without it a vibration would be taken for
inertia and for external torque.

A Kalman filter estimates all 27 numbers from a prior that says: the nominal J to 10 %, no external
torque to within that of a low orbit, nothing loose in motion. It needs no training. At rest nothing
is learned of J; one second of slew is enough.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ...ground.arrays import Array, Matrix3, Quaternion, Vector3
from ...ground.attitude import rotation_matrix
from ...ground.spacecraft import Spacecraft
from .field import PAIRS, SYMMETRIC, torque_map
from .samples import Samples

INERTIA, MOMENTUM, FIELD, LOOSE = slice(0, 6), slice(6, 9), slice(9, 24), slice(24, 27)
UNKNOWNS = 27

INERTIA_PRIOR = 0.1  # of the mean principal inertia, 1 sigma: before any flight
TRAINED_PRIOR = 0.005  # likewise, of an inertia that was learned from earlier flights
RATE_PRIOR = 2e-4  # rad/s: gyro noise of the first sample until more samples have shown it
GRADIENT_PRIOR = 3.7e-6  # 1/s^2: 3 mu / r^3 at 500 km
ARM_PRIOR = 1e-6  # Nm, each of the 9 numbers: drag, sunlight, dipole in low orbit
FIRST_DOUBT = 3e-4  # rad/s: of c over the inertia, until some periods have shown less
QUIET = 1e-2  # rad/s: below this nothing is learned of J; what little shows is not rigid motion
DRAG_ALLOWANCE = 3e-6  # Nm: external torque that may have acted unseen before a fresh start
FIELD_WALK = 3e-9  # Nm (and 1/s^2) in a second: an orbit turns the field by 4 deg a minute
MOMENTUM_WALK = 1e-9  # Nms in a second: torque that no field of this kind explains
AT_REST = 1e-3  # rad/s: stored momentum over inertia, below which n'Jn has no visible effect
SAMPLES_FOR_NOISE = 8  # fewer samples than this tell nothing of the noise
LOOSE_MEMORY = 0.1  # s: correlation time of c; well below a panel's period: little of it at rest
HIDES_TORQUE = 3e-5  # rad/s: a c this large over the inertia hides torque of the size of drift
SWAY_MEMORY = 5.0  # s: slower motion of what is loose is not told from the body's own

_WALK = np.repeat([0.0, MOMENTUM_WALK**2, FIELD_WALK**2, 0.0], (6, 3, 15, 3))


@dataclass(frozen=True)
class Knowledge:
    """Mean and covariance of the 27 unknowns: J (6), h_N (3), field (15), c (3)."""

    mean: Array
    covariance: Array
    t: float
    """Time up to which samples are taken in, s."""
    torque_map: Array
    """d tau_N / d field at that time, shape (3, 15)."""
    doubt: float = 0.0
    """Standard deviation of c over the mean inertia, rad/s: how far from rigid the craft may be."""
    restarts: int = 0
    """How often learning began afresh."""
    sway: Vector3 = field(default_factory=lambda: np.zeros(3))
    """Rotation (rad, body axes) by which the body has given way to what swings: it will be undone
    by itself, and is nothing to steer against."""

    @property
    def J(self) -> Matrix3:
        """Inertia, kg m^2."""
        return np.einsum("a,aij->ij", self.mean[INERTIA], SYMMETRIC)

    @property
    def h_N(self) -> Vector3:
        """Total angular momentum, inertial axes, Nms."""
        return self.mean[MOMENTUM]

    @property
    def loose(self) -> Vector3:
        """c, momentum of what is loose, body axes, Nms."""
        return self.mean[LOOSE]

    @property
    def loose_deviation(self) -> float:
        """Standard deviation of c by itself, Nms."""
        return self.doubt * float(np.trace(self.J)) / 3.0

    @property
    def reliance(self) -> float:
        """How far learned external torque can be relied upon, 0 to 1: what swings is no white noise
        and passes for torque."""
        return 1.0 / (1.0 + (self.doubt / HIDES_TORQUE) ** 2)

    def external_torque(self, q: Quaternion) -> Vector3:
        """External torque to expect at attitude q, inertial axes, Nm."""
        return torque_map(q, self.J) @ self.mean[FIELD]


def begin(
    spacecraft: Spacecraft,
    samples: Samples,
    rate_noise: float,
    inertia_prior: float = INERTIA_PRIOR,
) -> Knowledge:
    """What is known at the first sample: the nominal J, and the h_N that follows from it.

    `inertia_prior` is J's uncertainty, 1 sigma, over the mean principal inertia.

    How well h_N is known shows in the scatter of the samples, if there are enough of them, but is
    no better than `rate_noise` (rad/s, 1 sigma). Nothing loose is in motion yet.
    Without stored momentum only the ratio of n'J to n'Jn shows: n'Jn is then left at its nominal
    value, which gyro noise would otherwise pull towards zero.
    """
    size = np.trace(spacecraft.J) / 3.0
    sigma = np.repeat([inertia_prior * size, GRADIENT_PRIOR, ARM_PRIOR, 0.0], (9, 6, 9, 3))
    scatter = RATE_PRIOR * size
    if len(samples.t) >= SAMPLES_FOR_NOISE:
        scatter = momentum_noise(spacecraft.J, samples, rate_noise)
    sigma[MOMENTUM] = scatter
    prior = np.diag(sigma**2)
    if _at_rest(spacecraft, samples, size):
        prior = _without_own_scale(prior, spacecraft.unactuated)
    mean = np.zeros(UNKNOWNS)
    mean[INERTIA] = [spacecraft.J[pair] for pair in PAIRS]
    R = rotation_matrix(samples.q[0])
    follow = np.eye(UNKNOWNS)
    follow[MOMENTUM, INERTIA] = R @ _rate_matrix(samples.omega[0])
    mean = follow @ mean
    mean[MOMENTUM] += R @ samples.wheel_momentum[0]
    covariance = follow @ prior @ follow.T
    field_map = torque_map(samples.q[0], spacecraft.J)
    return Knowledge(mean, covariance, float(samples.t[0]), field_map, FIRST_DOUBT)


def restart(start: Knowledge, samples: Samples, doubt: float, restarts: int) -> Knowledge:
    """What was known at the first sample, carried to these: h_N has hardly moved since."""
    covariance = start.covariance.copy()
    moved = DRAG_ALLOWANCE * (float(samples.t[0]) - start.t)
    covariance[MOMENTUM, MOMENTUM] += moved**2 * np.eye(3)
    field_map = torque_map(samples.q[0], start.J)
    again = Knowledge(start.mean, covariance, float(samples.t[0]), field_map, doubt, restarts)
    covariance[LOOSE, LOOSE] += again.loose_deviation**2 * np.eye(3)
    return again


def _at_rest(spacecraft: Spacecraft, samples: Samples, size: float) -> bool:
    stored = spacecraft.J @ samples.omega[0] + samples.wheel_momentum[0]
    return bool(np.linalg.norm(stored) < AT_REST * size)


def _without_own_scale(prior: Array, n: Vector3 | None) -> Array:
    """The prior given that n'Jn is exact."""
    if n is None:
        return prior
    own = np.zeros(UNKNOWNS)
    own[INERTIA] = np.einsum("i,aij,j->a", n, SYMMETRIC, n)
    spread = prior @ own
    return prior - np.outer(spread, spread) / (own @ spread)


def learn(knowledge: Knowledge, samples: Samples, rate_noise: float) -> Knowledge:
    """Take in all samples newer than the knowledge.

    `rate_noise` (rad/s, 1 sigma) is the least gyro noise to assume; what the samples themselves
    scatter by counts if it is more.
    """
    noise = momentum_noise(knowledge.J, samples, rate_noise)
    maps = torque_map(samples.q, knowledge.J)
    balances = balance(samples)
    for k in np.flatnonzero(samples.t > knowledge.t + 1e-9):
        ahead = _predict(knowledge, float(samples.t[k]), maps[k])
        quiet = bool(np.linalg.norm(samples.omega[k]) < QUIET)
        after = _correct(ahead, balances[k], samples.wheel_momentum[k], noise, quiet)
        knowledge = replace(after, sway=_swayed(knowledge, after))
    return knowledge


def momentum_noise(J: Matrix3, samples: Samples, rate_noise: float) -> float:
    """Noise of the momentum balance, Nms: from its fourth differences, which are blind to anything
    smooth, a vibration too, and at least what the gyro's `rate_noise` makes of it."""
    floor = rate_noise * float(np.trace(J)) / 3.0
    if len(samples.t) < SAMPLES_FOR_NOISE:
        return floor
    rough = np.diff(samples.omega @ J + samples.wheel_momentum, n=4, axis=0)
    return max(floor, float(np.sqrt(np.mean(rough**2) / 70.0)))  # 1 + 16 + 36 + 16 + 1 variances


def forecast_error(knowledge: Knowledge, samples: Samples, noise: float) -> tuple[Array, Array]:
    """Error of the predicted momentum balance at samples not yet taken in, Nms, and the variance
    expected of it; both of shape (k, 3). `noise` is that of `momentum_noise`."""
    keep = loose_share(samples.t - knowledge.t)[:, None]
    H = balance(samples)
    H[:, :, LOOSE] *= keep[:, None]
    variance = np.einsum("kia,ab,kib->ki", H, knowledge.covariance, H) + noise**2
    variance += (1.0 - keep**2) * knowledge.loose_deviation**2
    return H @ knowledge.mean + samples.wheel_momentum, variance


def loose_share(dt: Array) -> Array:
    """How much of c is left after so many seconds."""
    return np.asarray(np.exp(-dt / LOOSE_MEMORY))


def _swayed(before: Knowledge, after: Knowledge) -> Vector3:
    """The sway a sample later: theta' = -J^-1 c, less what is forgotten."""
    dt = after.t - before.t
    loose = 0.5 * (before.loose + after.loose)
    return np.exp(-dt / SWAY_MEMORY) * before.sway - dt * np.linalg.solve(after.J, loose)


def _predict(knowledge: Knowledge, t: float, map_then: Array) -> Knowledge:
    """Knowledge at time t: h_N moved by the field's torque, c fading, all a little less certain."""
    dt = t - knowledge.t
    move = 0.5 * dt * (knowledge.torque_map + map_then)
    mean, P = knowledge.mean.copy(), knowledge.covariance.copy()
    mean[MOMENTUM] += move @ mean[FIELD]
    P[MOMENTUM] += move @ P[FIELD]
    P[:, MOMENTUM] += P[:, FIELD] @ move.T
    P[np.diag_indices(UNKNOWNS)] += _WALK * dt
    keep = float(loose_share(np.asarray(dt)))
    mean[LOOSE] *= keep
    P[LOOSE] *= keep
    P[:, LOOSE] *= keep
    P[LOOSE, LOOSE] += (1.0 - keep**2) * knowledge.loose_deviation**2 * np.eye(3)
    return replace(knowledge, mean=mean, covariance=P, t=t, torque_map=map_then)


def _correct(
    knowledge: Knowledge, H: Array, wheel_momentum: Vector3, noise: float, quiet: bool
) -> Knowledge:
    """Knowledge after the balance H mean = -A (Js Omega) was measured."""
    P = knowledge.covariance
    HP = H @ P
    gain = np.linalg.solve(HP @ H.T + noise**2 * np.eye(3), HP).T
    if quiet:
        gain[INERTIA] = 0.0
    mean = knowledge.mean - gain @ (wheel_momentum + H @ knowledge.mean)
    keep = np.eye(UNKNOWNS) - gain @ H
    P = keep @ P @ keep.T + noise**2 * gain @ gain.T  # Joseph: right for any gain
    return replace(knowledge, mean=mean, covariance=0.5 * (P + P.T))


def balance(samples: Samples) -> Array:
    """J omega - R'h_N + c as a matrix times the unknowns, shape (k, 3, 27)."""
    H = np.zeros((len(samples.t), 3, UNKNOWNS))
    H[:, :, INERTIA] = _rate_matrix(samples.omega)
    H[:, :, MOMENTUM] = -np.swapaxes(rotation_matrix(samples.q), -1, -2)
    H[:, :, LOOSE] = np.eye(3)
    return H


def _rate_matrix(omega: Vector3) -> Array:
    """J omega as a matrix times J's 6 numbers, shape (..., 3, 6)."""
    return np.einsum("aij,...j->...ia", SYMMETRIC, omega)
