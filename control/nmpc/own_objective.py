"""The baseline's planner with another objective: same prediction, limits and solver.

    stage     1/2 |r(q_BT, omega, effort, increment)|^2
    terminal  1/2 |r_N(q_BT, omega)|^2

Every term is a square, as `ocp.py` wants it: the fourth power of a norm is |phi|^2 as a residual.
"""

from collections.abc import Callable
from typing import TypeAlias

import casadi as ca
import numpy as np

from ..ground.arrays import Quaternion, Symbol
from ..ground.spacecraft import Spacecraft
from ..model.dynamics import build_dynamics, rk4_step
from ..model.ramp import mean_ramped_torque
from ..solver import solver_of
from ..solver.ocp import Ocp, build_ocp
from .planner import Nmpc, NmpcSettings, attitude_limits, torque_scale

Objective: TypeAlias = Callable[[Symbol, Symbol, Symbol, Symbol], tuple[Symbol, Symbol]]
"""(q_BT, omega, effort, increment) -> (r, r_N): attitude of the body relative to the target (4),
body rate (3, rad/s), motor torques and their changes since the period before (m each), both as
fractions of the torque limit. r_N may not depend on the last two."""


def build_nmpc_for(
    objective: Objective, spacecraft: Spacecraft, settings: NmpcSettings, target: Quaternion
) -> Nmpc:
    """The planner that minimises an objective of the user's own; `settings.weights` is not used."""
    ocp = build_ocp_for(objective, spacecraft, settings)
    solver_of(ocp, settings.solver.backend)
    scale = torque_scale(spacecraft, settings)
    return Nmpc(spacecraft, settings, np.asarray(target, float), ocp, scale)


def build_ocp_for(objective: Objective, spacecraft: Spacecraft, settings: NmpcSettings) -> Ocp:
    """The optimal control problem, x = (q_BT, omega, Omega, u_prev), p = tau_d."""
    m, period = spacecraft.wheels, settings.stage
    x, u, tau_d = ca.SX.sym("x", 7 + 2 * m), ca.SX.sym("u", m), ca.SX.sym("tau_d", 3)
    previous = x[7 + m :]
    derivative = build_dynamics(spacecraft, settings.friction)
    mean_torque = mean_ramped_torque(spacecraft, u, previous, period)
    moved = rk4_step(lambda s: derivative(s, mean_torque, tau_d), x[: 7 + m], period)
    scale = ca.DM(torque_scale(spacecraft, settings))
    residual, terminal = objective(x[:4], x[4:7], u / scale, (u - previous) / scale)
    return build_ocp(
        x,
        u,
        tau_d,
        dynamics=ca.vertcat(moved, u),
        residual=residual,
        terminal=terminal,
        limits=attitude_limits(spacecraft, settings),
        N=settings.horizon,
    )
