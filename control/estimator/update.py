"""What a fix or a known direction says: believed as far as the covariances allow, or doubted.

A fix whose innovation is beyond the gate is an outlier and changes nothing. Several in a row are
none: then it is the filter that is wrong, by the gyro's doing, and it opens attitude and bias as
wide as the innovation asks. Source: as for `propagation`, eq. 6.75-6.82 and 5.4 of Markley and
Crassidis; gates by Bar-Shalom, Li and Kirubarajan, Estimation with Applications, section 5.4.
"""

from dataclasses import replace

import numpy as np

from ..ground.arrays import Array
from ..ground.attitude import conjugate, multiply, normalized, rotation_matrix, rotation_vector
from ..ground.turn import turned
from ..interface.measurement import Fix, Sighting
from .propagation import cross_matrix
from .state import BIAS, ERRORS, GAIN, TURN, FilterState

GATE_FIX = 21.1  # chi-square of three degrees of freedom: one good fix in 10,000 is beyond
GATE_SIGHTING = 18.4  # of two degrees of freedom, likewise
PATIENCE = 4  # fixes doubted in a row before the filter doubts itself


def with_fix(state: FilterState, fix: Fix) -> FilterState:
    """The estimate after an attitude fix of its own time."""
    turn = rotation_vector(multiply(conjugate(state.q), fix.q))
    H = np.eye(3, ERRORS)
    distance = normalised(state.covariance, H, turn, fix.covariance)
    if not np.isfinite(distance):
        return state
    if distance > GATE_FIX:
        if state.doubted < PATIENCE:
            return replace(state, doubted=state.doubted + 1, distance=distance)
        state = opened(state, turn)
    state = corrected(state, H, turn, fix.covariance)
    return replace(state, doubted=0, t_trusted=state.t, distance=distance)


def with_sighting(state: FilterState, sighting: Sighting) -> FilterState:
    """The estimate after a known direction of its own time."""
    expected = rotation_matrix(state.q).T @ sighting.direction_N
    across = _across(expected)
    H = np.zeros((2, ERRORS))
    H[:, TURN] = across @ cross_matrix(expected)
    innovation = across @ (sighting.direction_B - expected)
    noise = sighting.deviation**2 * np.eye(2)
    behind = float(sighting.direction_B @ expected) <= 0.0
    if behind or not normalised(state.covariance, H, innovation, noise) <= GATE_SIGHTING:
        return state
    return corrected(state, H, innovation, noise)


def normalised(P: Array, H: Array, innovation: Array, noise: Array) -> float:
    """Innovation squared over the covariance expected of it."""
    S = H @ P @ H.T + noise
    return float(innovation @ np.linalg.solve(S, innovation))


def corrected(state: FilterState, H: Array, innovation: Array, noise: Array) -> FilterState:
    """The Kalman update; the covariance in Joseph's form."""
    P = state.covariance
    gain = np.linalg.solve(H @ P @ H.T + noise, H @ P).T
    error = gain @ innovation
    keep = np.eye(ERRORS) - gain @ H
    P = keep @ P @ keep.T + gain @ noise @ gain.T
    return replace(
        state,
        q=normalized(turned(state.q, error[TURN])),
        bias=state.bias + error[BIAS],
        gain_error=state.gain_error + error[GAIN].reshape(3, 3),
        covariance=0.5 * (P + P.T),
    )


def opened(state: FilterState, turn: Array) -> FilterState:
    """The estimate with room for such a turn since the last fix that was believed."""
    size = float(np.linalg.norm(turn))
    span = max(state.t - state.t_trusted, 1.0)  # s; a jump of the bias is no jump of the attitude
    P = state.covariance.copy()
    P[TURN, TURN] += size**2 * np.eye(3)
    P[BIAS, BIAS] += (size / span) ** 2 * np.eye(3)
    return replace(state, covariance=P)


def _across(direction: Array) -> Array:
    """Two unit rows across a direction, shape (2, 3)."""
    other = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = np.cross(direction, other)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])
