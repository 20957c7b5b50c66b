"""How the filter expects the appendage momentum c to go on.

A spacecraft that is not rigid carries momentum beside J omega in panels that bend or propellant
that swings. c comes and goes as a first-order Gauss-Markov process (Bar-Shalom, Li and Kirubarajan,
section 8.2); without it a vibration would be taken for inertia and for external torque. The hub
turns by what the appendages' deflection takes,

    theta' = -J^-1 c        (less what is forgotten)
"""

import numpy as np

from ...ground.arrays import Array, Vector3
from .estimate import ModelEstimate

CORRELATION_TIME = 0.1  # s, of c: well below a panel's period, so that little of it stays at rest
DEFLECTION_TIME = 5.0  # s: slower motion of the appendages is not told from the body's own


def appendage_correlation(dt: Array) -> Array:
    """Share of c that is left after so many seconds."""
    return np.asarray(np.exp(-dt / CORRELATION_TIME))


def next_deflection(before: ModelEstimate, after: ModelEstimate) -> Vector3:
    """The deflection a sample later, rad."""
    dt = after.t - before.t
    c = 0.5 * (before.appendage_momentum + after.appendage_momentum)
    return np.exp(-dt / DEFLECTION_TIME) * before.deflection - dt * np.linalg.solve(after.J, c)
