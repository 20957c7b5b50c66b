"""A craft that turns smoothly, with a gyro and a tracker whose errors follow the filter's model."""

from dataclasses import dataclass

import numpy as np

from simsat.control.estimator.state import GyroKnowledge
from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import normalized
from simsat.control.ground.turn import turned
from simsat.control.interface.measurement import Fix, History, Measurement

TICK = 0.1
ARCSEC = np.radians(1.0 / 3600.0)
DEG_H = np.radians(1.0) / 3600.0
GYRO = GyroKnowledge(
    tick=TICK,
    angle_random_walk=np.radians(0.15) / 60.0,
    rate_random_walk=3.0 * DEG_H / 60.0,
    bias_deviation=5.0 * DEG_H,
    gain_deviation=np.where(np.eye(3) > 0.0, 5e-4, 5e-4),
)
COVARIANCE = (ARCSEC * np.diag([6.0, 6.0, 40.0])) ** 2


@dataclass(frozen=True)
class Case:
    """Truth and readings at every tick, and the fixes by their own times."""

    t: Array
    q: Array
    bias: Array
    gain_error: Array
    readings: Array
    fixes: tuple[Fix, ...]

    def measurements(self, per_instant: int = 5, latency: int = 0) -> list[Measurement]:
        """What a controller gets every few ticks, fixes so many ticks late."""
        told = []
        for now in range(0, len(self.t), per_instant):
            rows = slice(max(now - per_instant, 0), now + 1)
            since = self.t[max(now - per_instant, -1)] if now else -np.inf
            due = [
                f for f in self.fixes if since + 1e-6 < arrival(f, latency) <= self.t[now] + 1e-6
            ]
            told.append(measurement(self.t[rows], self.readings[rows], tuple(due)))
        return told


def arrival(fix: Fix, latency: int) -> float:
    return fix.t if fix.t == 0.0 else fix.t + latency * TICK


def measurement(t: Array, readings: Array, fixes: tuple[Fix, ...]) -> Measurement:
    wheels = np.zeros((len(t), 2))
    q = np.array([1.0, 0.0, 0.0, 0.0])
    history = History(t, readings, wheels)
    return Measurement(float(t[-1]), q, readings[-1], wheels[-1], np.zeros(2), history, fixes=fixes)


def slew(seed: int, seconds: float = 40.0, rate_limit_deg_s: float = np.inf) -> Case:
    """A slew that peaks at 12 deg/s and ends in rest; two fixes a second unless too fast."""
    rng = np.random.default_rng(seed)
    t: Array = TICK * np.arange(round(seconds / TICK) + 1, dtype=np.float64)
    axis = rng.standard_normal(3)
    axis /= np.linalg.norm(axis)
    other = np.cross(axis, rng.standard_normal(3))
    s = np.clip(t / (0.6 * seconds), 0.0, 1.0)[:, None]
    omega = np.radians(12.0) * np.sin(np.pi * s) ** 2 * (axis + np.sin(2.0 * np.pi * s) * other)
    q = [normalized(rng.standard_normal(4))]
    for k in range(len(t) - 1):
        q.append(turned(q[-1], 0.5 * TICK * (omega[k] + omega[k + 1])))
    walk = GYRO.rate_random_walk * np.sqrt(TICK) * rng.standard_normal((len(t), 3))
    bias = GYRO.bias_deviation * rng.standard_normal(3) + np.cumsum(walk, axis=0)
    E = GYRO.gain_deviation * rng.standard_normal((3, 3))
    white = GYRO.angle_random_walk / np.sqrt(TICK) * rng.standard_normal((len(t), 3))
    readings: Array = omega @ (np.eye(3) + E).T + bias + white
    fixes = tuple(
        Fix(float(t[k]), turned(q[k], np.linalg.cholesky(COVARIANCE) @ rng.standard_normal(3)),
            COVARIANCE)
        for k in range(0, len(t), 5)
        if k == 0 or np.linalg.norm(omega[k]) < np.radians(rate_limit_deg_s)
    )  # fmt: skip
    return Case(t, np.array(q), bias, E, readings, fixes)
