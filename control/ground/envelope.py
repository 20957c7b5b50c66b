"""A motor's torque-speed envelope: what it gives of its torque limit as the wheel turns faster.

A motor at a voltage V gives (V - K Omega) / R of current, K of torque for each: back-emf takes the
torque away along a straight line that ends at the no-load speed V / K. Below the knee the current
limit is the smaller one. Data sheets draw both as a polygon over |speed|, and so does this class.

It is about torque that drives the wheel on, u Omega > 0. Braking torque is up to the torque limit
at any speed: back-emf then adds to the voltage.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .arrays import Array
from .units import Units


@dataclass(frozen=True)
class TorqueEnvelope:
    """Available driving torque over |speed|: linear between the points, constant behind the last.

    The first point is at rest, speeds ascend, torques do not rise.
    """

    points: tuple[tuple[float, float], ...]
    """(speed in rad/s relative to the hub, torque in Nm)."""

    def available(self, speed: Array | float) -> Array:
        """Largest driving torque at a speed of either sign, Nm, shaped as the speeds."""
        speeds, torques = np.transpose(self.points)
        return np.asarray(np.interp(np.abs(speed), speeds, torques))

    @property
    def stall(self) -> float:
        """Torque at rest, the largest, Nm."""
        return self.points[0][1]

    @property
    def knee(self) -> float:
        """Speed up to which the torque at rest is available, rad/s; inf if always."""
        flat = [speed for speed, torque in self.points if torque == self.stall]
        return flat[-1] if len(flat) < len(self.points) else math.inf

    def held(self, speed: float, half_gain: float) -> float:
        """Torque u >= 0 to hold over a time step that drives a wheel of `speed` >= 0 on, Nm.

        It is what is available in the middle of the step, u = T(speed + half_gain u), with
        half_gain the speed (rad/s) that 1 Nm brings in half a step: exact to second order, and
        stable however steep the line is.
        """
        for (s0, t0), (s1, t1) in self._segments():
            slope = (t1 - t0) / (s1 - s0)
            torque = (t0 + slope * (speed - s0)) / (1.0 - slope * half_gain)
            if speed + half_gain * torque <= s1:
                return torque
        return self.points[-1][1]

    def in_units(self, units: Units) -> "TorqueEnvelope":
        """The same in other units."""
        return TorqueEnvelope(tuple((s / units.rate, t / units.torque) for s, t in self.points))

    def capped(self, limit: float) -> "TorqueEnvelope":
        """The same under a torque limit, Nm."""
        points = [(0.0, min(self.stall, limit))]
        for (s0, t0), (s1, t1) in self._segments():
            if t0 > limit > t1:
                points.append((s0 + (t0 - limit) / (t0 - t1) * (s1 - s0), limit))
            points.append((s1, min(t1, limit)))
        return TorqueEnvelope(tuple(points))

    def fastest_box(self, rotation: float, speed_max: float) -> tuple[float, float]:
        """(torque, speed) under the envelope within which a slew from rest to rest ends soonest.

        Ramping to a wheel speed s at T(s), coasting and ramping back takes 1 / (c s) + s / T(s), in
        units of the spin inertia, with c = Js^2 / (angle J); at c s^2 = T(s) nothing is left to
        coast, and faster is of no use. `rotation` is c, Nm/(rad/s)^2. The speed given is the
        largest at which that torque is still there: whoever keeps both is never cut.
        """
        speeds = {speed for speed in self._turning_points(rotation) if 0.0 < speed <= speed_max}
        if math.isfinite(speed_max):
            speeds.add(speed_max)
        useful = [s for s in speeds if rotation * s * s <= self._at(s) * (1.0 + 1e-9)]
        best = min(useful, key=lambda s: 1.0 / (rotation * s) + s / self._at(s))
        torque = self._at(best)
        return torque, min(self._edge(torque), speed_max)

    def _turning_points(self, c: float) -> Iterator[float]:
        """Speeds at which the time of a slew can be least: ends of the lines a - b s, where nothing
        is left to coast, and where the derivative is zero."""
        last = self.points[-1]
        tail = (last, (last[0] + 1.0, last[1]))
        for (s0, t0), (s1, t1) in (*self._segments(), tail):
            b = (t0 - t1) / (s1 - s0)
            a = t0 + b * s0
            end = math.inf if s0 == last[0] else s1
            inside = [
                2.0 * a / (b + math.sqrt(b * b + 4.0 * c * a)) if a > 0.0 else 0.0,
                a / (b + math.sqrt(c * a)) if a > 0.0 else 0.0,
            ]
            yield from (s0, *(s for s in inside if s0 <= s <= end))

    def _at(self, speed: float) -> float:
        return float(self.available(speed))

    def _edge(self, torque: float) -> float:
        """Largest speed at which so much is available, rad/s."""
        if self.points[-1][1] >= torque:
            return math.inf
        edge = 0.0
        for (s0, t0), (s1, t1) in self._segments():
            if t0 >= torque:
                edge = s1 if t1 >= torque else s0 + (t0 - torque) / (t0 - t1) * (s1 - s0)
        return edge

    def _segments(self) -> Iterator[tuple[tuple[float, float], tuple[float, float]]]:
        return zip(self.points[:-1], self.points[1:], strict=True)
