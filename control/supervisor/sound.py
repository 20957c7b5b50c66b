"""The sound rule: an accepted correction never leaves V higher one period later.

**Promise.** Let the supervisor accept alpha > 0 at time t. Then V(t + Ts) <= V(t), with
V = 1/2 w'J_hub w + (k/2)(1 - q_0^2), on the full nonlinear spacecraft

    J_hub w' = tau(t) + d(t) - w x H,     H = J w + A Js Omega,     tau = -A u(t)

for every inertia with (1 - delta) J_nom <= J <= (1 + delta) J_nom (as quadratic forms), any wheel
speeds, any |d| <= D (environment, friction's reaction on the hub), and any s in [s_lo, s_hi] when
the wheels are commanded u* = u_plan + s alpha u_corr from their present torque u_prev, the ramp at
their torque rate **included**. s = 1 is the torque that acts; s = -2 is the paper's test. It
assumes an exact measurement and a command inside the torque limits: limit u_plan + u_corr first,
then scale, since u_plan + alpha u_corr lies between two allowed torques. It does not hold through
a wheel's speed limit, where the motor gives less than it was told.

**Proof.** V' = w'tau + w'd + (k/2) q_0 q_v'w, since w.(w x H) = 0. Write F for V' with tau = tau*
(the commanded torque) and without d. Over one period

    V(t+Ts) - V(t) = int F + int w'(tau - tau*) + int w'd
    int F          <= Ts F(0) + Ts^2/2 sup F'
    F'              = w''(tau* + (k/2) q_0 q_v) + (k/4)(q_0^2 |w|^2 - (q_v'w)^2)
                   <= a (T + k/4) + (k/4) W^2                   (|q_0 q_v| <= 1/2; w'' is dw/dt)
    int w'(tau - tau*) <= W sum_i (u*_i - u_prev,i)^2 / (2 rate_i)   (what the ramps leave out)

with bounds over the period on torque, rate and acceleration:

    T = |A| (|max(|u_prev|, |u_plan|)| + S alpha |u_corr|)      every wheel ramps monotonically
    W = sqrt(lambda_max/lambda_min) |w| + Ts (T + D)/lambda_min  from d/dt sqrt(w'J_hub w)
    a = (T + D + W h)/lambda_min,  h = |J_nom w + A Js Omega| + delta |J_nom| |w| + Ts D

where S = max(|s_lo|, |s_hi|), lambda are bounds of J_hub's eigenvalues over the set, and |H| <= h
since only d changes it. Taking W at alpha = 1 leaves a quadratic in alpha,

    g(alpha) = V'_plan + m alpha + sigma(alpha) <= 0,   m = max(s_lo c, s_hi c),  c = w'tau_corr,

with coefficients that are not negative beyond the constant one, so g rises and its root is the
largest safe share, in closed form.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..ground.arrays import (
    Array,
    Matrix3,
    Quaternion,
    Quaternions,
    Vector3,
    Vectors3,
    WheelAxes,
    WheelVector,
    WheelVectors,
)
from ..ground.errors import SettingsError
from ..ground.own import Own, own
from ..ground.settings import AtLeastOne, NotNegative, NotPositive, Settings, ShareBelowOne
from ..ground.spacecraft import Spacecraft
from ..interface.verdict import Reason, Verdict, judged, refused
from .lyapunov import Energy, dot, energy, energy_rate


@dataclass(frozen=True)
class SoundSettings(Settings, group="sound"):
    """The sound supervisor."""

    attitude_gain: Annotated[NotNegative | None, Own("torque", 0.1)] = None
    """k in V, Nm; 0.1 in the craft's own units, twice its torque, unless given. Larger lets a
    correction spend more kinetic energy while the error falls, and widens the margin."""
    s_lo: NotPositive = -2.0
    """Smallest factor on the correction that must be safe too, not above 0: -2 is the paper's
    test against a sign-flipped estimate."""
    s_hi: AtLeastOne = 1.0
    """Largest factor on the correction that must be safe too, at least 1 (the torque that acts)."""
    inertia_uncertainty: ShareBelowOne = 0.2
    """delta: the true inertia is believed within this share of the nominal one, 0 to 1."""
    disturbance_max: Annotated[NotNegative | None, Own("torque", 1e-5)] = None
    """Bound on the environment's torque, Nm; 1e-5 in the craft's own units, a 5000th of its torque,
    unless given. The wheels' friction is added to it from the model."""

    @property
    def gain(self) -> float:
        """k in V."""
        return own(self, "attitude_gain")


@dataclass(frozen=True)
class PlantBounds:
    """What the rule knows of the spacecraft; built once by `build_plant_bounds`."""

    J_hub: Matrix3
    """Nominal J - A Js A', kg m^2: only V as reported needs it."""
    J: Matrix3
    """Nominal inertia, wheels included and locked, kg m^2."""
    A: WheelAxes
    wheel_inertia: WheelVector
    """Js, kg m^2."""
    torque_rate_max: WheelVector
    """Nm/s, inf where the torque jumps."""
    hub_min: float
    """Smallest eigenvalue of J_hub over the set, kg m^2."""
    hub_max: float
    """Largest, kg m^2."""
    J_spread: float
    """Bound of |J - J_nom| over the set, kg m^2."""
    axes_norm: float
    """|A|, 1 for orthogonal wheels."""
    disturbance: float
    """D: environment and friction, Nm."""
    period: float
    """Ts, s."""


def build_plant_bounds(nominal: Spacecraft, settings: SoundSettings, period: float) -> PlantBounds:
    """Bounds over the inertia set around the nominal spacecraft.

    Friction is bounded at the wheels' speed limit. Without a limit, viscous friction has no bound,
    and is refused.
    """
    delta = settings.inertia_uncertainty
    rotors = (nominal.A * nominal.Js) @ nominal.A.T
    smallest = float(np.linalg.eigvalsh((1.0 - delta) * nominal.J - rotors)[0])
    if smallest <= 0.0:
        raise SettingsError(
            f"--sound.inertia-uncertainty {delta:g} allows a hub without inertia: take less"
        )
    axes_norm = float(np.linalg.norm(nominal.A, 2))
    return PlantBounds(
        J_hub=nominal.J_hub,
        J=nominal.J,
        A=nominal.A,
        wheel_inertia=nominal.Js,
        torque_rate_max=nominal.torque_rate_max,
        hub_min=smallest,
        hub_max=float(np.linalg.eigvalsh((1.0 + delta) * nominal.J - rotors)[-1]),
        J_spread=delta * float(np.linalg.norm(nominal.J, 2)),
        axes_norm=axes_norm,
        disturbance=own(settings, "disturbance_max") + axes_norm * _friction_max(nominal),
        period=period,
    )


def _friction_max(nominal: Spacecraft) -> float:
    """|friction| of all wheels at their speed limits, Nm."""
    viscous = np.where(nominal.viscous > 0.0, nominal.viscous * nominal.speed_max, 0.0)
    if not np.isfinite(viscous).all():
        raise SettingsError(
            "the sound supervisor can't bound viscous friction on a wheel without a speed limit: "
            "give the wheel a limit"
        )
    return float(np.linalg.norm(nominal.coulomb + viscous))


def margin(
    omega: Vectors3,
    wheel_speed: WheelVectors,
    u_prev: WheelVectors,
    u_plan: WheelVectors,
    u_correction: WheelVectors,
    bounds: PlantBounds,
    settings: SoundSettings,
) -> Array:
    """sigma(alpha), W, as coefficients (constant, linear, quadratic) in the last axis.

    What V' may gain on its value at the start of the period, on average over it; see the module's
    proof for each line. Batches in the leading axes.
    """
    Ts, D, quarter = bounds.period, bounds.disturbance, 0.25 * settings.gain
    reach = max(-settings.s_lo, settings.s_hi) * np.abs(u_correction)
    speed = _norm(omega)

    T0 = bounds.axes_norm * _norm(np.maximum(np.abs(u_prev), np.abs(u_plan)))
    T1 = bounds.axes_norm * _norm(reach)
    W = np.sqrt(bounds.hub_max / bounds.hub_min) * speed + Ts * (T0 + T1 + D) / bounds.hub_min
    nominal_momentum = omega @ bounds.J.T + (wheel_speed * bounds.wheel_inertia) @ bounds.A.T
    h = _norm(nominal_momentum) + bounds.J_spread * speed + Ts * D
    a0, a1 = (T0 + D + W * h) / bounds.hub_min, T1 / bounds.hub_min

    step = np.abs(u_plan - u_prev)
    ramp = (0.5 / bounds.torque_rate_max) / Ts
    return np.stack(
        [
            0.5 * Ts * (a0 * (T0 + quarter) + quarter * W**2) + W * (D + step**2 @ ramp),
            0.5 * Ts * (a0 * T1 + a1 * (T0 + quarter)) + W * (2.0 * step * reach @ ramp),
            0.5 * Ts * a1 * T1 + W * (reach**2 @ ramp),
        ],
        axis=-1,
    )


def sound_alpha(rate: Array, worst_power: Array, sigma: Array) -> Array:
    """Largest alpha in [0, 1] with rate + worst_power alpha + sigma(alpha) <= 0, else 0.

    rate and worst_power (not negative) in watt; sigma as `margin` gives it, last axis 3.
    """
    c0, c1, c2 = rate + sigma[..., 0], worst_power + sigma[..., 1], sigma[..., 2]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        root = -2.0 * c0 / (c1 + np.sqrt(np.maximum(c1**2 - 4.0 * c2 * c0, 0.0)))
    safe = np.where(c0 + c1 + c2 <= 0.0, 1.0, np.minimum(root, 1.0))
    return np.where(c0 < 0.0, safe, np.where((c0 == 0.0) & (c1 + c2 == 0.0), 1.0, 0.0))


def worst_power(power: Array, settings: SoundSettings) -> Array:
    """m = max(s_lo c, s_hi c), W: the most that the correction may add to V' per unit of alpha."""
    return np.maximum(settings.s_lo * power, settings.s_hi * power)


@dataclass(frozen=True)
class SafeShare:
    """The largest safe share and the rates behind it, W."""

    alpha: Array
    rate: Array
    """V' under the plan alone, at the start of the period."""
    rate_bound: Array
    """g(alpha), which bounds the mean of V' over the period in the worst case."""


def sound_share(
    q_BT: Quaternions,
    omega: Vectors3,
    wheel_speed: WheelVectors,
    u_prev: WheelVectors,
    u_plan: WheelVectors,
    u_correction: WheelVectors,
    bounds: PlantBounds,
    settings: SoundSettings,
) -> SafeShare:
    """The rule itself, on wheel torques u (Nm; the hub feels -A u). Batches in the leading axes.

    u_prev is the torque that acts as the period begins, u_plan the planned command, u_correction
    what would be added to it (already limited so that the sum is a torque the wheels can give).
    """
    plan, correction = -u_plan @ bounds.A.T, -u_correction @ bounds.A.T
    rate = energy_rate(Energy.SQUARED, q_BT, omega, plan, settings.gain)
    m = worst_power(dot(omega, correction), settings)
    sigma = margin(omega, wheel_speed, u_prev, u_plan, u_correction, bounds, settings)
    alpha = sound_alpha(rate, m, sigma)
    powers = np.stack([np.ones_like(alpha), alpha, alpha**2], axis=-1)
    return SafeShare(alpha, rate, rate + m * alpha + np.sum(sigma * powers, axis=-1))


def supervise_sound(
    q_BT: Quaternion,
    omega: Vector3,
    wheel_speed: WheelVector,
    u_prev: WheelVector,
    u_plan: WheelVector,
    u_correction: WheelVector,
    bounds: PlantBounds,
    settings: SoundSettings,
) -> Verdict:
    """The sound verdict; arguments as in `sound_share`."""
    V = float(energy(Energy.SQUARED, q_BT, omega, bounds.J_hub, settings.gain))
    finite = bool(np.isfinite(u_correction).all())
    offered = u_correction if finite else np.zeros_like(u_correction)
    share = sound_share(q_BT, omega, wheel_speed, u_prev, u_plan, offered, bounds, settings)
    if not finite:
        return refused(Reason.NOT_FINITE, V, float(share.rate))
    return judged(float(share.alpha), V, float(share.rate), float(share.rate_bound))


def _norm(v: Array) -> Array:
    return np.asarray(np.linalg.norm(v, axis=-1))
