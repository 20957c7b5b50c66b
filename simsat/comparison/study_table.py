"""What a study leaves: a table with a row per point and controller, and a picture of it."""

import csv
import io
import math
from pathlib import Path

from simsat.comparison.markdown import markdown_table
from simsat.comparison.statistics import FINAL_ERROR, SETTLING, STEADY_STATE
from simsat.comparison.study_rows import StudyRow
from simsat.results.files import write_text
from simsat.results.pictures.lettering import for_spreadsheets

SUMMARISED = (STEADY_STATE, FINAL_ERROR, SETTLING)


def write_study(folder: Path, table: list[StudyRow]) -> str:
    """Write study.csv, study.md and study.png; returns the Markdown."""
    from simsat.comparison.study_picture import (
        draw_study,  # matplotlib takes half a second to import
    )

    head, body = study_table(table)
    cells = io.StringIO(newline="")
    csv.writer(cells).writerows([[for_spreadsheets(cell) for cell in row] for row in (head, *body)])
    write_text(folder / "study.csv", cells.getvalue())
    text = markdown_table(head, body)
    write_text(folder / "study.md", text)
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
