"""What a run says on the terminal and in the recording: the spacecraft, and the result."""

import re
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np

from simsat.appraisal.preview import Preview, preview, warnings
from simsat.comparison.markdown import literal
from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.reachable import Reach
from simsat.flight.mission import Mission
from simsat.mjcf import Model
from simsat.mjcf.wheels import RPM


def describe(model: Model, believed: Spacecraft) -> str:
    """The spacecraft as read from its file: wheels, actuation, limits, what the controller doesn't
    know or nobody uses, both inertias."""
    craft = model.spacecraft
    lines = [f"{craft.name}: {craft.mass:g} kg, {craft.wheels} wheel(s), {_actuation(craft)}"]
    if craft.rods.count:
        lines[0] += f", {craft.rods.count} magnetic rod(s)"
    for i, name in enumerate(craft.wheel_names):
        lines.append(
            f"  {name:<10} axis {_row(craft.A[:, i])}  torque {_limit(craft.torque_max[i], 'Nm')}, "
            f"rate {_limit(craft.torque_rate_max[i], 'Nm/s')}, "
            f"speed {_limit(craft.speed_max[i] / RPM, 'rpm')}, "
            f"h_max {_limit(craft.momentum_max[i], 'Nms')}, "
            f"spin-up {_limit(craft.spin_up_time[i], 's')}"
        )
    lines += _weakening(craft, believed)
    for i, name in enumerate(craft.rods.names):
        limit = _limit(craft.rods.dipole_max[i], "A m^2")
        lines.append(f"  {name:<10} axis {_row(craft.rods.axes[:, i])}  dipole {limit}")
    for what, names in (
        ("wheels failed, their rotors fixed to the bus", model.failed_wheels),
        ("joints unknown to the controller", model.passive_joints),
        ("actuators declared unused, held at zero", model.unused_actuators),
        ("without effect here", model.ignored),
        ("MuJoCo warns", model.warnings),
    ):
        if names:
            lines.append(f"  {what}: {', '.join(names)}")
    lines.append("  inertia, kg m^2: true                          nominal")
    lines += [f"    [{_row(a)}]    [{_row(b)}]" for a, b in zip(craft.J, believed.J, strict=True)]
    return "\n".join(lines)


def _weakening(craft: Spacecraft, believed: Spacecraft) -> list[str]:
    """Where a motor's torque falls off, and what planners count on instead."""
    return [
        f"  {name:<10} full torque up to {envelope.knee / RPM:.4g} rpm, then "
        + ", ".join(f"{torque:.4g} Nm at {speed / RPM:.4g} rpm" for speed, torque in envelope.points
                    if speed > envelope.knee)
        + f"; planned with {believed.torque_max[i]:.4g} Nm up to {believed.speed_max[i] / RPM:.4g}"
        " rpm"
        for i, (name, envelope) in enumerate(zip(craft.wheel_names, craft.envelopes, strict=False))
        if envelope is not None
    ]  # fmt: skip


def _actuation(craft: Spacecraft) -> str:
    rank, n = craft.actuation_rank, craft.unactuated
    if rank == 3:
        return "fully actuated"
    if n is not None:
        return f"actuation rank 2, unactuated direction {_row(n)}"
    return "actuation rank 1: two directions unactuated, no attitude is held on all three axes"


def describe_mission(mission: Mission) -> str:
    """The spacecraft, what of its surroundings does not reach its orbit, and what is known of the
    flight beforehand."""
    lines = [describe(mission.model, mission.believed), *left_out(mission)]
    if mission.pilot is not None:
        lines.append(foretell(preview(mission)))
    return "\n".join(lines)


def left_out(mission: Mission) -> list[str]:
    """A line where torques of the environment do not reach out to the orbit."""
    if not (torques := mission.environment.left_out):
        return []
    orbit = mission.environment.orbit
    where = f"{orbit.radius_at(0.0) / 1e3:.6g} km from the centre of {orbit.centre.value}"
    return [f"  left out, {where}: {', '.join(torques)}"]


def foretell(seen: Preview) -> str:
    """What is known of a flight beforehand: its times, what it can reach, what will go wrong."""
    horizon = "" if seen.horizon is None else f", horizon {seen.horizon:.4g} s"
    lines = [
        f"  natural time {seen.natural_time:.4g} s (own second {seen.own_second:.4g} s): control "
        f"period {seen.period:.4g} s{horizon}, slew about {seen.slew:.3g} s, flight "
        f"{seen.duration:.4g} s",
        f"  {seen.reach.reach.value}"
        + ("" if seen.reach.reach is Reach.TARGET else f" {seen.reach.reason}"),
    ]
    return "\n".join([*lines, *(f"  warning: {sentence}" for sentence in warnings(seen))])


def result_table(metrics: dict[str, Any]) -> str:
    """The result in a few lines."""
    converged = "yes" if metrics["converged"] else f"no: {metrics['convergence']}"
    rows = [("ended", metrics["reason"]), ("converged", converged)]
    for key, label, unit in (
        ("settling_time_s", "settling time", "s"),
        ("steady_state_rmse_deg", "steady-state RMSE", "deg"),
        ("final_error_deg", "final error", "deg"),
        ("peak_wheel_speed_rpm", "peak wheel speed", "rpm"),
    ):
        value = metrics[key]
        rows.append((label, "none" if value is None else f"{value:.4g} {unit}"))
    if "torque_cut_by_speed" in metrics:
        cut = metrics["torque_cut_by_speed"]
        rows.append(("commands above a motor", f"{cut} samples, the motor gave what it could"))
    violations = sum(metrics["limit_violations"].values())
    rows.append(("limit violations", str(violations)))
    if "solver_failures" in metrics:
        time = metrics["solve_time_ms"]
        rows.append(
            ("solver failures", f"{metrics['solver_failures']} of {metrics['control_steps']}")
        )
        rows.append(("planner time", f"median {time['median']:.2f} ms, worst {time['max']:.2f} ms"))
        if time["slower_than_period"]:
            late = f"{time['slower_than_period']} of {metrics['control_steps']}"
            rows.append(("plans slower than the period", late))
    if "measurements_refused" in metrics:
        refused = f"{metrics['measurements_refused']} of {metrics['control_steps']}"
        rows.append(("measurements refused", refused))
    if "corrections_accepted" in metrics:
        counts = [str(metrics[f"corrections_{k}"]) for k in ("accepted", "attenuated", "rejected")]
        rows.append(("corrections", "{} accepted, {} attenuated, {} rejected".format(*counts)))
    width = max(len(label) for label, _ in rows)
    return "\n".join(f"  {label:<{width}}  {value}" for label, value in rows)


def viewer_command(recording: Path) -> str:
    """What to type to look at a recording: rerun is beside the interpreter if not on the path."""
    if shutil.which("rerun"):
        return f"rerun {recording}"
    viewer, here = Path(sys.executable).with_name("rerun"), Path.cwd()
    return f"{viewer.relative_to(here) if viewer.is_relative_to(here) else viewer} {recording}"


def recording_notes(mission: Mission) -> str:
    """The same in Markdown, for the recording."""
    spacecraft = describe_mission(mission)
    fence = "`" * (3 + max(map(len, re.findall("`+", spacecraft)), default=0))
    title, length = literal(mission.title), mission.duration_s
    return f"# {title}\n\n{length:g} s.\n\n{fence}\n{spacecraft}\n{fence}\n"


def _row(values: Array) -> str:
    return " ".join(f"{round(value, 4) + 0.0:8.4f}" for value in values)


def _limit(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}" if np.isfinite(value) else "none"
