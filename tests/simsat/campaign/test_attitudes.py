"""The campaign's initial attitudes: an even lattice, the paper's formula, files and refusals."""

import math
from pathlib import Path

import numpy as np
import pytest

from simsat.campaign.attitudes import choose_attitudes, fibonacci_directions, read_attitudes
from simsat.control.ground.errors import SettingsError


def test_paper_campaign_follows_its_formula() -> None:
    paper = choose_attitudes("paper")
    assert len(paper) == 100
    for i in range(50):
        z = 1.0 - (2 * i + 1) / 50.0
        longitude = i * math.pi * (3.0 - math.sqrt(5.0))
        axis = (
            math.cos(longitude) * math.sqrt(1 - z * z),
            math.sin(longitude) * math.sqrt(1 - z * z),
            z,
        )
        for start, angle in zip(paper[2 * i : 2 * i + 2], (75.0, 125.0), strict=True):
            np.testing.assert_allclose(start.axis, axis, rtol=0.0, atol=1e-13)
            assert start.angle_deg == angle
    assert [start.index for start in paper] == list(range(100))


@pytest.mark.parametrize("n", [10, 50, 400])
def test_directions_are_spread_evenly(n: int) -> None:
    directions = fibonacci_directions(n)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-15)
    # Moments of the uniform sphere: zero mean, second moment 1/3 on every axis, to the lattice's
    # O(1/n); random directions would be off by O(1/sqrt n).
    assert np.linalg.norm(directions.mean(axis=0)) < 1.0 / n
    np.testing.assert_allclose(directions.T @ directions / n, np.eye(3) / 3.0, atol=1.5 / n)
    cosines = directions @ directions.T - 2.0 * np.eye(n)
    nearest = np.arccos(cosines.max(axis=1))
    assert nearest.min() > 0.75 * math.sqrt(4.0 * math.pi / n)  # no two neighbours crowd


def test_count_of_a_hundred_is_the_paper() -> None:
    assert choose_attitudes("100") == choose_attitudes("paper")


def test_odd_count_leaves_out_one_large_angle() -> None:
    angles = [start.angle_deg for start in choose_attitudes("5")]
    assert angles == [75.0, 125.0, 75.0, 125.0, 75.0]


def test_file_is_read_in_its_own_order(tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text("angle_deg,axis_x,axis_y,axis_z\n30,1,0,0\n-90, 0, 2, 0\n")
    first, second = choose_attitudes(str(path))
    assert (first.index, first.axis, first.angle_deg) == (0, (1.0, 0.0, 0.0), 30.0)
    assert (second.index, second.axis, second.angle_deg) == (1, (0.0, 2.0, 0.0), -90.0)


HEADER = "axis_x,axis_y,axis_z,angle_deg\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no column axis_x, axis_y, axis_z, angle_deg"),
        ("axis_x,axis_y,angle_deg\n1,0,30\n", "no column axis_z; the first line must name"),
        (HEADER, "no attitude below"),
        (HEADER + "1,0,0,75\n1,0,x,75\n", r"line 3: four numbers wanted, .*'x'"),
        (HEADER + "1,0,0\n", "line 2: four numbers wanted"),
        (HEADER + "0,0,0,75\n", "line 2: axis and angle must be finite and not zero, got 0 0 0 75"),
        (HEADER + "1,0,0,nan\n", "line 2: axis and angle must be finite and not zero"),
        (HEADER + "1,0,0,0\n", "line 2: axis and angle must be finite and not zero"),
        (HEADER + "1e300,0,0,5\n", "line 2: axis and angle must be finite and not zero"),
        (HEADER + "1,0,0,5,6\n", "line 2: more values than the first line names columns"),
    ],
)
def test_bad_files_are_refused_by_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(SettingsError, match=message):
        read_attitudes(path)


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_bytes(b"\x80\x81")
    with pytest.raises(SettingsError, match="can't be read as text"):
        choose_attitudes(str(path))


def test_a_spreadsheet_s_mark_and_line_ends_are_read(tmp_path: Path) -> None:
    path = tmp_path / "windows.csv"
    path.write_bytes(b"\xef\xbb\xbf" + (HEADER + "1,0,0,75\n").replace("\n", "\r\n").encode())
    (start,) = choose_attitudes(str(path))
    assert start.axis == (1.0, 0.0, 0.0)
    assert start.angle_deg == 75.0


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("0", "a count from 1 to 100000, got 0"),
        ("-3", "a count from 1 to 100000, got -3"),
        ("papers", "takes 'paper', a count or a file, and 'papers' is no file here"),
    ],
)
def test_bad_choices_say_what_is_allowed(spec: str, message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        choose_attitudes(spec)
