"""What a flight is judged by. Every figure is about the truth, whatever the sensors showed.

Source: the paper, section 3 (convergence, steady-state error, final error).
"""

import math
from collections import Counter
from typing import Any

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternion
from simsat.flight.loop import Ending, Flight
from simsat.mjcf.wheels import RPM

CONVERGED_BELOW_DEG = 0.5  # the paper's settling angle
SPEED_SLACK = 1e-6  # relative; the drives hold the speed limit to this within a physics step
TORQUE_SLACK = 1e-9  # relative
AT_SPEED_LIMIT = 0.999  # of the speed limit: from here on the drive may cut its torque


def error_deg(flight: Flight, target: Quaternion) -> Array:
    """Angle between body and target at every sample, degrees, shape (rows,)."""
    return np.degrees(attitude.error_angle(flight.plant.attitudes, target))


def settling_sample(error: Array) -> int | None:
    """First sample of the stretch below 0.5 deg that lasts to the end; None without one."""
    above = np.flatnonzero(~(error < CONVERGED_BELOW_DEG))
    first = int(above[-1]) + 1 if len(above) else 0
    return first if first < len(error) else None


def judge(flight: Flight, target: Quaternion) -> dict[str, Any]:
    """The metrics of one flight, ready for JSON; None where a figure does not exist.

    A flight that was broken off has not converged, however small its last error.
    """
    error = error_deg(flight, target)
    complete = flight.ending is Ending.COMPLETE
    settled = settling_sample(error) if complete else None
    t = flight.plant.log.t
    return {
        "converged": settled is not None,
        "settling_time_s": None if settled is None else float(t[settled]),
        "steady_state_rmse_deg": (
            None if settled is None else float(np.sqrt(np.mean(error[settled:] ** 2)))
        ),
        "final_error_deg": float(error[-1]),
        "flown_s": float(t[-1]),
        "ending": flight.ending.name.lower(),
        "reason": flight.reason,
        **_effort(flight),
        **_planning(flight),
        **_supervision(flight),
    }


def _effort(flight: Flight) -> dict[str, Any]:
    plant, craft = flight.plant, flight.plant.model.spacecraft
    torque, speed = plant.torques, plant.wheel_speeds
    return {
        "peak_wheel_speed_rpm": float(np.abs(speed).max() / RPM),
        "peak_torque_Nm": float(np.abs(torque).max()),
        "torque_effort_Nms": float(np.abs(torque[1:]).sum() * plant.tick),
        "limit_violations": {
            "torque": int((np.abs(torque) > craft.torque_max * (1 + TORQUE_SLACK)).sum()),
            "torque_rate": _rate_violations(flight),
            "wheel_speed": int((np.abs(speed) > craft.speed_max * (1 + SPEED_SLACK)).sum()),
        },
    }


def _rate_violations(flight: Flight) -> int:
    """Samples in which a torque changed faster than its limit; a drive that cuts its torque because
    the wheel is at its speed limit breaks no limit."""
    plant, craft = flight.plant, flight.plant.model.spacecraft
    change = np.abs(np.diff(plant.torques, axis=0))
    cut = np.abs(plant.wheel_speeds) >= AT_SPEED_LIMIT * craft.speed_max
    too_fast = change > craft.torque_rate_max * plant.tick * (1 + TORQUE_SLACK)
    return int((too_fast & ~cut[1:] & ~cut[:-1]).sum())


def _planning(flight: Flight) -> dict[str, Any]:
    steps = flight.steps
    if not steps:
        return {}
    milliseconds = 1e3 * np.array([step.plan_time_s for step in steps])
    return {
        "control_steps": len(steps),
        "solver_failures": sum(step.plan.failed for step in steps),
        "plan_statuses": dict(Counter(step.plan.label for step in steps)),
        "solve_time_ms": {
            "median": float(np.median(milliseconds)),
            "p95": float(np.percentile(milliseconds, 95)),
            "max": float(milliseconds.max()),
        },
    }


def _supervision(flight: Flight) -> dict[str, Any]:
    corrections = [step.correction for step in flight.steps if step.correction is not None]
    if not corrections:
        return {}
    figures: dict[str, Any] = {"corrections_active": sum(c.active for c in corrections)}
    verdicts = [
        step.verdict
        for step in flight.steps
        if step.verdict is not None and step.correction is not None and step.correction.active
    ]
    if verdicts:
        counts = Counter(verdict.decision.name.lower() for verdict in verdicts)
        figures |= {
            f"corrections_{name}": counts[name] for name in ("accepted", "attenuated", "rejected")
        }
        figures["verdict_reasons"] = dict(Counter(v.reason.name.lower() for v in verdicts))
        figures["mean_alpha"] = float(np.mean([verdict.alpha for verdict in verdicts]))
        health = [v.signals["model_health"] for v in verdicts if "model_health" in v.signals]
        if health:
            figures["model_health"] = float(np.mean(health))
    if not all(math.isfinite(v) for c in corrections for v in c.torque):
        figures["corrections_not_finite"] = sum(
            not np.isfinite(c.torque).all() for c in corrections
        )
    return figures
