"""What the believed model missed along a flight: known to the simulator, for the recording."""

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.model.ramp import ramped_torques
from simsat.control.model.rates import RateModel, residual_torque
from simsat.flight.loop import Flight


def true_residuals(flight: Flight, believed: RateModel, first: int = 0) -> Array:
    """Residual torque on the wheel axes of every control period from `first` on, Nm, (k, m).

    From the true rates at the ends of each period: what an ideal estimator would have said. A
    period that was not flown to its end has none, nor has one in a log that is thinner than that.
    """
    plant, ticks = flight.plant, flight.ticks_per_period
    keep = round(plant.log.tick / plant.tick)
    if ticks % keep:
        return np.zeros((0, plant.torques.shape[1]))  # the log has no sample at their ends
    whole = min(len(flight.commands), (plant.log.rows - 1) * keep // ticks)
    commands = np.array(flight.commands[:whole]).reshape(whole, plant.torques.shape[1])
    before = np.concatenate([np.zeros_like(commands[:1]), commands[:-1]])
    period = ticks * plant.tick
    rate_max = plant.model.spacecraft.torque_rate_max
    torques = ramped_torques(commands[first:], before[first:], rate_max, period)
    rows, stride = np.arange(first, whole) * (ticks // keep), ticks // keep
    rates, speeds = plant.rates, plant.wheel_speeds[rows]
    return residual_torque(believed, rates[rows], speeds, torques, rates[rows + stride], period)
