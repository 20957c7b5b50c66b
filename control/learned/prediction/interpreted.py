"""Propagation without a compiler: CasADi's virtual machine, interval by interval, and NumPy."""

import numpy as np

from ...ground.arrays import Array, Quaternion
from ...model.momentum import MomentumModel
from ...solver.buffered import BufferedFunction
from .interval import IntervalFunctions


def known_of(model: MomentumModel) -> Array:
    """(J_hub^-1, h_N) as the functions take them."""
    return np.concatenate([model.J_hub_inverse.ravel("F"), model.h_N])


class InterpretedPropagator:
    """See `propagation.Propagator`."""

    def __init__(self, functions: IntervalFunctions, numbers: Array) -> None:
        self.even, self._numbers = functions.even, numbers
        self._step, self._end = BufferedFunction(functions.step), BufferedFunction(functions.end)
        self._step_slope = BufferedFunction(functions.step_slope)
        self._end_slope = BufferedFunction(functions.end_slope)

    def end(
        self, model: MomentumModel, x0: Array, torque: Array, lengths: Array, goal: Quaternion
    ) -> Array:
        """Where the plan ends."""
        known, x = known_of(model), x0
        for u, h in zip(torque, lengths, strict=True):
            (x_next,) = self._step(x, u, h, known, self._numbers)
            x = x_next[0, :, 0].copy()
        (end,) = self._end(x, goal, known, self._numbers)
        return end[0, :, 0].copy()

    def linearize(
        self, model: MomentumModel, x0: Array, torque: Array, lengths: Array, goal: Quaternion
    ) -> tuple[Array, Array, Array]:
        """End, slope and states."""
        known, (K, m), nx = known_of(model), torque.shape, len(x0)
        x, F = np.vstack([x0, np.zeros((K, nx))]), np.zeros((K, nx, nx + m))
        for k in range(K):
            x_next, slope = self._step_slope(x[k], torque[k], lengths[k], known, self._numbers)
            x[k + 1], F[k] = x_next[0, :, 0], slope[0]
        end, adjoint = self._end_slope(x[K], goal, known, self._numbers)
        by_torque, along = np.zeros((end.shape[1], K, m)), adjoint[0].copy()
        for k in range(K - 1, -1, -1):
            both = along @ F[k]
            along, by_torque[:, k] = both[:, :nx], both[:, nx:]
        return end[0, :, 0].copy(), by_torque.reshape(len(by_torque), K * m), x
