"""The network that estimates the residual torque, in plain NumPy: what flies.

    tau_hat = bound tanh(W_L h + b_L),   h = tanh(W_l h + b_l) ...,   h_0 = (x - mean) / scale

The same class holds the linear baseline: one layer and no bound, tau_hat = W_1 h_0 + b_1.
"""

from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Array, WheelVectors


@dataclass(frozen=True)
class Network:
    """Weights and normalisation."""

    mean: Array
    """Of each input over the training set, shape (inputs,)."""
    scale: Array
    """Standard deviation of each input there, shape (inputs,)."""
    weights: tuple[Array, ...]
    """One matrix per layer, shape (outputs, inputs)."""
    biases: tuple[Array, ...]
    bound: float | None
    """Largest estimate the output can express, Nm; None for an unbounded output."""

    @property
    def inputs(self) -> int:
        """Number of inputs."""
        return int(self.weights[0].shape[1])

    @property
    def outputs(self) -> int:
        """Number of outputs: one per wheel."""
        return int(self.weights[-1].shape[0])

    def estimate(self, x: Array) -> WheelVectors:
        """Residual torque on the wheel axes, Nm, shape (..., m), for inputs (..., inputs)."""
        h = (x - self.mean) / self.scale
        last = len(self.weights) - 1
        for layer, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            h = h @ weight.T + bias
            if layer < last:
                h = np.tanh(h)
        return h if self.bound is None else self.bound * np.tanh(h)
