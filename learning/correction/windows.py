"""Telemetry cut into windows that start at control instants, with what the nominal model misses.

Between two control instants the command is constant, so that a window of one control period is the
longest over which "the torque about to be applied" means one thing.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simsat.control.correction.features import features
from simsat.control.ground.arrays import Array, WheelVector
from simsat.control.model.ramp import ramped_torques
from simsat.control.model.rates import RateModel, residual_torque


@dataclass(frozen=True)
class Telemetry:
    """One flight as sampled at 20 Hz."""

    sample: float
    """Interval between samples, s."""
    omega: Array
    """Body rates, rad/s, body axes, shape (rows, 3)."""
    wheel_speed: Array
    """Wheel speeds, rad/s, shape (rows, m)."""
    torque: Array
    """Torque commanded over each control period, Nm, shape (periods, m)."""


@dataclass(frozen=True)
class Windows:
    """R flights of K control periods each; every array is (R, K, ...)."""

    omega: Array
    """Rates at the start of the window, rad/s, body axes."""
    omega_before: Array
    """Rates one period earlier; at a flight's start those at its start."""
    wheel_speed: Array
    torque: Array
    """Torque commanded over the window, Nm."""
    torques: Array
    """Mean torque in each of the H sub-steps, its ramp included, Nm, (R, K, H, m)."""
    omega_after: Array
    """Rates at the end of the window."""
    residual: Array
    """Torque on the wheel axes that the nominal model misses (see `residual_torque`), Nm."""
    period: float
    """Length of a window, s."""

    @property
    def flights(self) -> int:
        """Number of flights, R."""
        return len(self.omega)

    def pick(self, flights: Any) -> "Windows":
        """Some of the flights, by their indices."""
        arrays: dict[str, Any] = {name: getattr(self, name)[flights] for name in ARRAYS}
        return replace(self, **arrays)

    def features(self, previous: Array, believed: RateModel) -> Array:
        """Inputs of the network (R, K, inputs), given the previous estimates (R, K, m)."""
        before = self.omega_before
        return features(previous, self.omega, before, self.period, self.torque, believed.J)


ARRAYS = (
    "omega",
    "omega_before",
    "wheel_speed",
    "torque",
    "torques",
    "omega_after",
    "residual",
)


def joined(first: Windows, second: Windows) -> Windows:
    """The flights of both, which must be equally long."""
    pairs = ((name, getattr(first, name), getattr(second, name)) for name in ARRAYS)
    arrays: dict[str, Any] = {name: np.concatenate([a, b]) for name, a, b in pairs}
    return replace(first, **arrays)


def cut(
    flights: list[Telemetry], period: float, believed: RateModel, rate_max: WheelVector
) -> Windows:
    """Windows of flights of equal length; `rate_max` is the motors' torque-rate limit, Nm/s."""
    ticks = round(period / flights[0].sample)
    omega, speed, torque = (
        np.stack([getattr(flight, name) for flight in flights])
        for name in ("omega", "wheel_speed", "torque")
    )
    start = np.arange(torque.shape[1]) * ticks
    torque_before = np.concatenate([np.zeros_like(torque[:, :1]), torque[:, :-1]], axis=1)
    torques = ramped_torques(torque, torque_before, rate_max, period)
    now, after = omega[:, start], omega[:, start + ticks]
    return Windows(
        omega=now,
        omega_before=omega[:, np.maximum(start - ticks, 0)],
        wheel_speed=speed[:, start],
        torque=torque,
        torques=torques,
        omega_after=after,
        residual=residual_torque(believed, now, speed[:, start], torques, after, period),
        period=period,
    )


def shifted(estimates: Array) -> Array:
    """Estimates (R, K, m) one period later, zero at the start: the network's first inputs."""
    return np.concatenate([np.zeros_like(estimates[:, :1]), estimates[:, :-1]], axis=1)
