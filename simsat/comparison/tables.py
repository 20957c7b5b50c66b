"""The campaign's tables as text: Markdown and CSV, the paper's figures beside ours."""

import csv
import io
import math
from collections.abc import Sequence

from simsat.comparison.markdown import literal, markdown_table
from simsat.comparison.paper import PAPER_IMPROVEMENT, PAPER_TABLE
from simsat.comparison.signed_rank import EXACT_PAIRS
from simsat.comparison.statistics import (
    EFFORT,
    FINAL_ERROR,
    METRICS,
    STEADY_STATE,
    Aggregate,
    Comparison,
    Metric,
    Summary,
)
from simsat.results.metrics import CONVERGED_BELOW_DEG, MINIMUM_STAY
from simsat.results.pictures.lettering import for_spreadsheets

DIGITS = {"deg": 4, "s": 1, "Nms": 2, "rpm": 0}


def table_md(aggregates: Sequence[Aggregate]) -> str:
    """The paper's rows and ours, a column per controller."""
    header = ["", *(a.controller for a in aggregates)]
    rows = [["converged", *(f"{a.converged} / {a.runs}" for a in aggregates)]]
    for metric in (*METRICS, *EFFORT):
        summaries = [a.summaries[metric.name] for a in aggregates]
        name = f"{metric.label} ({metric.unit})"
        rows.append([f"{name}, mean ± std", *(_mean(s, metric) for s in summaries)])
        rows.append([f"{name}, max", *(_number(s.maximum, metric) for s in summaries)])
    return (
        markdown_table(header, rows)
        + f"\nA run converged if it stayed below {CONVERGED_BELOW_DEG:g} deg for its last "
        f"{MINIMUM_STAY:g} own seconds at least. SS RMSE and settling time are over the runs that "
        "converged; the final error is over all runs that were flown.\n"
    )


def paper_md() -> str:
    """The paper's own table in the same form."""
    columns = PAPER_TABLE.values()
    rows = [
        _paper_row("SS RMSE (deg), mean ± std", "steady_state_mean", "steady_state_deviation"),
        ["SS RMSE (deg), max", *(f"{c.steady_state_maximum:.4f}" for c in columns)],
        _paper_row("Final error (deg), mean ± std", "final_mean", "final_deviation"),
        ["Final error (deg), max", *(f"{c.final_maximum:.4f}" for c in columns)],
    ]
    return markdown_table(["the paper", *PAPER_TABLE], rows)


def _paper_row(name: str, mean: str, deviation: str) -> list[str]:
    pairs = ((getattr(c, mean), getattr(c, deviation)) for c in PAPER_TABLE.values())
    return [name, *(f"{m:.4f} ± {d:.4f}" for m, d in pairs)]


def table_csv(aggregates: Sequence[Aggregate]) -> str:
    """The same, a row per controller, every figure a column of its own in full precision."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    names = [m.name for m in (*METRICS, *EFFORT)]
    figures = ("count", "mean", "deviation", "maximum")
    writer.writerow(
        ["controller", "runs", "converged", *(f"{n}_{f}" for n in names for f in figures)]
    )
    for a in aggregates:
        values = [getattr(a.summaries[n], f) for n in names for f in figures]
        writer.writerow([for_spreadsheets(a.controller), a.runs, a.converged, *values])
    return out.getvalue()


def comparison_md(comparisons: Sequence[Comparison]) -> str:
    """Paired improvements with their tests, and what the paper states."""
    if not comparisons:
        return "One controller alone: nothing to compare.\n"
    header = ["controller", "metric", "pairs", "mean", "max", "std", "median difference [95 %]"]
    header += ["p (Wilcoxon)", "p (Holm)", "effect"]
    baseline = comparisons[0].baseline
    return (
        f"Against {literal(baseline)}, paired by attitude.\n\n"
        + markdown_table(header, [_comparison_row(c) for c in comparisons])
        + "\nmean, max and std are improvements in percent of the baseline's over the pairs, "
        "positive is better. The median difference is Hodges and Lehmann's, controller minus "
        "baseline, negative is better. p is the two-sided signed-rank test's, exact with ties and "
        f"zeros up to {EXACT_PAIRS} pairs, Holm-corrected over the rows of this table; the "
        "interval holds the differences that the test does not reject at 5 %. The effect is the "
        "rank-biserial correlation: -1 when the controller is lower in every pair, 1 when it is "
        "higher in every pair. Zero differences are ranked and count for neither side (Pratt "
        "1959). A pair is an attitude on which both have the metric: SS RMSE and settling time "
        "rest on those where both converged.\n\n"
        + _worst_rank_md(comparisons)
        + "\n"
        + _paper_comparison()
    )


def _worst_rank_md(comparisons: Sequence[Comparison]) -> str:
    """The test over all attitudes, with what it rests on."""
    baseline = comparisons[0].baseline
    header = ["controller", "metric", "attitudes", "both", f"only {baseline} lacks it"]
    header += ["only the controller lacks it", "neither has it", "p (worst rank)"]
    header += ["p (worst rank, Holm)", "effect"]
    return (
        f"Against {literal(baseline)} by worst ranks, over all attitudes, converged or not.\n\n"
        + markdown_table(header, [_worst_rank_row(c) for c in comparisons])
        + "\nA run without the metric did not converge (or, for the final error, did not fly) and "
        "counts as worse than any that has it. Attitudes on which only one has it share the top "
        "rank; those on which neither has it count for neither side, as zero differences do. p is "
        "the two-sided signed-rank test of these ranks, Holm-corrected over the rows of this "
        "table; the effect is their rank-biserial correlation (Lachin 1999).\n"
    )


def _worst_rank_row(c: Comparison) -> list[str]:
    w = c.worst_rank
    counts = (w.attitudes, c.pairs, w.won, w.lost, w.neither)
    return [
        c.controller,
        f"{c.metric.label} ({c.metric.unit})",
        *map(str, counts),
        _probability(w.p),
        _probability(w.p_holm),
        _plain(w.effect, 2),
    ]


def _comparison_row(c: Comparison) -> list[str]:
    low, high = (_number(v, c.metric) for v in c.interval)
    return [
        c.controller,
        f"{c.metric.label} ({c.metric.unit})",
        str(c.pairs),
        *(_percent(v) for v in (c.mean_improvement, c.maximum_improvement)),
        _percent(c.deviation_improvement),
        f"{_number(c.difference, c.metric)} [{low}, {high}]",
        _probability(c.p),
        _probability(c.p_holm),
        _plain(c.effect, 2),
    ]


def _paper_comparison() -> str:
    rows = []
    for controller, column in PAPER_IMPROVEMENT.items():
        for metric, stem in ((STEADY_STATE, "steady_state"), (FINAL_ERROR, "final")):
            values = (getattr(column, f"{stem}_{f}") for f in ("mean", "maximum", "deviation"))
            rows.append([controller, metric.label, *(f"{v:+.2f} %" for v in values)])
    return "The paper states, without p-values:\n\n" + markdown_table(
        ["controller", "metric", "mean", "max", "std"], rows
    )


def _mean(summary: Summary, metric: Metric) -> str:
    return f"{_number(summary.mean, metric)} ± {_number(summary.deviation, metric)}"


def _number(value: float, metric: Metric) -> str:
    return _plain(value, DIGITS[metric.unit])


def _plain(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "none"


def _percent(value: float) -> str:
    return f"{value:+.1f} %" if math.isfinite(value) else "none"


def _probability(value: float) -> str:
    return f"{value:.2g}" if math.isfinite(value) else "none"
