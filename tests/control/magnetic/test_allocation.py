import numpy as np
import pytest
from scipy.optimize import linprog

from simsat.control.ground.arrays import Array
from simsat.control.ground.magnetorquers import NO_RODS, Magnetorquers
from simsat.control.magnetic.allocation import allocate, capability, torque_map

SKEWED = np.array([[1.0, 0.0, 0.6, 0.0], [0.0, 0.8, 0.0, -0.6], [0.0, 0.6, 0.8, 0.8]])


def rods(axes: Array, limit: float = 0.2) -> Magnetorquers:
    names = tuple(f"rod_{i}" for i in range(axes.shape[1]))
    return Magnetorquers(names, axes, np.linspace(limit, 1.5 * limit, len(names)))


THREE, FOUR, TWO, ONE = (
    rods(axes) for axes in (np.eye(3), SKEWED, np.eye(3)[:, :2], np.eye(3)[:, 2:])
)


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


@pytest.mark.parametrize("craft", [THREE, FOUR, TWO, ONE])
def test_no_dipole_within_the_limits_gives_more_than_the_capability(craft: Magnetorquers) -> None:
    for n, B in draws(20):
        best = linprog(-1e5 * n @ torque_map(craft, B), bounds=[(-m, m) for m in craft.dipole_max])
        assert capability(craft, B, n) == pytest.approx(-best.fun / 1e5, rel=1e-9)


def test_three_rods_split_the_torque_plane_exactly() -> None:
    strong = rods(np.eye(3), 2.0)
    for n, B in draws(50):
        b = B / np.linalg.norm(B)
        across = np.linalg.norm(np.cross(b, n))
        if across < 0.5:
            continue
        e1, e2 = (n - b * (b @ n)) / across, np.cross(b, n) / across
        got = strong.torque(allocate(strong, B, 1e-7 * n + 2e-7 * e2, n), B)
        assert got == pytest.approx(1e-7 / across * e1 + 2e-7 * e2, rel=0.05, abs=5e-9)
        assert n @ got == pytest.approx(1e-7, rel=0.05)


@pytest.mark.parametrize("craft", [THREE, FOUR, TWO, ONE])
def test_what_is_asked_along_n_is_met_until_it_costs_ten_times_as_much_across(
    craft: Magnetorquers,
) -> None:
    for n, B in draws(50):
        dipole = allocate(craft, B, 0.5 * capability(craft, B, n) * n, n)
        assert np.all(np.abs(dipole) <= craft.dipole_max)
        torque = craft.torque(dipole, B)
        across = float(np.linalg.norm(torque - n * (n @ torque)))
        met = float(n @ torque) / (0.5 * capability(craft, B, n))
        assert met <= 1.0 + 1e-9
        assert met >= 0.45 or across > 5.0 * abs(float(n @ torque))


def test_without_a_field_or_rods_there_is_no_dipole() -> None:
    n = np.array([0.0, 0.0, 1.0])
    assert allocate(THREE, 0.0 * n, 1e-6 * n, n) == pytest.approx(np.zeros(3))
    assert allocate(NO_RODS, 1e-5 * n, 1e-6 * n, n).shape == (0,)
