"""What every field model answers."""

from collections.abc import Callable
from typing import TypeAlias

from simsat.environment.components import Number, Triple

MagneticField: TypeAlias = Callable[[Number], Triple]
"""Time (s) -> B where the spacecraft then is, T, inertial axes; one instant or an array of them."""
