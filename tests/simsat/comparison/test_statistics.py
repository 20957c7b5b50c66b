"""The statistics against scipy, brute force over all signs, and the paper's own percentages."""

import itertools
from collections.abc import Sequence

import numpy as np
import pytest
from scipy import stats

from simsat.comparison.paper import PAPER_IMPROVEMENT, PAPER_TABLE
from simsat.comparison.statistics import (
    FINAL_ERROR,
    STEADY_STATE,
    Row,
    aggregate,
    compare,
    hodges_lehmann,
    hodges_lehmann_interval,
    holm,
    improvement,
    rank_biserial,
    signed_rank_distribution,
    summarize,
    wilcoxon_p,
    worst_rank,
)
from simsat.comparison.tables import comparison_md, paper_md, table_csv, table_md
from simsat.control.ground.errors import SettingsError

RNG = np.random.default_rng(20)


def rows_of(controller: str, final: Sequence[float], steady: Sequence[float | None]) -> list[Row]:
    return [
        {
            "controller": controller,
            "attitude": i,
            "converged": s is not None,
            "settling_time_s": None if s is None else 20.0 + i,
            "steady_state_rmse_deg": s,
            "final_error_deg": f,
        }
        for i, (f, s) in enumerate(zip(final, steady, strict=True))
    ]


def test_aggregates_say_how_many_runs_they_rest_on() -> None:
    rows = rows_of("a", [0.1, 0.2, 9.0], [0.1, 0.3, None]) + rows_of("b", [0.5], [0.4])
    a, b = aggregate(rows)
    assert (a.controller, a.runs, a.converged) == ("a", 3, 2)
    steady, final = a.summaries[STEADY_STATE.name], a.summaries[FINAL_ERROR.name]
    assert (steady.count, steady.maximum) == (2, 0.3)
    assert steady.mean == pytest.approx(0.2)
    assert steady.deviation == pytest.approx(0.02**0.5)
    assert final.count == 3  # what diverges still counts
    assert final.mean == pytest.approx(3.1)
    assert (b.runs, b.summaries[STEADY_STATE.name].count) == (1, 1)
    assert np.isnan(b.summaries[STEADY_STATE.name].deviation)
    assert summarize([np.nan]).count == 0


@pytest.mark.parametrize("n", [1, 2, 5, 10])
def test_the_null_distribution_counts_every_choice_of_signs(n: int) -> None:
    sums = [
        sum(rank for rank, sign in zip(range(1, n + 1), signs, strict=True) if sign)
        for signs in itertools.product([0, 1], repeat=n)
    ]
    expected = np.bincount(sums, minlength=n * (n + 1) // 2 + 1) / 2**n
    np.testing.assert_allclose(signed_rank_distribution(n), expected, rtol=0, atol=1e-15)


def test_the_interval_holds_the_shifts_that_the_test_does_not_reject() -> None:
    for n in (8, 20, 45):
        d = RNG.normal(0.3, 1.0, n)
        low, high = hodges_lehmann_interval(d)
        assert low < hodges_lehmann(d) < high
        for edge, inwards in ((low, 1e-9), (high, -1e-9)):
            inside = stats.wilcoxon(d - edge - inwards, method="exact").pvalue
            outside = stats.wilcoxon(d - edge + inwards, method="exact").pvalue
            assert inside > 0.05 >= outside


def test_too_few_pairs_leave_the_interval_open() -> None:
    assert hodges_lehmann_interval(np.array([1.0, 2.0, 3.0])) == (-np.inf, np.inf)
    assert hodges_lehmann_interval(np.zeros(0)) == (-np.inf, np.inf)


def test_the_interval_covers_the_true_shift_as_often_as_it_says() -> None:
    covered = 0
    for _ in range(400):
        low, high = hodges_lehmann_interval(RNG.standard_t(3, 25) + 0.7)
        covered += low <= 0.7 <= high
    assert covered > 0.95 * 400 - 3 * np.sqrt(400 * 0.95 * 0.05)  # three sigma below


def test_hodges_lehmann_is_the_centre_of_a_symmetric_sample() -> None:
    d = np.concatenate([2.0 + np.arange(1, 6), 2.0 - np.arange(1, 6)])
    assert hodges_lehmann(d) == pytest.approx(2.0)
    # Averages of pairs, each with itself too: 0, 0.5, 1, 5, 5.5, 10.
    assert hodges_lehmann(np.array([0.0, 10.0, 1.0])) == pytest.approx(3.0)
    assert np.isnan(hodges_lehmann(np.zeros(0)))


def test_holm_agrees_with_the_definition() -> None:
    # Holm (1979): sorted p times 4, 3, 2, 1, then the running maximum.
    corrected = holm([0.01, 0.04, 0.03, 0.005])
    np.testing.assert_allclose(corrected, [0.03, 0.06, 0.06, 0.02])
    assert (holm([0.5, 0.9, 0.8]) <= 1.0).all()
    assert holm([]).size == 0


def test_the_effect_is_the_excess_of_favourable_ranks() -> None:
    assert rank_biserial(np.array([1.0, 2.0, 3.0])) == 1.0
    assert rank_biserial(np.array([-1.0, -2.0, 0.0])) == -1.0
    # Ranks 1, 2, 3: (1 + 3 - 2) / 6.
    assert rank_biserial(np.array([0.1, -0.2, 0.3])) == pytest.approx(1.0 / 3.0)
    assert rank_biserial(np.zeros(4)) == 0.0
    d = RNG.normal(0.2, 1.0, 30)
    smaller = stats.wilcoxon(d).statistic  # min(T+, T-)
    assert abs(rank_biserial(d)) == pytest.approx(1.0 - 2.0 * smaller / (30 * 31 / 2))


def test_the_comparison_is_scipys_on_the_pairs_that_exist() -> None:
    base = RNG.uniform(0.1, 0.4, 40)
    ours = base - RNG.uniform(-0.02, 0.08, 40)
    steady_ours: list[float | None] = list(ours)
    steady_ours[3] = None  # not converged: no steady state, but a final error
    rows = rows_of("ours", list(ours), steady_ours) + rows_of("base", list(base), list(base))
    steady, final, settling = compare(rows, "base")
    assert (steady.pairs, final.pairs, settling.pairs) == (39, 40, 39)
    kept = np.arange(40) != 3
    assert final.p == stats.wilcoxon(ours, base).pvalue
    assert steady.p == stats.wilcoxon(ours[kept], base[kept]).pvalue
    assert final.difference < 0.0  # lower error is better
    assert final.interval[0] < final.difference < final.interval[1] < 0.0
    assert final.effect < -0.5
    assert final.mean_improvement == pytest.approx(100 * (1 - ours.mean() / base.mean()))
    assert final.maximum_improvement == pytest.approx(100 * (1 - ours.max() / base.max()))
    expected = 100 * (1 - np.std(ours, ddof=1) / np.std(base, ddof=1))
    assert final.deviation_improvement == pytest.approx(expected)
    assert settling.p == 1.0  # nothing differs
    assert [c.p_holm for c in (steady, final, settling)] == list(
        holm([steady.p, final.p, settling.p])
    )


def test_worst_ranks_by_hand() -> None:
    none = np.nan
    pairs = np.array(
        [
            [1.0, 2.0],  # -1: rank 1
            [5.0, 3.0],  # +2: rank 2
            [9.0, none],  # won three times: ranks 3, 4, 5, shared: 4 each, whatever the 9
            [0.1, none],
            [0.2, none],
            [none, none],  # a tie, dropped
            [0.3, 0.3],  # no difference, dropped
        ]
    )
    test = worst_rank(pairs)
    assert (test.attitudes, test.won, test.lost, test.neither) == (7, 3, 0, 1)
    assert test.effect == pytest.approx((2 - (1 + 4 + 4 + 4)) / 15)
    # T+ = 2. Of the 32 choices of signs of ranks 1, 2, 4, 4, 4 three have T+ <= 2: {}, {1}, {2}.
    assert test.p == pytest.approx(2 * 3 / 32)
    mirrored = worst_rank(pairs[:, ::-1])
    assert (mirrored.won, mirrored.lost) == (0, 3)
    assert (mirrored.effect, mirrored.p) == (-test.effect, test.p)


def test_a_lost_run_outranks_the_largest_difference() -> None:
    # Ranks 1 for -30, and 2 for the lost one: T+ = 2, T- = 1.
    test = worst_rank(np.array([[10.0, 40.0], [np.nan, 1.0]]))
    assert test.effect == pytest.approx((2 - 1) / 3)


def test_where_all_have_the_metric_worst_ranks_are_the_plain_test() -> None:
    base = RNG.uniform(0.1, 0.4, 30)
    ours = base - RNG.uniform(-0.02, 0.08, 30)
    test = worst_rank(np.column_stack([ours, base]))
    assert test.p == stats.wilcoxon(ours, base).pvalue
    assert test.effect == rank_biserial(ours - base)
    assert worst_rank(np.full((4, 2), np.nan)).p == 1.0
    assert worst_rank(np.zeros((0, 2))).attitudes == 0


def test_a_baseline_that_rarely_converges_is_beaten_by_worst_ranks_alone() -> None:
    """As --nominal.mismatch 2: five of the baseline's hundred runs converge."""
    steady = [0.3 if i < 5 else None for i in range(100)]
    rows = rows_of("base", [9.0] * 100, steady) + rows_of("ours", [0.01] * 100, [0.02] * 100)
    ss, final, settling = compare(rows, "base")
    assert (ss.pairs, ss.worst_rank.attitudes, ss.worst_rank.won) == (5, 100, 95)
    assert ss.p > 0.01
    assert ss.worst_rank.p < 1e-15
    assert ss.worst_rank.effect == -1.0
    assert final.worst_rank.p == final.p
    assert settling.worst_rank.effect < -0.99  # equal in the five, zero differences
    tests = [c.worst_rank for c in (ss, final, settling)]
    assert [t.p_holm for t in tests] == list(holm([t.p for t in tests]))
    text = comparison_md([ss, final, settling])
    assert "| ours | SS RMSE (deg) | 100 | 5 | 95 | 0 | 0 | " in text
    assert "by worst ranks, over all attitudes" in text


def test_pairs_are_matched_by_attitude_not_by_order() -> None:
    base = rows_of("base", [0.1, 0.2, 0.3, 0.9], [0.1] * 4)
    ours = rows_of("ours", [0.1, 0.2, 0.3, 0.9], [0.1] * 4)
    final = compare([*base, *ours[1:], *ours[:1]], "base")[1]
    assert (final.pairs, final.difference, final.p, final.effect) == (4, 0.0, 1.0, 0.0)


def test_an_unflown_baseline_is_refused() -> None:
    with pytest.raises(SettingsError, match=r"the baseline nmpc has no runs .*; flown: ours"):
        compare(rows_of("ours", [0.1], [0.1]), "nmpc")


def test_no_difference_at_all_is_no_evidence() -> None:
    assert wilcoxon_p(np.zeros(5)) == 1.0
    assert wilcoxon_p(np.zeros(0)) == 1.0


@pytest.mark.parametrize("controller", PAPER_IMPROVEMENT)
def test_the_papers_percentages_follow_from_its_table(controller: str) -> None:
    """To what rounding its table to four decimals leaves open."""
    base, ours = PAPER_TABLE["nmpc"], PAPER_TABLE[controller]
    for name, stated in vars(PAPER_IMPROVEMENT[controller]).items():
        theirs = getattr(base, name)
        slack = 100 * 1e-4 / theirs  # percent: half a unit in the last place of either figure
        assert improvement(getattr(ours, name), theirs) == pytest.approx(stated, abs=slack)


def test_tables_hold_every_figure() -> None:
    rows = rows_of("nmpc", [0.1, 0.2, 9.0], [0.1, 0.3, None])
    rows += rows_of("ours", [0.05, 0.1, 0.2], [0.05, 0.2, 0.1])
    text = table_md(aggregate(rows))
    assert "| converged | 2 / 3 | 3 / 3 |" in text
    assert "| SS RMSE (deg), mean ± std | 0.2000 ± 0.1414 | 0.1167 ± 0.0764 |" in text
    assert "| Final error (deg), max | 9.0000 | 0.2000 |" in text
    assert "| Torque effort (Nms), max | none | none |" in text
    lines = table_csv(aggregate(rows)).splitlines()
    assert lines[0].startswith("controller,runs,converged,steady_state_rmse_deg_count,")
    assert lines[1].startswith("nmpc,3,2,2,0.2,")
    compared = comparison_md(compare(rows, "nmpc"))
    assert "| ours | SS RMSE (deg) | 2 | +37.5 % | +33.3 % |" in compared
    assert "| nmpc-pinn | Final error | +16.93 % | +67.30 % | +35.77 % |" in compared
    assert "0.1476 ± 0.0672 | 0.1385 ± 0.0437 | 0.1419 ± 0.0495" in paper_md()


def test_a_controller_alone_is_compared_with_nothing() -> None:
    assert compare(rows_of("nmpc", [0.1], [0.1]), "nmpc") == []
    assert comparison_md([]) == "One controller alone: nothing to compare.\n"
