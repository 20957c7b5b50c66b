"""A plan's intervals: all periods, few of them, and the same impulses."""

import numpy as np
import pytest

from simsat.control.learned.prediction.grid import (
    FIRST,
    LAST,
    MOST,
    gathered,
    interval_lengths,
    spread,
)


@pytest.mark.parametrize("periods", [1, 2, MOST, MOST + 1, 105, 300, 2999])
def test_they_fill_the_plan_and_are_never_many(periods: int) -> None:
    lengths = interval_lengths(periods, even=False)
    assert lengths.sum() == periods
    assert len(lengths) <= MOST
    assert np.all(lengths > 0)
    assert np.all(lengths[:FIRST] == 1)
    assert np.all(lengths[-LAST:] == 1)
    assert len(interval_lengths(periods, even=True)) == periods


def test_a_plan_of_few_periods_is_left_as_it_is() -> None:
    torque = np.random.default_rng(0).normal(size=(MOST, 2))
    lengths = interval_lengths(MOST, even=False)
    assert np.array_equal(gathered(torque, lengths), torque)
    assert np.array_equal(spread(torque, lengths), torque)


def test_the_impulse_up_to_every_boundary_is_kept() -> None:
    torque = np.random.default_rng(0).normal(size=(301, 3))
    lengths = interval_lengths(301, even=False)
    again = spread(gathered(torque, lengths), lengths)
    assert again.shape == torque.shape
    at = np.cumsum(lengths) - 1
    assert np.abs((np.cumsum(torque, axis=0) - np.cumsum(again, axis=0))[at]).max() < 1e-12


def test_a_period_later_the_far_intervals_stand_where_they_did() -> None:
    """So that what is planned on them passes on unchanged."""
    torque = np.random.default_rng(0).normal(size=(200, 2))
    lengths = interval_lengths(200, even=False)
    planned = spread(gathered(torque, lengths), lengths)
    later = interval_lengths(199, even=False)
    assert np.abs(spread(gathered(planned[1:], later), later) - planned[1:]).max() < 1e-15
