"""Body rates one control period ahead, and what a model misses of them.

The attitude plays no part. In the momenta H of the whole spacecraft (body axes) and L of the rotors
about their axes, for motor torques u and a residual torque tau on the body,

    H' = tau - omega x H,    L' = u - friction(Omega),
    omega = J_hub^-1 (H - A L),    Omega = L / Js - A' omega.

Everything takes batches in the leading axes, and NumPy arrays as well as torch tensors: the loss
of the training and the labels and oracles it is compared with are one piece of code.
"""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ..ground.arrays import Array, Vectors3, WheelVectors
from ..ground.spacecraft import Spacecraft
from .bearing import coulomb_rational

Tensor: TypeAlias = Any
"""A NumPy array or a torch tensor (every one in a call of the same kind)."""


@dataclass(frozen=True)
class RateModel:
    """A spacecraft's numbers, as NumPy arrays or torch tensors."""

    J: Tensor
    A: Tensor
    Js: Tensor
    J_hub_inverse: Tensor
    friction: tuple[Tensor, Tensor] | None
    """Viscous (Nms/rad) and Coulomb (Nm) friction of each wheel; None for ideal bearings."""


def build_rate_model(spacecraft: Spacecraft, friction: bool) -> RateModel:
    """The model of a spacecraft in NumPy, with or without its bearings' friction."""
    return RateModel(
        spacecraft.J,
        spacecraft.A,
        spacecraft.Js,
        np.linalg.inv(spacecraft.J_hub),
        (spacecraft.viscous, spacecraft.coulomb) if friction else None,
    )


def predict_rate(
    model: RateModel, omega: Tensor, speed: Tensor, torques: Tensor, tau: Tensor, period: float
) -> Tensor:
    """Body rates after the period, rad/s, shape (..., 3), by one RK4 step per sub-step.

    From rates (..., 3) and wheel speeds (..., m), under motor torques (..., H, m), each held over
    its sub-step, and a torque tau on the body (..., 3), held over the period; Nm.
    """
    steps = torques.shape[-2]
    h = period / steps
    L = model.Js * (speed + omega @ model.A)
    H = omega @ model.J.T + (speed * model.Js) @ model.A.T
    for i in range(steps):
        u = torques[..., i, :]
        H1, L1 = momentum_rates(model, H, L, u, tau)
        H2, L2 = momentum_rates(model, H + 0.5 * h * H1, L + 0.5 * h * L1, u, tau)
        H3, L3 = momentum_rates(model, H + 0.5 * h * H2, L + 0.5 * h * L2, u, tau)
        H4, L4 = momentum_rates(model, H + h * H3, L + h * L3, u, tau)
        H = H + (h / 6.0) * (H1 + 2.0 * (H2 + H3) + H4)
        L = L + (h / 6.0) * (L1 + 2.0 * (L2 + L3) + L4)
    return _rates(model, H, L)


def momentum_rates(
    model: RateModel, H: Tensor, L: Tensor, torque: Tensor, tau: Tensor
) -> tuple[Tensor, Tensor]:
    """(H', L') of the equations above, Nm: H and tau (..., 3), L and torque (..., m)."""
    omega = _rates(model, H, L)
    if model.friction is not None:
        viscous, coulomb = model.friction
        speed = L / model.Js - omega @ model.A
        torque = torque - viscous * speed - coulomb_rational(coulomb, speed)
    return tau - cross(omega, H), torque


def _rates(model: RateModel, H: Tensor, L: Tensor) -> Tensor:
    """omega = J_hub^-1 (H - A L)."""
    return (H - L @ model.A.T) @ model.J_hub_inverse.T


def cross(a: Tensor, b: Tensor) -> Tensor:
    """a x b over the last axis."""
    if not isinstance(a, np.ndarray):
        return a.cross(b, dim=-1)
    y, z = [1, 2, 0], [2, 0, 1]
    return a[..., y] * b[..., z] - a[..., z] * b[..., y]


def residual_torque(
    believed: RateModel,
    omega: Vectors3,
    speed: WheelVectors,
    torques: Array,
    omega_after: Vectors3,
    period: float,
) -> WheelVectors:
    """The torque on the wheel axes that the believed model misses over a period, Nm, (..., m).

    From rates and wheel speeds at its start, rates at its end and the motor torques of its
    sub-steps (..., H, m).
    """
    expected = predict_rate(believed, omega, speed, torques, np.zeros(3), period)
    return missed_torque(believed, omega_after - expected, period)


def missed_torque(model: RateModel, missed_rate: Vectors3, period: float) -> WheelVectors:
    """The torque on the wheel axes, held over the period, that explains best a rate error.

    The least-squares solution of `rate_effect` tau = missed_rate, shape (..., m), Nm: what a
    perfect network answers. Rate errors that no torque in the span of A explains stay unexplained.
    """
    return missed_rate @ np.linalg.pinv(rate_effect(model, period)).T


def rate_effect(model: RateModel, period: float) -> Array:
    """What a torque on the wheel axes, held over the period, adds to the rates: T_s J_hub^-1 A,
    to first order, in rad/s per Nm, shape (3, m)."""
    effect: Array = period * model.J_hub_inverse @ model.A
    return effect
