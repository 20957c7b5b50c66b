import numpy as np
import pytest
from scipy.optimize import linprog

from simsat.control.ground.arrays import Array
from simsat.control.magnetic.allocation import allocate, capability, rod_torque, torque_map

LIMIT = np.array([0.2, 0.2, 0.2])
SKEWED = np.array([[1.0, 0.0, 0.6, 0.0], [0.0, 0.8, 0.0, -0.6], [0.0, 0.6, 0.8, 0.8]])


def draws(count: int) -> list[tuple[Array, Array]]:
    """Unit directions and fields of the size of a low orbit's, T."""
    rng = np.random.default_rng(5)
    n = rng.normal(size=(count, 3))
    return list(
        zip(
            n / np.linalg.norm(n, axis=1, keepdims=True),
            2e-5 * rng.normal(size=(count, 3)),
            strict=True,
        )
    )


def test_the_torque_is_the_loop_current_law() -> None:
    # A coil of one turn and area a in the y-z plane, I = 2 A: force I dl x B on its four sides.
    side, current, B = 0.5, 2.0, np.array([1e-5, -3e-5, 2e-5])
    corners = side / 2.0 * np.array([[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]])
    torque = np.zeros(3)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        torque += np.cross(0.5 * (start + end), current * np.cross(end - start, B))
    dipole = np.array([current * side**2])
    assert rod_torque(np.array([[1.0], [0.0], [0.0]]), dipole, B) == pytest.approx(
        torque, rel=1e-12
    )


@pytest.mark.parametrize("axes", [np.eye(3), SKEWED])
def test_no_dipole_within_the_limits_gives_more_than_the_capability(axes: Array) -> None:
    limit = np.linspace(0.1, 0.3, axes.shape[1])
    for n, B in draws(20):
        best = linprog(-n @ torque_map(axes, B) * 1e5, bounds=[(-m, m) for m in limit])
        assert capability(axes, limit, B, n) == pytest.approx(-best.fun / 1e5, rel=1e-9)


def test_three_rods_split_the_torque_plane_exactly() -> None:
    for n, B in draws(50):
        b = B / np.linalg.norm(B)
        across = np.linalg.norm(np.cross(b, n))
        e1, e2 = (n - b * (b @ n)) / across, np.cross(b, n) / across
        wanted = 1e-7 * n + 2e-7 * e2
        got = rod_torque(np.eye(3), allocate(np.eye(3), 10.0 * LIMIT, B, wanted, n), B)
        assert got == pytest.approx(1e-7 / across * e1 + 2e-7 * e2, rel=1e-3, abs=2e-10)
        assert n @ got == pytest.approx(1e-7, rel=1e-3)


@pytest.mark.parametrize("axes", [np.eye(3), SKEWED, np.eye(3)[:, :2], np.eye(3)[:, 2:]])
def test_what_comes_first_is_met_as_far_as_any_dipole_can(axes: Array) -> None:
    limit = np.full(axes.shape[1], 0.2)
    for n, B in draws(50):
        most = capability(axes, limit, B, n)
        for share in (0.5, 3.0):
            dipole = allocate(axes, limit, B, share * most * n + 1e-5 * np.cross(n, B) / 2e-5, n)
            assert np.all(np.abs(dipole) <= limit)
            along = n @ rod_torque(axes, dipole, B)
            assert along == pytest.approx(min(share, 1.0) * most, rel=2e-2, abs=1e-10)


def test_without_a_field_or_rods_there_is_no_dipole() -> None:
    n = np.array([0.0, 0.0, 1.0])
    assert allocate(np.eye(3), LIMIT, np.zeros(3), 1e-6 * n, n) == pytest.approx(np.zeros(3))
    assert allocate(np.zeros((3, 0)), np.zeros(0), 1e-5 * n, n).shape == (0,)
