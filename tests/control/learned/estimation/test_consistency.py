from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest

from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.learned.estimation.appendage_process import CORRELATION_TIME
from simsat.control.learned.estimation.consistency import (
    consistent,
    normalised_innovation,
    plausible,
)
from simsat.control.learned.estimation.estimate import ModelEstimate
from simsat.control.learned.estimation.filter import filtered
from simsat.control.learned.estimation.prior import INITIAL_FLEXIBILITY, initial_estimate
from simsat.control.learned.estimation.samples import Samples, samples_of
from tests.learned_cases import NOMINAL_J, TARGET, TRUE_J, craft, flown, slewing, times

Q = np.array([0.8, -0.36, 0.48, 0.0])
NOISE = 1e-6  # rad/s

Corruption = Callable[[ModelEstimate], ModelEstimate]


def windows(seconds: float = 6.0, wobble: float = 0.0) -> tuple[Spacecraft, list[Samples]]:
    """Samples of half a second each, of a rigid craft or one whose gyro shows a vibration."""
    truth = craft()
    f = flown(truth, slewing, times(int(seconds * 20) + 1), Q)
    omega = f.omega + wobble * np.sin(7.0 * f.t)[:, None] * np.array([1.0, -0.7, 0.5])
    nominal = craft(NOMINAL_J)
    parts = [slice(k, k + 11) for k in range(0, len(f.t) - 1, 10)]
    return nominal, [samples_of(f.q[p][-1], f.t[p], omega[p], f.speed[p], nominal) for p in parts]


def follow(
    nominal: Spacecraft,
    parts: list[Samples],
    corrupt_at: int | None = None,
    corrupt: Corruption = lambda k: k,
) -> list[ModelEstimate]:
    start = initial_estimate(nominal, parts[0], NOISE)
    history = [filtered(start, parts[0], NOISE)]
    for k, samples in enumerate(parts[1:], 1):
        known = corrupt(history[-1]) if k == corrupt_at else history[-1]
        history.append(filtered(consistent(start, known, samples, NOISE), samples, NOISE))
    return history


def test_a_rigid_craft_is_allowed_ever_less_flexibility() -> None:
    nominal, parts = windows()
    history = follow(nominal, parts)
    assert history[-1].restarts == 0
    assert history[-1].flexibility < 1e-3 * INITIAL_FLEXIBILITY


CORRUPTIONS = {
    "sign of the tilt": lambda k: spoilt(k, [4, 5], -3.0),
    "inertia too large": lambda k: spoilt(k, [0, 1], 1.4),
    "not a body": lambda k: spoilt(k, range(6), -1.0),
    "not a number": lambda k: spoilt(k, [7], np.nan),
    "no covariance": lambda k: replace(k, covariance=np.full((27, 27), np.inf)),
}


def spoilt(estimate: ModelEstimate, places: Iterable[int], factor: float) -> ModelEstimate:
    mean = estimate.mean.copy()
    mean[list(places)] *= factor
    return replace(estimate, mean=mean)


@pytest.mark.parametrize("corrupt", CORRUPTIONS.values(), ids=CORRUPTIONS.keys())
def test_a_corrupted_model_is_dropped_at_once_and_learned_again(corrupt: Corruption) -> None:
    nominal, parts = windows()
    history = follow(nominal, parts, corrupt_at=5, corrupt=corrupt)
    assert history[5].restarts == 1
    assert np.max(np.abs(history[5].J - TRUE_J)[:2, :2]) < 0.05
    assert np.max(np.abs(history[-1].J - TRUE_J)[:2, :2]) < 0.01


def test_a_craft_that_is_not_rigid_is_averaged_not_followed() -> None:
    nominal, parts = windows(seconds=12.0, wobble=2e-3)
    history = follow(nominal, parts)
    assert history[-1].flexibility > INITIAL_FLEXIBILITY
    assert np.max(np.abs(history[-1].J - TRUE_J)[:2, :2]) < 0.1
    assert np.max(np.abs(history[-1].h_N)) < 2e-4  # Nms; the vibration carries 3e-3
    settled = [known.restarts for known in history[-8:]]
    assert settled[0] == settled[-1]


def test_the_normalised_innovation_is_the_error_over_its_expectation() -> None:
    nominal, parts = windows()
    known = follow(nominal, parts)[-2]
    known = replace(
        known,
        mean=np.concatenate([known.mean[:6], np.zeros(21)]),
        covariance=np.zeros((27, 27)),
        flexibility=1e-3,
    )
    size = np.trace(known.J) / 3.0
    error = np.tile(np.full(3, 2e-3 * size), (11, 1))
    smooth = replace(parts[-1], omega=np.zeros_like(error), wheel_momentum=error)
    later = replace(smooth, t=smooth.t + 100.0)
    assert normalised_innovation(known, later, NOISE) == pytest.approx(
        2.0, rel=1e-5
    )  # c has had time to grow
    since = smooth.t - known.t
    grown = np.sqrt(np.mean(1.0 - np.exp(-2.0 * since / CORRELATION_TIME)))
    assert normalised_innovation(known, smooth, NOISE) == pytest.approx(2.0 / grown, rel=1e-5)
    rng = np.random.default_rng(0)
    noisy = replace(smooth, wheel_momentum=2e-3 * size * rng.normal(size=(11, 3)))
    rigid = replace(known, flexibility=0.0)
    assert normalised_innovation(rigid, noisy, NOISE) == pytest.approx(
        1.0, rel=0.3
    )  # scatter counts as noise


def test_what_is_plausible() -> None:
    nominal, parts = windows(1.0)
    start = initial_estimate(nominal, parts[0], NOISE)
    assert plausible(start, start)
    assert not plausible(start, spoilt(start, range(6), 4.0))
    assert not plausible(start, spoilt(start, [0], 0.1))


def test_the_deflection_is_the_rotation_by_which_a_vibration_moves_the_body() -> None:
    spacecraft = craft()
    t, axis = times(401), np.array([1.0, -0.7, 0.5])
    rates = 2e-3 * np.sin(7.0 * t)[:, None] * axis  # at rest but for the vibration
    rest = Samples(
        t,
        np.tile(TARGET, (401, 1)),
        rates,
        np.zeros_like(rates),
        np.zeros_like(rates),
        rates[:, :2],
    )
    start = initial_estimate(spacecraft, rest, NOISE)
    known = filtered(replace(start, covariance=np.zeros((27, 27)), flexibility=2e-3), rest, NOISE)
    swing = -2e-3 / 7.0 * np.cos(7.0 * t[-1]) * axis
    assert np.max(np.abs(known.deflection - swing)) < 0.06 * 2e-3 / 7.0
    assert np.max(np.abs(known.appendage_momentum + TRUE_J @ rates[-1])) < 1e-5
