"""Outer faces met by a beam, of air or of sunlight."""

from typing import TypeAlias

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.environment.components import Triple

Samples: TypeAlias = Array
"""Shape (k,) for one instant, (k, n) for n of them; k faces."""


def caught(area_normal: Array, source: Triple) -> Samples:
    """A_i max(n_i . s, 0): what each face, (k, 3) area times normal, shows a vector s.

    Faces don't shade each other: panels in their own hull's shadow are pushed a little too much.
    """
    faced: Array = np.maximum(area_normal @ np.array(source), 0.0)
    return faced


def summed(weights: Samples, vectors: Array) -> Triple:
    """sum_i w_i v_i over faces with vectors (k, 3)."""
    total = vectors.T @ weights
    x, y, z = total if total.ndim > 1 else total.tolist()
    return x, y, z
