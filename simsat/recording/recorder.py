"""The recording of a flight: 3D attitude and signals in rerun's format, written headlessly.

Columns go out about once a second, so that a run killed half-way leaves a file that opens.
Quaternions are turned to rerun's (x, y, z, w) here and nowhere else.
"""

import time
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import rerun as rr

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.model.rates import build_rate_model
from simsat.environment.orbit import Centre
from simsat.faults.fault import acting
from simsat.flight.loop import Flight, Step
from simsat.flight.mission import Mission
from simsat.flight.residuals import true_residuals
from simsat.mjcf.wheels import RPM
from simsat.recording.layout import ENVIRONMENT_COLORS, TIMELINE, blueprint, part, styles
from simsat.recording.outlet import Outlet
from simsat.recording.shapes import archetype, axes

WRITE_EVERY_S = 1.0  # wall time between writes: what a kill -9 can lose


class Recorder:
    """Writes recording.rrd while a flight goes on; use as a context manager.

    `follow` is the flight's watch; leaving the block writes what is left and the footer. On a full
    disk the recording gives way: its file is removed, to leave the results room, and the flight
    goes on.
    """

    def __init__(self, path: Path, mission: Mission, summary: str):
        self._mission = mission
        self._summary = summary
        self._bus = mission.model.bus
        self._rows = 0
        self._every = max(mission.keep_ticks // mission.ticks_per_period, 1)  # decisions
        self._steps = 0
        self._turned = attitude.IDENTITY  # attitude error that was written last
        self._written = time.monotonic()
        self._flight: Flight | None = None
        self._path = path
        self._rec = rr.RecordingStream("simsat", recording_id=str(path), send_properties=False)

    def __enter__(self) -> "Recorder":
        self._rec.__enter__()
        self._outlet = Outlet(self._path)
        self._rec.save(self._outlet.name, default_blueprint=blueprint(self._mission))
        self._outlet.taken()
        self._log_static()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._flight is not None and not self._outlet.lost:
            self._write(self._flight)
        self._rec.__exit__(kind, error, trace)
        self._outlet.close()

    def follow(self, flight: Flight) -> None:
        """Write what the flight has added, about once a second."""
        self._flight = flight
        if not self._outlet.lost and time.monotonic() - self._written >= WRITE_EVERY_S:
            self._write(flight)

    # What never changes.

    def _log_static(self) -> None:
        rec, model = self._rec, self._mission.model
        rec.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        rec.log("notes", rr.TextDocument(self._summary, media_type=rr.MediaType.MARKDOWN),
                static=True)  # fmt: skip
        for shape in model.shapes:
            entity = f"world/{part(model.body_names[shape.body])}/{part(shape.name)}"
            rec.log(entity, archetype(shape), static=True)
        size = max((float(shape.size.max()) for shape in model.shapes), default=0.3)
        bus = part(model.body_names[self._bus])
        rec.log(f"world/{bus}/axes", axes(2.2 * size, "B", 255), static=True)
        if not self._mission.reference.moving:
            target = rr.Transform3D(quaternion=attitude.scalar_last(self._mission.target))
            rec.log("world/target", target, static=True)
        rec.log("world/target/axes", axes(3.0 * size, "T", 90), static=True)
        self._arrow = 2.6 * size
        for path, names, colors in styles(self._mission):
            rec.log(path, rr.SeriesLines(names=names, colors=colors), static=True)

    # What does.

    def _write(self, flight: Flight) -> None:
        first, last = self._rows, flight.plant.log.rows
        if last > first:
            self._write_poses(flight, first)
            self._write_signals(flight, first)
        steps = flight.steps[self._steps :]
        if steps:
            self._write_steps(steps[:: self._every])
            if steps[0].correction is not None:
                self._write_residuals(flight)
        self._rows, self._steps = last, len(flight.steps)
        self._written = time.monotonic()

    def _write_poses(self, flight: Flight, first: int) -> None:
        plant, t = flight.plant, flight.plant.since(first).t
        stamps = self._time(t)
        positions, quaternions = plant.body_poses(first)
        origin = positions[:, self._bus]  # the craft stays in view: only its attitude matters
        for body, name in enumerate(self._mission.model.body_names):
            if body == 0:
                continue  # the world
            columns = rr.Transform3D.columns(
                translation=positions[:, body] - origin,
                quaternion=attitude.scalar_last(quaternions[:, body]),
            )
            self._rec.send_columns(f"world/{part(name)}", stamps, columns)
        if self._mission.reference.moving:
            turned = attitude.scalar_last(self._mission.reference.attitude(t))
            columns = rr.Transform3D.columns(quaternion=turned)
            self._rec.send_columns("world/target", stamps, columns)
        environment = self._mission.environment
        inwards = "nadir" if environment.orbit.centre is Centre.EARTH else "to the Sun"
        for name, label, vector in (
            ("nadir", inwards, -environment.position(t)),
            ("velocity", "velocity", environment.velocity(t)),
        ):
            arrows = self._arrow * vector / np.linalg.norm(vector, axis=1, keepdims=True)
            color = ENVIRONMENT_COLORS[0] if name == "nadir" else ENVIRONMENT_COLORS[2]
            columns = rr.Arrows3D.columns(
                vectors=arrows, colors=[color] * len(t), labels=[label] * len(t)
            )
            self._rec.send_columns(f"world/{name}", stamps, columns)

    def _write_signals(self, flight: Flight, first: int) -> None:
        truth, mission = flight.plant.since(first), self._mission
        t, q = truth.t, truth.q
        target = mission.reference.attitude(t)
        error = np.degrees(attitude.error_angle(q, target))
        self._scalars("signals/error", t, np.stack([error, np.full(len(t), 0.5)], axis=1))
        history = attitude.continuous(attitude.error_quaternion(q, target), self._turned)
        self._scalars("signals/quaternion", t, history)
        self._turned = history[-1]
        self._scalars("signals/rate", t, np.degrees(truth.omega))
        craft = mission.model.spacecraft
        speed = truth.wheel_speed / RPM
        self._scalars("signals/wheel_speed", t, _with_limits(speed, craft.speed_max / RPM))
        torque = 1e3 * truth.torque
        self._scalars("signals/torque", t, _with_limits(torque, 1e3 * craft.torque_max))
        command = 1e3 * flight.held_commands_since(first)
        self._scalars("signals/torque_command", t, command)
        if craft.rods.count:
            self._scalars("signals/dipole", t, _with_limits(truth.dipole, craft.rods.dipole_max))
            to_body = np.swapaxes(attitude.rotation_matrix(q), 1, 2)
            field = np.einsum("kij,kj->ki", to_body, mission.environment.field_N(t))
            self._scalars("signals/field", t, 1e6 * field)
        for name, torques in mission.environment.torques(t, q).items():
            self._scalars(f"environment/{part(name)}", t, 1e6 * torques)

    def _write_steps(self, steps: list[Step]) -> None:
        t = np.array([step.t for step in steps])
        self._scalars("planner/time", t, np.array([[1e3 * step.plan_time_s] for step in steps]))
        self._states("planner/status", t, [step.plan.label for step in steps])
        for layer, signals in (
            ("planner", [step.plan.signals for step in steps]),
            ("correction", [step.correction.signals if step.correction else {} for step in steps]),
            ("supervisor", [step.verdict.signals if step.verdict else {} for step in steps]),
            ("sensors", [step.estimator for step in steps]),
        ):
            for name in sorted({name for signal in signals for name in signal}):
                values = np.array([[signal.get(name, np.nan)] for signal in signals])
                self._scalars(f"{layer}/{part(name)}", t, values)
        if steps[0].correction is not None:
            self._write_corrections(t, steps)
        if not self._mission.sees_truth and self._mission.keep_ticks == 1:
            self._write_seen(steps)
        if self._mission.faults:
            broken = [acting(self._mission.faults, step.t) or "none" for step in steps]
            self._states("faults/acting", t, broken)

    def _write_seen(self, steps: list[Step]) -> None:
        """How far what the controller saw is off the truth of the same instant."""
        assert self._flight is not None
        plant, per_period = self._flight.plant, self._flight.ticks_per_period
        told = [(self._steps + k, step.seen) for k, step in enumerate(steps) if step.seen]
        if not told:
            return
        rows = per_period * np.array([k for k, _ in told])
        t = plant.log.t[rows]
        q = np.array([seen.q for _, seen in told])
        off = np.degrees(attitude.error_angle(plant.attitudes[rows], q))
        self._scalars("sensors/attitude_error_deg", t, off[:, None])
        rate = np.array([seen.omega for _, seen in told]) - plant.rates[rows]
        self._scalars("sensors/rate_error_deg_s", t, np.degrees(rate))
        speed = np.array([seen.wheel_speed for _, seen in told]) - plant.wheel_speeds[rows]
        self._scalars("sensors/wheel_speed_error_rpm", t, speed / RPM)

    def _write_corrections(self, t: Array, steps: list[Step]) -> None:
        corrections = [step.correction for step in steps if step.correction is not None]
        self._scalars("correction/torque", t, 1e3 * np.array([c.torque for c in corrections]))
        self._scalars("correction/estimate", t, 1e3 * np.array([c.estimate for c in corrections]))
        self._states("correction/switch", t, ["on" if c.active else "off" for c in corrections])
        verdicts = [step.verdict for step in steps if step.verdict is not None]
        if not verdicts:
            return
        self._scalars("supervisor/alpha", t, np.array([[v.alpha] for v in verdicts]))
        self._scalars("supervisor/certificate", t, np.array([[v.certificate] for v in verdicts]))
        self._scalars("supervisor/rate", t, np.array([[v.rate, v.rate_bound] for v in verdicts]))
        self._states("supervisor/decision", t, [v.decision.name.lower() for v in verdicts])
        self._states("supervisor/reason", t, [v.reason.name.lower() for v in verdicts])

    def _write_residuals(self, flight: Flight) -> None:
        """What the network should have said."""
        friction = self._mission.settings.nmpc.friction
        believed = build_rate_model(self._mission.believed, friction)
        residuals = true_residuals(flight, believed, self._steps)
        t = np.array([step.t for step in flight.steps[self._steps :]])[: len(residuals)]
        self._scalars("correction/residual", t, 1e3 * residuals)

    @staticmethod
    def _time(t: Array) -> list[Any]:
        return [rr.TimeColumn(TIMELINE, duration=t)]

    def _scalars(self, path: str, t: Array, values: Array) -> None:
        if values.shape[1]:
            self._rec.send_columns(path, self._time(t), rr.Scalars.columns(scalars=values))

    def _states(self, path: str, t: Array, values: list[str]) -> None:
        self._rec.send_columns(path, self._time(t), rr.StateChange.columns(state=values))


def _with_limits(values: Array, limits: Array) -> Array:
    """Values with the smallest finite limit, twice, as further columns."""
    finite = limits[np.isfinite(limits)]
    if not len(finite):
        return values
    bound = np.full((len(values), 1), finite.min())
    return np.concatenate([values, bound, -bound], axis=1)
