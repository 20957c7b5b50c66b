"""The paper's rule, as printed: try the opposite of the correction, twice as large.

It accepts the largest alpha in [0, 1] for which V' <= 0 under tau_nom - 2 alpha tau_corr. With the
rate of the plan V'_n and the power c = w'tau_corr the test reads V'_n - 2 alpha c <= 0.

**Its hole.** The torque that acts is tau_nom + alpha tau_corr, whose rate is V'_n + alpha c. For
c > 0 and -c < V'_n <= 2c the rule answers alpha = 1 although V rises. (A sign-flipped estimate
would give tau_nom + 2 tau_corr, not the -2 of the test.) The rule in `sound` closes it.
Source: the paper, section 2.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from ..ground.arrays import Array, Matrix3, Quaternion, Vector3
from ..ground.own import Own, own
from ..ground.settings import NotNegative, Settings
from ..interface.verdict import Reason, Verdict, judged, refused
from .lyapunov import Energy, dot, energy, energy_rate


@dataclass(frozen=True)
class FaithfulSettings(Settings, group="faithful"):
    """The paper's supervisor."""

    attitude_gain: Annotated[NotNegative | None, Own("torque", 0.1)] = None
    """k in V, Nm; 0.1 in the craft's own units, twice its torque, unless given (the paper names no
    value). Larger lets a correction spend more kinetic energy while the error falls; smaller makes
    the rule a brake on rates alone."""
    energy: Literal["squared", "linear", "printed"] = "squared"
    """squared: V with (k/2)(1 - q0^2) and its own rate; linear: k(1 - q0) and its own rate;
    printed: linear's V with squared's rate, as in the paper (same decisions as squared)."""

    @property
    def gain(self) -> float:
        """k in V."""
        return own(self, "attitude_gain")


def faithful_alpha(rate: Array, power: Array) -> Array:
    """Largest alpha in [0, 1] with rate - 2 alpha power <= 0, or 0 where there is none.

    Both in watt, any shape. power > 0: larger alpha only helps the test, so all or nothing;
    power < 0: the share that the plan's own decrease pays for; power = 0: all, if V falls.
    """
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        share = np.minimum(1.0, rate / (2.0 * power))
    helped = np.where(rate <= 2.0 * power, 1.0, 0.0)
    paid = np.where(rate <= 0.0, share, 0.0)
    return np.where(power >= 0.0, helped, paid)


def supervise_faithful(
    q_BT: Quaternion,
    omega: Vector3,
    torque_plan: Vector3,
    torque_correction: Vector3,
    J_hub: Matrix3,
    settings: FaithfulSettings,
) -> Verdict:
    """The paper's verdict; torques on the hub (-A u) and omega in body axes, Nm and rad/s."""
    form, gain = Energy(settings.energy), settings.gain
    V = float(energy(form, q_BT, omega, J_hub, gain))
    rate = float(energy_rate(form, q_BT, omega, torque_plan, gain))
    power = float(dot(omega, torque_correction))
    if not np.isfinite(torque_correction).all():
        return refused(Reason.NOT_FINITE, V, rate)
    alpha = float(faithful_alpha(np.array(rate), np.array(power)))
    return judged(alpha, V, rate, rate - 2.0 * alpha * power)
