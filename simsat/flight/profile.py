"""A torque profile to play open loop: someone's flight data, or another simulator's."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternion, Vector3, WheelVector
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.flight.archive import read_arrays
from simsat.settings import RATE_MAX_DEG_S, SAMPLES_MAX, has_direction

PADDING = 1_000_000  # bytes: headers, and what is beside the torques
NEEDED = ("u", "dt_u")
OPTIONAL = ("q0", "w0", "Om0")


@dataclass(frozen=True)
class Profile:
    """Wheel torques over time, and the state they start from."""

    torque: Array
    """Motor torque on each rotor, Nm, shape (rows, m): wheels in the order of the model file's
    actuators, each row held for `row_s`."""
    row_s: float
    """Length of a row, s."""
    q: Quaternion
    """Attitude at the start, body -> inertial."""
    omega: Vector3
    """Body rate at the start, body axes, rad/s."""
    wheel_speed: WheelVector
    """Wheel speeds at the start, relative to the hub, rad/s."""


def read_profile(path: Path, craft: Spacecraft) -> Profile:
    """Read a profile for this spacecraft from a NumPy archive.

    `u` (rows, m) in Nm and `dt_u` in s; optional `q0` (4,), `w0` (3,) in rad/s and `Om0` (m,) in
    rad/s, else the identity attitude at rest. Other entries are ignored.

    Raises `SettingsError` on a missing file or entry, a wrong shape or a number that isn't finite.
    """
    m = craft.wheels
    entries = _load(path, m)
    torque = _numbers(path, entries, "u")
    if torque.ndim != 2 or torque.shape[1] != m or len(torque) == 0:
        raise SettingsError(
            f"profile '{path}': u has the shape {torque.shape}, but '{craft.name}' has {m} "
            f"wheels ({', '.join(craft.wheel_names)}): it must be (rows, {m})"
        )
    row_s = _numbers(path, entries, "dt_u")
    if row_s.size != 1 or row_s.item() <= 0.0:
        raise SettingsError(f"profile '{path}': dt_u must be one number of seconds above zero")
    start = {
        "q0": attitude.IDENTITY,
        "w0": np.zeros(3),
        "Om0": np.zeros(m),
        **{name: _numbers(path, entries, name) for name in OPTIONAL if name in entries},
    }
    for name, shape in (("q0", (4,)), ("w0", (3,)), ("Om0", (m,))):
        if start[name].shape != shape:
            raise SettingsError(
                f"profile '{path}': {name} has the shape {start[name].shape}, it must be {shape}"
            )
    if not has_direction(start["q0"]):
        raise SettingsError(
            f"profile '{path}': q0 is zero or huge, it must be a quaternion w x y z"
        )
    if np.any(np.abs(start["w0"]) > np.radians(RATE_MAX_DEG_S)):
        raise SettingsError(f"profile '{path}': w0 is beyond {RATE_MAX_DEG_S:g} deg/s")
    return Profile(
        torque, row_s.item(), attitude.normalized(start["q0"]), start["w0"], start["Om0"]
    )


def _load(path: Path, wheels: int) -> dict[str, Array]:
    longest = 8 * SAMPLES_MAX * wheels + PADDING
    entries, found = read_arrays(path, (*NEEDED, *OPTIONAL), longest)
    missing = [name for name in NEEDED if name not in entries]
    if missing:
        raise SettingsError(
            f"profile '{path}' has no {' and no '.join(missing)}, only {', '.join(found)}; "
            "it needs u (rows, wheels) in Nm and dt_u in s"
        )
    return entries


def _numbers(path: Path, entries: dict[str, Array], name: str) -> Array:
    try:
        values = np.asarray(entries[name]).astype(float, casting="same_kind")
    except (TypeError, ValueError):
        raise SettingsError(f"profile '{path}': {name} holds no numbers") from None
    if not np.all(np.isfinite(values)):
        raise SettingsError(f"profile '{path}': {name} holds a number that isn't finite")
    return values
