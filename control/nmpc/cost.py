"""The paper's quadratic cost as residuals: attitude error, rate, effort, input increments.

    stage     |phi|_W^2 + w |omega|^2 + e |u / u_max|^2 + d |(u - u_prev) / u_max|^2,  phi = 2 q_v
    terminal  F (|phi|_W^2 + w |omega|^2)

W weighs the part of phi along J n differently, n the unactuated direction: without momentum all
rates are at right angles to J n, so an error along it is corrected only to second order (by the
area of a loop in the other two) and an equal weight never pays for the loop. With W too large the
optimum chases, in a limit cycle, what the model gets wrong. Any quadratic cost leaves a dead zone
around the target, in which not moving is optimal; it shrinks with that weight (Mueller and
Worthmann, Automatica 2017).
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca

from ..ground.arrays import Symbol
from ..ground.settings import NotNegative, Positive, Settings


@dataclass(frozen=True)
class Weights(Settings, group="nmpc.weights"):
    """What the planner trades against what. Only ratios matter."""

    attitude: Positive = 1.0
    """Weight of the squared attitude error about the actuated axes, per rad^2."""
    unactuated: NotNegative = 20.0
    """Weight of the squared attitude error that only a loop can remove, per rad^2. Larger
    leaves a smaller final error, until the planner chases its own model error in a limit cycle."""
    rate: NotNegative = 1.0
    """Weight of the squared body rate, per (rad per own second)^2. Larger slews more slowly."""
    effort: NotNegative = 1e-4
    """Weight of the squared wheel torque as a fraction of its limit."""
    increment: NotNegative = 1e-3
    """Weight of the squared change of wheel torque from one period to the next, as a fraction of
    the torque limit. Larger commands more smoothly."""
    terminal: NotNegative = 10.0
    """Weight of the last state of the horizon relative to a stage."""


def state_residual(
    q: Symbol, omega: Symbol, weights: Any, normal: Symbol | None, share: Symbol = 1.0
) -> Symbol:
    """Attitude and rate residuals (6), half the sum of whose squares is `share` of their cost.

    `weights` has the fields of `Weights`, `normal` is the spacecraft's `loop_normal`; all of these
    may be symbols. What depends on them alone comes first: it is computed once (`stage.py`).
    """
    root = ca.sqrt(2.0 * share)
    along = ca.sqrt(weights.attitude) * ca.DM.eye(3)
    if normal is not None:
        stretch = ca.sqrt(weights.unactuated) - ca.sqrt(weights.attitude)
        along = along + stretch * (normal @ normal.T)
    return ca.vertcat((2.0 * root * along) @ q[1:4], (root * ca.sqrt(weights.rate)) * omega)


def input_residual(torque: Symbol, previous: Symbol, scale: Symbol, weights: Any) -> Symbol:
    """Residuals of the torques and their changes, both as fractions of `scale`."""
    effort, increment = ca.sqrt(2.0 * weights.effort), ca.sqrt(2.0 * weights.increment)
    return ca.vertcat((effort / scale) * torque, (increment / scale) * (torque - previous))
