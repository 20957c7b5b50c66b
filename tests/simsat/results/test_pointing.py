"""Pointing over hours: what counts from the first settling on."""

from pathlib import Path

import numpy as np
import pytest

import simsat
from simsat.results.pointing import first_settled, unactuated_momentum

T = np.arange(0.0, 60.0, 0.5)


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        ([(10.0, 12.0), (20.0, 60.0)], 20.0),  # what drifts through does not count
        ([(0.0, 60.0)], 0.0),
        ([(10.0, 15.0)], 10.0),  # five seconds are enough
        ([(10.0, 14.5)], None),
        ([(56.0, 60.0)], None),
        ([], None),
    ],
)
def test_settled_is_what_stays(inside: list[tuple[float, float]], expected: float | None) -> None:
    error = np.full(len(T), 2.0)
    for start, end in inside:
        error[(start <= T) & (end >= T)] = 0.1
    first = first_settled(T, error, 0.5, 5.0)
    assert (None if first is None else T[first]) == expected


def test_figures_of_a_flight_that_leaves_its_bounds_again() -> None:
    """Without rods the residual dipole turns two wheels away from their target."""
    result = simsat.fly("two_wheel", controller="nmpc", angle_deg=0.1, duration_s=300.0,
                        environment={"magnetic": True, "dipole_Am2": (0.5, 0.5, 0.0)})  # fmt: skip
    figures, error = result.metrics, result.table["error_deg"].to_numpy()
    assert figures["first_settled_s"] == 0.0
    assert figures["share_in_bounds"] == pytest.approx(np.mean(error < 0.5))
    assert 0.0 < figures["share_in_bounds"] < 1.0
    assert figures["largest_excursion_deg"] == error.max() > 0.5
    assert figures["median_error_deg"] == np.median(error)
    assert figures["p95_error_deg"] == pytest.approx(np.percentile(error, 95))
    assert "peak_dipole_Am2" not in figures
    along = result.flight.plant.momentum_N()
    R = simsat.control.ground.attitude.rotation_matrix(result.flight.plant.attitudes)
    expected = np.einsum("kij,kj->ki", np.swapaxes(R, 1, 2), along)[:, 2]
    np.testing.assert_allclose(unactuated_momentum(result.flight), expected, atol=1e-12)  # Nms
    assert figures["unactuated_momentum_Nms"]["largest"] == pytest.approx(np.abs(expected).max())


def test_what_never_settles_has_no_figures(tmp_path: Path) -> None:
    result = simsat.fly("two_wheel", angle_deg=90.0, duration_s=2.0)
    for name in ("first_settled_s", "share_in_bounds", "largest_excursion_deg", "p95_error_deg"):
        assert result.metrics[name] is None
    assert "targets" not in result.metrics
