"""The recording of a flight: 3D attitude and signals in rerun's format, written headlessly.

Columns go out about once a second, so that a run killed half-way leaves a file that opens.
Quaternions are turned to rerun's (x, y, z, w) here and nowhere else.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from control.prediction import build_rate_model
from simsat import attitude
from simsat.arrays import Array
from simsat.errors import OutputError
from simsat.loop import Flight, Step
from simsat.mission import Mission
from simsat.mjcf import Shape
from simsat.mjcf.wheels import RPM
from simsat.residuals import true_residuals

WRITE_EVERY_S = 1.0  # wall time between writes: what a kill -9 can lose
TIMELINE = "sim_time"
AXIS_COLORS = ((230, 60, 60), (60, 190, 80), (70, 120, 250))
WHEEL_COLORS = ((240, 160, 40), (60, 180, 220), (200, 90, 220), (120, 200, 90), (230, 90, 90),
                (150, 150, 160))  # fmt: skip
LIMIT_COLOR = (200, 60, 60)
GREY = (150, 150, 160)
PALE = (120, 140, 120)
ENVIRONMENT_COLORS = ((90, 170, 250), (250, 170, 60), (250, 230, 90), (190, 110, 240))


class Recorder:
    """Writes recording.rrd while a flight goes on; use as a context manager.

    `follow` is the flight's watch; leaving the block writes what is left and the footer.
    """

    def __init__(self, path: Path, mission: Mission, summary: str):
        self._mission = mission
        self._path = path
        self._summary = summary
        self._bus = mission.model.bus
        self._rows = 0
        self._steps = 0
        self._written = time.monotonic()
        self._flight: Flight | None = None
        self._rec = rr.RecordingStream("simsat", recording_id=str(path), send_properties=False)

    def __enter__(self) -> "Recorder":
        self._rec.__enter__()
        self._rec.save(self._path, default_blueprint=blueprint(self._mission))
        self._log_static()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with _disk_errors_named(self._path):
            if self._flight is not None:
                self._write(self._flight)
            self._rec.__exit__(kind, error, trace)

    def follow(self, flight: Flight) -> None:
        """Write what the flight has added, about once a second."""
        self._flight = flight
        if time.monotonic() - self._written >= WRITE_EVERY_S:
            with _disk_errors_named(self._path):
                self._write(flight)

    # What never changes.

    def _log_static(self) -> None:
        rec, model = self._rec, self._mission.model
        rec.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        rec.log("notes", rr.TextDocument(self._summary, media_type=rr.MediaType.MARKDOWN),
                static=True)  # fmt: skip
        for shape in model.shapes:
            entity = f"world/{model.body_names[shape.body]}/{shape.name}"
            rec.log(entity, _archetype(shape), static=True)
        size = max((float(shape.size.max()) for shape in model.shapes), default=0.3)
        bus = model.body_names[self._bus]
        rec.log(f"world/{bus}/axes", _axes(2.2 * size, "B", 255), static=True)
        rec.log(
            "world/target", rr.Transform3D(quaternion=attitude.scalar_last(self._mission.target)),
            static=True,
        )  # fmt: skip
        rec.log("world/target/axes", _axes(3.0 * size, "T", 90), static=True)
        self._arrow = 2.6 * size
        for path, names, colors in _styles(self._mission):
            rec.log(path, rr.SeriesLines(names=names, colors=colors), static=True)

    # What does.

    def _write(self, flight: Flight) -> None:
        first, last = self._rows, flight.plant.log.rows
        if last > first:
            self._write_poses(flight, first)
            self._write_signals(flight, first)
        steps = flight.steps[self._steps :]
        if steps:
            self._write_steps(steps)
            if steps[0].correction is not None:
                self._write_residuals(flight)
        self._rows, self._steps = last, len(flight.steps)
        self._written = time.monotonic()

    def _write_poses(self, flight: Flight, first: int) -> None:
        plant = flight.plant
        stamps = self._time(plant.log.t[first:])
        positions, quaternions = plant.body_poses(first)
        origin = positions[:, self._bus]  # the craft stays in view: only its attitude matters
        for body, name in enumerate(self._mission.model.body_names):
            if body == 0:
                continue  # the world
            columns = rr.Transform3D.columns(
                translation=positions[:, body] - origin,
                quaternion=attitude.scalar_last(quaternions[:, body]),
            )
            self._rec.send_columns(f"world/{name}", stamps, columns)
        environment, t = self._mission.environment, plant.log.t[first:]
        for name, vector in (
            ("nadir", -environment.position(t)),
            ("velocity", environment.velocity(t)),
        ):
            arrows = self._arrow * vector / np.linalg.norm(vector, axis=1, keepdims=True)
            color = ENVIRONMENT_COLORS[0] if name == "nadir" else ENVIRONMENT_COLORS[2]
            columns = rr.Arrows3D.columns(
                vectors=arrows, colors=[color] * len(t), labels=[name] * len(t)
            )
            self._rec.send_columns(f"world/{name}", stamps, columns)

    def _write_signals(self, flight: Flight, first: int) -> None:
        plant, mission = flight.plant, self._mission
        t, q = plant.log.t[first:], plant.attitudes[first:]
        error = np.degrees(attitude.error_angle(q, mission.target))
        self._scalars("signals/error", t, np.stack([error, np.full(len(t), 0.5)], axis=1))
        self._scalars("signals/quaternion", t, attitude.error_quaternion(q, mission.target))
        self._scalars("signals/rate", t, np.degrees(plant.rates[first:]))
        craft = mission.model.spacecraft
        speed = plant.wheel_speeds[first:] / RPM
        self._scalars("signals/wheel_speed", t, _with_limits(speed, craft.speed_max / RPM))
        torque = 1e3 * plant.torques[first:]
        self._scalars("signals/torque", t, _with_limits(torque, 1e3 * craft.torque_max))
        command = 1e3 * flight.held_commands()[first:]
        self._scalars("signals/torque_command", t, command)
        for name, torques in mission.environment.torques(t, q).items():
            self._scalars(f"environment/{name}", t, 1e6 * torques)

    def _write_steps(self, steps: list[Step]) -> None:
        t = np.array([step.t for step in steps])
        self._scalars("planner/time", t, np.array([[1e3 * step.plan_time_s] for step in steps]))
        self._states("planner/status", t, [step.plan.status.name.lower() for step in steps])
        for layer, signals in (
            ("planner", [step.plan.signals for step in steps]),
            ("correction", [step.correction.signals if step.correction else {} for step in steps]),
            ("supervisor", [step.verdict.signals if step.verdict else {} for step in steps]),
        ):
            for name in sorted({name for signal in signals for name in signal}):
                values = np.array([[signal.get(name, np.nan)] for signal in signals])
                self._scalars(f"{layer}/{name}", t, values)
        if steps[0].correction is not None:
            self._write_corrections(t, steps)

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


@contextmanager
def _disk_errors_named(path: Path) -> Iterator[None]:
    """rerun's writer thread reports a full disk as a RuntimeError."""
    try:
        yield
    except RuntimeError as error:
        raise OutputError(f"can't write the recording '{path}' (disk full?): {error}") from error


def blueprint(mission: Mission) -> rrb.Blueprint:
    """How the recording opens: the craft on the left, signals on the right."""
    space = rrb.Spatial3DView(
        origin="world",
        name="Attitude (B body, T target)",
        eye_controls=rrb.EyeControls3D(position=(0.95, 1.1, 0.65), look_target=(0.0, 0.0, 0.0)),
        line_grid=False,
    )
    signals = rrb.Vertical(
        rrb.Tabs(
            rrb.TimeSeriesView(origin="signals/error", name="Attitude error, deg"),
            rrb.TimeSeriesView(
                origin="signals/error",
                name="Close-up, deg",
                axis_y=rrb.ScalarAxis(range=(0.0, 1.0), zoom_lock=True),
            ),
        ),
        rrb.TimeSeriesView(origin="signals/rate", name="Body rates, deg/s"),
        rrb.TimeSeriesView(origin="signals/wheel_speed", name="Wheel speeds and limits, rpm"),
        rrb.TimeSeriesView(
            origin="signals",
            contents=["$origin/torque"],
            name="Wheel torques applied and limits, mNm",
        ),
        _layers(mission),
    )
    return rrb.Blueprint(
        rrb.Horizontal(space, signals, column_shares=[5, 4]),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def _layers(mission: Mission) -> rrb.Tabs:
    """The bottom row: one tab for each layer that is switched on."""
    tabs: list[Any] = [
        rrb.TimeSeriesView(origin="planner", contents="planner/time", name="Planner time, ms"),
        rrb.StateTimelineView(origin="planner", contents="planner/status", name="Planner status"),
    ]
    if mission.pilot is not None and mission.pilot.corrector is not None:
        tabs.append(
            rrb.TimeSeriesView(
                origin="correction",
                contents=["correction/torque", "correction/estimate", "correction/residual"],
                name="Correction, mNm",
            )
        )
    if mission.pilot is not None and mission.pilot.supervisor is not None:
        tabs.append(rrb.TimeSeriesView(origin="supervisor/alpha", name="Supervisor: alpha"))
        tabs.append(rrb.TimeSeriesView(origin="supervisor/certificate", name="Supervisor: V"))
        tabs.append(rrb.TimeSeriesView(origin="supervisor/rate", name="V' and its bound"))
        tabs.append(
            rrb.StateTimelineView(
                origin="supervisor",
                contents=["supervisor/decision", "supervisor/reason"],
                name="Verdicts",
            )
        )
    tabs.append(rrb.TimeSeriesView(origin="environment", name="Environment torques, uNm"))
    tabs.append(rrb.TextDocumentView(origin="notes", name="Settings"))
    return rrb.Tabs(*tabs)


def _styles(mission: Mission) -> list[tuple[str, list[str], list[Any]]]:
    """(entity, series names, colours) of every curve whose names are known beforehand."""
    craft = mission.model.spacecraft
    names = list(craft.wheel_names)
    wheels = list(WHEEL_COLORS[: craft.wheels])
    axes = ["x", "y", "z"]
    speed_names, speed_colors = _limit_styles(names, wheels, craft.speed_max)
    torque_names, torque_colors = _limit_styles(names, wheels, craft.torque_max)
    styles = [
        ("signals/error", ["error", "converged below 0.5"], [(250, 200, 60), LIMIT_COLOR]),
        ("signals/quaternion", ["q0", "q1", "q2", "q3"], [GREY, *AXIS_COLORS]),
        ("signals/rate", axes, list(AXIS_COLORS)),
        ("signals/wheel_speed", speed_names, speed_colors),
        ("signals/torque", torque_names, torque_colors),
        ("signals/torque_command", [f"{name} commanded" for name in names], wheels),
        ("planner/time", ["time"], [WHEEL_COLORS[1]]),
        ("correction/torque", [f"{name} correction" for name in names], wheels),
        ("correction/estimate", [f"{name} estimate" for name in names], [GREY] * len(names)),
        ("correction/residual", [f"{name} true residual" for name in names], [PALE] * len(names)),
        ("supervisor/alpha", ["alpha"], [WHEEL_COLORS[0]]),
        ("supervisor/certificate", ["V"], [WHEEL_COLORS[2]]),
        ("supervisor/rate", ["plan alone", "bound with the correction"], list(WHEEL_COLORS[:2])),
    ]
    for k, (name, _) in enumerate(mission.environment.models):
        label = name.replace("_", " ")
        colors = [_shade(ENVIRONMENT_COLORS[k % 4], shade) for shade in (1.0, 0.75, 0.5)]
        styles.append((f"environment/{name}", [f"{label} {axis}" for axis in axes], colors))
    return styles


def _limit_styles(
    names: list[str], colors: list[Any], limits: Array
) -> tuple[list[str], list[Any]]:
    if not np.isfinite(limits).any():
        return names, colors
    return [*names, "limit", "-limit"], [*colors, LIMIT_COLOR, LIMIT_COLOR]


def _with_limits(values: Array, limits: Array) -> Array:
    """Values with the smallest finite limit, twice, as further columns."""
    finite = limits[np.isfinite(limits)]
    if not len(finite):
        return values
    bound = np.full((len(values), 1), finite.min())
    return np.concatenate([values, bound, -bound], axis=1)


def _shade(color: tuple[int, int, int], shade: float) -> tuple[int, ...]:
    return tuple(int(shade * part) for part in color)


def _axes(length: float, frame: str, alpha: int) -> rr.Arrows3D:
    return rr.Arrows3D(
        vectors=length * np.eye(3),
        colors=[(*color, alpha) for color in AXIS_COLORS],
        labels=[f"{axis}_{frame}" for axis in "xyz"],
        radii=length / (90.0 if frame == "B" else 180.0),
    )


def _archetype(shape: Shape) -> Any:
    """The rerun shape of a geom, in its body's frame."""
    color = [round(255 * float(part)) for part in shape.rgba]
    place: dict[str, Any] = {
        "centers": [shape.position],
        "quaternions": [attitude.scalar_last(shape.quaternion)],
        "colors": [color],
    }
    a, b = float(shape.size[0]), float(shape.size[1])
    if shape.kind == "box":
        return rr.Boxes3D(half_sizes=[shape.size], fill_mode="solid", **place)
    if shape.kind == "cylinder":
        return rr.Cylinders3D(radii=[a], lengths=[2 * b], fill_mode="solid", **place)
    if shape.kind == "capsule":
        offset = attitude.rotation_matrix(shape.quaternion) @ np.array([0.0, 0.0, -b])
        return rr.Capsules3D(radii=[a], lengths=[2 * b], translations=[shape.position + offset],
                             quaternions=place["quaternions"], colors=[color])  # fmt: skip
    half = shape.size if shape.kind == "ellipsoid" else np.full(3, a)
    return rr.Ellipsoids3D(half_sizes=[half], fill_mode="solid", **place)
