"""Body rates one control period ahead, and what a model misses of them.

The attitude plays no part: rates and wheel speeds follow from each other, the motor torques u and
a residual torque tau on the body (body axes, held over the period),

    J_hub omega' = tau - A v - omega x (J omega + A Js Omega),    Js (Omega' + A' omega') = v,
    v = u - c_v Omega - c_C Omega / (|Omega| + COULOMB_SPEED).

Everything takes batches in the leading axes, and NumPy arrays as well as torch tensors: the loss
of the training and the labels and oracles it is compared with are one piece of code.
"""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from simsat.arrays import Array, WheelVector
from simsat.spacecraft import Spacecraft

Tensor: TypeAlias = Any
"""A NumPy array or a torch tensor (every one in a call of the same kind)."""

SUB_STEPS = 10
"""Runge-Kutta steps per control period; the paper's H."""

COULOMB_SPEED = 0.05  # rad/s; sharp beside the tens of rad/s of a slew, and RK4-stable at 50 ms


@dataclass(frozen=True)
class RateModel:
    """A spacecraft's numbers, as NumPy arrays or torch tensors."""

    J: Tensor
    A: Tensor
    Js: Tensor
    J_hub_inverse: Tensor
    viscous: Tensor
    coulomb: Tensor


def build_rate_model(spacecraft: Spacecraft, friction: bool) -> RateModel:
    """The model of a spacecraft in NumPy, with or without its bearings' friction."""
    inverse = np.linalg.inv(spacecraft.J_hub)
    rubbing = 1.0 if friction else 0.0
    return RateModel(
        spacecraft.J,
        spacecraft.A,
        spacecraft.Js,
        inverse,
        rubbing * spacecraft.viscous,
        rubbing * spacecraft.coulomb,
    )


def rate_derivative(
    model: RateModel, omega: Tensor, speed: Tensor, torque: Tensor, tau: Tensor
) -> tuple[Tensor, Tensor]:
    """(omega', Omega') of the equations above; omega, tau (..., 3), speed, torque (..., m)."""
    momentum = omega @ model.J.T + (speed * model.Js) @ model.A.T
    drag = model.viscous * speed + model.coulomb * speed / (abs(speed) + COULOMB_SPEED)
    net = torque - drag
    omega_dot = (tau - net @ model.A.T - cross(omega, momentum)) @ model.J_hub_inverse.T
    return omega_dot, net / model.Js - omega_dot @ model.A


def cross(a: Tensor, b: Tensor) -> Tensor:
    """a x b over the last axis."""
    y, z = [1, 2, 0], [2, 0, 1]
    return a[..., y] * b[..., z] - a[..., z] * b[..., y]


def predict_rate(
    model: RateModel, omega: Tensor, speed: Tensor, torques: Tensor, tau: Tensor, period: float
) -> Tensor:
    """Body rates after the period, shape (..., 3), by one RK4 step per entry of `torques`
    (..., H, m), each held over its sub-step."""
    steps = torques.shape[-2]
    h = period / steps
    for i in range(steps):
        u = torques[..., i, :]
        a1, b1 = rate_derivative(model, omega, speed, u, tau)
        a2, b2 = rate_derivative(model, omega + 0.5 * h * a1, speed + 0.5 * h * b1, u, tau)
        a3, b3 = rate_derivative(model, omega + 0.5 * h * a2, speed + 0.5 * h * b2, u, tau)
        a4, b4 = rate_derivative(model, omega + h * a3, speed + h * b3, u, tau)
        omega = omega + (h / 6.0) * (a1 + 2.0 * (a2 + a3) + a4)
        speed = speed + (h / 6.0) * (b1 + 2.0 * (b2 + b3) + b4)
    return omega


def ramped_torques(
    torque: WheelVector,
    previous: WheelVector,
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


def missed_torque(model: RateModel, missed_rate: Array, period: float) -> WheelVector:
    """The torque on the wheel axes, held over the period, that explains best a rate error.

    The least-squares solution of period * J_hub^-1 A tau = missed_rate, shape (..., m), Nm: what a
    perfect network answers. Rate errors that no torque in the span of A explains stay unexplained.
    """
    effect = period * model.J_hub_inverse @ model.A
    return missed_rate @ np.linalg.pinv(effect).T
