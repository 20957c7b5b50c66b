"""The signed-rank test against brute force over all signs and SciPy, its interval against itself.

Truth for settling times is their whole multiples of the sample interval, which have no round-off.
"""

import itertools

import numpy as np
import pytest
from scipy import stats

from simsat.comparison.signed_rank import (
    EXACT_PAIRS,
    differences,
    hodges_lehmann,
    hodges_lehmann_interval,
    rank_biserial,
    signed_rank_distribution,
    signed_ranks,
    wilcoxon_p,
)

SAMPLE_S = 0.05


def by_enumeration(d: np.ndarray) -> float:
    """Two-sided p of whole differences: the share of all 2^n choices of signs whose sum of signed
    ranks is as far from zero as theirs. Zeros are ranked, then dropped (Pratt 1959)."""
    ranks = 2.0 * stats.rankdata(np.abs(d)) * (d != 0)  # twice mean ranks: whole numbers
    signs = np.array(list(itertools.product([-1.0, 1.0], repeat=d.size)))
    return float(np.mean(np.abs(signs @ ranks) >= abs(np.sign(d) @ ranks)))


def settling(rng: np.random.Generator, pairs: int) -> np.ndarray:
    """Settling times of two controllers, in samples, with many ties and some zeros."""
    base = rng.integers(100, 1800, pairs)
    step = rng.normal(rng.choice([0.0, 0.7, 1.5]), rng.choice([0.8, 2.0, 6.0]), pairs)
    return np.column_stack([base + np.rint(step).astype(int), base])


def campaigns(count: int, most: int) -> list[np.ndarray]:
    rng = np.random.default_rng(20)
    return [settling(rng, int(rng.integers(1, most + 1))) for _ in range(count)]


def test_p_is_the_share_of_all_choices_of_signs() -> None:
    tied = zero = 0
    for samples in campaigns(200, 12):
        whole = samples[:, 0] - samples[:, 1]
        zero += 0 in whole
        tied += np.unique(np.abs(whole)).size < whole.size
        for unit in (SAMPLE_S, 1 / 256, 0.07):
            d = differences(unit * samples.astype(float))
            assert wilcoxon_p(d) == pytest.approx(by_enumeration(whole), rel=1e-12)
            assert rank_biserial(d) == rank_biserial(whole.astype(float))
    assert min(tied, zero) > 50


def test_p_is_scipys_over_permutations_and_without_ties_its_exact_one() -> None:
    everything = stats.PermutationMethod(n_resamples=np.inf)
    for samples in campaigns(8, 10):
        d = (samples[:, 0] - samples[:, 1]).astype(float)
        truth = stats.wilcoxon(d, zero_method="pratt", method=everything).pvalue
        assert wilcoxon_p(d) == pytest.approx(truth, rel=1e-12)
    for n in (1, 9, 40, EXACT_PAIRS):
        d = np.random.default_rng(n).normal(0.4, 1.0, n)
        truth = stats.wilcoxon(d, method="exact").pvalue
        assert wilcoxon_p(d) == pytest.approx(truth, rel=1e-9)


def test_round_off_does_not_rank_thirteen_pairs() -> None:
    """As the numbers come, p is 0.016 and the effect 0.74: significant by round-off alone."""
    ours = [1219, 1650, 778, 1527, 371, 550, 1186, 943, 477, 1427, 147, 623, 1621]
    base = [1220, 1649, 777, 1528, 370, 549, 1185, 942, 476, 1424, 146, 624, 1620]
    pairs = SAMPLE_S * np.column_stack([ours, base])
    raw = pairs[:, 0] - pairs[:, 1]
    assert np.unique(np.abs(raw)).size > 2
    assert wilcoxon_p(raw) == pytest.approx(0.016, abs=5e-4)
    d = differences(pairs)
    assert np.unique(np.abs(d)).size == 2
    # Twelve sizes of 1 share rank 6.5, the three of them against: T- = 19.5, T+ = 71.5.
    assert rank_biserial(d) == pytest.approx((71.5 - 19.5) / 91)
    assert (
        wilcoxon_p(d) == by_enumeration(np.subtract(ours, base)) == pytest.approx(0.0762, abs=1e-4)
    )


def test_what_differs_by_round_off_is_equal() -> None:
    a = np.array([0.1, 0.3, 90.0])
    d = differences(np.column_stack([a * (1 + 4e-16), a]))
    np.testing.assert_array_equal(d, np.zeros(3))
    # Relative to the largest value, 50: the differences 1e-9 and 1e-6 are nothing and something.
    d = differences(np.array([[50.0, 40.0], [1.0 + 1e-9, 1.0], [1.0, 1.0 + 1e-6]]))
    np.testing.assert_allclose(d, [10.0, 0.0, -1e-6], rtol=1e-9)
    assert differences(np.zeros((0, 2))).size == 0


@pytest.mark.parametrize("n", [1, 2, 5, 10])
def test_the_null_distribution_counts_every_choice_of_signs(n: int) -> None:
    ranks = np.arange(1.0, n + 1.0)
    sums = [int(ranks @ signs) for signs in itertools.product([0, 1], repeat=n)]
    expected = np.bincount(sums, minlength=n * (n + 1) // 2 + 1) / 2**n
    np.testing.assert_allclose(signed_rank_distribution(ranks), expected, rtol=0, atol=1e-15)


def test_signed_ranks_are_mean_ranks_with_a_sign() -> None:
    for samples in campaigns(50, 30):
        d = (samples[:, 0] - samples[:, 1]).astype(float)
        for shift in (0.0, 1.0, -0.5):
            moved = d - shift
            expected = np.sign(moved) * stats.rankdata(np.abs(moved))
            np.testing.assert_array_equal(signed_ranks(d, shift), expected)


def test_many_pairs_are_tested_by_scipys_approximation() -> None:
    samples = settling(np.random.default_rng(3), EXACT_PAIRS + 1)
    d = (samples[:, 0] - samples[:, 1]).astype(float)
    truth = stats.wilcoxon(d, zero_method="pratt", method="asymptotic").pvalue
    assert wilcoxon_p(d) == pytest.approx(truth, rel=1e-9)
    assert wilcoxon_p(d) == pytest.approx(_exactly(d), rel=0.07)  # as EXACT_PAIRS says
    assert wilcoxon_p(np.zeros(EXACT_PAIRS + 1)) == 1.0


def _exactly(d: np.ndarray) -> float:
    """The exact p, whatever the number of pairs: twice the tail that T+ lies in."""
    doubled = 2.0 * stats.rankdata(np.abs(d)) * (d != 0)
    p, t = signed_rank_distribution(doubled), int(doubled[d > 0].sum())
    return 2.0 * float(min(p[t:].sum(), p[: t + 1].sum()))


def test_zero_is_outside_the_interval_only_where_the_test_rejects_it() -> None:
    """An end itself is left open; what lies strictly inside or outside follows the test."""
    inside = outside = 0
    for samples in campaigns(300, 25):
        d = differences(SAMPLE_S * samples.astype(float))
        p, (low, high) = wilcoxon_p(d), hodges_lehmann_interval(d)
        assert low <= hodges_lehmann(d) <= high
        inside += low < 0.0 < high
        outside += not low <= 0.0 <= high
        if p > 0.05:
            assert low <= 0.0 <= high
        else:
            assert not low < 0.0 < high
    assert min(inside, outside) > 50


def test_the_interval_s_ends_are_where_the_test_turns() -> None:
    rng = np.random.default_rng(5)
    for n in (8, 20, 45):
        for d in (rng.normal(0.3, 1.0, n), np.rint(rng.normal(1.0, 3.0, n))):
            low, high = hodges_lehmann_interval(d)
            assert low < hodges_lehmann(d) < high
            for edge, inwards in ((low, 1e-6), (high, -1e-6)):
                assert wilcoxon_p(d - edge - inwards) > 0.05 >= wilcoxon_p(d - edge + inwards)


def test_the_interval_is_mirrored_with_the_data() -> None:
    for samples in campaigns(20, 20):
        d = (samples[:, 0] - samples[:, 1]).astype(float)
        low, high = hodges_lehmann_interval(d)
        assert hodges_lehmann_interval(-d) == (-high, -low)
        assert wilcoxon_p(-d) == wilcoxon_p(d)


def test_no_signed_rank_rises_with_the_shift_unless_zeros_are_dropped() -> None:
    """Why the interval has no holes, and why the rule is Pratt's: dropped zeros lower the ranks of
    all others, and a shift that makes everything smaller makes the evidence stronger."""
    broken = 0
    for samples in campaigns(50, 12):
        d = (samples[:, 0] - samples[:, 1]).astype(float)
        shifts = np.arange(d.min() - 1.0, d.max() + 1.0, 0.25)
        ranks = np.array([signed_ranks(d, shift) for shift in shifts])
        assert (np.diff(ranks, axis=0) <= 0.0).all()
        dropped = [d[d != shift] - shift for shift in shifts]
        tails = [stats.wilcoxon(x, alternative="greater", method="exact").pvalue if x.size else 1.0
                 for x in dropped if np.unique(np.abs(x)).size == x.size]  # fmt: skip
        broken += bool((np.diff(tails) < 0.0).any())
    assert broken > 0


def test_too_few_pairs_leave_the_interval_open() -> None:
    assert hodges_lehmann_interval(np.array([1.0, 2.0, 3.0])) == (-np.inf, np.inf)
    assert hodges_lehmann_interval(np.zeros(5)) == (-np.inf, np.inf)  # p is 1/16 at the least
    assert hodges_lehmann_interval(np.zeros(6)) == (0.0, 0.0)
    assert hodges_lehmann_interval(np.zeros(0)) == (-np.inf, np.inf)


@pytest.mark.parametrize("grid", [None, 0.5])
def test_the_interval_covers_the_true_shift_as_often_as_it_says(grid: float | None) -> None:
    rng = np.random.default_rng(6)
    covered = 0
    for _ in range(400):
        d = rng.standard_t(3, 25)
        d = 1.5 + (d if grid is None else grid * np.rint(d / grid))
        low, high = hodges_lehmann_interval(d)
        covered += low <= 1.5 <= high
    assert covered > 0.95 * 400 - 3 * np.sqrt(400 * 0.95 * 0.05)  # three sigma below


def test_hodges_lehmann_is_the_centre_of_a_symmetric_sample() -> None:
    d = np.concatenate([2.0 + np.arange(1, 6), 2.0 - np.arange(1, 6)])
    assert hodges_lehmann(d) == pytest.approx(2.0)
    # Averages of pairs, each with itself too: 0, 0.5, 1, 5, 5.5, 10.
    assert hodges_lehmann(np.array([0.0, 10.0, 1.0])) == pytest.approx(3.0)


def test_the_effect_is_the_excess_of_favourable_ranks() -> None:
    assert rank_biserial(np.array([1.0, 2.0, 3.0])) == 1.0
    assert rank_biserial(np.array([-1.0, -2.0, 0.0])) == pytest.approx(-5.0 / 6.0)  # ranks 2, 3
    # Ranks 1, 2, 3: (1 + 3 - 2) / 6.
    assert rank_biserial(np.array([0.1, -0.2, 0.3])) == pytest.approx(1.0 / 3.0)
    d = np.random.default_rng(7).normal(0.2, 1.0, 30)
    smaller = stats.wilcoxon(d).statistic  # min(T+, T-)
    assert abs(rank_biserial(d)) == pytest.approx(1.0 - 2.0 * smaller / (30 * 31 / 2))


def test_no_difference_is_no_evidence_and_no_pair_is_no_test() -> None:
    assert (wilcoxon_p(np.zeros(5)), rank_biserial(np.zeros(5))) == (1.0, 0.0)
    assert hodges_lehmann(np.zeros(5)) == 0.0
    assert wilcoxon_p(np.array([0.3])) == 1.0
    nothing = np.zeros(0)
    assert np.isnan([wilcoxon_p(nothing), rank_biserial(nothing), hodges_lehmann(nothing)]).all()
