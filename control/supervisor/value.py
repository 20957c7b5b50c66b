"""The value rule: a correction may act if the planner's own cost still falls in the worst case.

No smooth energy falls all the way on a spacecraft that two wheels steer (Brockett 1983): a good
manoeuvre spends V to loop about the third axis, and the rules of `faithful` and `sound` shut the
correction out there. The planner's optimal cost J_N is the certificate that fits. With the plan
u_0..u_{N-1} of cost J_N from x, the stage cost l(x, u_0) and the plan shifted by one period, the
rule accepts the largest share alpha it tries for which

    max over J, s of  J_N(x+, shifted plan)  <=  J_N(x, plan) - beta l(x, u_0),
    x+ = f_J(x, u_0 + s alpha u_corr),   J over an inertia set's corners,  s in {s_lo, s_hi}.

The shifted plan is one that can be flown, so its cost bounds the next optimum from above: after an
accepted correction the optimal cost falls by at least beta l, for every inertia tried. What lies
between the tried inertias and factors is covered as far as J_N(x+) is convex in them; the tail of
the roll-out uses the planner's nominal model. f_J is the planner's own step (one Runge-Kutta step
under the mean of the ramped torque): what it misses of the true motion, up to 0.05 l in 10,000
random cases, comes out of beta l, so take beta above that.
Source: Rawlings, Mayne and Diehl, Model Predictive Control, 2nd ed., section 2.4 (the value as a
Lyapunov function); Brockett, Asymptotic stability and feedback stabilization (1983).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..ground.arrays import WheelVector
from ..ground.errors import SettingsError
from ..ground.settings import AtLeastOne, NotPositive, Settings, Share, ShareBelowOne
from ..interface.verdict import Reason, Verdict, judged, refused


@dataclass(frozen=True)
class ValueSettings(Settings, group="value"):
    """The value-function supervisor."""

    decrease: Share = 0.1
    """beta: share of the stage cost by which the planner's cost must fall, 0 to 1. Larger rejects
    more."""
    s_lo: NotPositive = -2.0
    """Smallest factor on the correction that must be safe too, not above 0."""
    s_hi: AtLeastOne = 1.0
    """Largest factor on the correction that must be safe too, at least 1 (the torque that acts)."""
    inertia_uncertainty: ShareBelowOne = 0.1
    """The corners of the inertia set: each principal moment of the nominal inertia times 1 minus
    or plus this."""
    shares: tuple[float, ...] = (1.0, 0.75, 0.5, 0.25)
    """Shares tried, from the largest on."""

    def check(self) -> None:
        """Shares are tried from the largest on."""
        falling = all(a > b for a, b in zip(self.shares, self.shares[1:], strict=False))
        if not (self.shares and falling and self.shares[-1] > 0.0 and self.shares[0] <= 1.0):
            raise SettingsError(
                f"--value.shares must fall from at most 1 to above 0, got {self.shares}"
            )


@dataclass(frozen=True)
class PlanValue:
    """What the rule knows of a plan."""

    cost: float
    """J_N(x, plan)."""
    stage_cost: float
    """l(x, u_0)."""
    worst_after: Callable[[WheelVector], float]
    """Change of torque in the coming period (Nm) -> the largest J_N(x+, shifted plan) over the
    inertias."""


def supervise_value(
    value: PlanValue | None, u_correction: WheelVector, period: float, settings: ValueSettings
) -> Verdict:
    """The value verdict. Rates are changes of cost per second, beyond the decrease that is asked.

    `value` is None when the planner has no solution. u_correction is added to the planned torque,
    Nm, already limited so that the sum is a torque the wheels can give.
    """
    if value is None:
        return refused(Reason.NO_PLAN, np.nan, np.nan)
    wanted = value.cost - settings.decrease * value.stage_cost
    alone = (value.worst_after(np.zeros_like(u_correction)) - wanted) / period
    if not np.isfinite(u_correction).all():
        return refused(Reason.NOT_FINITE, value.cost, alone)
    if not np.any(u_correction):
        return judged(1.0 if alone <= 0.0 else 0.0, value.cost, alone, alone)
    if alone <= 0.0:
        for share in settings.shares:
            factors = (settings.s_lo * share, settings.s_hi * share)
            worst = max(value.worst_after(s * u_correction) for s in factors)
            if worst <= wanted:
                return judged(share, value.cost, alone, (worst - wanted) / period)
    return judged(0.0, value.cost, alone, alone)
