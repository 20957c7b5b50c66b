"""Random spacecraft and moments for the supervisor's tests, and the true motion over a period.

Independent of the project's models: momentum balance integrated by RK4 in plain numpy, in batches.
"""

from dataclasses import dataclass

import numpy as np

from simsat.control.ground.arrays import Array, Matrix3, Quaternion, Vector3, WheelAxes, WheelVector
from simsat.control.ground.spacecraft import Spacecraft

PERIOD = 0.5  # s
RATE_MAX = 0.4  # Nm/s
DELTA = 0.2  # inertia uncertainty of the cases
DISTURBANCE = 1e-5  # Nm


@dataclass(frozen=True)
class Cases:
    """n moments of one nominal spacecraft with m wheels, each with a true inertia of its own."""

    q_BT: Quaternion
    omega: Vector3
    wheel_speed: WheelVector
    J: Matrix3
    """True inertias, inside the uncertainty set of J_nominal, shape (n, 3, 3)."""
    J_nominal: Matrix3
    A: WheelAxes
    Js: float
    u_prev: WheelVector
    u_plan: WheelVector
    u_correction: WheelVector

    @property
    def J_hub(self) -> Matrix3:
        return self.J - self.Js * self.A @ self.A.T


def craft(J: Array, A: Array, Js: float = 1.43e-3) -> Spacecraft:
    m = A.shape[1]
    return Spacecraft(
        name="case",
        mass=50.0,
        J=J,
        wheel_names=tuple(f"w{i}" for i in range(m)),
        A=A,
        Js=np.full(m, Js),
        torque_max=np.full(m, 0.05),
        torque_rate_max=np.full(m, RATE_MAX),
        speed_max=np.full(m, 628.3),
        viscous=np.zeros(m),
        coulomb=np.zeros(m),
    )


def random_cases(rng: np.random.Generator, n: int, wheels: int = 2) -> Cases:
    """Rates and torques over decades, and every second correction along or against the rate."""
    directions = rng.normal(size=(n, 3))
    q_BT = unit(rng.normal(size=(n, 4)) + [3.0, 0, 0, 0] * rng.integers(0, 2, (n, 1)))
    q_BT *= np.where(q_BT[:, :1] < 0, -1.0, 1.0)
    q_BT[: n // 10] = unit(np.c_[np.ones(n // 10), 0.01 * directions[: n // 10]])
    omega = unit(directions) * 10.0 ** rng.uniform(-4, -0.5, (n, 1))
    A = unit(rng.normal(size=(wheels, 3))).T
    u_plan = rng.uniform(-0.05, 0.05, (n, wheels)) * 10.0 ** rng.uniform(-2, 0, (n, 1))
    # Two of three plans push against the rate: only those can leave anything to a correction.
    brake = unit(omega) @ A
    u_plan = np.where(rng.uniform(size=(n, 1)) < 0.67, np.abs(u_plan) * np.sign(brake), u_plan)
    u_correction = rng.uniform(-0.015, 0.015, (n, wheels)) * 10.0 ** rng.uniform(-3, 0, (n, 1))
    along = np.sign(brake) * np.abs(u_correction) * rng.choice([-1.0, 1.0], (n, 1))
    u_correction[::2] = along[::2]
    u_prev = np.where(rng.uniform(size=(n, 1)) < 0.5, u_plan, rng.uniform(-0.05, 0.05, (n, wheels)))
    J_nominal, J = _inertias(rng, n)
    return Cases(
        q_BT=q_BT,
        omega=omega,
        wheel_speed=rng.uniform(-628.0, 628.0, (n, wheels)) * rng.integers(0, 2, (n, 1)),
        J=J,
        J_nominal=J_nominal,
        A=A,
        Js=1.43e-3,
        u_prev=u_prev,
        u_plan=u_plan,
        u_correction=u_correction,
    )


def _inertias(rng: np.random.Generator, n: int) -> tuple[Matrix3, Matrix3]:
    """A nominal inertia, and n true ones with (1 - DELTA) J_nom <= J <= (1 + DELTA) J_nom."""
    L = np.linalg.qr(rng.normal(size=(3, 3)))[0] * np.sqrt(rng.uniform(0.8, 2.0, 3))
    inner = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    size = rng.uniform(-1, 1, (n, 3))
    size = np.where(rng.uniform(size=(n, 1)) < 0.5, np.sign(size), size)  # on the set's edge
    error = np.eye(3) + DELTA * (inner * size[:, None, :]) @ np.swapaxes(inner, 1, 2)
    return L @ L.T, L @ error @ L.T


def fly(
    case: Cases,
    u: WheelVector,
    u_start: WheelVector,
    period: float = PERIOD,
    steps: int = 25,
    disturbance: float = 0.0,
) -> tuple[Quaternion, Vector3]:
    """(q_BT, omega) after a period in which the wheels ramp from u_start to u at RATE_MAX.

    (J - A Js A') w' = -A u - w x (J w + A Js Omega) + d,  Js (Omega' + A'w') = u, with d a torque
    of the given size along w: the one that adds the most energy.
    """
    J_hub_inverse, J, A = np.asarray(np.linalg.inv(case.J_hub)), case.J, case.A

    def rates(t: float, y: Array) -> Array:
        q, w, Omega = y[:, :4], y[:, 4:7], y[:, 7:]
        torque = u_start + np.clip(u - u_start, -RATE_MAX * abs(t), RATE_MAX * abs(t))
        H = mv(J, w) + case.Js * mv(A, Omega)
        push = -mv(A, torque) - np.cross(w, H) + disturbance * unit(w)
        w_dot = mv(J_hub_inverse, push)
        Omega_dot = torque / case.Js - w_dot @ A
        q_dot = 0.5 * np.concatenate(
            [-np.sum(q[:, 1:] * w, 1, keepdims=True), q[:, :1] * w + np.cross(q[:, 1:], w)], 1
        )
        return np.concatenate([q_dot, w_dot, Omega_dot], 1)

    y, h = np.concatenate([case.q_BT, case.omega, case.wheel_speed], 1), period / steps
    for k in range(steps):
        t = k * h
        k1 = rates(t, y)
        k2 = rates(t + h / 2, y + h / 2 * k1)
        k3 = rates(t + h / 2, y + h / 2 * k2)
        k4 = rates(t + h, y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return unit(y[:, :4]), y[:, 4:7]


def unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def mv(M: Array, v: Array) -> Array:
    return np.asarray(np.einsum("...ij,...j->...i", M, v))
