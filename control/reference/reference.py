"""What every reference answers, and the two that do not turn: one attitude, or one after another.

T is the frame that the body is to be in: q_NT maps T components to inertial ones, and w_TN_T is the
rate of T relative to N in T axes, which is the body rate once the body is there.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..ground.arrays import Array, Quaternion, Quaternions, Vector3, Vectors3
from ..ground.attitude import multiply, normalized

Times = float | Array
"""Seconds from the flight's start: one instant, or k of them."""


class Reference(Protocol):
    """An attitude at any time, and the rate at which it turns."""

    @property
    def moving(self) -> bool:
        """Whether it ever changes."""
        ...

    def attitude(self, t: Times) -> Quaternions:
        """q_NT at time t (s), shape (4,), or (k, 4) for k instants."""
        ...

    def rate(self, t: Times) -> Vectors3:
        """w_TN_T at time t (s), rad/s, T axes, shape (3,), or (k, 3)."""
        ...


@dataclass(frozen=True)
class Inertial:
    """One attitude for all time."""

    q: Quaternion

    @property
    def moving(self) -> bool:
        """No."""
        return False

    def attitude(self, t: Times) -> Quaternions:
        """The attitude, whenever."""
        return np.broadcast_to(self.q, (*np.shape(t), 4))

    def rate(self, t: Times) -> Vectors3:
        """Zero."""
        return np.zeros((*np.shape(t), 3))


@dataclass(frozen=True)
class Sequence:
    """Attitudes one after another, each for a while: the slews between are the controller's."""

    starts: Array
    """When each begins to count, s, rising from 0, shape (k,)."""
    attitudes: Quaternions
    """Shape (k, 4)."""

    @property
    def moving(self) -> bool:
        """Whether there is more than one."""
        return len(self.starts) > 1

    def index(self, t: Times) -> Array:
        """Which of them counts at time t, shape () or (k,); from its start on."""
        return np.clip(np.searchsorted(self.starts, t, "right") - 1, 0, None)

    def attitude(self, t: Times) -> Quaternions:
        """The one that counts."""
        q: Quaternions = self.attitudes[self.index(t)]
        return q

    def rate(self, t: Times) -> Vectors3:
        """Zero: it rests but where it jumps."""
        return np.zeros((*np.shape(t), 3))


@dataclass(frozen=True)
class Curve:
    """A smooth history of attitudes, whose rate is its exact derivative.

    `value` answers a curve of quaternions p(t) of any length but zero, `slope` its derivative:
    q = p / |p|, and w = 2 Im(q* (x) q') with q' the part of p' / |p| across p.
    """

    value: Callable[[Times], Array]
    slope: Callable[[Times], Array]

    @property
    def moving(self) -> bool:
        """Yes."""
        return True

    def attitude(self, t: Times) -> Quaternions:
        """q_NT, of unit length."""
        return normalized(self.value(t))

    def rate(self, t: Times) -> Vectors3:
        """w_TN_T; the imaginary part drops what p' has along p."""
        p, slope = np.asarray(self.value(t)), np.asarray(self.slope(t))
        size = np.linalg.norm(p, axis=-1, keepdims=True)
        back = p * np.array([1.0, -1.0, -1.0, -1.0]) / size
        rate: Vectors3 = 2.0 * multiply(back, slope / size)[..., 1:]
        return rate


def mean_acceleration(reference: Reference, start: float, end: float) -> Vector3:
    """Angular acceleration from one time to another (s), rad/s^2, T axes."""
    change: Vector3 = reference.rate(end) - reference.rate(start)
    return change / (end - start)
