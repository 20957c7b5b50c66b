"""The prediction model: a rigid spacecraft with reaction wheels, in CasADi.

State s = (q, omega, Omega): attitude of the body relative to the target (q_BT, scalar first), body
rate (body axes, rad/s), wheel speeds relative to the hub (rad/s). Input u: motor torques, Nm.

    (J - A Js A') omega' = -A (u - f) - omega x (J omega + A Js Omega) + tau_d
    Js (Omega' + A' omega') = u - f(Omega)
    q' = 1/2 q (x) (0, omega)

tau_d is the residual torque of the paper's equation (1): body axes, on the body as a whole, zero
for the baseline. The wheel momentum A Js Omega is left out in the paper; without it the prediction
is wrong as soon as the wheels turn (at zero total momentum the gyroscopic torque vanishes).
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import casadi as ca

from ..ground.arrays import Symbol
from ..ground.spacecraft import Spacecraft
from .bearing import coulomb_tanh
from .rotation import rotation_rate

ResidualTorque: TypeAlias = Callable[[Symbol, Symbol, Symbol], Symbol]
"""(omega, wheel speed, motor torque) -> torque on the body, body axes, Nm."""


def state_derivative(
    state: Symbol,
    torque: Symbol,
    tau_d: Symbol,
    J: Symbol,
    hub_inverse: Symbol,
    A: Symbol,
    Js: Symbol,
    friction: Symbol = 0.0,
) -> Symbol:
    """s' = f(s, u) of the equations above; J and (J - A Js A')^-1 (3 x 3), A (3 x m), Js (m) and
    the friction torque (m) may be numbers or symbols."""
    q, omega, speed = state[0:4], state[4:7], state[7:]
    net = torque - friction
    momentum = J @ omega + A @ (Js * speed)
    omega_dot = hub_inverse @ (tau_d - A @ net - ca.cross(omega, momentum))
    return ca.vertcat(rotation_rate(q, omega), omega_dot, net / Js - A.T @ omega_dot)


def friction_torque(viscous: Symbol, coulomb: Symbol, speed: Symbol) -> Symbol:
    """Bearing friction that opposes each wheel, c_v Omega + c_C tanh(Omega / s), Nm."""
    return viscous * speed + coulomb_tanh(coulomb, speed)


def invert_hub(J: Symbol, A: Symbol, Js: Symbol) -> Symbol:
    """(J - A Js A')^-1 of CasADi's numbers or symbols."""
    return ca.inv(J - A @ ca.diag(Js) @ A.T)


def build_dynamics(
    spacecraft: Spacecraft, friction: bool = False, residual: ResidualTorque | None = None
) -> Any:
    """CasADi function (s, u, tau_d) -> s' with the spacecraft's numbers.

    `friction` puts the model file's bearing friction into the prediction; `residual` adds a torque
    that follows the predicted rates, wheel speeds and inputs (a learned model, say).
    """
    m = spacecraft.wheels
    state, torque = ca.SX.sym("s", 7 + m), ca.SX.sym("u", m)
    tau_d = ca.SX.sym("tau_d", 3)
    total = tau_d
    if residual is not None:
        total = total + residual(state[4:7], state[7:], torque)
    J, A, Js = ca.DM(spacecraft.J), ca.DM(spacecraft.A), ca.DM(spacecraft.Js)
    viscous, coulomb = ca.DM(spacecraft.viscous), ca.DM(spacecraft.coulomb)
    opposing = friction_torque(viscous, coulomb, state[7:]) if friction else 0.0
    derivative = state_derivative(state, torque, total, J, invert_hub(J, A, Js), A, Js, opposing)
    return ca.Function("derivative", [state, torque, tau_d], [derivative])


def rk4_step(
    derivative: Callable[[Symbol], Symbol], state: Symbol, period: float | Symbol
) -> Symbol:
    """One classical Runge-Kutta step of s' = derivative(s) over `period` seconds."""
    k1 = derivative(state)
    k2 = derivative(state + period / 2.0 * k1)
    k3 = derivative(state + period / 2.0 * k2)
    k4 = derivative(state + period * k3)
    return state + period / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
