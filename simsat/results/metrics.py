"""What a flight is judged by. Every figure is about the truth, whatever the sensors showed.

Source: the paper, section 3 (convergence, steady-state error, final error).
"""

import math
from collections import Counter
from typing import Any

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternions
from simsat.flight.loop import Ending, Flight
from simsat.mjcf.wheels import RPM
from simsat.results.pointing import pointing_metrics

CONVERGED_BELOW_DEG = 0.5  # the paper's settling angle
MINIMUM_STAY = 5.0
"""How long the error must have been below 0.5 deg at the end of a flight that has converged, in the
craft's own seconds: ten control periods, and what drifts through the target is through sooner
unless it is slower than 0.2 deg per own second. The shortest stay in the paper's campaign is 10.9 s
of 100 s."""
TIME_SLACK = 1e-6  # of a sample: sample times are multiples of the interval, to round-off
SPEED_SLACK = 1e-6  # relative; the drives hold the speed limit to this within a physics step
TORQUE_SLACK = 1e-9  # relative
AT_SPEED_LIMIT = 0.999  # of the speed limit: from here on the drive may cut its torque


def error_deg(flight: Flight, target: Quaternions) -> Array:
    """Angle between body and target at every sample, degrees, shape (rows,).

    The target is one attitude, or one for each sample, shape (rows, 4).
    """
    return np.degrees(attitude.error_angle(flight.plant.attitudes, target))


def minimum_stay_s(flight: Flight) -> float:
    """How long its error must have been below 0.5 deg at the end to have converged, s."""
    return MINIMUM_STAY * flight.plant.model.spacecraft.own_units.time


def settling_sample(flight: Flight, error: Array, stay_s: float | None = None) -> int | None:
    """First sample of the stretch below 0.5 deg that lasts to the end.

    None without one, if it is shorter than the minimum stay, or if the flight was broken off.
    """
    first = _last_stretch(error)
    if flight.ending is not Ending.COMPLETE or first == len(error):
        return None
    t = flight.plant.log.t
    stay = minimum_stay_s(flight) if stay_s is None else stay_s
    return first if t[-1] - t[first] >= stay - TIME_SLACK * flight.plant.tick else None


def _last_stretch(error: Array) -> int:
    """First sample of the stretch below 0.5 deg that lasts to the end; their number without one."""
    above = np.flatnonzero(~(error < CONVERGED_BELOW_DEG))
    return int(above[-1]) + 1 if len(above) else 0


def judge(flight: Flight, target: Quaternions, stay_s: float | None = None) -> dict[str, Any]:
    """The metrics of one flight, ready for JSON; None where a figure does not exist.

    Converged is what stayed below 0.5 deg for the last `stay_s` at least, `minimum_stay_s` unless
    given. A flight that was broken off has not converged, however small its last error.
    `convergence` says it in words.
    """
    stay_s = minimum_stay_s(flight) if stay_s is None else stay_s
    error = error_deg(flight, target)
    settled = settling_sample(flight, error, stay_s)
    t = flight.plant.log.t
    return {
        "converged": settled is not None,
        "convergence": _convergence(flight, error, settled, stay_s),
        "settling_time_s": None if settled is None else float(t[settled]),
        "steady_state_rmse_deg": (
            None if settled is None else float(np.sqrt(np.mean(error[settled:] ** 2)))
        ),
        "final_error_deg": float(error[-1]),
        "flown_s": float(t[-1]),
        "ending": flight.ending.name.lower(),
        "reason": flight.reason,
        **pointing_metrics(flight, error, CONVERGED_BELOW_DEG, stay_s),
        **_effort(flight),
        **_planning(flight),
        **_sensing(flight),
        **_supervision(flight),
    }


def _convergence(flight: Flight, error: Array, settled: int | None, stay_s: float) -> str:
    """Whether the flight converged and, if not, what it lacks."""
    t, first = flight.plant.log.t, _last_stretch(error)
    if settled is not None:
        return f"settled at t = {t[settled]:.2f} s"
    if flight.ending is not Ending.COMPLETE:
        return f"broken off at t = {t[-1]:.2f} s"
    if first == len(error):
        return f"{error[-1]:.3g} deg at the end, not below {CONVERGED_BELOW_DEG:g} deg"
    return (
        f"below {CONVERGED_BELOW_DEG:g} deg only for the last {t[-1] - t[first]:.2f} s; "
        f"{stay_s:.3g} s are needed"
    )


def _effort(flight: Flight) -> dict[str, Any]:
    plant, craft = flight.plant, flight.plant.model.spacecraft
    torque, speed = plant.torques, plant.wheel_speeds
    most = craft.torque_available(speed, torque)
    return {
        "peak_wheel_speed_rpm": float(np.abs(speed).max() / RPM),
        "peak_torque_Nm": float(np.abs(torque).max()),
        "torque_effort_Nms": float(np.abs(torque[1:]).sum() * plant.log.tick),
        "limit_violations": {
            "torque": int((np.abs(torque) > most * (1 + TORQUE_SLACK)).sum()),
            "torque_rate": _rate_violations(flight),
            "wheel_speed": int((np.abs(speed) > craft.speed_max * (1 + SPEED_SLACK)).sum()),
        },
        **_cut(flight),
    }


def _cut(flight: Flight) -> dict[str, Any]:
    """In how many samples a command asked for more than a motor gives at its speed; nothing where
    motors give the same at any."""
    plant, craft = flight.plant, flight.plant.model.spacecraft
    if not craft.envelopes:
        return {}
    command = flight.held_commands()
    most = craft.torque_available(plant.wheel_speeds, command)
    return {"torque_cut_by_speed": int((np.abs(command) > most * (1 + TORQUE_SLACK)).sum())}


def _rate_violations(flight: Flight) -> int:
    """Samples in which a torque changed faster than its limit; a drive that cuts its torque because
    the wheel is at its speed limit, or too fast for its motor, breaks no limit."""
    plant, craft = flight.plant, flight.plant.model.spacecraft
    change = np.abs(np.diff(plant.torques, axis=0))
    speed = np.abs(plant.wheel_speeds)
    cut = speed >= AT_SPEED_LIMIT * craft.speed_max
    for i, envelope in enumerate(craft.envelopes):
        if envelope is not None:
            cut[:, i] |= speed[:, i] >= AT_SPEED_LIMIT * envelope.knee
    too_fast = change > craft.torque_rate_max * plant.log.tick * (1 + TORQUE_SLACK)
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
            "slower_than_period": int(
                (milliseconds > 1e3 * flight.ticks_per_period * flight.plant.tick).sum()
            ),
        },
    }


def _sensing(flight: Flight) -> dict[str, Any]:
    """How many measurements were refused, and why; nothing if none was."""
    refused = [step.refusal.name.lower() for step in flight.steps if step.refusal is not None]
    if not refused:
        return {}
    return {"measurements_refused": len(refused), "refusals": dict(Counter(refused))}


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
