"""The time series of a flight as a table, one row per sample."""

from pathlib import Path

import numpy as np
import pyarrow as pa

from simsat.control.ground.arrays import Quaternion
from simsat.flight.loop import Flight
from simsat.results.files import write_table
from simsat.results.metrics import error_deg


def timeseries(flight: Flight, target: Quaternion) -> pa.Table:
    """Columns t_s, q_*, omega_* (rad/s, body), error_deg, momentum_N_* (Nms, inertial) and per
    wheel wheel_speed_NAME (rad/s) and torque_{command,limited,applied}_NAME (Nm on the rotor).

    `command` is what the controller asks for, `limited` the same inside the torque limit, `applied`
    what acts on the rotor after torque-rate and speed limits.
    """
    plant, craft = flight.plant, flight.plant.model.spacecraft
    command = flight.held_commands()
    columns = {
        "t_s": plant.log.t,
        **_components("q", "wxyz", plant.attitudes),
        **_components("omega", "xyz", plant.rates),
        "error_deg": error_deg(flight, target),
        **_components("momentum_N", "xyz", plant.momentum_N()),
        **_components("wheel_speed", craft.wheel_names, plant.wheel_speeds),
        **_components("torque_command", craft.wheel_names, command),
        **_components(
            "torque_limited",
            craft.wheel_names,
            np.clip(command, -craft.torque_max, craft.torque_max),
        ),
        **_components("torque_applied", craft.wheel_names, plant.torques),
    }
    return pa.table(columns)


def write_timeseries(flight: Flight, target: Quaternion, path: Path) -> None:
    """Write `timeseries` as Parquet."""
    write_table(path, timeseries(flight, target))


def _components(
    name: str, parts: tuple[str, ...] | str, values: np.ndarray
) -> dict[str, np.ndarray]:
    return {f"{name}_{part}": values[:, i] for i, part in enumerate(parts)}
