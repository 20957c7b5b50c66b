"""The momentum of appendages, one control period at a time: what a network has learned of it.

Panels and propellant carry a momentum c of their own beside that of the locked spacecraft:

    J omega + A (Js * Omega) + c = R(q)' h_N    <=>    omega = J_hub^-1 (R(q)' h_N - A p - c)

c is a sum over modes delta_i eta_i', each a weakly damped oscillator that the hub's acceleration
drives, so that over control periods (torque u held, after a ramp from the last one) it follows a
recursion of second order, which the network holds:

    (c_{k+1}, mean of c over period k) = N(c_k, c_{k-1}, u_k, u_{k-1}, u_{k-2}; p_k) = s_y * y
    y = W x + V tanh(U x) + B ((E x) * (G z))
    x = (c_k, c_{k-1}, u_k, u_{k-1}, u_{k-2}) / s_x,    z = p_k / s_p

W is the oscillators. The tanh is what their drive has not linear in it: the ramp's impulse,
|u_k - u_{k-1}| times u_k - u_{k-1}. The gate is what turns with the body: panels that are bent are
another inertia, and a deflection (linear in x) times a body rate (at zero total momentum linear in
the rotors' spin momenta p, here their means over the period) is a momentum, along axes without a
wheel too. There is no bias: where nothing moves and no motor pushes, nothing starts to move. The
mirrored motion, -x with -p, differs by the gate alone. Products of two rates, as centrifugal force,
are not in N.
"""

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from ..ground.arrays import Array, Matrix3, Symbol, Vectors3, WheelVector, WheelVectors
from ..ground.units import Units

MOMENTA = 6  # inputs that are momenta, and all outputs: two times three axes


@dataclass(frozen=True)
class NetworkSize:
    """What decides the form of the network's equations, whatever its numbers."""

    wheels: int
    width: int
    gates: int

    @property
    def shapes(self) -> list[tuple[int, int]]:
        """Rows and columns of its arrays, in the order of the fields below."""
        inputs = MOMENTA + 3 * self.wheels
        scales = [(inputs, 1), (self.wheels, 1), (MOMENTA, 1)]
        layer = [(MOMENTA, inputs), (self.width, inputs), (MOMENTA, self.width)]
        return [
            *scales,
            *layer,
            (self.gates, inputs),
            (self.gates, self.wheels),
            (MOMENTA, self.gates),
        ]

    @property
    def count(self) -> int:
        """How many numbers that is."""
        return sum(rows * columns for rows, columns in self.shapes)


@dataclass(frozen=True)
class AppendageNetwork:
    """Weights and scales, for m wheels, a tanh layer of some width and some gates (0 is none)."""

    J: Matrix3
    """kg m^2, body axes: the inertia for which c was learned; another makes another c."""
    input_scale: Array
    """s_x: Nms for the momenta, Nm for the torques, shape (6 + 3 m,)."""
    spin_scale: Array
    """s_p, Nms, shape (m,)."""
    output_scale: Array
    """s_y, Nms, shape (6,)."""
    W: Array
    """Linear part, shape (6, 6 + 3 m)."""
    U: Array
    """Into the tanh layer, shape (width, 6 + 3 m)."""
    V: Array
    """Out of it, shape (6, width)."""
    E: Array
    """What the gates let through, shape (gates, 6 + 3 m)."""
    G: Array
    """How far they open, shape (gates, m)."""
    B: Array
    """Out of them, shape (6, gates)."""
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

    @property
    def gates(self) -> int:
        """Number of gates."""
        return int(self.E.shape[0])

    def in_units(self, units: Units) -> "AppendageNetwork":
        """The same network for momenta and torques in other units."""
        torques = 3 * self.wheels
        scale = np.repeat([units.momentum, units.torque], (MOMENTA, torques))
        return replace(
            self,
            J=self.J / units.inertia,
            input_scale=self.input_scale / scale,
            spin_scale=self.spin_scale / units.momentum,
            output_scale=self.output_scale / units.momentum,
            period=self.period / units.time,
        )

    @property
    def size(self) -> NetworkSize:
        """Wheels, width and gates together."""
        return NetworkSize(self.wheels, self.width, self.gates)

    @property
    def numbers(self) -> Array:
        """Scales and weights one after the other, each by columns, as `symbolic_momentum` takes
        them."""
        scales = (self.input_scale, self.spin_scale, self.output_scale)
        weights = (self.W, self.U, self.V, self.E, self.G, self.B)
        return np.concatenate([part.ravel(order="F") for part in (*scales, *weights)])


def next_momentum(
    network: AppendageNetwork,
    c: Vectors3,
    c_before: Vectors3,
    u: WheelVectors,
    u_before: WheelVectors,
    u_before2: WheelVectors,
    p: WheelVectors,
) -> tuple[Vectors3, Vectors3]:
    """(c at the end of the period, its mean over the period), Nms, body axes, shape (..., 3).

    c and c_before (..., 3) are the momentum now and a period ago, body axes, Nms; u (..., m) the
    motor torques over the coming period and the two before it, Nm; p (..., m) the rotors' spin
    momenta, Nms, mean over the coming period.
    """
    x = np.concatenate([c, c_before, u, u_before, u_before2], axis=-1) / network.input_scale
    opened = p / network.spin_scale @ network.G.T
    y = x @ network.W.T + np.tanh(x @ network.U.T) @ network.V.T
    y = y + (x @ network.E.T * opened) @ network.B.T
    y = y * network.output_scale
    return y[..., :3], y[..., 3:]


def symbolic_momentum(
    size: NetworkSize,
    numbers: Symbol,
    c: Symbol,
    c_before: Symbol,
    u: Symbol,
    u1: Symbol,
    u2: Symbol,
    p: Symbol,
) -> tuple[Symbol, Symbol]:
    """The same in CasADi: columns of SX or MX, u1 and u2 the torques one and two periods ago, and
    `numbers` those of a network of that size."""
    input_scale, spin_scale, output_scale, W, U, V, E, G, B = _unpacked(size, numbers)
    x = ca.vertcat(c, c_before, u, u1, u2) / input_scale
    y = W @ x
    if size.width:
        y += V @ ca.tanh(U @ x)
    if size.gates:
        y += B @ (E @ x * (G @ (p / spin_scale)))
    y = y * output_scale
    return y[:3], y[3:]


def _unpacked(size: NetworkSize, numbers: Symbol) -> list[Symbol]:
    """The arrays that a network's numbers are made of, as matrices."""
    ends = np.cumsum([0, *(rows * columns for rows, columns in size.shapes)]).tolist()
    parts = ca.vertsplit(numbers, ends)
    return [ca.reshape(part, *shape) for part, shape in zip(parts, size.shapes, strict=True)]


def spectral_radius(network: AppendageNetwork, p: WheelVector) -> float:
    """Largest modulus of the recursion's eigenvalues about c = 0, without torque, while the rotors
    keep the spin momenta p (Nms, zero at rest): below 1 it decays.

    The slope there is W + V U + B diag(G z) E, in the scales.
    """
    opened = network.G @ (p / network.spin_scale)
    slope = network.W + network.V @ network.U + network.B * opened @ network.E
    slope = network.output_scale[:3, None] * slope[:3, :MOMENTA] / network.input_scale[:MOMENTA]
    companion = np.block([[slope], [np.eye(3), np.zeros((3, 3))]])
    return float(np.abs(np.linalg.eigvals(companion)).max())
