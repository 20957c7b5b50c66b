"""An independent flight of a rigid spacecraft with wheels, by SciPy, for tests of what is learned.

Euler's equation with wheels in its usual form, integrated to 1e-10: nothing is shared with the
momentum form that it judges.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from simsat.control.ground.arrays import Array, Vector3
from simsat.control.ground.spacecraft import Spacecraft

JS = 0.9 / (6000.0 * 2.0 * np.pi / 60.0)  # kg m^2
TRUE_J = np.array([[1.62, 0.06, -0.05], [0.06, 1.488, 0.07], [-0.05, 0.07, 1.272]])
NOMINAL_J = np.diag([1.5, 1.6, 1.2])
TARGET = np.array([1.0, 0.0, 0.0, 0.0])
SKEWED = np.array([[0.98, 0.16, 0.1], [0.3, 0.93, -0.2]]).T
SKEWED = SKEWED / np.linalg.norm(SKEWED, axis=0)


def craft(
    J: Array = TRUE_J,
    A: Array | None = None,
    coulomb: float = 0.0,
    viscous: float = 0.0,
    rate: float = 0.4,
    speed_max: float = 628.3,
    torque_max: float = 0.05,
) -> Spacecraft:
    A = np.eye(3)[:, :2] if A is None else A
    m = A.shape[1]
    names = tuple(f"wheel_{j}" for j in range(m))
    return Spacecraft(
        "case",
        50.0,
        J,
        names,
        A,
        Js=np.full(m, JS),
        torque_max=np.full(m, torque_max),
        torque_rate_max=np.full(m, rate),
        speed_max=np.full(m, speed_max),
        viscous=np.full(m, viscous),
        coulomb=np.full(m, coulomb),
    )


@dataclass(frozen=True)
class Flown:
    t: Array
    q: Array
    omega: Array
    speed: Array


def flown(
    spacecraft: Spacecraft,
    torque: Callable[[float], Array],
    t: Array,
    q0: Array = TARGET,
    omega0: Vector3 | None = None,
    speed0: Array | None = None,
    external_N: Callable[[float, Array], Vector3] = lambda t, R: np.array([0.0, 0.0, 0.0]),
    rtol: float = 1e-10,
) -> Flown:
    """States at times t under motor torques torque(t) and an external torque (inertial axes)."""
    J, A, Js, m = spacecraft.J, spacecraft.A, spacecraft.Js, spacecraft.wheels
    hub_inverse = np.linalg.inv(J - (A * Js) @ A.T)

    def rate(time: float, x: Array) -> Array:
        q, w, speed = x[:4], x[4:7], x[7:]
        R = matrix(q)
        friction = spacecraft.coulomb * np.tanh(speed / 0.5) + spacecraft.viscous * speed
        net = torque(time) - friction
        H = J @ w + A @ (Js * speed)
        w_dot = hub_inverse @ (R.T @ external_N(time, R) - A @ net - cross(w, H))
        q_dot = 0.5 * np.r_[-q[1:] @ w, q[0] * w + cross(q[1:], w)]
        return np.r_[q_dot, w_dot, net / Js - A.T @ w_dot]

    start = np.r_[
        q0,
        np.zeros(3) if omega0 is None else omega0,
        np.zeros(m) if speed0 is None else speed0,
    ]
    span = (float(t[0]), float(t[-1]))
    x = solve_ivp(rate, span, start, "DOP853", t, rtol=rtol, atol=0.1 * rtol, max_step=0.5).y.T
    q = x[:, :4] / np.linalg.norm(x[:, :4], axis=1, keepdims=True)
    return Flown(t, q, x[:, 4:7], x[:, 7:])


def times(count: int, step: float = 0.05) -> Array:
    """So many sample times from zero, s."""
    return np.arange(count, dtype=np.float64) * step


def cross(a: Vector3, b: Vector3) -> Vector3:
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def matrix(q: Array) -> Array:
    """R(q), body to inertial, by Rodrigues' formula."""
    v = q[1:]
    K = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + 2.0 * q[0] * K + 2.0 * K @ K


def slewing(t: float) -> Array:
    """Torques of a lively two-wheel slew, Nm."""
    return 0.03 * np.array([np.cos(0.8 * t), np.sin(0.55 * t + 0.4)])


def ramped(plan: Array, before: Array, rate: float, period: float) -> Callable[[float], Array]:
    """Motor torques that follow a plan of shape (K, m) at a limited rate, from `before`."""
    held = np.vstack([before, plan])

    def torque(t: float) -> Array:
        k = min(int(t / period + 1e-12), len(plan) - 1)
        change = held[k + 1] - held[k]
        moved = np.minimum(np.abs(change), rate * (t - k * period))
        return held[k] + np.sign(change) * moved

    return torque
