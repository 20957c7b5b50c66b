"""What a campaign leaves: tables, statistics, pictures and a report, all made from its rows."""

from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from simsat.rows import as_table, flat_rows, read_trajectories, timing_rows
from simsat.study_results import study_rows, write_study


def write_campaign_results(folder: Path, records: list[dict[str, Any]]) -> str:
    """Write everything that follows from the rows; returns the table to print."""
    rows = flat_rows(records)
    pq.write_table(as_table(rows), folder / "results.parquet")
    pq.write_table(as_table(timing_rows(records)), folder / "timing.parquet")
    pq.write_table(read_trajectories(folder, records), folder / "trajectories.parquet")
    return write_study(folder, study_rows(records, rows)) if records[0]["point"] else ""
