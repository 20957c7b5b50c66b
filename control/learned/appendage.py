"""The momentum of what bends and swings, one control period at a time: what a network has learned.

Panels and propellant carry a momentum c of their own beside that of the locked spacecraft:

    J omega + A (Js * Omega) + c = R(q)' h_N    <=>    omega = J_hub^-1 (R(q)' h_N - A p - c)

c is a sum over modes delta_i eta_i', each a weakly damped oscillator that the hub's acceleration
drives, so that over control periods (torque u held, after a ramp from the last one) it follows a
recursion of second order, which the network holds:

    (c_{k+1}, mean of c over period k) = N(c_k, c_{k-1}, u_k, u_{k-1}, u_{k-2}) = s_y * y
    y = W x + V tanh(U x),    x = (c_k, c_{k-1}, u_k, u_{k-1}, u_{k-2}) / s_x

W is the oscillators, the tanh what is not linear in them: the ramp's impulse, |u_k - u_{k-1}| times
u_k - u_{k-1}. There is no bias: where nothing moves and no motor pushes, nothing starts to move.
N is odd: what is quadratic in the rates, as centrifugal force, is not in it.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from simsat.arrays import Array, Matrix3, Vector3, WheelVector

Symbol = Any

MOMENTA = 6  # inputs that are momenta, and all outputs: two times three axes


@dataclass(frozen=True)
class AppendageNetwork:
    """Weights and scales, for m wheels and a tanh layer of some width (0 is a linear network)."""

    J: Matrix3
    """kg m^2, body axes: the inertia for which c was learned; another makes another c."""
    input_scale: Array
    """s_x: Nms for the momenta, Nm for the torques, shape (6 + 3 m,)."""
    output_scale: Array
    """s_y, Nms, shape (6,)."""
    W: Array
    """Linear part, shape (6, 6 + 3 m)."""
    U: Array
    """Into the tanh layer, shape (width, 6 + 3 m)."""
    V: Array
    """Out of it, shape (6, width)."""
    period: float
    """Control period that one application stands for, s."""

    @property
    def wheels(self) -> int:
        """Number of wheels, m."""
        return (len(self.input_scale) - MOMENTA) // 3

    @property
    def width(self) -> int:
        """Width of the tanh layer."""
        return int(self.U.shape[0])


def advance(
    network: AppendageNetwork,
    c: Vector3,
    c_before: Vector3,
    u: WheelVector,
    u_before: WheelVector,
    u_before2: WheelVector,
) -> tuple[Vector3, Vector3]:
    """(c at the end of the period, its mean over the period), Nms, body axes, shape (..., 3).

    c and c_before (..., 3) are the momentum now and a period ago, body axes, Nms; u (..., m) the
    motor torques over the coming period and the two before it, Nm.
    """
    x = np.concatenate([c, c_before, u, u_before, u_before2], axis=-1) / network.input_scale
    y = x @ network.W.T + np.tanh(x @ network.U.T) @ network.V.T
    y = y * network.output_scale
    return y[..., :3], y[..., 3:]


def symbolic(
    network: AppendageNetwork, c: Symbol, c_before: Symbol, u: Symbol, u1: Symbol, u2: Symbol
) -> tuple[Symbol, Symbol]:
    """The same in CasADi: columns of SX or MX, u1 and u2 the torques one and two periods ago."""
    x = ca.vertcat(c, c_before, u, u1, u2) / ca.DM(network.input_scale)
    y = ca.DM(network.W) @ x
    if network.width:
        y += ca.DM(network.V) @ ca.tanh(ca.DM(network.U) @ x)
    y = y * ca.DM(network.output_scale)
    return y[:3], y[3:]


def growth(network: AppendageNetwork) -> float:
    """Largest modulus of the recursion's eigenvalues about rest, without torque: below 1 it decays.

    The slope there is W + V U, in the scales.
    """
    slope = network.W + network.V @ network.U
    slope = network.output_scale[:3, None] * slope[:3, :MOMENTA] / network.input_scale[:MOMENTA]
    companion = np.block([[slope], [np.eye(3), np.zeros((3, 3))]])
    return float(np.abs(np.linalg.eigvals(companion)).max())
