"""Names of wheels are text in the pictures of a training, never formulas."""

from pathlib import Path
from typing import Any

import pytest
from matplotlib.text import Text

from simsat.control.correction.network import Network
from simsat.learning.correction import report
from simsat.mjcf import Model
from simsat.results.files import write_picture
from tests.learning_cases import believed_of, made_up_windows

NAMES = ("$\\frac{$", "a$b_1$")
"""The first, taken for a formula, raises; the second is set in italics."""


def test_a_wheel_s_name_is_shown_as_it_is(
    two_wheel: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Any] = []

    def drawing(path: Path, figure: Any, dpi: float) -> None:
        drawn.append(figure)
        write_picture(path, figure, dpi)

    monkeypatch.setattr(report, "write_picture", drawing)
    windows = made_up_windows(two_wheel, 2, 4)
    nothing: dict[str, Network] = {}
    report.draw_flight(nothing, windows, believed_of(two_wheel), NAMES, tmp_path / "flight.png")
    labels = [axis.get_ylabel() for axis in drawn[0].axes]
    shown = [Text()._preprocess_math(label)[0] for label in labels]  # type: ignore[attr-defined]
    assert shown == [f"{name}, mNm" for name in NAMES]
    assert (tmp_path / "flight.png").exists()
