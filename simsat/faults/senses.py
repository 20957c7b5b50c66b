"""The faults that are the instruments', as instruments around the sound ones."""

import math
from dataclasses import dataclass, replace

import numpy as np

from simsat.control.ground.arrays import Array, Quaternion
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.interface.measurement import Fix
from simsat.faults.fault import GYRO, Fault, Kind
from simsat.plant.plant import Plant
from simsat.sensors.suite import AttitudeSource, Reading, Rows, Suite


@dataclass(frozen=True)
class Stuck:
    """One component of a reading repeats what it read last."""

    inner: Reading
    component: int
    first: int
    """The sample from which on it is stuck."""
    last: float
    """The sample from which on it is well again."""

    def __call__(self, plant: Plant, rows: Rows) -> Array:
        """The reading."""
        told = self.inner(plant, rows).copy()
        stuck = (rows >= self.first) & (rows < self.last)
        if stuck.any():
            held = self.inner(plant, np.array([self.first]))
            told[stuck, self.component] = held[0, self.component]
        return told


@dataclass(frozen=True)
class Biased:
    """One component of a reading is off by so much."""

    inner: Reading
    component: int
    by: float
    first: int
    last: float

    def __call__(self, plant: Plant, rows: Rows) -> Array:
        """The reading."""
        told = self.inner(plant, rows).copy()
        told[(rows >= self.first) & (rows < self.last), self.component] += self.by
        return told


@dataclass(frozen=True)
class Blinded:
    """An attitude instrument that finds none for a while."""

    inner: AttitudeSource
    first: int
    last: float
    tick: float

    def attitude(self, plant: Plant, row: int) -> Quaternion:
        """What was told last before it went blind."""
        return self.inner.attitude(plant, self.first if self.first <= row < self.last else row)

    def fixes(self, plant: Plant, rows: Rows) -> tuple[Fix, ...]:
        """Those that were taken while it saw."""
        told = self.inner.fixes(plant, rows)
        return tuple(f for f in told if not self.first <= round(f.t / self.tick) < self.last)


def faulty(suite: Suite, faults: tuple[Fault, ...], craft: Spacecraft, tick: float) -> Suite:
    """The instruments with the faults that are theirs; the suite itself where there are none."""
    sound = suite
    for fault in faults:
        first = round(fault.start / tick)
        last = math.inf if math.isinf(fault.end) else round(fault.end / tick)
        if fault.kind is Kind.STUCK:
            stuck = Stuck(suite.gyro, GYRO.index(fault.part), first, last)
            suite = replace(suite, gyro=stuck)
        elif fault.kind is Kind.BIAS:
            by = math.radians(fault.values[0])
            suite = replace(suite, gyro=Biased(suite.gyro, GYRO.index(fault.part), by, first, last))
        elif fault.kind is Kind.TACHOMETER:
            wheel = craft.wheel_names.index(fault.part)
            suite = replace(suite, tachometers=Stuck(suite.tachometers, wheel, first, last))
        elif fault.kind is Kind.OUT:
            suite = replace(suite, attitudes=Blinded(suite.attitudes, first, last, tick))
    return suite if suite is sound else replace(suite, needs_all=True)
