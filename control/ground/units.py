"""A craft's own units, in which every spacecraft is as large and as quick as the benchmark.

Wheels of torque u turn an inertia J through a given angle in a time that goes with

    T0 = sqrt(J / u)          the natural time,

with J the mean principal inertia and u the weakest wheel's torque limit. Written in units of J and
T0 the equations of motion hold neither any more: a PocketQube (T0 = 3 s) and Hubble (300 s) fly the
same flight. So controllers think in these units, and each of their constants means the same for a
craft of any size. The units are scaled so that those of the benchmark, `models/two_wheel`, are SI:

    own second   T0 / T0 of the benchmark          own unit of inertia   J / J of the benchmark

All others follow from the two. A craft whose wheels have no torque limit has no natural time: its
own second is the second. Source: dimensional analysis (Buckingham, Phys. Rev. 4, 345, 1914).
"""

import math
from dataclasses import dataclass

BENCHMARK_INERTIA = 1.46  # kg m^2, a third of the trace of J of models/two_wheel
BENCHMARK_TORQUE = 0.05  # Nm, of its wheels
BENCHMARK_NATURAL_TIME = math.sqrt(BENCHMARK_INERTIA / BENCHMARK_TORQUE)  # 5.4 s
DIGITS = 9  # of a unit: round-off in a file's inertia moves none


@dataclass(frozen=True)
class Units:
    """What the units are in SI; those of the benchmark unless told otherwise."""

    time: float = 1.0
    """The own second, s."""
    inertia: float = 1.0
    """The own unit of inertia, in kg m^2."""

    @property
    def natural_time(self) -> float:
        """T0 of the craft, s."""
        return self.time * BENCHMARK_NATURAL_TIME

    @property
    def rate(self) -> float:
        """Of angular rates, rad/s."""
        return 1.0 / self.time

    @property
    def momentum(self) -> float:
        """Nms."""
        return self.inertia / self.time

    @property
    def torque(self) -> float:
        """Nm."""
        return self.inertia / self.time**2

    @property
    def torque_rate(self) -> float:
        """Nm/s."""
        return self.inertia / self.time**3

    @property
    def back(self) -> "Units":
        """SI as seen from these units: what `in_units(units)` has converted, `in_units(units.back)`
        converts back."""
        return Units(1.0 / self.time, 1.0 / self.inertia)

    def of(self, name: str) -> float:
        """The unit of a quantity by the unit that its name ends in (`time_to_go_s`); 1 for angles
        and pure numbers."""
        for suffix, unit in (
            ("_rad_s", self.rate),
            ("_deg_s", self.rate),
            ("_Nms", self.momentum),
            ("_Nm", self.torque),
            ("_s", self.time),
        ):
            if name.endswith(suffix):
                return unit
        return 1.0


def units_for(inertia: float, torque: float) -> Units:
    """The units of a craft with this mean principal inertia (kg m^2) and torque limit (Nm; inf is
    none)."""
    size = inertia / BENCHMARK_INERTIA
    if math.isinf(torque):
        return Units(1.0, _rounded(size))
    return Units(_rounded(math.sqrt(inertia / torque) / BENCHMARK_NATURAL_TIME), _rounded(size))


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS - 1}e}")
