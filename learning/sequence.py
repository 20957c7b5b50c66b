"""Estimates along a flight, each fed back into the next: the network as it flies."""

import numpy as np

from simsat.control.correction.features import features
from simsat.control.correction.network import Network
from simsat.control.ground.arrays import WheelVector
from simsat.control.model.rates import RateModel

from .correction.windows import Windows


def self_fed(network: Network, windows: Windows, believed: RateModel) -> WheelVector:
    """Estimates of every window (R, K, m), Nm, the previous one being the network's own."""
    estimates = np.zeros_like(windows.torque)
    previous = np.zeros_like(windows.torque[:, 0])
    for k in range(windows.torque.shape[1]):
        x = features(
            previous,
            windows.omega[:, k],
            windows.omega_before[:, k],
            windows.period,
            windows.torque[:, k],
            believed.J,
        )
        previous = network.estimate(x)
        estimates[:, k] = previous
    return estimates
