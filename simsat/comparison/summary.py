"""Everything that a campaign's rows say: tables, comparison, pictures and the report."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from simsat.comparison.pictures import draw_campaign
from simsat.comparison.report import write_report
from simsat.comparison.statistics import Row, aggregate, compare
from simsat.comparison.tables import comparison_md, paper_md, table_csv, table_md
from simsat.results.files import write_text

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
    write_text(folder / "table.md", beside)
    write_text(folder / "table.csv", table_csv(aggregates))
    write_text(folder / "comparison.md", comparison)
    pictures = folder / "pictures"
    pictures.mkdir(exist_ok=True)
    drawn = draw_campaign(rows, trajectories, pictures)
    sections = {"Results": beside, "Comparison": comparison}
    write_report(folder / "report.html", title, sections, drawn, rows, settings)
    return table
