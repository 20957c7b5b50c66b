"""The torque along n, the axis that wheels can't push, that brings the craft home about it.

With the wheels' plane held at the reference, phi_n = n'J phi / n'J n moves as a double integrator,

    phi_n' = w,    w = n'J (omega - omega_ref) / n'J n,    n'J n w' = tau_rods + tau_external

(exactly: n'A = 0 leaves n'J omega = n'H - n'A Js Omega = n'H). A rate w* is wanted that stops in
time with the torque there is; near the reference this is a PD of natural frequency w0 and damping
zeta:

    tau = n'J n 2 zeta w0 (w* - w) - tau_external         w* = -w0 / (2 zeta) phi_n    near zero
                                                          |w*| = sqrt(2 a |phi_n| - c)   far away

The far law is that of the proximate time-optimal servo, c makes both ends meet with one slope
(Franklin, Powell and Workman, Digital Control of Dynamic Systems, section 13.5). What acts from
outside beyond what is known is told by an observer from w and the rods' own torque (there, section
8.2); it learns at the rods' limit too, where an integral would wind up.
"""

from dataclasses import dataclass

import numpy as np

DAMPING = 0.9  # zeta: no overshoot worth the name at 20 periods a time constant
BRAKING = 0.3  # share of the torque there is that a stop counts on: the rest is for the unknown


@dataclass(frozen=True)
class ThirdAxis:
    """Where the craft is about its unactuated axis."""

    angle: float
    """phi_n, rad."""
    rate: float
    """w, rad/s."""
    inertia: float
    """n'J n, kg m^2."""


@dataclass(frozen=True)
class Observer:
    """What the rate lets know of the torque from outside."""

    rate: float
    """w expected at the next instant, rad/s."""
    external: float = 0.0
    """Torque along n that nobody told of, Nm."""


def wanted_rate(angle: float, frequency: float, braking: float) -> float:
    """The rate (rad/s) at which to go for zero: w0 / (2 zeta) per rad near it, and far from it what
    a deceleration `braking` (rad/s^2) can still stop."""
    slope = frequency / (2.0 * DAMPING)
    size, linear = abs(angle), braking / slope**2
    if size <= linear:
        return -slope * angle
    return float(-np.sign(angle) * np.sqrt(2.0 * braking * size - (braking / slope) ** 2))


def wanted_torque(axis: ThirdAxis, frequency: float, external: float, most: float) -> float:
    """Torque along n (Nm) to ask the rods for, which can give `most`; `external` is what acts from
    outside."""
    rate = wanted_rate(axis.angle, frequency, BRAKING * most / axis.inertia)
    return float(axis.inertia * 2.0 * DAMPING * frequency * (rate - axis.rate) - external)


def observed(
    observer: Observer | None, axis: ThirdAxis, frequency: float, period: float
) -> Observer:
    """The observer after another measurement of w; its `rate` is then w filtered.

    Both poles lie at w0: gains 1 - z^2 and (1 - z)^2 with z = exp(-w0 T).
    """
    if observer is None:
        return Observer(axis.rate)
    z, innovation = float(np.exp(-frequency * period)), axis.rate - observer.rate
    return Observer(
        observer.rate + (1.0 - z**2) * innovation,
        observer.external + axis.inertia / period * (1.0 - z) ** 2 * innovation,
    )


def expected(observer: Observer, inertia: float, torque: float, period: float) -> Observer:
    """The observer a period later, through which the rods gave `torque` and the known outside."""
    gained = period * (torque + observer.external) / inertia
    return Observer(observer.rate + gained, observer.external)
