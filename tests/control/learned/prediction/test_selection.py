"""Which model is planned with, from where each says that the plan ends."""

from collections.abc import Mapping

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.learned.prediction.selection import (
    FORGETTING,
    LARGEST,
    NEGLIGIBLE,
    ModelSelection,
    PredictionModel,
    reselected,
    select,
)

NOMINAL, LEARNED, NETWORK = PredictionModel
HERE = np.zeros(5)


def off(size: float) -> Array:
    return HERE + size * np.array([0.6, 0.0, 0.0, -0.8, 0.0])


def after(
    selection: ModelSelection, moved: Mapping[PredictionModel, Array], period: float = 0.5
) -> ModelSelection:
    """The selection after a period in which each model's end moved so far."""
    return reselected(selection, {model: (HERE, end) for model, end in moved.items()}, period)


def test_a_rise_is_how_far_the_plans_end_moved_and_fades() -> None:
    selection = after(ModelSelection(LEARNED), {NOMINAL: off(0.02), LEARNED: HERE})
    assert selection.value_rise[NOMINAL] == pytest.approx(0.02)
    assert selection.value_rise[LEARNED] == 0.0
    selection = after(selection, {NOMINAL: off(0.01), LEARNED: HERE})
    assert selection.value_rise[NOMINAL] == pytest.approx(FORGETTING * 0.02 + 0.01)


def test_a_rise_fades_as_fast_whatever_the_period() -> None:
    for period, count in ((0.5, 2), (0.1, 10)):
        selection = ModelSelection(LEARNED, {NOMINAL: 1.0})
        for _ in range(count):
            selection = after(selection, {NOMINAL: HERE}, period)
        assert selection.value_rise[NOMINAL] == pytest.approx(FORGETTING**2)


def test_without_anything_to_tell_them_apart_the_choice_stays() -> None:
    for now in PredictionModel:
        assert select(now, {}) is now
        assert select(now, dict.fromkeys(PredictionModel, 0.01)) is now


def test_a_network_is_adopted_once_it_is_clearly_better() -> None:
    assert select(LEARNED, {NOMINAL: 0.1, LEARNED: 0.01, NETWORK: 0.008}) is LEARNED
    assert select(LEARNED, {NOMINAL: 0.1, LEARNED: 0.01, NETWORK: 0.006}) is NETWORK
    assert select(NETWORK, {NOMINAL: 0.1, LEARNED: 0.01, NETWORK: 0.008}) is NETWORK


def test_what_does_worse_than_something_simpler_is_left_at_once() -> None:
    assert select(NETWORK, {NOMINAL: 0.1, LEARNED: 0.01, NETWORK: 0.013}) is LEARNED
    assert select(LEARNED, {NOMINAL: 0.01, LEARNED: 0.02}) is NOMINAL
    assert select(NETWORK, {NOMINAL: 0.01, LEARNED: 0.02, NETWORK: 0.005}) is NETWORK


def test_where_all_are_right_the_richest_is_taken() -> None:
    assert select(NOMINAL, dict.fromkeys(PredictionModel, 0.5 * NEGLIGIBLE)) is NETWORK


def test_an_end_that_is_no_number_counts_as_the_worst_and_is_forgiven_in_time() -> None:
    selection = after(ModelSelection(NETWORK), {LEARNED: HERE, NETWORK: np.full(5, np.nan)})
    assert selection.value_rise[NETWORK] == LARGEST
    assert selection.selected is LEARNED
    for _ in range(60):
        selection = after(selection, {LEARNED: HERE, NETWORK: HERE})
    assert selection.selected is NETWORK


def test_every_model_is_a_sentence() -> None:
    assert all(model.value.endswith(".") for model in PredictionModel)
