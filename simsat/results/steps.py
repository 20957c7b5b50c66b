"""The decisions of a flight as a table, one row per control instant."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import error_angle
from simsat.control.model.rates import build_rate_model
from simsat.faults.fault import acting
from simsat.flight.loop import Flight, Step
from simsat.flight.mission import Mission
from simsat.flight.residuals import true_residuals
from simsat.results.columns import Column, components, table


def steps_table(flight: Flight, mission: Mission) -> pa.Table:
    """Columns of every layer: `t_s`, plan (`plan_status`, `plan_failed`, `plan_time_ms`), per wheel
    `torque_{plan,command}_NAME` and `torque_residual_NAME` (what the believed model missed),
    per magnetic rod `dipole_NAME` as commanded, correction (`torque_{correction,estimate}_NAME`,
    `correction_active`), verdict (`alpha`, `decision`, `reason`, `certificate`,
    `certificate_rate`), why a measurement was refused (`refusal`, where any was), what is broken
    (`faults`, where anything breaks), and every signal of a layer under its own name.

    Where there are sensors, also what the layers saw of the state (`seen_q_*`, `seen_omega_*`,
    `seen_wheel_speed_NAME`, nan in a refused period) and how far that attitude was off
    (`seen_error_deg`).
    """
    steps, wheels = flight.steps, mission.model.spacecraft.wheel_names
    columns = {
        "t_s": Column([step.t for step in steps], "s"),
        "plan_status": Column([step.plan.label for step in steps]),
        "plan_failed": Column([step.plan.failed for step in steps]),
        "plan_time_ms": Column([1e3 * step.plan_time_s for step in steps], "ms"),
        **_torques("plan", [step.plan.torque for step in steps], wheels),
        **_torques("command", [step.command for step in steps], wheels),
        **_torques("residual", list(_residuals(flight, mission)), wheels),
        **_dipoles(steps, mission.model.spacecraft.rods.names),
        **_signals("plan", [step.plan.signals for step in steps]),
    }
    if not mission.sees_truth and flight.plant.keeps_all:
        columns |= _seen(flight, wheels)
    if mission.faults:
        columns["faults"] = Column([acting(mission.faults, step.t) for step in steps])
    if any(step.refusal is not None for step in steps):
        reasons = ["" if step.refusal is None else step.refusal.name.lower() for step in steps]
        columns["refusal"] = Column(reasons)
    if any(step.correction is not None for step in steps):
        columns |= _corrections(steps, wheels)
    if any(step.verdict is not None for step in steps):
        columns |= _verdicts(steps)
    return table(columns)


def _dipoles(steps: list[Step], rods: tuple[str, ...]) -> dict[str, Column]:
    values = np.array([step.dipole for step in steps]).reshape(len(steps), len(rods))
    return components("dipole", rods, values, "A m^2", "rod")


def _seen(flight: Flight, wheels: tuple[str, ...]) -> dict[str, Column]:
    """What the layers were told, beside the truth of the same instant."""
    steps, plant = flight.steps, flight.plant
    blind = np.full(7 + len(wheels), np.nan)
    told = [
        blind if s is None else np.concatenate([s.q, s.omega, s.wheel_speed])
        for s in (step.seen for step in steps)
    ]
    every = np.array(told).reshape(len(steps), len(blind))
    q, omega, speed = every[:, :4], every[:, 4:7], every[:, 7:]
    rows = flight.ticks_per_period * np.arange(len(steps))
    off = np.degrees(error_angle(plant.attitudes[rows], q))
    return {
        **components("seen_q", "wxyz", q, "1", "body -> inertial"),
        **components("seen_omega", "xyz", omega, "rad/s", "body"),
        **components("seen_wheel_speed", wheels, speed, "rad/s", "rotor"),
        "seen_error_deg": Column(off, "deg"),
        **_signals("estimator", [step.estimator for step in steps]),
    }


def _residuals(flight: Flight, mission: Mission) -> Array:
    """True residual torques, with nothing in a period that was not flown to its end."""
    count, wheels = len(flight.steps), mission.model.spacecraft.wheels
    filled = np.full((count, wheels), np.nan)
    if count:
        believed = build_rate_model(mission.believed, mission.settings.nmpc.friction)
        known = true_residuals(flight, believed)
        filled[: len(known)] = known
    return filled


def _corrections(steps: list[Step], wheels: tuple[str, ...]) -> dict[str, Column]:
    corrections = [step.correction for step in steps if step.correction is not None]
    return {
        **_torques("correction", [c.torque for c in corrections], wheels),
        **_torques("estimate", [c.estimate for c in corrections], wheels),
        "correction_active": Column([c.active for c in corrections]),
        **_signals("correction", [c.signals for c in corrections]),
    }


def _verdicts(steps: list[Step]) -> dict[str, Column]:
    verdicts = [step.verdict for step in steps if step.verdict is not None]
    return {
        "alpha": Column([v.alpha for v in verdicts], "1"),
        "decision": Column([v.decision.name.lower() for v in verdicts]),
        "reason": Column([v.reason.name.lower() for v in verdicts]),
        "certificate": Column([v.certificate for v in verdicts]),
        "certificate_rate": Column([v.rate for v in verdicts]),
        **_signals("supervisor", [v.signals for v in verdicts]),
    }


def _torques(what: str, rows: list[Array], wheels: tuple[str, ...]) -> dict[str, Column]:
    values = np.array(rows, float).reshape(len(rows), len(wheels))
    return components(f"torque_{what}", wheels, values, "Nm", "rotor")


def _signals(layer: str, rows: Sequence[Mapping[str, Any]]) -> dict[str, Column]:
    names = sorted({name for row in rows for name in row})
    return {
        f"{layer}_{name}": Column([float(row.get(name, np.nan)) for row in rows]) for name in names
    }
