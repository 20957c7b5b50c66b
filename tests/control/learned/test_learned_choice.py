"""Which prediction is planned with, from where each says that the plan ends."""

from collections.abc import Mapping

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.learned.choice.choice import (
    FADING,
    NOTHING,
    WORST,
    Prediction,
    Trial,
    choose,
    judge,
)

NOMINAL, LEARNED, NETWORK = Prediction
HERE = np.zeros(5)


def off(size: float) -> Array:
    return HERE + size * np.array([0.6, 0.0, 0.0, -0.8, 0.0])


def after(trial: Trial, moved: Mapping[Prediction, Array]) -> Trial:
    """The trial after a period in which each prediction's end moved so far."""
    return judge(trial, {prediction: (HERE, end) for prediction, end in moved.items()})


def test_a_rise_is_how_far_the_plans_end_moved_and_fades() -> None:
    trial = after(Trial(LEARNED), {NOMINAL: off(0.02), LEARNED: HERE})
    assert trial.rise[NOMINAL] == pytest.approx(0.02)
    assert trial.rise[LEARNED] == 0.0
    trial = after(trial, {NOMINAL: off(0.01), LEARNED: HERE})
    assert trial.rise[NOMINAL] == pytest.approx(FADING * 0.02 + 0.01)


def test_without_anything_to_tell_them_apart_the_choice_stays() -> None:
    for now in Prediction:
        assert choose(now, {}) is now
        assert choose(now, dict.fromkeys(Prediction, 0.01)) is now


def test_a_network_is_adopted_once_it_is_clearly_better() -> None:
    assert choose(LEARNED, {NOMINAL: 0.1, LEARNED: 0.01, NETWORK: 0.008}) is LEARNED
    assert choose(LEARNED, {NOMINAL: 0.1, LEARNED: 0.01, NETWORK: 0.006}) is NETWORK
    assert choose(NETWORK, {NOMINAL: 0.1, LEARNED: 0.01, NETWORK: 0.008}) is NETWORK


def test_what_does_worse_than_something_simpler_is_left_at_once() -> None:
    assert choose(NETWORK, {NOMINAL: 0.1, LEARNED: 0.01, NETWORK: 0.013}) is LEARNED
    assert choose(LEARNED, {NOMINAL: 0.01, LEARNED: 0.02}) is NOMINAL
    assert choose(NETWORK, {NOMINAL: 0.01, LEARNED: 0.02, NETWORK: 0.005}) is NETWORK


def test_where_all_are_right_the_richest_is_taken() -> None:
    assert choose(NOMINAL, dict.fromkeys(Prediction, 0.5 * NOTHING)) is NETWORK


def test_an_end_that_is_no_number_counts_as_the_worst_and_is_forgiven_in_time() -> None:
    trial = after(Trial(NETWORK), {LEARNED: HERE, NETWORK: np.full(5, np.nan)})
    assert trial.rise[NETWORK] == WORST
    assert trial.chosen is LEARNED
    for _ in range(60):
        trial = after(trial, {LEARNED: HERE, NETWORK: HERE})
    assert trial.chosen is NETWORK


def test_every_prediction_is_a_sentence() -> None:
    assert all(prediction.value.endswith(".") for prediction in Prediction)
