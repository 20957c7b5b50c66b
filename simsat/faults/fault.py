"""A fault as data, and its text: PART:KIND[=VALUE]@START[-END], times in s.

wheel_z:dead@6            its motor gives no torque, the rotor coasts
wheel_z:seize@4           its rotor locks to the hub
wheel_z:weak=0.3@4-20     its motor gives 0.3 of what is asked
wheel_z:friction=0.002@4  its bearing takes 2 mNm more (Coulomb)
wheel_z:tachometer@4      its tachometer repeats what it read last
tracker:out@10-40         no attitude is found
gyro_x:stuck@5            an axis repeats what it read last
gyro_y:bias=0.1@5         an axis reads 0.1 deg/s more
rod_x:on@5-60             a magnetic rod stays at its largest dipole
body:inertia=1.3@8        the hub's inertia, one factor or three about its principal axes
"""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from simsat.control.ground.errors import SettingsError
from simsat.control.ground.spacecraft import Spacecraft

GYRO = tuple(f"gyro_{axis}" for axis in "xyz")
TRACKER, BODY = "tracker", "body"
FORM = re.compile(
    r"(?P<part>[^:@=]+):(?P<kind>[^:@=]+)(=(?P<value>[^@]+))?@(?P<start>[^@-]+)(-(?P<end>[^@-]+))?"
)


class Kind(StrEnum):
    """What can happen, by the name in a fault's text."""

    DEAD = "dead"
    SEIZE = "seize"
    WEAK = "weak"
    FRICTION = "friction"
    TACHOMETER = "tachometer"
    OUT = "out"
    STUCK = "stuck"
    BIAS = "bias"
    ON = "on"
    INERTIA = "inertia"


WHEEL_KINDS = (Kind.DEAD, Kind.SEIZE, Kind.WEAK, Kind.FRICTION, Kind.TACHOMETER)
VALUED = {Kind.WEAK: "a share of 0 to 1", Kind.FRICTION: "a torque in Nm, above 0",
          Kind.BIAS: "a rate in deg/s", Kind.INERTIA: "one or three factors above 0"}  # fmt: skip
FOR_GOOD = (Kind.SEIZE, Kind.INERTIA)


@dataclass(frozen=True)
class Fault:
    """Something that breaks at `start` and, unless it is for good, is well again at `end`."""

    part: str
    kind: Kind
    values: tuple[float, ...]
    start: float
    """s."""
    end: float = math.inf

    @property
    def text(self) -> str:
        """As `read_fault` reads it."""
        value = "=" + " ".join(f"{v:g}" for v in self.values) if self.values else ""
        until = "" if math.isinf(self.end) else f"-{self.end:g}"
        return f"{self.part}:{self.kind}{value}@{self.start:g}{until}"

    def acts_at(self, t: float) -> bool:
        """Whether it is there at t."""
        return self.start <= t < self.end


def acting(faults: Iterable[Fault], t: float) -> str:
    """The faults that are there at t, in words."""
    return ", ".join(f"{fault.part} {fault.kind}" for fault in faults if fault.acts_at(t))


def read_faults(texts: Iterable[str], craft: Spacecraft) -> tuple[Fault, ...]:
    """The faults that the texts state, in order of time.

    Raises `SettingsError` for a text that is none, or a part or kind that the craft hasn't.
    """
    faults = [read_fault(text, craft) for text in texts]
    return tuple(sorted(faults, key=lambda fault: fault.start))


def read_fault(text: str, craft: Spacecraft) -> Fault:
    """The fault that the text states. Raises `SettingsError` likewise."""
    match = FORM.fullmatch(text.strip())
    if match is None:
        raise SettingsError(
            f"--fault '{text}' is no fault: give PART:KIND@START, PART:KIND=VALUE@START or "
            "PART:KIND@START-END with times in s, for example wheel_z:seize@4"
        )
    kind = _kind(text, match["part"], match["kind"], craft)
    values = _values(text, kind, match["value"])
    start = _time(text, match["start"])
    if match["end"] is None:
        return Fault(match["part"], kind, values, start)
    end = _time(text, match["end"])
    if kind in FOR_GOOD:
        raise SettingsError(f"--fault '{text}' has an end, but '{kind}' is for good")
    if not end > start:
        raise SettingsError(f"--fault '{text}' ends at {end:g} s, not after its start")
    return Fault(match["part"], kind, values, start, end)


def _kind(text: str, part: str, kind: str, craft: Spacecraft) -> Kind:
    kinds = kinds_of(part, craft)
    if not kinds:
        parts = ", ".join((*craft.wheel_names, *craft.rods.names, TRACKER, *GYRO, BODY))
        raise SettingsError(f"--fault '{text}': '{craft.name}' has no '{part}'; there are: {parts}")
    if kind not in kinds:
        raise SettingsError(f"--fault '{text}': '{part}' can be {', '.join(kinds)}, not '{kind}'")
    return Kind(kind)


def kinds_of(part: str, craft: Spacecraft) -> tuple[Kind, ...]:
    """What can happen to a part; nothing to one that there isn't."""
    if part in craft.wheel_names:
        return WHEEL_KINDS
    if part in craft.rods.names:
        return (Kind.ON,)
    kinds = {TRACKER: (Kind.OUT,), BODY: (Kind.INERTIA,)}
    return (Kind.STUCK, Kind.BIAS) if part in GYRO else kinds.get(part, ())


def _values(text: str, kind: Kind, given: str | None) -> tuple[float, ...]:
    if kind not in VALUED:
        if given is not None:
            raise SettingsError(f"--fault '{text}': '{kind}' takes no value")
        return ()
    numbers = _numbers(given or "")
    allowed = {
        Kind.WEAK: len(numbers) == 1 and bool((numbers >= 0.0).all() and (numbers <= 1.0).all()),
        Kind.FRICTION: len(numbers) == 1 and bool((numbers > 0.0).all()),
        Kind.BIAS: len(numbers) == 1,
        Kind.INERTIA: len(numbers) in (1, 3) and bool((numbers > 0.0).all()),
    }
    if not allowed[kind]:
        raise SettingsError(f"--fault '{text}': '{kind}' takes {VALUED[kind]}, as {kind}=VALUE")
    return tuple(numbers.tolist())


def _numbers(text: str) -> np.ndarray:
    try:
        numbers = np.array([float(part) for part in text.replace(",", " ").split()])
    except ValueError:
        return np.zeros(0)
    return numbers if np.isfinite(numbers).all() else np.zeros(0)


def _time(text: str, given: str) -> float:
    numbers = _numbers(given)
    if len(numbers) != 1 or not numbers[0] >= 0.0:
        raise SettingsError(f"--fault '{text}': '{given}' is no time: give seconds from 0 up")
    return float(numbers[0])
