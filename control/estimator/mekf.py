"""The multiplicative extended Kalman filter as the layer between instruments and controller.

It tells the controller the attitude of now, rates without the gyro's bias and gain error, and the
readings since the last instant likewise. Through a blackout it goes on with the gyro alone. Before
the first fix it has nothing to add, and the controller is told what the instruments say.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..ground.arrays import Vector3
from ..ground.attitude import rotation_matrix
from ..interface.measurement import History, Measurement
from .state import FilterState, GyroKnowledge, first_state
from .timeline import SPAN, Aid, Timeline, extended, started

DEG_H = math.degrees(1.0) * 3600.0
ARCSEC = math.degrees(1.0) * 3600.0


@dataclass(frozen=True)
class Mekf:
    """A filter for a gyro of known quality; the fixes say themselves how good they are."""

    gyro: GyroKnowledge

    def estimate(
        self, measurement: Measurement, timeline: Timeline | None
    ) -> tuple[Measurement, Timeline | None]:
        """The measurement as it is after filtering, and the filter's memory."""
        h = measurement.history
        aids: tuple[Aid, ...] = (*measurement.fixes, *measurement.sightings)
        if timeline is None:
            fresh = [fix for fix in measurement.fixes if fix.t > measurement.t - SPAN]
            if not fresh:
                return measurement, None
            first = fresh[0]
            reading = h.omega[int(np.argmin(np.abs(h.t - first.t)))]
            timeline = started(first, reading, first_state(first, self.gyro))
            aids = tuple(aid for aid in aids if aid is not first)
        timeline = extended(timeline, h.t, h.omega, aids, self.gyro)
        return told(measurement, timeline[-1].state), timeline

    def signals(self, timeline: Timeline | None) -> Mapping[str, float]:
        """Curves for the recording."""
        return {} if timeline is None else signals_of(timeline[-1].state)


def told(measurement: Measurement, state: FilterState) -> Measurement:
    """What the controller is told: nothing of the filter's errors is left in the readings."""
    h = measurement.history
    return replace(
        measurement,
        q=state.q,
        omega=state.rate(measurement.omega),
        history=History(h.t, state.rate(h.omega), h.wheel_speed),
        fixes=(),
        sightings=(),
        field_B=_turned_field(measurement, state),
    )


def _turned_field(measurement: Measurement, state: FilterState) -> Vector3 | None:
    """The field known on board, which was turned into body axes by the attitude as sensed, by the
    attitude as filtered."""
    if measurement.field_B is None:
        return None
    field_N = rotation_matrix(measurement.q) @ measurement.field_B
    return rotation_matrix(state.q).T @ field_N


def signals_of(state: FilterState) -> Mapping[str, float]:
    """Deviation of the attitude, time without a fix, bias, and how far off the last fix was."""
    return {
        "attitude_deviation_arcsec": ARCSEC * state.turn_deviation,
        "blackout_s": state.t - state.t_trusted,
        "fix_distance": state.distance,
        **{f"gyro_bias_{axis}_deg_h": DEG_H * b for axis, b in zip("xyz", state.bias, strict=True)},
    }
