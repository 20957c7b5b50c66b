"""Labels, values and reasons of the user's own are shown as they are, in every kind of result."""

import csv
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simsat.comparison.markdown import cells, literal, markdown_table, plain
from simsat.comparison.statistics import aggregate
from simsat.comparison.study_picture import draw_study
from simsat.comparison.study_rows import StudyRow
from simsat.comparison.study_table import write_study
from simsat.comparison.summary import write_summary
from simsat.results.pictures.lettering import for_picture, for_spreadsheets
from simsat.results.summary import recording_notes

NASTY = (
    "BODY", "TITLE", "{{ title }}", "{% raw %}", "{{ 7 * 7 }}", "$BODY",
    "<script>alert(1)</script>",
    "a & b &amp; c", "a | b", "\\|", "\\", "`x`", "*x* **y**", "_x_", "[x](javascript:y)", "~~x~~",
    "$x^2$", "$\\frac{", "a$b", "\\$", "^_^", "=1+1", "+a", "-a", "@a", '"quoted"', "it's", "# x",
    "</td></table>", "a_b.c:d_e",
)  # fmt: skip


class Page(HTMLParser):
    """Its tags, and its text outside of style and script."""

    def __init__(self, source: str):
        super().__init__()
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.feed(source)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1] not in ("style", "script"):
            self.texts.append(data.strip())


def rows_of(label: str) -> list[dict[str, Any]]:
    figures = {"settling_time_s": 10.0, "steady_state_rmse_deg": 0.1, "final_error_deg": 0.1}
    return [
        {
            "run": run, "controller": name, "attitude": run % 2, "axis_x": 0.0, "axis_y": 1.0,
            "axis_z": 0.0, "angle_deg": 75.0, "converged": True, "reason": label, **figures,
        }
        for run, name in enumerate(("nmpc", "nmpc", label, label))
    ]  # fmt: skip


@pytest.fixture(scope="module")
def plain_page(tmp_path_factory: pytest.TempPathFactory) -> Page:
    folder = tmp_path_factory.mktemp("plain")
    write_summary(folder, rows_of("ours"), pa.table({}), {"model": "ours"}, "ours")
    return Page((folder / "report.html").read_text())


@pytest.mark.parametrize("text", NASTY)
def test_the_report_shows_it_and_stays_the_same_page(
    text: str, tmp_path: Path, plain_page: Page
) -> None:
    write_summary(tmp_path, rows_of(text), pa.table({}), {"model": text}, text)
    page = Page((tmp_path / "report.html").read_text())
    assert page.tags == plain_page.tags
    shown = sum(piece.count("ours") for piece in plain_page.texts)
    assert sum(piece.count(text) for piece in page.texts) >= shown - 1  # JSON quotes its own way
    assert text in page.texts
    settings = next(piece for piece in page.texts if piece.startswith("{\n"))
    assert json.loads(settings) == {"model": text}


@pytest.mark.parametrize("text", NASTY)
def test_a_markdown_table_keeps_its_cells(text: str, tmp_path: Path) -> None:
    write_summary(tmp_path, rows_of(text), pa.table({}), {}, text)
    for name in ("table.md", "comparison.md"):
        lines = (tmp_path / name).read_text().splitlines()
        tables = [cells(line) for line in lines if line.startswith("|")]
        assert any(text in row for row in tables)
    counts = {len(row) for row in tables[:2]}
    assert len(counts) == 1


@given(st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Zl", "Zp", "Zs"])))
def test_literal_markdown_reads_as_the_text(text: str) -> None:
    assert plain(literal(text)) == text
    head, _, row = markdown_table([text, "b"], [["c", text]]).splitlines()
    assert (cells(head), cells(row)) == ([text, "b"], ["c", text])
    unescaped = re.sub(r"\\.", "", literal(text))
    assert not set("|`*<>&~#\\") & set(unescaped)


def test_ordinary_words_need_no_escape() -> None:
    for text in ("nmpc-pinn", "two_wheel", "SS RMSE (deg), mean ± std", "0.1 [0.0, 0.2]", "+1.0 %"):
        assert literal(text) == text


@pytest.mark.parametrize("text", NASTY)
def test_a_study_shows_it(text: str, tmp_path: Path) -> None:
    table = [StudyRow({"model": text, "x": "-1"}, a) for a in aggregate(rows_of(text))]
    markdown = write_study(tmp_path, table)
    assert cells(markdown.splitlines()[2])[:2] == [text, "-1"]
    with (tmp_path / "study.csv").open(newline="") as file:
        first = list(csv.reader(file))[1]
    assert first[0].removeprefix("'") == text
    assert not first[0].startswith(("=", "+", "-", "@"))
    assert first[1] == "-1"


@pytest.mark.parametrize("text", NASTY)
def test_a_picture_shows_it(text: str, tmp_path: Path) -> None:
    """No formula (an unbalanced one would raise), and a legend that leaves out nobody."""
    from matplotlib import cbook
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    table = [StudyRow({"x": value}, a) for value in ("0", text) for a in aggregate(rows_of(text))]
    draw_study(table, tmp_path / "study.png")
    shown = for_picture(text)
    assert not cbook.is_math_text(shown)
    axes = Figure().subplots()
    axes.plot([0, 1], label=shown)
    assert axes.get_legend_handles_labels()[1] == [shown]
    assert Text()._preprocess_math(shown)[0].strip() == text  # type: ignore[attr-defined]


def test_only_text_is_kept_from_spreadsheets() -> None:
    assert for_spreadsheets("=HYPERLINK(1)") == "'=HYPERLINK(1)"
    assert for_spreadsheets("@x") == "'@x"
    assert [for_spreadsheets(x) for x in ("-1.5", "+2e3", "a=b", "")] == ["-1.5", "+2e3", "a=b", ""]


def test_the_notes_of_a_recording_show_it(monkeypatch: pytest.MonkeyPatch) -> None:
    from simsat.results import summary

    class Told:
        title = "# <b>*craft*</b>\n# more"
        duration_s = 1.0

        class model:  # noqa: N801
            spacecraft, passive_joints = None, ()

        believed = pilot = None

        class environment:  # noqa: N801
            left_out = ()

    monkeypatch.setattr(summary, "describe", lambda *args: "craft ```\n````\n# x")
    notes = recording_notes(Told())  # type: ignore[arg-type]
    first, *_ = notes.splitlines()
    assert plain(first) == "# # <b>*craft*</b> # more"
    assert "<" not in re.sub(r"\\.", "", first)
    assert notes.count("`````") == 2
