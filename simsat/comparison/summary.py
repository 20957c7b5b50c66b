"""Everything that a campaign's rows say: tables, comparison, pictures and the report."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from simsat.comparison.pictures import draw_campaign
from simsat.comparison.report import write_report
from simsat.comparison.statistics import Row, aggregate, compare
from simsat.comparison.tables import comparison_md, paper_md, table_csv, table_md

BASELINE = "nmpc"


def write_summary(
    folder: Path,
    rows: Sequence[Row],
    trajectories: pa.Table,
    settings: Mapping[str, Any],
    title: str = "Campaign",
) -> str:
    """Write table.md, table.csv, comparison.md, pictures/ and report.html; returns the table.

    Every controller is compared with `nmpc`, or with the first one if that wasn't flown.
    """
    aggregates = aggregate(rows)
    flown = [a.controller for a in aggregates]
    table = table_md(aggregates)
    comparison = comparison_md(compare(rows, BASELINE if BASELINE in flown else flown[0]))
    beside = table + "\n" + paper_md()
    (folder / "table.md").write_text(beside, encoding="utf-8")
    (folder / "table.csv").write_text(table_csv(aggregates), encoding="utf-8")
    (folder / "comparison.md").write_text(comparison, encoding="utf-8")
    pictures = folder / "pictures"
    pictures.mkdir(exist_ok=True)
    drawn = draw_campaign(rows, trajectories, pictures)
    sections = {"Results": beside, "Comparison": comparison}
    write_report(folder / "report.html", title, sections, drawn, rows, settings)
    return table
