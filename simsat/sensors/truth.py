"""Instruments without an error, for faults on flights that show the controller the truth."""

from dataclasses import dataclass

from simsat.control.ground.arrays import Array, Quaternion
from simsat.control.interface.measurement import Fix
from simsat.plant.plant import Plant
from simsat.sensors.suite import Rows, Suite


@dataclass(frozen=True)
class TrueAttitude:
    """The attitude as it is; nothing is late, so that no estimator is needed."""

    def attitude(self, plant: Plant, row: int) -> Quaternion:
        """Body -> inertial."""
        return plant.attitudes[row].copy()

    def fixes(self, plant: Plant, rows: Rows) -> tuple[Fix, ...]:
        """None."""
        return ()


def true_rates(plant: Plant, rows: Rows) -> Array:
    """Body rates, rad/s."""
    return plant.rates[rows]


def true_wheel_speeds(plant: Plant, rows: Rows) -> Array:
    """Wheel speeds, rad/s."""
    return plant.wheel_speeds[rows]


TRUTH = Suite(true_rates, true_wheel_speeds, TrueAttitude(), needs_all=False)
"""Says the same as `sense_truth`."""
