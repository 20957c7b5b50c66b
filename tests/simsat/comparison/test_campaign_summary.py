"""The campaign's pictures and page hold the runs that they are made of."""

from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from simsat.comparison.pictures import (
    draw_distributions,
    draw_settling,
    draw_sphere,
    draw_trajectories,
)
from simsat.comparison.report import blocks
from simsat.comparison.statistics import Row
from simsat.comparison.summary import write_summary

VOID = {"meta", "link", "img"}


def campaign() -> tuple[list[Row], pa.Table]:
    """Two controllers, three attitudes; one run did not converge, one failed to fly."""
    rows: list[Row] = []
    curves: dict[str, list[object]] = {
        name: [] for name in ("run", "controller", "attitude", "t_s", "q_w", "q_x", "q_y", "q_z")
    }
    for run in range(6):
        controller, attitude = ("nmpc", "ours")[run // 3], run % 3
        converged, flown = run not in (1, 5), run != 5
        rows.append(
            {
                "run": run,
                "controller": controller,
                "attitude": attitude,
                "axis_x": [0.0, 2.0, 0.0][attitude],
                "axis_y": [3.0, 0.0, 0.0][attitude],
                "axis_z": [0.0, 0.0, 1.0][attitude],
                "angle_deg": 75.0,
                "converged": converged,
                "settling_time_s": 10.0 + run if converged else None,
                "steady_state_rmse_deg": 0.1 + 0.01 * run if converged else None,
                "final_error_deg": (0.05 * (run + 1) if converged else 3.0) if flown else None,
                "torque_effort_Nms": 3.5,
                "reason": "flown to the end" if flown else "a < b & 'quoted'",
            }
        )
        if flown:
            for t, sign in ((0.0, -1.0), (0.5, -1.0), (1.0, 1.0)):
                values = (run, controller, attitude, t, sign * 0.8, sign * 0.6, 0.0, 0.0)
                for name, value in zip(curves, values, strict=True):
                    curves[name].append(value)
    return rows, pa.table(curves)


def test_the_trajectories_are_drawn_on_one_side_of_the_double_cover() -> None:
    figure: Any = draw_trajectories(campaign()[1])
    assert figure is not None
    assert [len(ax.lines) for ax in figure.axes] == [4 * 3, 4 * 2]  # components times runs flown
    assert all(line.get_ydata()[0] == 0.8 for line in figure.axes[0].lines[:3])
    assert all(len(line.get_xdata()) == 3 for line in figure.axes[0].lines)


def test_a_run_that_turns_over_is_drawn_without_a_jump() -> None:
    """From 170 to 360 degrees, kept with q_w >= 0, and a second run that starts anew."""
    angle = np.radians(np.linspace(170.0, 360.0, 21))
    w, z = np.cos(angle / 2), np.sin(angle / 2)
    near = np.where(w < 0.0, -1.0, 1.0)
    columns = {"q_w": near * w, "q_x": 0.0 * w, "q_y": 0.0 * w, "q_z": near * z, "t_s": 0.5 * angle}
    twice = {name: np.tile(values, 2) for name, values in columns.items()}
    runs = {"run": np.repeat([0, 1], 21), "controller": ["nmpc"] * 42, "attitude": [0] * 42}
    figure: Any = draw_trajectories(pa.table(runs | twice))
    first, second = figure.axes[0].lines[6:]  # q_z of both runs
    for line in (first, second):
        np.testing.assert_allclose(line.get_ydata(), z, atol=1e-12)


def test_without_a_flight_there_is_no_trajectory_to_draw() -> None:
    assert draw_trajectories(pa.table({})) is None


def test_the_settling_curve_counts_runs_that_never_settle() -> None:
    ax: Any = draw_settling(campaign()[0]).axes[0]
    nmpc = ax.lines[0]
    np.testing.assert_allclose(nmpc.get_xdata()[:3], [0.0, 10.0, 12.0])
    np.testing.assert_allclose(nmpc.get_ydata()[:3], [0.0, 100 / 3, 200 / 3])
    labels = ax.get_legend_handles_labels()[1]
    assert labels == ["nmpc (2 of 3)", "ours (2 of 3)"]


def test_the_sphere_shows_each_axis_where_it_points() -> None:
    figure: Any = draw_sphere(campaign()[0])
    dots, crosses = figure.axes[0].collections[:2]
    expected = [[np.pi / 2, 0.0], [0.0, 0.0], [0.0, np.pi / 2]]  # longitude, latitude
    np.testing.assert_allclose(dots.get_offsets(), expected, atol=1e-7)
    np.testing.assert_allclose(dots.get_array(), [0.05, 3.0, 0.15])
    np.testing.assert_allclose(crosses.get_offsets(), [[0.0, 0.0]], atol=1e-7)


def test_a_line_joins_only_runs_of_the_same_attitude() -> None:
    figure: Any = draw_distributions(campaign()[0])
    final, steady = figure.axes
    joined = [
        sorted(list(line.get_ydata()) for line in ax.lines[:-1] if _joins(line))
        for ax in (final, steady)
    ]
    np.testing.assert_allclose(joined[0], [[0.05, 0.2], [3.0, 0.25]])
    np.testing.assert_allclose(joined[1], [[0.1, 0.13]])


def _joins(line: Any) -> bool:
    return list(line.get_xdata()) == [0, 1]


class Page(HTMLParser):
    """Checks that tags close in order and gathers what the tests ask for."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.sources: list[str] = []
        self.cells: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attrs:
            if name in ("src", "href"):
                self.sources.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] in ("td", "th"):
            self.cells.append(data)


def test_the_report_holds_everything_and_needs_nothing(tmp_path: Path) -> None:
    rows, trajectories = campaign()
    table = write_summary(tmp_path, rows, trajectories, {"note": "<script>"}, "A & B")
    assert "| converged | 2 / 3 | 2 / 3 |" in table
    assert (tmp_path / "table.md").read_text().startswith(table)
    assert "the paper" in (tmp_path / "table.md").read_text()
    assert "Against nmpc" in (tmp_path / "comparison.md").read_text()
    assert (tmp_path / "table.csv").read_text().count("\n") == 3
    text = (tmp_path / "report.html").read_text()
    page = Page()
    page.feed(text)
    assert page.open == []
    assert len(page.sources) == 5
    assert all(source.startswith("data:") for source in page.sources)
    assert "a < b & 'quoted'" in page.cells  # escaped in the file, whole on the page
    assert text.count("<script>") == 1
    assert text.count('data-value="3.5"') == 6
    assert {path.stem for path in (tmp_path / "pictures").iterdir()} == {
        "trajectories",
        "distributions",
        "sphere",
        "settling",
    }


def test_without_the_baseline_the_first_controller_is_compared_with(tmp_path: Path) -> None:
    rows, trajectories = campaign()
    renamed = [{**row, "controller": f"x-{row['controller']}"} for row in rows]
    write_summary(tmp_path, renamed, trajectories, {})
    assert "Against x-nmpc" in (tmp_path / "comparison.md").read_text()


def test_a_campaign_without_a_single_flight_is_still_reported(tmp_path: Path) -> None:
    lost = [row for row in campaign()[0] if row["run"] == 5]
    write_summary(tmp_path, lost, pa.table({}), {})
    assert "0 / 1" in (tmp_path / "table.md").read_text()
    assert not (tmp_path / "pictures" / "trajectories.png").exists()


def test_paragraphs_and_tables_are_told_apart() -> None:
    text = "| a | b |\n| --- | --- |\n| 1 | x \\< y |\n\nA \\*note\\*.\n"
    table, note = blocks(text)
    assert (table.head, table.rows, table.prose) == (["a", "b"], [["1", "x < y"]], "")
    assert (note.head, note.rows, note.prose) == ([], [], "A *note*.")
