"""How a recording is laid out: the views it opens with, names and colours of its curves."""

from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from simsat.control.ground.arrays import Array
from simsat.control.ground.magnetorquers import Magnetorquers
from simsat.flight.mission import Mission

TIMELINE = "sim_time"
AXIS_COLORS = ((230, 60, 60), (60, 190, 80), (70, 120, 250))
WHEEL_COLORS = ((240, 160, 40), (60, 180, 220), (200, 90, 220), (120, 200, 90), (230, 90, 90),
                (150, 150, 160))  # fmt: skip
LIMIT_COLOR = (200, 60, 60)
GREY = (150, 150, 160)
PALE = (120, 140, 120)
ENVIRONMENT_COLORS = ((90, 170, 250), (250, 170, 60), (250, 230, 90), (190, 110, 240))


def part(name: str) -> str:
    """A name as one part of an entity's path, whatever characters it has."""
    return str(rr.escape_entity_path_part(name))


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
        *_rods(mission),
        _layers(mission),
    )
    return rrb.Blueprint(
        rrb.Horizontal(space, signals, column_shares=[5, 4]),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def _rods(mission: Mission) -> list[Any]:
    """The rods' row, where there are any."""
    if not mission.model.spacecraft.rods.count:
        return []
    return [
        rrb.Tabs(
            rrb.TimeSeriesView(origin="signals/dipole", name="Dipoles and limits, A m^2"),
            rrb.TimeSeriesView(origin="signals/field", name="Magnetic field (body), uT"),
        )
    ]


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
    if not mission.sees_truth:
        tabs.append(
            rrb.TimeSeriesView(
                origin="sensors",
                contents=["sensors/attitude_error_deg", "sensors/attitude_deviation_arcsec"],
                name="Attitude seen: error, deg, and deviation, arcsec",
            )
        )
        tabs.append(
            rrb.TimeSeriesView(origin="sensors/rate_error_deg_s", name="Rates seen: error, deg/s")
        )
    if mission.faults:
        tabs.append(rrb.StateTimelineView(origin="faults", contents="faults/acting", name="Faults"))
    tabs.append(rrb.TimeSeriesView(origin="environment", name="Environment torques, uNm"))
    tabs.append(rrb.TextDocumentView(origin="notes", name="Settings"))
    return rrb.Tabs(*tabs)


def styles(mission: Mission) -> list[tuple[str, list[str], list[Any]]]:
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
        ("sensors/attitude_error_deg", ["error, deg"], [LIMIT_COLOR]),
        ("sensors/attitude_deviation_arcsec", ["deviation, arcsec"], [GREY]),
        ("sensors/rate_error_deg_s", axes, list(AXIS_COLORS)),
        ("sensors/wheel_speed_error_rpm", names, wheels),
        ("correction/torque", [f"{name} correction" for name in names], wheels),
        ("correction/estimate", [f"{name} estimate" for name in names], [GREY] * len(names)),
        ("correction/residual", [f"{name} true residual" for name in names], [PALE] * len(names)),
        ("supervisor/alpha", ["alpha"], [WHEEL_COLORS[0]]),
        ("supervisor/certificate", ["V"], [WHEEL_COLORS[2]]),
        ("supervisor/rate", ["plan alone", "bound with the correction"], list(WHEEL_COLORS[:2])),
    ]
    styles += _rod_styles(craft.rods)
    for k, (name, _) in enumerate(mission.environment.models):
        label = name.replace("_", " ")
        colors = [_shade(ENVIRONMENT_COLORS[k % 4], shade) for shade in (1.0, 0.75, 0.5)]
        styles.append((f"environment/{part(name)}", [f"{label} {axis}" for axis in axes], colors))
    return styles


def _rod_styles(rods: Magnetorquers) -> list[tuple[str, list[str], list[Any]]]:
    if not rods.count:
        return []
    colors = [WHEEL_COLORS[i % len(WHEEL_COLORS)] for i in range(rods.count)]
    return [
        ("signals/dipole", *_limit_styles(list(rods.names), colors, rods.dipole_max)),
        ("signals/field", ["x", "y", "z"], list(AXIS_COLORS)),
    ]


def _limit_styles(
    names: list[str], colors: list[Any], limits: Array
) -> tuple[list[str], list[Any]]:
    if not np.isfinite(limits).any():
        return names, colors
    return [*names, "limit", "-limit"], [*colors, LIMIT_COLOR, LIMIT_COLOR]


def _shade(color: tuple[int, int, int], shade: float) -> tuple[int, ...]:
    return tuple(int(shade * part) for part in color)
