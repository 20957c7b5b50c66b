"""report.html: a campaign on one page that needs nothing but a browser.

Tables, statistics, pictures and settings are inside the file; the table of runs sorts by a click on
a column's head. No network, no library.
"""

import base64
import html
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

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
    body = [f"<h1>{html.escape(title)}</h1>"]
    for heading, text in sections.items():
        body += [f"<h2>{html.escape(heading)}</h2>", markdown_html(text)]
    body += ["<h2>Pictures</h2>", *(_picture(picture) for picture in pictures)]
    body += ["<h2>Runs</h2>", "<p>Click a column's head to sort.</p>", _runs(rows)]
    body += ["<h2>Settings</h2>", "<details><summary>all settings</summary><pre>"]
    body += [html.escape(json_text(settings)), "</pre></details>"]
    page = PAGE.replace("TITLE", html.escape(title)).replace("BODY", "\n".join(body))
    write_text(path, page)


def markdown_html(text: str) -> str:
    """HTML of paragraphs and pipe tables, the Markdown that `result_tables` writes."""
    blocks = (block for block in text.split("\n\n") if block.strip())
    return "\n".join(_block(block) for block in blocks)


def _block(block: str) -> str:
    table = [line for line in block.splitlines() if line.startswith("|")]
    prose = " ".join(line for line in block.splitlines() if not line.startswith("|"))
    paragraph = f"<p>{html.escape(prose)}</p>" if prose.strip() else ""
    if not table:
        return paragraph
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table]
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in cells[0])
    lines = (
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>"
        for row in cells[2:]
    )
    return (
        f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(lines)}</tbody></table>{paragraph}"
    )


def _picture(path: Path) -> str:
    data = base64.b64encode(path.read_bytes()).decode()
    caption = html.escape(CAPTIONS.get(path.stem, path.stem))
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{data}">'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def _runs(rows: Sequence[Row]) -> str:
    shown = [(key, name) for key, name in COLUMNS if any(key in row for row in rows)]
    head = "".join(f"<th>{html.escape(name)}</th>" for _, name in shown)
    lines = ("<tr>" + "".join(_cell(row.get(key)) for key, _ in shown) + "</tr>" for row in rows)
    return (
        f'<table class="runs"><thead><tr>{head}</tr></thead><tbody>{"".join(lines)}</tbody></table>'
    )


def _cell(value: Any) -> str:
    """A cell that sorts by its exact value and shows four digits; what is missing sorts last."""
    if value is None:
        return '<td data-value="">none</td>'
    if isinstance(value, bool):
        return f'<td data-value="{int(value)}">{"yes" if value else "no"}</td>'
    text = f"{value:.4g}" if isinstance(value, float) else str(value)
    return f'<td data-value="{html.escape(str(value))}">{html.escape(text)}</td>'


PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>TITLE</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<style>
body { font: 15px/1.5 system-ui, sans-serif; color: #22282f; max-width: 75rem; margin: 2rem auto;
  padding: 0 1.5rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; }
table { border-collapse: collapse; margin: .8rem 0; font-variant-numeric: tabular-nums;
  font-size: .88rem; display: block; overflow-x: auto; }
th, td { padding: .25rem .7rem; border-bottom: 1px solid #e3e6ea; text-align: right;
  white-space: nowrap; }
th { background: #f4f6f8; border-bottom: 2px solid #c9ced4; }
th:first-child, td:first-child { text-align: left; }
table.runs { max-height: 32rem; overflow-y: auto; }
table.runs th { cursor: pointer; position: sticky; top: 0; }
table.runs th[aria-sort=ascending]::after { content: " \\2191"; }
table.runs th[aria-sort=descending]::after { content: " \\2193"; }
table.runs tr:hover td { background: #f0f5fb; }
figure { margin: 1rem 0; } img { max-width: 100%; }
figcaption, p { color: #55606b; } pre { background: #f4f6f8; padding: 1rem; overflow-x: auto; }
</style></head><body>
BODY
<script>
for (const table of document.querySelectorAll("table.runs")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => head.addEventListener("click", () => {
    const rising = head.getAttribute("aria-sort") !== "ascending";
    heads.forEach(other => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", rising ? "ascending" : "descending");
    const key = row => row.cells[column].dataset.value;
    const rows = [...table.tBodies[0].rows];
    rows.sort((a, b) => {
      const x = key(a), y = key(b);
      if (x === "" || y === "") return (x === "") - (y === "");
      const order = isNaN(x) || isNaN(y) ? x.localeCompare(y) : x - y;
      return rising ? order : -order;
    });
    table.tBodies[0].append(...rows);
  }));
}
</script></body></html>
"""
