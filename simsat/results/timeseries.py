"""The time series of a flight as a table, one row per sample."""

import numpy as np
import pyarrow as pa

from simsat.control.ground.arrays import Quaternion
from simsat.flight.loop import Flight
from simsat.results.columns import Column, components, table
from simsat.results.metrics import error_deg


def timeseries(flight: Flight, target: Quaternion) -> pa.Table:
    """Columns t_s, q_*, omega_* (rad/s, body), error_deg, momentum_N_* (Nms, inertial) and per
    wheel wheel_speed_NAME (rad/s) and torque_{command,limited,applied}_NAME (Nm on the rotor).

    `command` is what the controller asks for, `limited` the same inside the torque limit, `applied`
    what acts on the rotor after torque-rate and speed limits.
    """
    plant, craft = flight.plant, flight.plant.model.spacecraft
    command, wheels = flight.held_commands(), craft.wheel_names
    limited = np.clip(command, -craft.torque_max, craft.torque_max)
    return table(
        {
            "t_s": Column(plant.log.t, "s"),
            **components("q", "wxyz", plant.attitudes, "1", "body -> inertial"),
            **components("omega", "xyz", plant.rates, "rad/s", "body"),
            "error_deg": Column(error_deg(flight, target), "deg"),
            **components("momentum_N", "xyz", plant.momentum_N(), "Nms", "inertial"),
            **components("wheel_speed", wheels, plant.wheel_speeds, "rad/s", "rotor"),
            **components("torque_command", wheels, command, "Nm", "rotor"),
            **components("torque_limited", wheels, limited, "Nm", "rotor"),
            **components("torque_applied", wheels, plant.torques, "Nm", "rotor"),
        }
    )
