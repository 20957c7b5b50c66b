"""CasADi functions on NumPy arrays, without copies or conversions between the two."""

from typing import Any

import numpy as np

from ..ground.arrays import Array


class BufferedFunction:
    """A CasADi function that reads and writes arrays of its own.

    CasADi stores matrices by columns, a mapped function's side by side: for `stages` stages, an
    output of k rows and c columns a stage arrives as an array of shape (stages, k, c).
    """

    def __init__(self, function: Any, stages: int = 1) -> None:
        self._buffer, self._run = function.buffer()
        self._inputs = [
            np.zeros((function.size2_in(i), function.size1_in(i))) for i in range(function.n_in())
        ]
        memory = [np.zeros(function.size_out(i)[::-1]) for i in range(function.n_out())]
        for i, array in enumerate(self._inputs):
            self._buffer.set_arg(i, memoryview(array.data))
        for i, array in enumerate(memory):
            self._buffer.set_res(i, memoryview(array.data))
        self._outputs = [
            array.reshape(stages, -1, array.shape[1]).transpose(0, 2, 1) for array in memory
        ]

    def __call__(self, *values: Array) -> list[Array]:
        """Outputs, which the next call overwrites; each input has a row per stage."""
        for array, value in zip(self._inputs, values, strict=True):
            array[:] = value
        self._run()
        return self._outputs
