"""The linear baseline: least squares from the same inputs, without the previous estimate.

The residual torque is almost linear in the motor torque, so that this is a serious opponent.
"""

import numpy as np

from simsat.control.correction.network import Network
from simsat.control.model.rates import RateModel

from .windows import Windows

RANK_TOLERANCE = 1e-3  # relative; at zero momentum inputs depend on each other up to noise


def fit_linear(windows: Windows, believed: RateModel) -> Network:
    """Least squares of the missed torque over all windows, as a one-layer network."""
    wheels = windows.torque.shape[-1]
    x = windows.features(np.zeros_like(windows.torque), believed)
    x = x.reshape(-1, x.shape[-1])
    y = windows.residual.reshape(-1, wheels)
    mean, spread = x.mean(axis=0), x.std(axis=0)
    scale = np.where(spread > 0.0, spread, 1.0)
    solution = np.linalg.lstsq((x - mean) / scale, y - y.mean(axis=0), rcond=RANK_TOLERANCE)[0]
    return Network(mean, scale, (solution.T,), (y.mean(axis=0),), bound=None)
