"""Names for array shapes: a signature says what it takes, the docstring adds frame and unit.

mypy tells kinds apart by their axes: the last one is 3 (vector) or 4 (quaternion), two of them are
a matrix, one is a value per wheel. Each passed for another is an error, except wheel axes for a
matrix. It counts neither batches nor wheels, and what a NumPy operation returns (also `Array` and
`WheelVectors`) has any shape to it: that flows into every name unseen.

The tests check the rest, numbers included, at every call of the packages that tests/shape_checks.py
names: the shapes below, the type float64, one m and batches that broadcast within a call. Elsewhere
jaxtyping is not imported, and nothing is checked.

NumPy gives `np.zeros(3)` the type of one axis of any length; a Vector3 is written out,
`np.array([0.0, 0.0, 0.0])`, which has any shape to mypy.
"""

import sys
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING or "jaxtyping" not in sys.modules:  # its import would cost every start 30 ms
    Vector3: TypeAlias = np.ndarray[tuple[*tuple[int, ...], Literal[3]], np.dtype[np.float64]]
    """Shape (3,)."""

    Vectors3: TypeAlias = Vector3
    """Shape (..., 3): one or a batch."""

    Matrix3: TypeAlias = np.ndarray[tuple[int, int], np.dtype[np.float64]]
    """Shape (3, 3)."""

    Matrices3: TypeAlias = Matrix3
    """Shape (..., 3, 3): one or a batch."""

    Quaternion: TypeAlias = np.ndarray[tuple[*tuple[int, ...], Literal[4]], np.dtype[np.float64]]
    """Shape (4,): unit, scalar first (w, x, y, z), body -> inertial (see `attitude`)."""

    Quaternions: TypeAlias = Quaternion
    """Shape (..., 4): one or a batch."""

    WheelVector: TypeAlias = np.ndarray[tuple[int], np.dtype[np.float64]]
    """Shape (m,): one number per wheel, in the order of the model file's actuators."""

    WheelVectors: TypeAlias = NDArray[np.float64]
    """Shape (..., m): one or a batch."""

    WheelAxes: TypeAlias = np.ndarray[tuple[Literal[3], int], np.dtype[np.float64]]
    """Shape (3, m): one unit spin axis per column, in body axes."""

    RodVector: TypeAlias = np.ndarray[tuple[int], np.dtype[np.float64]]
    """Shape (k,): one number per magnetorquer, in the order of the model file's tuple."""

    Rods: TypeAlias = NDArray[np.float64]
    """Shape (..., k): one or a batch."""

    RodAxes: TypeAlias = np.ndarray[tuple[Literal[3], int], np.dtype[np.float64]]
    """Shape (3, k): one unit axis per column, in body axes."""

    Array: TypeAlias = NDArray[np.float64]
    """Any other shape; the docstring says which."""
else:
    from jaxtyping import Float64

    Vector3 = Float64[np.ndarray, "3"]
    Vectors3 = Float64[np.ndarray, "*#batch 3"]
    Matrix3 = Float64[np.ndarray, "3 3"]
    Matrices3 = Float64[np.ndarray, "*#batch 3 3"]
    Quaternion = Float64[np.ndarray, "4"]
    Quaternions = Float64[np.ndarray, "*#batch 4"]
    WheelVector = Float64[np.ndarray, "m"]
    WheelVectors = Float64[np.ndarray, "*#batch m"]
    WheelAxes = Float64[np.ndarray, "3 m"]
    RodVector = Float64[np.ndarray, "k"]
    Rods = Float64[np.ndarray, "*#batch k"]
    RodAxes = Float64[np.ndarray, "3 k"]
    Array = Float64[np.ndarray | np.float64, "..."]  # a reduction to no axes leaves a scalar

Symbol: TypeAlias = Any
"""A CasADi expression, SX or MX: a column vector unless said otherwise."""
