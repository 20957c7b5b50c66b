"""report.html: a campaign on one page that needs nothing but a browser.

Tables, statistics, pictures and settings are inside the file; the table of runs sorts by a click on
a column's head. No network, no library. The page is `report.html.j2`, and what it is given is
escaped.
"""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from simsat.comparison.markdown import cells, plain
from simsat.comparison.statistics import Row
from simsat.results.files import json_text, write_text

COLUMNS = (
    ("run", "run"),
    ("controller", "controller"),
    ("attitude", "attitude"),
    ("angle_deg", "angle, deg"),
    ("axis_x", "axis x"),
    ("axis_y", "axis y"),
    ("axis_z", "axis z"),
    ("converged", "converged"),
    ("outcome", "outcome"),
    ("settling_time_s", "settling, s"),
    ("steady_state_rmse_deg", "SS RMSE, deg"),
    ("final_error_deg", "final error, deg"),
    ("torque_effort_Nms", "effort, Nms"),
    ("peak_wheel_speed_rpm", "peak speed, rpm"),
    ("solver_failures", "solver failures"),
    ("reason", "ended"),
)
CAPTIONS = {
    "trajectories": "Attitude quaternion of every run, body to inertial.",
    "distributions": "Final error and steady-state RMSE; a line joins runs from one attitude.",
    "sphere": "Initial rotation axes on the sphere, coloured by final error.",
    "settling": "Share of runs that have settled below 0.5 degrees for good.",
}


@dataclass(frozen=True)
class Block:
    """A table, a paragraph, or a table with what is said below it."""

    head: list[str]
    rows: list[list[str]]
    prose: str


@dataclass(frozen=True)
class Cell:
    """What a cell shows, and what it sorts by."""

    text: str
    key: str


@dataclass(frozen=True)
class Picture:
    """A PNG inside the page."""

    caption: str
    data: str
    """In base64."""


def write_report(
    path: Path,
    title: str,
    sections: Mapping[str, str],
    pictures: Sequence[Path],
    rows: Sequence[Row],
    settings: Mapping[str, Any],
) -> None:
    """Write the page: sections (heading -> Markdown of tables and paragraphs), pictures (PNG), a
    row per run, the settings folded away."""
    page = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    ).get_template("report.html.j2")
    content = page.render(
        title=title,
        sections=[(heading, blocks(text)) for heading, text in sections.items()],
        pictures=[_picture(picture) for picture in pictures],
        runs=_runs(rows),
        settings=json_text(settings),
    )
    write_text(path, content)


def blocks(text: str) -> list[Block]:
    """The paragraphs and pipe tables of Markdown as `markdown_table` writes it."""
    return [_block(block) for block in text.split("\n\n") if block.strip()]


def _block(block: str) -> Block:
    table = [cells(line) for line in block.splitlines() if line.startswith("|")]
    prose = " ".join(line for line in block.splitlines() if not line.startswith("|"))
    return Block(table[0] if table else [], table[2:], plain(prose.strip()))


def _picture(path: Path) -> Picture:
    data = base64.b64encode(path.read_bytes()).decode()
    return Picture(CAPTIONS.get(path.stem, path.stem), data)


def _runs(rows: Sequence[Row]) -> dict[str, Any]:
    """Head and rows of the table of runs: the columns that any run has."""
    shown = [(key, name) for key, name in COLUMNS if any(key in row for row in rows)]
    return {
        "head": [name for _, name in shown],
        "rows": [[_cell(row.get(key)) for key, _ in shown] for row in rows],
    }


def _cell(value: Any) -> Cell:
    """A cell that sorts by its exact value and shows four digits; what is missing sorts last."""
    if value is None:
        return Cell("none", "")
    if isinstance(value, bool):
        return Cell("yes" if value else "no", str(int(value)))
    return Cell(f"{value:.4g}" if isinstance(value, float) else str(value), str(value))
