"""Names for array shapes: a signature says what it takes, the docstring adds frame and unit."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Vector3: TypeAlias = NDArray[np.float64]
"""Shape (3,), or (..., 3) where the docstring allows a batch."""

Matrix3: TypeAlias = NDArray[np.float64]
"""Shape (3, 3)."""

Quaternion: TypeAlias = NDArray[np.float64]
"""Shape (4,) or (..., 4): unit, scalar first (w, x, y, z), body -> inertial (see `attitude`)."""

WheelVector: TypeAlias = NDArray[np.float64]
"""Shape (m,): one number per wheel, in the order of the model file's actuators."""

WheelAxes: TypeAlias = NDArray[np.float64]
"""Shape (3, m): one unit spin axis per column, in body axes."""

Array: TypeAlias = NDArray[np.float64]
"""Any other shape; the docstring says which."""

Symbol: TypeAlias = Any
"""A CasADi expression, SX or MX: a column vector unless said otherwise."""
