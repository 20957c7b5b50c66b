"""The planner's solver beside others on the same states: python -m tests.bench.solver.

States and warm starts are those of three closed-loop slews on attitudes outside the campaign (plans
2 to 40 of each: the slew proper), recorded once; every solver then meets them in turn, interleaved,
in one process. IPOPT is as a CasADi user writes it: multiple shooting, SX, exact Hessian, started
from the same guess and its roll-out. do-mpc joins if it is installed. Times are the thread's CPU
time, so that nothing else on the machine counts.
"""

import importlib.util
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.nmpc.planner import Nmpc
from simsat.control.solver import SolverSettings, roll_out, solve_ocp, solver_of
from simsat.control.solver.ocp import Ocp
from simsat.flight.controllers import baseline
from simsat.flight.mission import prepare
from simsat.settings import FlightSettings

SLEWS = (((0.48, -0.64, 0.60), 125.0), ((-0.2, 0.3, 0.93), 100.0), ((0.9, 0.3, -0.3), 70.0))
NO_RESIDUAL = np.zeros(3)


@dataclass(frozen=True)
class Case:
    """One plan: where the craft is, and the guess."""

    x0: Array
    guess: Array
    states: Array
    """Roll-out of the guess."""


Solve = Callable[[Case], tuple[float, int]]
"""Case -> (cost, iterations)."""


def recorded() -> tuple[Ocp, list[Case], list[Case]]:
    """The problem, the slews' warm cases, and their cold first ones."""
    warm: list[Case] = []
    cold: list[Case] = []
    for axis, angle_deg in SLEWS:
        settings = FlightSettings(axis=axis, angle_deg=angle_deg, duration_s=20.0)
        mission = prepare(settings)
        assert mission.pilot is not None
        planner = baseline(mission.brief)
        ocp = planner.ocp
        watched = Watched(planner)
        replace(mission, pilot=replace(mission.pilot, planner=watched)).fly()
        cold.append(watched.cases[0])
        warm.extend(watched.cases[1:])
    return ocp, warm, cold


class Watched:
    """A planner that keeps what it was asked."""

    def __init__(self, planner: Nmpc) -> None:
        self.planner, self.cases = planner, list[Case]()

    def plan(self, measurement: Any, memory: Any, residual: Any = 0.0) -> Any:
        """The planner's plan."""
        ocp, x0 = self.planner.ocp, self.planner.state(measurement)
        guess = np.zeros((ocp.N, ocp.nu)) if memory is None else memory.torque
        self.cases.append(Case(x0, guess, roll_out(ocp, x0, guess, NO_RESIDUAL)[0]))
        return self.planner.plan(measurement, memory, residual)


def ours(ocp: Ocp, backend: Any) -> Solve:
    """This project's solver."""
    settings = SolverSettings(backend=backend)
    solver_of(ocp, backend)

    def solve(case: Case) -> tuple[float, int]:
        solution = solve_ocp(ocp, case.x0, case.guess, NO_RESIDUAL, settings)
        return solution.objective, solution.iterations

    return solve


def bounds(ocp: Ocp) -> tuple[Array, Array]:
    """Largest |x| and |u| from the limits, whose rows here have one entry each."""
    x, u = np.full(ocp.nx, np.inf), np.full(ocp.nu, np.inf)
    for cx, cu in zip(ocp.limits.Cx, ocp.limits.Cu, strict=True):
        x[cx != 0.0], u[cu != 0.0] = 1.0 / cx[cx != 0.0], 1.0 / cu[cu != 0.0]
    return x, u


def ipopt(ocp: Ocp) -> Solve:
    """CasADi and IPOPT."""
    X = [ca.SX.sym(f"x{k}", ocp.nx) for k in range(ocp.N + 1)]
    U = [ca.SX.sym(f"u{k}", ocp.nu) for k in range(ocp.N)]
    x0 = ca.SX.sym("x0", ocp.nx)
    cost, gaps = 0.5 * ca.sumsqr(ocp.evaluate_end(X[-1], NO_RESIDUAL)), [X[0] - x0]
    for k in range(ocp.N):
        x_next, r = ocp.evaluate(X[k], U[k], NO_RESIDUAL)
        cost += 0.5 * ca.sumsqr(r)
        gaps.append(X[k + 1] - x_next)
    problem = {"x": ca.vertcat(*X, *U), "f": cost, "g": ca.vertcat(*gaps), "p": x0}
    options: dict[str, Any] = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes"}
    solver = ca.nlpsol("ipopt", "ipopt", problem, options)
    x_max, u_max = bounds(ocp)
    high = np.concatenate([np.full(ocp.nx, np.inf), np.tile(x_max, ocp.N), np.tile(u_max, ocp.N)])

    def solve(case: Case) -> tuple[float, int]:
        start = np.concatenate([case.states.ravel(), case.guess.ravel()])
        answer = solver(x0=start, lbx=-high, ubx=high, lbg=0.0, ubg=0.0, p=case.x0)
        return float(answer["f"]), int(solver.stats()["iter_count"])

    return solve


def do_mpc_solver(ocp: Ocp) -> Solve:
    """do-mpc with its discrete model, which drives IPOPT too."""
    import do_mpc

    model = do_mpc.model.Model("discrete", "SX")
    x, u = model.set_variable("_x", "x", (ocp.nx, 1)), model.set_variable("_u", "u", (ocp.nu, 1))
    model.set_rhs("x", ocp.evaluate(x, u, NO_RESIDUAL)[0])
    model.setup()
    _, r = ocp.evaluate(model.x["x"], model.u["u"], NO_RESIDUAL)
    mpc = do_mpc.controller.MPC(model)
    mpc.settings.n_horizon, mpc.settings.t_step = ocp.N, 0.5
    mpc.settings.store_full_solution = False
    mpc.settings.supress_ipopt_output()
    end = ocp.evaluate_end(model.x["x"], NO_RESIDUAL)
    mpc.set_objective(mterm=0.5 * ca.sumsqr(end), lterm=0.5 * ca.sumsqr(r))
    mpc.set_rterm(u=0.0)
    x_max, u_max = bounds(ocp)
    mpc.bounds["lower", "_x", "x"], mpc.bounds["upper", "_x", "x"] = -x_max, x_max
    mpc.bounds["lower", "_u", "u"], mpc.bounds["upper", "_u", "u"] = -u_max, u_max
    mpc.setup()

    def solve(case: Case) -> tuple[float, int]:
        mpc.x0 = case.x0
        mpc.set_initial_guess()
        for k in range(ocp.N + 1):
            mpc.opt_x_num["_x", k, 0, 0] = case.states[k]
        for k in range(ocp.N):
            mpc.opt_x_num["_u", k, 0] = case.guess[k]
        mpc.make_step(case.x0)
        u = [np.array(mpc.opt_x_num["_u", k, 0]).ravel() for k in range(ocp.N)]
        _, cost = roll_out(ocp, case.x0, np.array(u), NO_RESIDUAL)
        return cost, int(mpc.solver_stats["iter_count"])

    return solve


def measure(solvers: dict[str, Solve], cases: list[Case]) -> dict[str, Array]:
    """Rows (CPU seconds, iterations, cost), one per case, for each solver; they take turns."""
    rows: dict[str, list[tuple[float, float, float]]] = {name: [] for name in solvers}
    for case in cases:
        for name, solve in solvers.items():
            started = time.thread_time()
            cost, iterations = solve(case)
            rows[name].append((time.thread_time() - started, iterations, cost))
    return {name: np.array(row) for name, row in rows.items()}


def table(title: str, rows: dict[str, Array]) -> str:
    """Markdown: times in ms, iterations, how much more the found optimum costs than the best."""
    slowest = np.median(rows[IPOPT][:, 0])
    best = np.min([row[:, 2] for row in rows.values()], axis=0)
    lines = [
        f"| {title} | median CPU ms | p95 | worst | iterations | times faster | cost above best |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name, row in rows.items():
        ms = 1e3 * row[:, 0]
        above = np.max(row[:, 2] / best - 1.0)
        lines.append(
            f"| {name} | {np.median(ms):.2f} | {np.percentile(ms, 95):.2f} | {ms.max():.2f} "
            f"| {np.mean(row[:, 1]):.1f} | {slowest / np.median(row[:, 0]):.1f} | {above:.0e} |"
        )
    return "\n".join(lines)


IPOPT = "CasADi + IPOPT"


def main() -> None:
    """Print the tables."""
    ocp, warm, cold = recorded()
    solvers = {
        "ours, compiled": ours(ocp, "auto"),
        "ours, interpreted": ours(ocp, "interpreted"),
        IPOPT: ipopt(ocp),
    }
    if importlib.util.find_spec("do_mpc"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solvers["do-mpc"] = do_mpc_solver(ocp)
    measure(solvers, warm[:3])  # the first calls load and allocate
    print(table(f"warm, {len(warm)} plans", measure(solvers, warm)))
    print()
    print(table(f"cold, {len(cold)} first plans", measure(solvers, cold)))


if __name__ == "__main__":
    main()
