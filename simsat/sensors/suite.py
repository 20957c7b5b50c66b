"""All instruments of a craft as what the loop senses with."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from simsat.control.ground.arrays import Array, Quaternion, WheelVector
from simsat.control.interface.measurement import Fix, History, Measurement, Sighting
from simsat.plant.plant import Plant

Rows = NDArray[np.int64]

Reading = Callable[[Plant, Rows], Array]
"""(plant, samples) -> what was read at each of them, shape (k, ...)."""


class AttitudeSource(Protocol):
    """An instrument that finds attitudes."""

    def attitude(self, plant: Plant, row: int) -> Quaternion:
        """The attitude that was told last at a sample: what a controller without an estimator
        believes."""
        ...

    def fixes(self, plant: Plant, rows: Rows) -> tuple[Fix, ...]:
        """What is delivered at these samples, for an estimator."""
        ...


Sights = Callable[[Plant, Rows], tuple[Sighting, ...]]
"""(plant, samples) -> the known directions seen at them."""


@dataclass(frozen=True)
class Suite:
    """A gyro, tachometers and attitudes, and further instruments that see known directions."""

    gyro: Reading
    """rad/s, body axes, shape (k, 3)."""
    tachometers: Reading
    """rad/s, shape (k, m)."""
    attitudes: AttitudeSource
    sights: tuple[Sights, ...] = ()
    needs_all: bool = True
    """Whether any of them looks back to samples that a log may have dropped."""

    def __call__(self, plant: Plant, samples: int, torque: WheelVector) -> Measurement:
        """The measurement at the plant's newest sample, with those since the last instant."""
        newest = plant.sampled - 1
        rows = np.arange(newest - samples, newest + 1)
        t = plant.recent(samples + 1).t
        omega, speed = self.gyro(plant, rows), self.tachometers(plant, rows)
        new = rows[1:] if samples else rows
        return Measurement(
            t[-1],
            self.attitudes.attitude(plant, newest),
            omega[-1],
            speed[-1],
            torque,
            History(t, omega, speed),
            plant.commanded_dipole,
            fixes=self.attitudes.fixes(plant, new),
            sightings=tuple(sight for sights in self.sights for sight in sights(plant, new)),
        )
