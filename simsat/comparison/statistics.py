"""The campaign's statistics: aggregates of a controller, paired comparisons to a baseline.

A row is one run: `controller`, `attitude` (its index) and the metrics, None where a run has none.
The test is paired by attitude, as the paper's is, and says on how many pairs it rests: a run that
never converged has no steady state, but always a final error. So that such runs are not forgotten,
a second test, by worst ranks, keeps all attitudes: a run without the metric is worse than any that
has it.

Sources: Wilcoxon, Biometrics Bulletin 1 (1945) 80; Holm, Scand. J. Statist. 6 (1979) 65; Hodges and
Lehmann, Ann. Math. Statist. 34 (1963) 598; Kerby, Comprehensive Psychology 3 (2014) 11 (rank-
biserial correlation of matched pairs); Lachin, Controlled Clinical Trials 20 (1999) 408 (worst
ranks).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import stats

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Metric:
    """A column of the results that is summarised; smaller is better."""

    name: str
    """Column."""
    label: str
    unit: str


STEADY_STATE = Metric("steady_state_rmse_deg", "SS RMSE", "deg")
FINAL_ERROR = Metric("final_error_deg", "Final error", "deg")
SETTLING = Metric("settling_time_s", "Settling time", "s")
METRICS = (STEADY_STATE, FINAL_ERROR, SETTLING)
"""What controllers are compared by."""
EFFORT = (
    Metric("torque_effort_Nms", "Torque effort", "Nms"),
    Metric("peak_wheel_speed_rpm", "Peak wheel speed", "rpm"),
)
"""What it took them; summarised only."""


@dataclass(frozen=True)
class Summary:
    """Runs that have the metric, their mean, sample standard deviation and maximum."""

    count: int
    mean: float
    deviation: float
    maximum: float


@dataclass(frozen=True)
class Aggregate:
    """All runs of one controller."""

    controller: str
    runs: int
    converged: int
    summaries: dict[str, Summary]
    """By column name."""


@dataclass(frozen=True)
class WorstRank:
    """Signed-rank test over all attitudes that both flew: a run without the metric did not converge
    and counts as worse than any that has it."""

    attitudes: int
    lost: int
    """Attitudes on which only the controller lacks the metric."""
    won: int
    """Attitudes on which only the baseline lacks it."""
    neither: int
    """Attitudes on which both lack it: ties, which the test drops."""
    p: float
    """Two-sided Wilcoxon signed-rank; the lost and won attitudes share the top rank."""
    p_holm: float
    """The same, Holm-corrected over every worst-rank test of the table."""
    effect: float
    """Rank-biserial correlation of the same ranks."""


@dataclass(frozen=True)
class Comparison:
    """One metric of a controller against the baseline; differences are controller - baseline."""

    controller: str
    baseline: str
    metric: Metric
    pairs: int
    """Attitudes on which both have the metric."""
    mean_improvement: float
    """Percent of the baseline's mean, over the pairs; positive is better (likewise below)."""
    maximum_improvement: float
    deviation_improvement: float
    p: float
    """Two-sided Wilcoxon signed-rank."""
    p_holm: float
    """The same, Holm-corrected over every comparison of the table."""
    difference: float
    """Hodges-Lehmann median difference, in the metric's unit; negative is better."""
    interval: tuple[float, float]
    """Distribution-free interval of the difference, at least 95 %."""
    effect: float
    """Rank-biserial correlation, -1 (lower in every pair) to 1 (higher in every pair)."""
    worst_rank: WorstRank
    """The test that keeps the attitudes on which either lacks the metric."""


def aggregate(rows: Iterable[Row]) -> list[Aggregate]:
    """One Aggregate per controller, in the order in which they first appear."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(str(row["controller"]), []).append(row)
    return [_aggregate(controller, group) for controller, group in groups.items()]


def _aggregate(controller: str, rows: Sequence[Row]) -> Aggregate:
    return Aggregate(
        controller,
        len(rows),
        sum(bool(row.get("converged")) for row in rows),
        {m.name: summarize([_value(row, m) for row in rows]) for m in (*METRICS, *EFFORT)},
    )


def summarize(values: Sequence[float]) -> Summary:
    """Summary of the finite values; a mean, deviation or maximum that doesn't exist is nan."""
    known = np.array([v for v in values if np.isfinite(v)])
    if known.size == 0:
        return Summary(0, np.nan, np.nan, np.nan)
    deviation = float(known.std(ddof=1)) if known.size > 1 else np.nan
    return Summary(known.size, float(known.mean()), deviation, float(known.max()))


def compare(rows: Iterable[Row], baseline: str) -> list[Comparison]:
    """Every other controller against the baseline, metric by metric, paired by attitude.

    Raises SettingsError when the baseline isn't among the rows.
    """
    by_controller: dict[str, dict[Any, Row]] = {}
    for row in rows:
        by_controller.setdefault(str(row["controller"]), {})[row["attitude"]] = row
    if baseline not in by_controller:
        flown = ", ".join(by_controller) or "none"
        raise SettingsError(f"the baseline {baseline} has no runs to compare with; flown: {flown}.")
    reference = by_controller.pop(baseline)
    raw = [
        _compare(controller, baseline, metric, runs, reference)
        for controller, runs in by_controller.items()
        for metric in METRICS
    ]
    corrected = holm([c.p for c in raw])
    ranked = holm([c.worst_rank.p for c in raw])
    return [
        replace(c, p_holm=float(p), worst_rank=replace(c.worst_rank, p_holm=float(r)))
        for c, p, r in zip(raw, corrected, ranked, strict=True)
    ]


def _compare(
    controller: str,
    baseline: str,
    metric: Metric,
    runs: Mapping[Any, Row],
    reference: Mapping[Any, Row],
) -> Comparison:
    pairs = np.array(
        [(_value(runs[k], metric), _value(reference[k], metric)) for k in runs if k in reference]
    ).reshape(-1, 2)
    both = pairs[np.isfinite(pairs).all(axis=1)]
    ours, theirs = summarize(list(both[:, 0])), summarize(list(both[:, 1]))
    d = both[:, 0] - both[:, 1]
    p = wilcoxon_p(d)
    lo, hi = hodges_lehmann_interval(d)
    return Comparison(
        controller=controller,
        baseline=baseline,
        metric=metric,
        pairs=len(d),
        mean_improvement=improvement(ours.mean, theirs.mean),
        maximum_improvement=improvement(ours.maximum, theirs.maximum),
        deviation_improvement=improvement(ours.deviation, theirs.deviation),
        p=p,
        p_holm=p,
        difference=hodges_lehmann(d),
        interval=(lo, hi),
        effect=rank_biserial(d),
        worst_rank=worst_rank(pairs),
    )


def worst_rank(pairs: Array) -> WorstRank:
    """The test of pairs (controller, baseline), shape (k, 2); what is not finite is missing."""
    lacking = ~np.isfinite(pairs)
    lost, won = lacking[:, 0] & ~lacking[:, 1], lacking[:, 1] & ~lacking[:, 0]
    neither = lacking.all(axis=1)
    kept = np.where(lacking, 0.0, pairs)
    d = np.where(neither | lost | won, 0.0, kept[:, 0] - kept[:, 1])
    top = 1.0 + float(np.abs(d).max(initial=0.0))  # only ranks count: any number above the others
    d = d + top * lost - top * won
    p = wilcoxon_p(d)
    n_lost, n_won, n_neither = (int(part.sum()) for part in (lost, won, neither))
    return WorstRank(len(pairs), n_lost, n_won, n_neither, p, p, rank_biserial(d))


def improvement(ours: float, theirs: float) -> float:
    """100 (theirs - ours) / theirs, percent; nan where there is nothing to divide by."""
    return 100.0 * (theirs - ours) / theirs if theirs else np.nan


def wilcoxon_p(differences: Array) -> float:
    """Two-sided p of the signed-rank test, zeros dropped; 1 when nothing differs."""
    d = differences[differences != 0.0]
    return float(stats.wilcoxon(d).pvalue) if d.size else 1.0


def holm(p: Sequence[float]) -> Array:
    """Holm's step-down correction: the i-th smallest of n times n - i, kept monotone, at most 1."""
    p_values = np.asarray(p, float)
    order = np.argsort(p_values, kind="stable")
    scaled = p_values[order] * np.arange(p_values.size, 0, -1)
    corrected = np.empty_like(p_values)
    corrected[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return corrected


def walsh_averages(differences: Array) -> Array:
    """(d_i + d_j)/2 for i <= j, sorted."""
    i, j = np.triu_indices(differences.size)
    return np.sort(0.5 * (differences[i] + differences[j]))


def hodges_lehmann(differences: Array) -> float:
    """Median of the Walsh averages: the shift that the signed-rank test would call none."""
    return float(np.median(walsh_averages(differences))) if differences.size else np.nan


def hodges_lehmann_interval(differences: Array, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of the shifts that the two-sided signed-rank test would not reject.

    Its ends are the k-th smallest and k-th largest Walsh averages, k the largest number with
    P(T < k) <= (1 - confidence)/2 under the exact null distribution of T; unbounded (inf) when
    there are too few pairs for that confidence.
    """
    averages = walsh_averages(differences)
    tail = 0.5 * (1.0 - confidence)
    k = int(np.searchsorted(np.cumsum(signed_rank_distribution(differences.size)), tail, "right"))
    if k == 0:
        return -np.inf, np.inf
    return float(averages[k - 1]), float(averages[-k])


def signed_rank_distribution(n: int) -> Array:
    """P(T = t), t = 0..n(n+1)/2: the sum of ranks 1..n, each counted with probability 1/2."""
    p = np.zeros(n * (n + 1) // 2 + 1)
    p[0] = 1.0
    for rank in range(1, n + 1):
        p[rank:] = 0.5 * (p[rank:] + p[:-rank])
        p[:rank] *= 0.5
    return p


def rank_biserial(differences: Array) -> float:
    """(T+ - T-)/(T+ + T-) of the signed ranks, zeros dropped; 0 when nothing differs."""
    d = differences[differences != 0.0]
    if d.size == 0:
        return 0.0
    ranks = stats.rankdata(np.abs(d))
    return float(np.sum(np.sign(d) * ranks) / np.sum(ranks))


def _value(row: Row, metric: Metric) -> float:
    value = row.get(metric.name)
    return np.nan if value is None else float(value)
