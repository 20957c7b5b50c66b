"""The limits along the horizon: rows with inputs at stages 0..N-1, then the others at 1..N."""

import numpy as np

from ..ground.arrays import Array
from .ocp import Limits


class Rows:
    """All rows of a problem, stage by stage, in one flat array."""

    def __init__(self, limits: Limits, N: int) -> None:
        inputs, states = limits.on_input, ~limits.on_input
        self._N = N
        self._Cx_input, self._Cu_input = limits.Cx[inputs], limits.Cu[inputs]
        self._Cx_state = limits.Cx[states]

        def along(values: Array) -> Array:
            return np.concatenate([np.tile(values[inputs], N), np.tile(values[states], N)])

        self.lower, self.upper = along(limits.lower), along(limits.upper)
        self.softness = along(limits.softness)
        self.soft = np.isfinite(self.softness)

    def value(self, x: Array, u: Array) -> Array:
        """Cx x + Cu u of every row."""
        on_input = x[:-1] @ self._Cx_input.T + u @ self._Cu_input.T
        return np.concatenate([on_input.ravel(), (x[1:] @ self._Cx_state.T).ravel()])

    def jacobian(self, Z: Array, G_end: Array) -> Array:
        """d value / d inputs from the stages' sensitivities (see `linearization.py`)."""
        n, nx = Z.shape[2], self._Cx_state.shape[1]
        on_input = np.concatenate([self._Cx_input, self._Cu_input], axis=1) @ Z
        following = np.concatenate([Z[1:, :nx], G_end[None]])
        return np.concatenate(
            [on_input.reshape(-1, n), (self._Cx_state @ following).reshape(-1, n)]
        )

    def pull(self, multipliers: Array) -> Array:
        """Cx'z: what the multipliers add to the derivative by each state, shape (N + 1, nx)."""
        split = self._N * len(self._Cu_input)
        on_input = multipliers[:split].reshape(self._N, -1)
        on_state = multipliers[split:].reshape(self._N, -1)
        by_state = np.zeros((self._N + 1, self._Cx_input.shape[1]))
        by_state[:-1] += on_input @ self._Cx_input
        by_state[1:] += on_state @ self._Cx_state
        return by_state

    def violation(self, value: Array) -> Array:
        """How far each row is outside its bounds."""
        return np.maximum(np.maximum(value - self.upper, self.lower - value), 0.0)

    def penalty(self, x: Array, u: Array) -> float:
        """What violated soft rows cost."""
        if not self.soft.any():
            return 0.0
        v = self.violation(self.value(x, u))[self.soft]
        return float(self.softness[self.soft] @ (v + 0.5 * v * v))
