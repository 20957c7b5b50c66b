"""The motor's torque ramp: what a torque-rate limit leaves of a commanded step, in closed form.

A torque that is commanded from u_prev to u ramps at the motor's rate limit r for tau = |u - u_prev|
/ r and stays there. Over a period h that is not shorter than tau, with du = u - u_prev:

    impulse              int u dt        = h u - du tau / 2
    mean torque          impulse / h     = u - du |du| / (2 r h)
    spin momentum        p(h)            = p + h u - du tau / 2
    its mean over h      1/h int p dt    = p + h u / 2 - du (tau / 2 - tau^2 / (6 h))

An infinite rate limit leaves the step as it is. Where the period is shorter, u stands for what is
reached at its end, u_prev + r h sign(du).
"""

import casadi as ca
import numpy as np

from ..ground.arrays import Array, Symbol, WheelVector, WheelVectors
from ..ground.spacecraft import Spacecraft

SUB_STEPS = 10
"""Sub-steps of a control period; the paper's H."""

ROUNDING = 1e-3  # of the largest change within a period: alters what its ramp withholds by 5e-7


def ramped_impulse(
    torque: WheelVectors, previous: WheelVectors, rate: WheelVector, period: float
) -> WheelVectors:
    """Impulse over a period, Nms."""
    reached = reached_torque(torque, previous, rate, period)
    change = reached - previous
    return period * reached - change * np.abs(change) / (2.0 * rate)


def reached_torque(
    torque: WheelVectors, previous: WheelVectors, rate: WheelVector, period: float
) -> WheelVectors:
    """Torque at the end of a period, Nm: the commanded one, if the ramp ends within it."""
    furthest = rate * period
    return np.clip(torque, previous - furthest, previous + furthest)


def ramped_torques(
    torque: WheelVectors,
    previous: WheelVectors,
    rate_max: WheelVector,
    period: float,
    steps: int = SUB_STEPS,
) -> Array:
    """Mean motor torque over each sub-step while it ramps from `previous` to `torque`.

    Torques (..., m) in Nm to shape (..., H, m). The impulse is exact, wherever the ramp ends.
    """
    change = torque - previous
    ramp = np.abs(change) / rate_max  # s; zero without a rate limit
    t = np.linspace(0.0, period, steps + 1)[:, None]
    ramp = ramp[..., None, :]
    # Integral of the ramp's share, 0 at its start and 1 from its end on.
    inside = np.minimum(t, ramp)
    share = np.divide(inside**2, 2.0 * ramp, out=np.zeros(inside.shape), where=ramp > 0.0)
    share = share + t - inside
    mean_share = np.diff(share, axis=-2) * (steps / period)
    return previous[..., None, :] + mean_share * change[..., None, :]


def mean_ramped_torque(
    spacecraft: Spacecraft, torque: Symbol, previous: Symbol, period: float
) -> Symbol:
    """Mean motor torque over a period, with |du| rounded off near zero, where a planner wants a
    second derivative."""
    slowness, rounding = ramp_numbers(spacecraft.torque_rate_max, period)
    return mean_rounded_torque(torque, previous, ca.DM(slowness), ca.DM(rounding))


def ramp_numbers(rate_max: WheelVector, period: float) -> tuple[WheelVector, WheelVector]:
    """Of each wheel 1 / (2 r h), zero without a rate limit, and the rounding of |du|, Nm."""
    reach = rate_max * period
    slowness = np.where(np.isinf(reach), 0.0, 0.5 / reach)
    return slowness, np.where(np.isinf(reach), 1.0, ROUNDING * reach)


def mean_rounded_torque(
    torque: Symbol, previous: Symbol, slowness: Symbol, rounding: Symbol
) -> Symbol:
    """`mean_ramped_torque` of a ramp's numbers, which may be symbols."""
    change = torque - previous
    return torque - slowness * ca.sqrt(change**2 + rounding**2) * change


def ramped_spin(
    p: Symbol, torque: Symbol, previous: Symbol, h: Symbol, rate_max: Symbol
) -> tuple[Symbol, Symbol, Symbol]:
    """Torque reached (Nm) and spin momentum (Nms) after h seconds, and its mean over them."""
    furthest = rate_max * h
    reached = ca.fmax(ca.fmin(torque, previous + furthest), previous - furthest)
    change = reached - previous
    ramp = ca.fabs(change) / rate_max
    after = p + h * reached - change * ramp / 2.0
    mean = p + h * reached / 2.0 - change * (ramp / 2.0 - ramp**2 / (6.0 * h))
    return reached, after, mean
