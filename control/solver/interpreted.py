"""The solver without a compiler: CasADi's virtual machine, NumPy, and a condensed dense QP.

Sequential quadratic programming on roll-outs: the dynamics always hold, only the inputs are
unknown. The first step has the Gauss-Newton Hessian, later ones the exact Hessian of the
Lagrangian, made convex along rows that press on their bounds (which does not move the step), or
Gauss-Newton's again where that is not enough: at a saddle, say. Steps are full, because a search
along them stalls (the unactuated axis moves only to second order); a long solve becomes careful.

`sqp.c` does the same, step for step, with a Riccati recursion in place of the condensing.
"""

from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Array
from .buffered import BufferedFunction
from .linearization import Linearization, condensed
from .ocp import Ocp
from .qp.program import AT_BOUND, Places, QpSolution, QuadraticProgram, is_convex
from .qp.qp import solve_qp
from .rows import Rows
from .solution import Kkt, Solution, SolverSettings, SolverStatus

PRESSURE = 20.0  # curvature along a pressed row, per unit of its multiplier
FULL_STEPS = 8  # after these, back to the best, and a step that raises the cost is halved
HALVINGS = 6
ON_BOUND = 1e-9  # a guess this close to a bound is supposed to end on it


@dataclass(frozen=True, eq=False)
class Iterate:
    """Inputs, their roll-out and its cost, and the multipliers and places of all rows."""

    u: Array
    x: Array
    cost: float
    multipliers: Array
    place: Places


class InterpretedSolver:
    """Work space of one problem."""

    def __init__(self, ocp: Ocp) -> None:
        self.ocp = ocp
        self.rows = Rows(ocp.limits, ocp.N)
        self._c = ocp.coefficients
        stage, N = ocp.stage, ocp.N
        self._evaluate = BufferedFunction(stage.evaluate.mapaccum(N), N)
        self._linearize = BufferedFunction(stage.linearize.map(N), N)
        self._curvature = BufferedFunction(stage.curvature.map(N), N)
        self._evaluate_end = BufferedFunction(stage.evaluate_end)
        self._linearize_end = BufferedFunction(stage.linearize_end)
        self._curvature_end = BufferedFunction(stage.curvature_end)

    def roll_out(self, x0: Array, u: Array, p: Array) -> tuple[Array, float]:
        """States (N + 1, nx) that the inputs lead to, and the cost with what soft rows cost."""
        following, residual = self._evaluate(x0[None, :], u, p[:-1], self._c)
        x = np.concatenate([x0[None, :], following[:, :, 0]])
        (end,) = self._evaluate_end(x[-1:], p[-1:], self._c)
        squares = float(np.vdot(residual, residual) + np.vdot(end, end))
        return x, 0.5 * squares + self.rows.penalty(x, u)

    def solve(self, x0: Array, guess: Array, p: Array, settings: SolverSettings) -> Solution:
        """Best inputs from a guess (N, nu); p has a row for each of the N + 1 stages."""
        best = now = self._first(x0, guess, p)
        status, iterations, factorizations = SolverStatus.ITERATION_LIMIT, 0, 0
        while iterations < settings.max_iterations and np.isfinite(now.cost):
            if iterations == FULL_STEPS:
                now = best
            qp = self._step(now, p, exact=iterations > 0, damping=settings.damping)
            before, now = now, self._moved(x0, p, now, qp, careful=iterations >= FULL_STEPS)
            if iterations == 0 or now.cost <= (1.0 + settings.tolerance) * best.cost:
                best = now  # of equals the last: its multipliers are the truest
            iterations, factorizations = iterations + 1, factorizations + qp.factorizations
            if abs(before.cost - now.cost) <= settings.tolerance * now.cost:
                status = SolverStatus.SOLVED
                break
        if not np.isfinite(best.cost):
            status = SolverStatus.FAILED
        kkt = self._kkt(best, p)
        return Solution(best.u, best.x, best.cost, kkt, iterations, factorizations, status)

    def _first(self, x0: Array, guess: Array, p: Array) -> Iterate:
        x, cost = self.roll_out(x0, guess, p)
        value = self.rows.value(x, guess)
        above, below = value > self.rows.upper - ON_BOUND, value < self.rows.lower + ON_BOUND
        place = above.astype(int) - below.astype(int)
        return Iterate(guess, x, cost, np.zeros(len(value)), place)

    def _step(self, now: Iterate, p: Array, exact: bool, damping: float) -> QpSolution:
        """The change of the inputs by the quadratic model at an iterate."""
        at = self._linearized(now, p)
        Z, G_end = at.sensitivities()
        D = self.rows.jacobian(Z, G_end)
        g = at.gradient(Z, G_end)
        lift = damping * np.eye(len(g))
        H = lift + self._exact_hessian(now, p, at, Z, G_end, D) if exact else None
        if H is None or not is_convex(H):
            W = at.R.transpose(0, 2, 1) @ at.R
            H = lift + condensed(Z, G_end, W, at.R_end.T @ at.R_end)
        value, rows = self.rows.value(now.x, now.u), self.rows
        program = QuadraticProgram(H, g, D, rows.lower - value, rows.upper - value, rows.softness)
        return solve_qp(program, now.place)

    def _exact_hessian(
        self, now: Iterate, p: Array, at: Linearization, Z: Array, G_end: Array, D: Array
    ) -> Array:
        """Hessian of the Lagrangian by the inputs, plus the curvature along pressed rows."""
        costate = at.costate(self.rows.pull(now.multipliers))
        (W,) = self._curvature(now.x[:-1], now.u, p[:-1], self._c, costate[1:])
        (W_end,) = self._curvature_end(now.x[-1:], p[-1:], self._c)
        pressure = np.where(np.abs(now.place) == AT_BOUND, PRESSURE * np.abs(now.multipliers), 0.0)
        return condensed(Z, G_end, W, W_end[0]) + (D.T * pressure) @ D

    def _linearized(self, now: Iterate, p: Array) -> Linearization:
        F, r, R = self._linearize(now.x[:-1], now.u, p[:-1], self._c)
        r_end, R_end = self._linearize_end(now.x[-1:], p[-1:], self._c)
        return Linearization(F, r[:, :, 0], R, r_end[0, :, 0], R_end[0])

    def _moved(self, x0: Array, p: Array, start: Iterate, qp: QpSolution, careful: bool) -> Iterate:
        """The roll-out after a full step; a careful step is halved while it raises the cost."""
        step = qp.v.reshape(start.u.shape)
        for _ in range(1 + HALVINGS):
            u = start.u + step
            x, cost = self.roll_out(x0, u, p)
            if not careful or cost <= start.cost:
                break
            step = 0.5 * step
        return Iterate(u, x, cost, qp.multipliers, qp.place)

    def _kkt(self, at: Iterate, p: Array) -> Kkt:
        linearization = self._linearized(at, p)
        Z, G_end = linearization.sensitivities()
        stationarity = linearization.gradient(Z, G_end)
        stationarity = stationarity + at.multipliers @ self.rows.jacobian(Z, G_end)
        value, rows = self.rows.value(at.x, at.u), self.rows
        bound = np.where(at.place > 0, rows.upper, rows.lower)
        slack = np.where(np.abs(at.place) == AT_BOUND, np.abs(bound - value), 0.0)
        return Kkt(
            stationarity=float(np.max(np.abs(stationarity))),
            feasibility=float(np.max(rows.violation(value)[~rows.soft], initial=0.0)),
            complementarity=float(np.max(np.abs(at.multipliers) * slack, initial=0.0)),
        )
