"""The statistics against SciPy, hand calculation, and the paper's own percentages."""

from collections.abc import Sequence

import numpy as np
import pytest
from scipy import stats

from simsat.comparison.paper import PAPER_IMPROVEMENT, PAPER_TABLE
from simsat.comparison.signed_rank import rank_biserial
from simsat.comparison.statistics import (
    FINAL_ERROR,
    SETTLING,
    STEADY_STATE,
    Row,
    aggregate,
    compare,
    holm,
    improvement,
    summarize,
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


def test_equal_values_scatter_by_nothing_not_by_round_off() -> None:
    values = [0.1, 0.1, 0.1]
    assert np.std(values, ddof=1) > 0.0
    equal = summarize(values)
    assert (equal.deviation, equal.maximum) == (0.0, 0.1)
    assert np.isnan(improvement(0.3, equal.deviation))
    assert summarize([0.0, 0.0]).deviation == 0.0
    assert summarize([1.0, 1.0 + 1e-6]).deviation == pytest.approx(1e-6 / 2**0.5, rel=1e-6)


def test_holm_agrees_with_the_definition() -> None:
    # Holm (1979): sorted p times 4, 3, 2, 1, then the running maximum.
    corrected = holm([0.01, 0.04, 0.03, 0.005])
    np.testing.assert_allclose(corrected, [0.03, 0.06, 0.06, 0.02])
    assert (holm([0.5, 0.9, 0.8]) <= 1.0).all()
    assert holm([]).size == 0
    # The tied ones are both corrected as the smaller: 3 * 0.02.
    np.testing.assert_allclose(holm([0.02, 0.02, 0.9]), [0.06, 0.06, 0.9])
    np.testing.assert_allclose(holm([0.02 * (1 + 2e-16), 0.02, 0.9]), [0.06, 0.06, 0.9])
    # What rests on no pair at all is no test and costs the others nothing.
    np.testing.assert_allclose(holm([0.01, np.nan, 0.04]), [0.02, np.nan, 0.04])
    assert np.isnan(holm([np.nan])).all()


def test_the_comparison_is_scipys_on_the_pairs_that_exist() -> None:
    base = RNG.uniform(0.1, 0.4, 40)
    ours = base - RNG.uniform(-0.02, 0.08, 40)
    steady_ours: list[float | None] = list(ours)
    steady_ours[3] = None  # not converged: no steady state, but a final error
    rows = rows_of("ours", list(ours), steady_ours) + rows_of("base", list(base), list(base))
    steady, final, settling = compare(rows, "base")
    assert (steady.pairs, final.pairs, settling.pairs) == (39, 40, 39)
    kept = np.arange(40) != 3
    assert final.p == pytest.approx(stats.wilcoxon(ours, base).pvalue)
    assert steady.p == pytest.approx(stats.wilcoxon(ours[kept], base[kept]).pvalue)
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
            [1.0, 2.0],  # -1: rank 3, after the two zeros
            [5.0, 3.0],  # +2: rank 4
            [9.0, none],  # won three times: ranks 5, 6, 7, shared: 6 each, whatever the 9
            [0.1, none],
            [0.2, none],
            [none, none],  # a zero
            [0.3, 0.3],  # another
        ]
    )
    test = worst_rank(pairs)
    assert (test.attitudes, test.won, test.lost, test.neither) == (7, 3, 0, 1)
    assert test.effect == pytest.approx((4 - (3 + 6 + 6 + 6)) / 28)
    # T+ = 4. Of the 32 choices of signs of ranks 3, 4, 6, 6, 6 three have T+ <= 4: {}, {3}, {4}.
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
    assert test.p == pytest.approx(stats.wilcoxon(ours, base).pvalue)
    assert test.effect == rank_biserial(ours - base)
    assert worst_rank(np.full((4, 2), np.nan)).p == 1.0
    nothing = worst_rank(np.zeros((0, 2)))
    assert nothing.attitudes == 0
    assert np.isnan([nothing.p, nothing.effect]).all()


def test_worst_ranks_of_settling_times_tie_in_spite_of_round_off() -> None:
    """Differences of -1 and +1 samples tie; two runs that only the baseline lacks outrank them."""
    ours, base = 0.05 * np.array([246, 1001, 61]), 0.05 * np.array([247, 1000, 62])
    pairs = np.vstack([np.column_stack([ours, base]), [[20.0, np.nan]] * 2])
    assert np.unique(np.abs(ours - base)).size == 3
    # Ranks 2, 2, 2, 4.5, 4.5, of which one 2 is positive.
    assert worst_rank(pairs).effect == pytest.approx((2 - 13) / 15)


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


def settled(controller: str, samples: np.ndarray) -> list[Row]:
    rows = rows_of(controller, [1.0] * samples.size, [0.1] * samples.size)
    return [{**row, "settling_time_s": 0.05 * k} for row, k in zip(rows, samples, strict=True)]


def test_settling_times_are_compared_by_their_samples() -> None:
    """The whole comparison: fractions of 0.05 s that tie, though 12.35 - 12.3 is not 0.05 - 0."""
    samples = np.array([246, 10, 400, 77, 1000, 61, 300, 5])
    step = [1, 1, 1, 1, 1, -1, -1, 0]
    ours, base = settled("ours", samples + step), settled("base", samples)
    settling = compare([*ours, *base], "base")[2]
    assert settling.metric is SETTLING
    # A zero of rank 1 and seven sizes that share rank 5: five for, two against.
    assert settling.effect == pytest.approx(5 * (5 - 2) / 36)
    assert settling.p == pytest.approx(2 * (1 + 7 + 21) / 2**7)  # at most two of seven against
    assert settling.worst_rank.p == settling.p


def test_what_there_is_nothing_to_compare_in_is_none() -> None:
    """A metric that no pair has is no test: nan, "none" in the table, and not counted by Holm."""
    rows = rows_of("base", [0.2, 0.4, 0.3], [None] * 3) + rows_of(
        "ours", [0.1, 0.2, 0.1], [0.1] * 3
    )
    steady, final, settling = compare(rows, "base")
    for c in (steady, settling):
        assert c.pairs == 0
        figures = (c.p, c.p_holm, c.effect, c.difference, c.mean_improvement)
        assert np.isnan([*figures, c.maximum_improvement, c.deviation_improvement]).all()
        assert c.interval == (-np.inf, np.inf)
        assert c.worst_rank.won == 3
    assert final.p == final.p_holm == 0.25
    assert final.worst_rank.p_holm == 0.75
    text = comparison_md([steady, final, settling])
    none = " none |"
    assert f"| ours | SS RMSE (deg) | 0 |{3 * none} none [none, none] |{3 * none}\n" in text
    assert "nan" not in text


def test_controllers_that_share_no_attitude_have_nothing_to_compare() -> None:
    ours = [{**row, "attitude": 7} for row in rows_of("ours", [0.1], [0.1])]
    text = comparison_md(compare([*rows_of("base", [0.2], [0.2]), *ours], "base"))
    assert "| ours | Final error (deg) | 0 | 0 | 0 | 0 | 0 | none | none | none |" in text
    assert "nan" not in text


def test_a_single_pair_and_equal_pairs_are_compared() -> None:
    single = compare(rows_of("base", [0.2], [0.2]) + rows_of("ours", [0.1], [0.1]), "base")[1]
    assert (single.pairs, single.p, single.effect) == (1, 1.0, -1.0)
    assert single.difference == pytest.approx(-0.1)
    assert single.interval == (-np.inf, np.inf)
    assert np.isnan(single.deviation_improvement)
    same = rows_of("base", [0.1] * 7, [0.1] * 7) + rows_of("ours", [0.1] * 7, [0.1] * 7)
    equal = compare(same, "base")[1]
    assert (equal.p, equal.effect, equal.difference, equal.interval) == (1.0, 0.0, 0.0, (0.0, 0.0))
    assert np.isnan(equal.deviation_improvement)


def test_an_unflown_baseline_is_refused() -> None:
    with pytest.raises(SettingsError, match=r"the baseline nmpc has no runs .*; flown: ours"):
        compare(rows_of("ours", [0.1], [0.1]), "nmpc")


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
