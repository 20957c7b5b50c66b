"""The time series of a flight as a table, one row per sample."""

import numpy as np
import pyarrow as pa

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Quaternions
from simsat.flight.loop import Flight
from simsat.plant.plant import Plant
from simsat.results.columns import Column, components, table
from simsat.results.metrics import error_deg


def timeseries(flight: Flight, target: Quaternions) -> pa.Table:
    """Columns t_s, q_*, omega_* (rad/s, body), error_deg, q_ref_*, momentum_N_* (Nms, inertial) and
    per wheel wheel_speed_NAME (rad/s) and torque_{command,limited,applied}_NAME (Nm on the rotor).

    `command` is what the controller asks for, `limited` the same inside the torque limit, `applied`
    what acts on the rotor after torque-rate and speed limits. With magnetic rods also field_B_* (T,
    body), and over the tick that ends at the sample dipole_NAME (A m^2) and rod_torque_N_* (Nm,
    inertial): what the momentum gains by them.
    """
    plant, craft = flight.plant, flight.plant.model.spacecraft
    q_ref = np.broadcast_to(target, plant.attitudes.shape)
    command, wheels = flight.held_commands(), craft.wheel_names
    limited = np.clip(command, -craft.torque_max, craft.torque_max)
    return table(
        {
            "t_s": Column(plant.log.t, "s"),
            **components("q", "wxyz", plant.attitudes, "1", "body -> inertial"),
            **components("omega", "xyz", plant.rates, "rad/s", "body"),
            "error_deg": Column(error_deg(flight, target), "deg"),
            **components("q_ref", "wxyz", q_ref, "1", "reference -> inertial"),
            **components("momentum_N", "xyz", plant.momentum_N(), "Nms", "inertial"),
            **components("wheel_speed", wheels, plant.wheel_speeds, "rad/s", "rotor"),
            **components("torque_command", wheels, command, "Nm", "rotor"),
            **components("torque_limited", wheels, limited, "Nm", "rotor"),
            **components("torque_applied", wheels, plant.torques, "Nm", "rotor"),
            **_rods(plant),
        }
    )


def _rods(plant: Plant) -> dict[str, Column]:
    rods = plant.model.spacecraft.rods
    if not rods.count:
        return {}
    to_body = np.swapaxes(attitude.rotation_matrix(plant.attitudes), 1, 2)
    field_B = np.einsum("kij,kj->ki", to_body, plant.field_N())
    return {
        **components("field_B", "xyz", field_B, "T", "body"),
        **components("dipole", rods.names, plant.dipoles, "A m^2", "rod"),
        **components("rod_torque_N", "xyz", plant.rod_torques_N, "Nm", "inertial"),
    }
