"""What a campaign leaves: tables, statistics, pictures and a report, all made from its rows."""

import json
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from simsat.campaign.rows import read_trajectories
from simsat.campaign.table import as_table, flat_rows, timing_rows
from simsat.comparison.study_rows import study_rows
from simsat.comparison.study_table import write_study
from simsat.results.files import write_table

POINTS = "points"


def write_campaign_results(folder: Path, records: list[dict[str, Any]]) -> str:
    """Write everything that follows from the rows; returns the table to print.

    A campaign has its table, comparison, pictures and report in the folder itself; a study has a
    table and a picture of all points there, and those of each point in points/.
    """
    from simsat.comparison.summary import write_summary  # matplotlib: half a second to import

    rows = flat_rows(records)
    trajectories = read_trajectories(folder, records)
    write_table(folder / "results.parquet", as_table(rows))
    write_table(folder / "timing.parquet", as_table(timing_rows(records)))
    write_table(folder / "trajectories.parquet", trajectories)
    settings = json.loads((folder / "settings.json").read_text())
    if not records[0]["point"]:
        return write_summary(folder, rows, trajectories, settings)
    for number, name in enumerate(dict.fromkeys(row["study"] for row in rows)):
        inner = folder / POINTS / f"{number:02d}"
        inner.mkdir(parents=True, exist_ok=True)
        there = [row for row in rows if row["study"] == name]
        runs = pa.array([row["run"] for row in there])
        flown = trajectories.filter(pc.is_in(trajectories["run"], runs))
        write_summary(inner, there, flown, settings, title=name)
    return write_study(folder, study_rows(records, rows))
