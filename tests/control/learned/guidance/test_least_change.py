import numpy as np
from scipy.optimize import minimize

from simsat.control.ground.arrays import Array
from simsat.control.learned.guidance.least_change import least_change


def random_problem(seed: int, reachable: bool = True) -> tuple[Array, Array, Array]:
    n, rows = 12, 3
    rng = np.random.default_rng(seed)
    c, C = rng.normal(size=n), rng.normal(size=(rows, n))
    inside = rng.uniform(-1.0, 1.0, n)
    return c, C, C @ inside * (1.0 if reachable else 30.0)


def test_it_agrees_with_a_general_solver() -> None:
    for seed in range(20):
        c, C, d = random_problem(seed)
        ours = least_change(c, C, d, -np.ones(12), np.ones(12), 1e-9)
        theirs = minimize(
            lambda u, c=c: 0.5 * np.sum((u - c) ** 2),
            np.clip(c, -1, 1),
            jac=lambda u, c=c: u - c,
            bounds=[(-1.0, 1.0)] * 12,
            constraints={
                "type": "eq",
                "fun": lambda u, C=C, d=d: C @ u - d,
                "jac": lambda u, C=C: C,
            },
            options={"ftol": 1e-14, "maxiter": 500},
        ).x
        assert np.max(np.abs(C @ ours - d)) < 1e-7
        assert np.max(np.abs(ours - theirs)) < 1e-5


def test_what_cannot_be_reached_is_missed_inside_the_bounds() -> None:
    for seed in range(10):
        c, C, d = random_problem(seed, reachable=False)
        eps = 1e-4
        u = least_change(c, C, d, -np.ones(12), np.ones(12), eps)
        gradient = eps * (u - c) + C.T @ (C @ u - d)  # Karush-Kuhn-Tucker: signs at the bounds
        assert np.all(np.abs(u) <= 1.0)
        assert np.all(gradient[u >= 1.0] <= 1e-8)
        assert np.all(gradient[u <= -1.0] >= -1e-8)
        assert np.all(np.abs(gradient[np.abs(u) < 1.0]) < 1e-8)


def test_a_row_without_effect_does_no_harm() -> None:
    c, C, d = random_problem(3)
    C[1], d[1] = 0.0, 0.5
    u = least_change(c, C, d, -np.ones(12), np.ones(12), 1e-6)
    rest = least_change(c, C[[0, 2]], d[[0, 2]], -np.ones(12), np.ones(12), 1e-6)
    assert np.max(np.abs(u - rest)) < 1e-6
