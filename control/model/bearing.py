"""Coulomb friction without its jump at standstill: two smooth stand-ins for c_C sign(Omega).

    rational   c_C Omega / (|Omega| + s)      sharp, for labels and oracles, which only simulate
    tanh       c_C tanh(Omega / s)            for planners, which differentiate twice

The speeds s differ: the sharper the law, the shorter the steps that follow it stably. Both are
RK4-stable at the steps they are used with.
"""

from typing import Any

import casadi as ca

from ..ground.arrays import Symbol

COULOMB_RATIONAL_SPEED = 0.05  # rad/s; sharp beside tens of rad/s of a slew, stable at 50 ms
COULOMB_TANH_SPEED = 2.0  # rad/s; stable at the planner's 500 ms


def coulomb_rational(coulomb: Any, speed: Any) -> Any:
    """Coulomb friction against the speed (rad/s), Nm; NumPy arrays or torch tensors."""
    return coulomb * speed / (abs(speed) + COULOMB_RATIONAL_SPEED)


def coulomb_tanh(coulomb: Symbol, speed: Symbol) -> Symbol:
    """The same for CasADi."""
    return coulomb * ca.tanh(speed / COULOMB_TANH_SPEED)
