"""The campaign's statistics: aggregates of a controller, paired comparisons to a baseline.

A row is one run: `controller`, `attitude` (its index) and the metrics, None where a run has none.
The test is paired by attitude, as the paper's is, and says on how many pairs it rests: a run that
never converged has no steady state, but always a final error. So that such runs are not forgotten,
a second test, by worst ranks, keeps all attitudes: a run without the metric is worse than any that
has it. What there is nothing to compute from is nan.

Sources: Holm, Scand. J. Statist. 6 (1979) 65; Lachin, Controlled Clinical Trials 20 (1999) 408
(worst ranks).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simsat.comparison.signed_rank import (
    RESOLUTION,
    differences,
    hodges_lehmann,
    hodges_lehmann_interval,
    rank_biserial,
    wilcoxon_p,
)
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
    """Attitudes on which both lack it: zeros of the test."""
    p: float
    """Two-sided signed-rank test; the lost and won attitudes share the top rank."""
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
    """Two-sided signed-rank test; nan without any pair (likewise what follows)."""
    p_holm: float
    """The same, Holm-corrected over every comparison of the table."""
    difference: float
    """Hodges-Lehmann median difference, in the metric's unit; negative is better."""
    interval: tuple[float, float]
    """The differences that the test does not reject at 5 %: an interval of at least 95 %."""
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
    """Summary of the finite values; a mean, deviation or maximum that doesn't exist is nan.

    A deviation that is only round-off of the mean is 0: nothing can be compared with it.
    """
    known = np.array([v for v in values if np.isfinite(v)])
    if known.size == 0:
        return Summary(0, np.nan, np.nan, np.nan)
    deviation = float(known.std(ddof=1)) if known.size > 1 else np.nan
    if deviation <= RESOLUTION * np.abs(known).max():
        deviation = 0.0
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
    d = differences(both)
    p = wilcoxon_p(d)
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
        interval=hodges_lehmann_interval(d),
        effect=rank_biserial(d),
        worst_rank=worst_rank(pairs),
    )


def worst_rank(pairs: Array) -> WorstRank:
    """The test of pairs (controller, baseline), shape (k, 2); what is not finite is missing."""
    lacking = ~np.isfinite(pairs)
    lost, won = lacking[:, 0] & ~lacking[:, 1], lacking[:, 1] & ~lacking[:, 0]
    neither, both = lacking.all(axis=1), ~lacking.any(axis=1)
    d = np.zeros(len(pairs))
    d[both] = differences(pairs[both])
    top = 1.0 + float(np.abs(d).max(initial=0.0))  # only ranks count: any number above the others
    d = d + top * lost - top * won
    p = wilcoxon_p(d)
    n_lost, n_won, n_neither = (int(part.sum()) for part in (lost, won, neither))
    return WorstRank(len(pairs), n_lost, n_won, n_neither, p, p, rank_biserial(d))


def improvement(ours: float, theirs: float) -> float:
    """100 (theirs - ours) / theirs, percent; nan where there is nothing to divide by."""
    return 100.0 * (theirs - ours) / theirs if theirs else np.nan


def holm(p: Sequence[float]) -> Array:
    """Holm's step-down correction: the i-th smallest of n times n - i, kept monotone, at most 1.

    A nan is no test: it stays and does not count among the n.
    """
    corrected = np.array(p, float)
    tests = np.flatnonzero(~np.isnan(corrected))
    order = tests[np.argsort(corrected[tests], kind="stable")]
    scaled = corrected[order] * np.arange(order.size, 0, -1)
    corrected[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return corrected


def _value(row: Row, metric: Metric) -> float:
    value = row.get(metric.name)
    return np.nan if value is None else float(value)
