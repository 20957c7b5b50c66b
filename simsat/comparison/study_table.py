"""What a study leaves: a table with a row per point and controller, and a picture of it."""

import csv
import math
from pathlib import Path

from simsat.comparison.statistics import FINAL_ERROR, SETTLING, STEADY_STATE
from simsat.comparison.study_rows import StudyRow

SUMMARISED = (STEADY_STATE, FINAL_ERROR, SETTLING)


def write_study(folder: Path, table: list[StudyRow]) -> str:
    """Write study.csv, study.md and study.png; returns the Markdown."""
    from simsat.comparison.study_picture import (
        draw_study,  # matplotlib takes half a second to import
    )

    head, body = study_table(table)
    with (folder / "study.csv").open("w", newline="") as file:
        csv.writer(file).writerows([head, *body])
    text = _markdown(head, body)
    (folder / "study.md").write_text(text)
    draw_study(table, folder / "study.png")
    return text


def study_table(table: list[StudyRow]) -> tuple[list[str], list[list[str]]]:
    """Column names and cells: varied settings, controller, converged of runs, mean and maximum of
    each metric."""
    names = list(table[0].point)
    figures = [f"{m.label} {kind}, {m.unit}" for m in SUMMARISED for kind in ("mean", "max")]
    head = [*names, "controller", "runs", "converged", *figures]
    return head, [_cells(row) for row in table]


def _cells(row: StudyRow) -> list[str]:
    result = row.result
    summaries = [result.summaries[metric.name] for metric in SUMMARISED]
    figures = [value for s in summaries for value in (s.mean, s.maximum)]
    cells = ["" if math.isnan(value) else f"{value:.4g}" for value in figures]
    counts = [str(result.runs), str(result.converged)]
    return [*row.point.values(), result.controller, *counts, *cells]


def _markdown(head: list[str], body: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *body]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
