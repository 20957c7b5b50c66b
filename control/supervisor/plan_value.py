"""The planner's cost after a period, for the value rule: one step of every inertia, then the
shifted plan on the nominal model."""

import itertools
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ..ground.arrays import Array, Matrix3, Vector3, WheelVector
from ..interface.measurement import Measurement
from ..interface.plan import Plan
from ..model.dynamics import invert_hub, rk4_step, state_derivative
from ..model.ramp import mean_ramped_torque
from ..nmpc.guess import shifted
from ..nmpc.planner import Nmpc
from ..solver import roll_out
from .value import PlanValue

NO_RESIDUAL: Vector3 = np.array([0.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class PlanEvaluator:
    """A planner, and what its spacecraft may really be."""

    planner: Nmpc
    step: Any
    """CasADi function (x, u, J) -> x+ of the planner's state."""
    inertias: tuple[Matrix3, ...]


def build_plan_evaluator(planner: Nmpc, inertia_uncertainty: float) -> PlanEvaluator:
    """Over the nominal inertia and the corners of its principal moments."""
    craft, period = planner.spacecraft, planner.settings.stage
    m = craft.wheels
    x, u, J = ca.SX.sym("x", 7 + 2 * m), ca.SX.sym("u", m), ca.SX.sym("J", 3, 3)
    torque = mean_ramped_torque(craft, u, x[7 + m :], period)
    A, Js = ca.DM(craft.A), ca.DM(craft.Js)
    inverse, nothing = invert_hub(J, A, Js), ca.DM(NO_RESIDUAL)
    moved = rk4_step(
        lambda s: state_derivative(s, torque, nothing, J, inverse, A, Js), x[: 7 + m], period
    )
    step = ca.Function("step", [x, u, J], [ca.vertcat(moved, u)], {"cse": True})
    return PlanEvaluator(planner, step, inertia_corners(craft.J, inertia_uncertainty))


def inertia_corners(J: Matrix3, uncertainty: float) -> tuple[Matrix3, ...]:
    """J, and J with each principal moment times 1 - uncertainty or 1 + uncertainty."""
    moments, axes = np.linalg.eigh(J)
    corners = itertools.product((1.0 - uncertainty, 1.0 + uncertainty), repeat=3)
    return (J, *((axes * (moments * np.array(factors))) @ axes.T for factors in corners))


def plan_value(evaluator: PlanEvaluator, measurement: Measurement, plan: Plan) -> PlanValue | None:
    """What the value rule asks of a plan; None if no solver stands behind it."""
    if plan.evidence is None:
        return None
    ocp, solution = evaluator.planner.ocp, plan.evidence.solution
    x0, u = evaluator.planner.state(measurement), solution.u
    residual = np.asarray(ocp.evaluate(x0, u[0], NO_RESIDUAL)[1])
    tail = shifted(u)

    def worst_after(change: WheelVector) -> float:
        return max(
            roll_out(ocp, moved, tail, NO_RESIDUAL)[1]
            for moved in successors(evaluator, x0, u[0] + change)
        )

    return PlanValue(solution.objective, 0.5 * float(np.sum(residual**2)), worst_after)


def successors(evaluator: PlanEvaluator, x0: Array, u: WheelVector) -> list[Array]:
    """States one period after x0, one for each inertia, on the unit sphere again."""
    states = []
    for J in evaluator.inertias:
        x = np.asarray(evaluator.step(x0, u, J)).ravel()
        x[:4] /= np.linalg.norm(x[:4])
        states.append(x)
    return states
