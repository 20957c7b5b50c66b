"""From one gyro reading to the next: attitude by the rates, covariance by the gyro's noise.

    q' = 1/2 q (x) (0, omega)      a' = -omega x a - db - dE omega - n      db' = n_u

with omega held at the mean of the two readings, the transition is exact. Source: Lefferts, Markley
and Shuster, Kalman Filtering for Spacecraft Attitude Estimation, JGCD 5(5), 1982, eq. 80-92;
Markley and Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, eq. 6.83-6.93;
gain errors as in Crassidis and Junkins, Optimal Estimation of Dynamic Systems, 2nd ed., section
7.2.3.
"""

import math
from dataclasses import replace

import numpy as np

from ..ground.arrays import Array, Matrix3, Vector3
from ..ground.turn import turned
from .state import BIAS, ERRORS, GAIN, TURN, FilterState, GyroKnowledge

GAP = 1.5  # ticks between readings from which on one is missing
CURVED = 0.25  # of the change of rate over a gap times its length: how far the mean rate is off


def propagated(
    state: FilterState, t: float, before: Vector3, after: Vector3, gyro: GyroKnowledge
) -> FilterState:
    """The estimate at t, from the gyro readings (rad/s) at its own time and at t."""
    dt = t - state.t
    omega = state.rate(0.5 * (before + after))
    F = transition(omega, dt)
    P = F @ state.covariance @ F.T + process_noise(gyro, dt)
    if dt > GAP * gyro.tick:
        missed = CURVED * dt * float(np.linalg.norm(after - before))
        P[TURN, TURN] += missed**2 * np.eye(3)
    return replace(state, t=t, q=turned(state.q, omega * dt), covariance=0.5 * (P + P.T))


def transition(omega: Vector3, dt: float) -> Array:
    """Transition of the 15 errors at a constant rate (rad/s) over dt (s), shape (15, 15)."""
    K, angle = cross_matrix(omega * dt), float(np.linalg.norm(omega)) * dt
    sine, versine, third = _rotation_series(angle)
    square = K @ K
    F = np.eye(ERRORS)
    F[TURN, TURN] = np.eye(3) - sine * K + versine * square
    drift = -dt * (np.eye(3) - versine * K + third * square)
    F[TURN, BIAS] = drift
    F[TURN, GAIN] = np.kron(drift, omega)
    return F


def process_noise(gyro: GyroKnowledge, dt: float) -> Array:
    """Covariance of what the gyro's noise adds over dt (s), shape (15, 15)."""
    walk, drift = gyro.angle_random_walk**2, gyro.rate_random_walk**2
    Q = np.zeros((ERRORS, ERRORS))
    Q[TURN, TURN] = (walk * dt + drift * dt**3 / 3.0) * np.eye(3)
    Q[TURN, BIAS] = Q[BIAS, TURN] = -0.5 * drift * dt**2 * np.eye(3)
    Q[BIAS, BIAS] = drift * dt * np.eye(3)
    return Q


def cross_matrix(v: Vector3) -> Matrix3:
    """[v x]."""
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _rotation_series(angle: float) -> tuple[float, float, float]:
    """sin x / x, (1 - cos x) / x^2 and (x - sin x) / x^3."""
    if angle < 1e-3:
        s = angle * angle
        return 1.0 - s / 6.0, 0.5 - s / 24.0, 1.0 / 6.0 - s / 120.0
    sine, cosine = math.sin(angle), math.cos(angle)
    return sine / angle, (1.0 - cosine) / angle**2, (angle - sine) / angle**3
