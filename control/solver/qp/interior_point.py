"""A dense convex quadratic program by Mehrotra's predictor-corrector interior point.

It needs no supposition of which rows end on their bounds, and always arrives. The two sides of a
row are handled together, as arrays of shape (2, rows), the upper side first: slack t, multiplier z,
softening s, and the softening's own multiplier nu = w + w s - z. Every step is one Cholesky
factorisation of H + D' W D. Source: Nocedal and Wright, Numerical Optimization, 2nd ed., algorithm
16.4; the softening is eliminated like the slacks.

`interior_point.h` does the same, step for step, with a Riccati recursion in place of the Cholesky.
"""

from dataclasses import dataclass

import numpy as np

from ...ground.arrays import Array
from .program import (
    AT_BOUND,
    BEYOND,
    INSIDE,
    QpSolution,
    QuadraticProgram,
    cholesky,
    cholesky_solve,
)

START_SLACK = 0.1  # least initial distance to a limit, in the rows' (order one) unit
TO_BOUNDARY = 0.995  # fraction of the way to the boundary that a step may go
GAP = 1e-9  # done when the mean complementarity is this fraction of the cost's scale
ROW_ERROR = 1e-9  # and the rows hold to this much
MAX_STEPS = 50


@dataclass(frozen=True)
class Point:
    """An iterate, or a step of one."""

    v: Array
    t: Array
    z: Array
    s: Array
    nu: Array

    def moved(self, length: float, step: "Point") -> "Point":
        """The point plus a length times a step."""
        return Point(
            self.v + length * step.v,
            self.t + length * step.t,
            self.z + length * step.z,
            self.s + length * step.s,
            self.nu + length * step.nu,
        )


def solve_interior_point(program: QuadraticProgram) -> QpSolution:
    """The optimum to within GAP."""
    free = cholesky_solve(cholesky(program.H), -program.g)
    scale = -0.5 * float(program.g @ free)
    point = _start(program, scale)
    steps = 0
    while steps < MAX_STEPS:
        steps += 1
        newton = Newton(program, point)
        mu = _gap(program, point)
        affine = newton.step(0.0, 0.0)
        reached = point.moved(_to_boundary(program, point, affine), affine)
        target = mu * (_gap(program, reached) / mu) ** 3
        step = newton.step(target - affine.t * affine.z, target - affine.s * affine.nu)
        length = min(1.0, TO_BOUNDARY * _to_boundary(program, point, step))
        point = point.moved(length, step)
        row_error = (1.0 - length) * np.max(np.abs(newton.row_error))
        if _gap(program, point) <= GAP * scale and row_error <= ROW_ERROR:
            break
    return _solution(program, point, scale, steps)


def _solution(program: QuadraticProgram, point: Point, scale: float, steps: int) -> QpSolution:
    """Where rows end: on a bound if slack is smaller than multiplier, each by its own scale;
    beyond, if the softening is larger than its multiplier."""
    beyond = np.logical_and(program.soft, point.s * program.w > point.nu)
    pressed = point.t * scale < point.z
    place = np.where(pressed, np.where(beyond, BEYOND, AT_BOUND), INSIDE)
    return QpSolution(point.v, point.z[0] - point.z[1], place[0] - place[1], steps)


def _start(program: QuadraticProgram, scale: float) -> Point:
    """v = 0, every slack at least START_SLACK, every product t z the cost's scale over the rows."""
    limit, soft, w = program.limit, program.soft, program.w
    s = np.where(soft, START_SLACK + np.maximum(-limit, 0.0), 0.0)
    t = np.maximum(limit + s, START_SLACK)
    z = scale / (limit.size * t)
    z = np.where(soft, np.minimum(z, 0.5 * w), z)
    return Point(np.zeros(len(program.g)), t, z, s, np.where(soft, w + w * s - z, 1.0))


class Newton:
    """The linearised optimality conditions at a point, factorised."""

    def __init__(self, program: QuadraticProgram, point: Point) -> None:
        self.program, self.point = program, point
        row = program.D @ point.v
        self.row_error = program.limit - np.stack([row, -row]) + point.s - point.t
        multipliers = point.z[0] - point.z[1]
        self.stationarity = program.H @ point.v + program.g + multipliers @ program.D
        self.give = np.where(program.soft, 1.0 / (point.nu + program.w * point.s), 0.0)
        self.weight = 1.0 / (point.t / point.z + point.s * self.give)
        curvature = (program.D.T * (self.weight[0] + self.weight[1])) @ program.D
        self.factor = cholesky(program.H + curvature)

    def step(self, target_t: Array | float, target_s: Array | float) -> Point:
        """The step towards t z = target_t on every side and s nu = target_s on every soft one."""
        at, program = self.point, self.program
        soft_rest = self.give * (target_s - at.s * at.nu)
        rest = self.row_error + at.t - target_t / at.z + soft_rest
        push = self.weight * rest
        v = cholesky_solve(self.factor, (push[0] - push[1]) @ program.D - self.stationarity)
        row = program.D @ v
        z = self.weight * (np.stack([row, -row]) - rest)
        t = (target_t - at.t * z) / at.z - at.t
        s = soft_rest + self.give * at.s * z
        return Point(v, t, z, s, np.where(program.soft, program.w * s - z, 0.0))


def _gap(program: QuadraticProgram, point: Point) -> float:
    """Mean of the complementarity products."""
    products = point.t.size + 2 * np.count_nonzero(program.soft)
    return float(np.sum(point.t * point.z) + np.sum(point.s * point.nu)) / products


def _to_boundary(program: QuadraticProgram, point: Point, step: Point) -> float:
    """Longest step, at most 1 / TO_BOUNDARY, that leaves t, z, s and nu not negative."""
    worst = max(np.max(-step.t / point.t), np.max(-step.z / point.z))
    if program.soft.any():
        soft = program.soft
        worst = max(worst, np.max(-step.s[:, soft] / point.s[:, soft]))
        worst = max(worst, np.max(-step.nu[:, soft] / point.nu[:, soft]))
    return 1.0 / max(float(worst), TO_BOUNDARY)
