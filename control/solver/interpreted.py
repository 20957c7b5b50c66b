"""The solver without a compiler: CasADi's virtual machine, NumPy, and a condensed dense QP.

Gauss-Newton with full steps. Each iterate is a roll-out, so the dynamics always hold and only the
N * nu inputs are unknown: dx_k = G_k du with G_{k+1} = A_k G_k (+ B_k in stage k's columns).
`sqp.c` does the same step for step, with a Riccati recursion in place of the condensing.
"""

from typing import Any

import numpy as np

from control.ocp import Limits, Ocp
from control.solver.interior_point import solve_qp
from control.solver.solution import Kkt, Solution, SolverSettings, SolverStatus
from simsat.arrays import Array

FEASIBLE = 1e-9  # hard rows may be violated by this much, in their own (order one) unit


class BufferedFunction:
    """A CasADi function that reads and writes NumPy arrays in place.

    CasADi stores columns: a stage's vector is a row here, and a stage's matrix arrives transposed.
    """

    def __init__(self, function: Any) -> None:
        self._buffer, self._run = function.buffer()
        self.inputs = [
            np.zeros((function.size2_in(i), function.size1_in(i))) for i in range(function.n_in())
        ]
        self.outputs = [
            np.zeros((function.size2_out(i), function.size1_out(i)))
            for i in range(function.n_out())
        ]
        for i, array in enumerate(self.inputs):
            self._buffer.set_arg(i, memoryview(array))  # type: ignore[arg-type]
        for i, array in enumerate(self.outputs):
            self._buffer.set_res(i, memoryview(array))  # type: ignore[arg-type]

    def __call__(self, *values: Array) -> list[Array]:
        """Outputs, overwritten by the next call."""
        for array, value in zip(self.inputs, values, strict=True):
            array[:] = value
        self._run()
        return self.outputs


class Rows:
    """The limits along the horizon: rows with inputs for stages 0..N-1, then the others, 1..N."""

    def __init__(self, limits: Limits, N: int) -> None:
        inputs, states = limits.on_input, ~limits.on_input
        self.N = N
        self.Cx_input, self.Cu_input = limits.Cx[inputs], limits.Cu[inputs]
        self.Cx_state = limits.Cx[states]

        def along(values: Array) -> Array:
            return np.concatenate([np.tile(values[inputs], N), np.tile(values[states], N)])

        self.lower, self.upper = along(limits.lower), along(limits.upper)
        self.softness = along(limits.softness)
        self.soft = np.isfinite(self.softness)

    def value(self, x: Array, u: Array) -> Array:
        """Cx x + Cu u, flat."""
        on_input = x[:-1] @ self.Cx_input.T + u @ self.Cu_input.T
        return np.concatenate([on_input.ravel(), (x[1:] @ self.Cx_state.T).ravel()])

    def jacobian(self, G: Array) -> Array:
        """d value / du from the states' sensitivities G, shape (N + 1, nx, N nu)."""
        n, nu = G.shape[2], self.Cu_input.shape[1]
        on_input = self.Cx_input @ G[:-1]
        for k in range(self.N):
            on_input[k][:, k * nu : (k + 1) * nu] += self.Cu_input
        return np.concatenate([on_input.reshape(-1, n), (self.Cx_state @ G[1:]).reshape(-1, n)])

    def violation(self, value: Array) -> Array:
        """How far each row is outside its bounds."""
        return np.maximum(np.maximum(value - self.upper, self.lower - value), 0.0)


class InterpretedSolver:
    """Work space of one problem."""

    def __init__(self, ocp: Ocp) -> None:
        self.ocp = ocp
        self.rows = Rows(ocp.limits, ocp.N)
        self._evaluate = BufferedFunction(ocp.evaluate.mapaccum(ocp.N))
        self._linearize = BufferedFunction(ocp.linearize.map(ocp.N))
        self._evaluate_end = BufferedFunction(ocp.evaluate_end)
        self._linearize_end = BufferedFunction(ocp.linearize_end)

    def roll_out(self, x0: Array, u: Array, p: Array) -> tuple[Array, float]:
        """States (N + 1, nx) that the inputs lead to, and the cost with what soft rows cost."""
        following, residual = self._evaluate(x0[None, :], u, p[:-1])
        x = np.concatenate([x0[None, :], following])
        (end,) = self._evaluate_end(x[-1:], p[-1:])
        cost = 0.5 * float(np.vdot(residual, residual) + np.vdot(end, end))
        soft = self.rows.soft
        if soft.any():
            violation = self.rows.violation(self.rows.value(x, u))[soft]
            cost += float(self.rows.softness[soft] @ (violation + 0.5 * violation**2))
        return x, cost

    def condense(self, x: Array, u: Array, p: Array) -> tuple[Array, Array, Array]:
        """Gauss-Newton Hessian and gradient of the cost by all inputs, and the rows' Jacobian."""
        N, nu, nx = self.ocp.N, self.ocp.nu, self.ocp.nx
        A, B, residual, Rx, Ru = self._linearize(x[:-1], u, p[:-1])
        end, Rx_end = self._linearize_end(x[-1:], p[-1:])
        A_stages = A.reshape(N, nx, nx).transpose(0, 2, 1)
        B_stages = B.reshape(N, nu, nx).transpose(0, 2, 1)
        nr = residual.shape[1]
        G = np.zeros((N + 1, nx, N * nu))
        for k in range(N):
            past = k * nu
            np.matmul(A_stages[k], G[k][:, :past], out=G[k + 1][:, :past])
            G[k + 1][:, past : past + nu] = B_stages[k]
        M = Rx.reshape(N, nx, nr).transpose(0, 2, 1) @ G[:-1]
        Ru_stages = Ru.reshape(N, nu, nr).transpose(0, 2, 1)
        for k in range(N):
            M[k][:, k * nu : (k + 1) * nu] += Ru_stages[k]
        M = np.concatenate([M.reshape(N * nr, N * nu), Rx_end.T @ G[-1]])
        r = np.concatenate([residual.ravel(), end.ravel()])
        return M.T @ M, r @ M, self.rows.jacobian(G)

    def solve(self, x0: Array, guess: Array, p: Array, settings: SolverSettings) -> Solution:
        """Gauss-Newton from a guess (N, nu); p has a row for each of the N + 1 stages."""
        rows, u = self.rows, guess
        multipliers, complementarity = np.zeros(len(rows.lower)), 0.0
        x, cost = self.roll_out(x0, u, p)
        best = (np.inf, x, u)
        status, iterations, qp_iterations = SolverStatus.ITERATION_LIMIT, 0, 0
        while iterations < settings.max_iterations:
            if not np.isfinite(cost):
                status = SolverStatus.FAILED
                break
            iterations += 1
            H, g, D = self.condense(x, u, p)
            H[np.diag_indices_from(H)] += settings.damping
            value = rows.value(x, u)
            qp = solve_qp(H, g, D, rows.lower - value, rows.upper - value, rows.softness)
            multipliers, complementarity = qp.multipliers, qp.complementarity
            qp_iterations += qp.steps
            u = u + qp.v.reshape(u.shape)
            previous, (x, cost) = cost, self.roll_out(x0, u, p)
            if cost < best[0]:
                best = (cost, x, u)
            if abs(previous - cost) <= settings.tolerance * cost:
                status = SolverStatus.SOLVED
                break
        cost, x, u = best
        kkt = self._kkt(x, u, p, multipliers, complementarity)
        return Solution(u, x, cost, kkt, iterations, qp_iterations, status)

    def _kkt(self, x: Array, u: Array, p: Array, multipliers: Array, complementarity: float) -> Kkt:
        _, g, D = self.condense(x, u, p)
        violation = self.rows.violation(self.rows.value(x, u))
        hard = violation[~self.rows.soft]
        return Kkt(
            stationarity=float(np.max(np.abs(g + multipliers @ D))),
            feasibility=float(np.max(hard, initial=0.0)),
            complementarity=complementarity,
        )
