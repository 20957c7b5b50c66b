"""Optimal control problems for the solver's tests, and independent solutions of them."""

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.nmpc.planner import NmpcSettings, build_attitude_ocp
from simsat.control.solver.ocp import Limits, Ocp, build_ocp


def spacecraft(A: Array, **changes: Any) -> Spacecraft:
    """A 50 kg craft with the wheel axes A (3 x m) and the paper's wheels."""
    each = np.ones(A.shape[1])
    made = Spacecraft(
        name="test",
        mass=50.0,
        J=np.diag([1.5, 1.6, 1.2]),
        wheel_names=tuple(f"wheel_{i}" for i in range(A.shape[1])),
        A=A,
        Js=1.432394e-3 * each,
        torque_max=0.05 * each,
        torque_rate_max=0.4 * each,
        speed_max=628.3 * each,
        viscous=0.0 * each,
        coulomb=0.0 * each,
    )
    return replace(made, **changes)


TWO_WHEELS = spacecraft(np.eye(3)[:, :2])
THREE_WHEELS = spacecraft(np.eye(3))


def attitude_ocp(craft: Spacecraft = TWO_WHEELS, **settings: Any) -> Ocp:
    """The baseline's problem."""
    return build_attitude_ocp(craft, NmpcSettings(**settings))


def random_state(rng: np.random.Generator, craft: Spacecraft = TWO_WHEELS) -> Array:
    """x_0 of the baseline's problem, in the middle of a slew."""
    m = craft.wheels
    q = attitude.from_axis_angle(rng.normal(size=3), rng.uniform(0.3, 2.8))
    return np.concatenate(
        [q, 0.1 * rng.normal(size=3), rng.uniform(-150, 150, m), rng.uniform(-0.05, 0.05, m)]
    )


def double_integrator(limits: Limits | None = None, power: int = 1, N: int = 15) -> Ocp:
    """x'' = u in steps of 0.2 s; residuals are the state and input to a power."""
    x, u, p = ca.SX.sym("x", 2), ca.SX.sym("u"), ca.SX.sym("p")
    if limits is None:
        limits = Limits(np.zeros((1, 2)), np.ones((1, 1)), -np.ones(1), np.ones(1),
                        np.full(1, np.inf))  # fmt: skip
    x_next = ca.vertcat(x[0] + 0.2 * x[1] + 0.02 * (u + p), x[1] + 0.2 * (u + p))
    state = ca.vertcat(x[0], 0.5 * x[1]) ** power
    return build_ocp(x, u, p, x_next, ca.vertcat(state, 0.1 * u**power), 3.0 * state, limits, N)


def ipopt_objective(ocp: Ocp, x0: Array, guess: Array, p: Array) -> float:
    """The optimal cost by CasADi's IPOPT: multiple shooting, soft rows through slack variables."""
    limits = ocp.limits
    X = [ca.SX.sym(f"x{k}", ocp.nx) for k in range(ocp.N + 1)]
    U = [ca.SX.sym(f"u{k}", ocp.nu) for k in range(ocp.N)]
    soft = np.isfinite(limits.softness)
    cost, g, low, high, slacks = 0.0, [X[0] - x0], [np.zeros(ocp.nx)], [np.zeros(ocp.nx)], []

    def limit(rows: Array, value: Any) -> None:
        nonlocal cost
        for j in np.flatnonzero(rows):
            s = ca.SX.sym("s") if soft[j] else 0.0
            if soft[j]:
                slacks.append(s)
                cost += limits.softness[j] * (s + 0.5 * s**2)
            g.extend([value[j] - s, value[j] + s])
            low.extend([np.array([-np.inf]), limits.lower[j : j + 1]])
            high.extend([limits.upper[j : j + 1], np.array([np.inf])])

    for k in range(ocp.N):
        x_next, r = ocp.evaluate(X[k], U[k], p)
        cost += 0.5 * ca.sumsqr(r)
        g.append(X[k + 1] - x_next)
        low.append(np.zeros(ocp.nx))
        high.append(np.zeros(ocp.nx))
        limit(limits.on_input, limits.Cx @ X[k] + limits.Cu @ U[k])
        limit(~limits.on_input, limits.Cx @ X[k + 1])
    cost += 0.5 * ca.sumsqr(ocp.evaluate_end(X[-1], p))
    unknown = ca.vertcat(*X, *U, *slacks)
    problem = {"x": unknown, "f": cost, "g": ca.vertcat(*g)}
    options: dict[str, Any] = {
        "ipopt.print_level": 0,
        "print_time": 0,
        "ipopt.sb": "yes",
        "ipopt.tol": 1e-10,
        "ipopt.bound_relax_factor": 0.0,  # else it gains 1e-6 by breaking every bound a little
    }
    solver = ca.nlpsol("ipopt", "ipopt", problem, options)
    x = [x0]
    for k in range(ocp.N):
        x.append(np.array(ocp.evaluate(x[-1], guess[k], p)[0]).ravel())
    bounds = np.full(unknown.numel(), np.inf)
    start = np.concatenate([*x, guess.ravel(), np.zeros(len(slacks))])
    lower = -bounds
    lower[unknown.numel() - len(slacks) :] = 0.0
    answer = solver(x0=start, lbx=lower, ubx=bounds, lbg=np.concatenate(low),
                    ubg=np.concatenate(high))  # fmt: skip
    assert solver.stats()["success"]
    return float(answer["f"])
