"""References from files: CSV of attitudes or of targets, and attitude ephemeris messages."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.control.reference.reference import Curve, Sequence
from simsat.reference.aem import read_aem, write_aem
from simsat.reference.frames import j2000_in_date
from simsat.reference.tables import read_table

EPOCH = "2026-03-20T12:00:00"
T = np.arange(0.0, 105.0, 5.0)


def attitudes(t: Array) -> Array:
    """A slow roll about a tilted axis, on both hemispheres."""
    start = attitude.normalized(np.array([0.1, 0.7, -0.3, 0.4]))
    return attitude.multiply(start, attitude.from_axis_angle(np.array([1.0, 2.0, -1.0]), 0.03 * t))


def table(path: Path, rows: Array, header: str = "t_s,q_w,q_x,q_y,q_z") -> Path:
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.15g")
    return path


def over_time(path: Path, t: Array = T) -> Path:
    signs = np.where(np.arange(len(t)) % 3 == 1, -1.0, 1.0)[:, None]  # q and -q are one attitude
    return table(path, np.column_stack([t, signs * attitudes(t)]))


def test_a_curve_runs_through_the_attitudes_of_a_table(tmp_path: Path) -> None:
    curve = read_table(over_time(tmp_path / "a.csv"), 100.0)
    assert isinstance(curve, Curve)
    between = np.linspace(0.0, 100.0, 77)
    apart = attitude.error_angle(curve.attitude(between), attitudes(between))
    assert apart.max() < 2e-6  # rad: cubics of 0.15 rad steps
    axis = attitude.normalized(np.array([1.0, 2.0, -1.0]))
    np.testing.assert_allclose(curve.rate(between), np.tile(0.03 * axis, (77, 1)), atol=3e-6)


def test_beyond_its_ends_a_curve_rests(tmp_path: Path) -> None:
    curve = read_table(over_time(tmp_path / "a.csv"), 100.0)
    np.testing.assert_array_equal(curve.attitude(130.0), curve.attitude(100.0))
    assert not curve.rate(np.array([-3.0, 130.0])).any()
    assert curve.rate(50.0).any()


def test_targets_count_one_after_another(tmp_path: Path) -> None:
    q = attitudes(np.array([0.0, 40.0, 80.0]))
    rows = np.column_stack([[30.0, 50.0, 20.0], q])
    targets = read_table(table(tmp_path / "t.csv", rows, "dwell_s,q_w,q_x,q_y,q_z"), 100.0)
    assert isinstance(targets, Sequence)
    np.testing.assert_array_equal(targets.starts, [0.0, 30.0, 80.0])
    np.testing.assert_allclose(targets.attitude(79.0), q[1], atol=1e-15)


def test_a_message_goes_out_and_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "out.aem"
    write_aem(path, "CRAFT", T, attitudes(T), EPOCH)
    curve = read_aem(path, EPOCH, 100.0)
    apart = attitude.error_angle(curve.attitude(T), attitudes(T))
    assert apart.max() < 1e-12  # rad
    earlier = read_aem(path, "2026-03-20T12:00:10", 80.0)
    np.testing.assert_allclose(earlier.attitude(40.0), curve.attitude(50.0), atol=1e-9)


MESSAGE = """CCSDS_AEM_VERS = 1.0
CREATION_DATE = 2026-03-20T00:00:00
ORIGINATOR = TEST
META_START
COMMENT a comment
OBJECT_NAME = CRAFT
OBJECT_ID = 2026-001A
CENTER_NAME = EARTH
REF_FRAME_A = EME2000
REF_FRAME_B = SC_BODY_1
ATTITUDE_DIR = A2B
TIME_SYSTEM = UTC
START_TIME = 2026-03-20T12:00:00
STOP_TIME = 2026-03-20T12:00:40
ATTITUDE_TYPE = QUATERNION
QUATERNION_TYPE = LAST
INTERPOLATION_METHOD = HERMITE
META_STOP
DATA_START
{data}
DATA_STOP
"""


def message(path: Path, *edits: tuple[str, str], rows: Array | None = None) -> Path:
    """Scalar last, every ten seconds, the last stamp as a day of the year."""
    q = np.roll(attitudes(np.arange(0.0, 50.0, 10.0)), -1, axis=1) if rows is None else rows
    stamps = [f"2026-03-20T12:00:{10 * k:02d}" for k in range(len(q) - 1)]
    stamps.append(f"2026-079T12:00:{10 * (len(q) - 1):02d}.000Z")
    data = "\n".join(
        f"{stamp} {' '.join(f'{x:.15g}' for x in row)}"
        for stamp, row in zip(stamps, q, strict=True)
    )
    text = MESSAGE.format(data=data)
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return path


def test_frames_and_directions_of_a_message_are_respected(tmp_path: Path) -> None:
    """All of these say the same attitude: J2000 is turned to date, a quaternion the other way round
    is turned back, the scalar may come first."""
    path = tmp_path / "m.aem"
    there = attitudes(np.arange(0.0, 50.0, 10.0))
    from_j2000 = attitude.multiply(j2000_in_date(9575.0), there)
    back = np.roll(attitude.conjugate(there), -1, axis=1)
    for edits, rows, expected in (
        ([], None, from_j2000),
        ([("= EME2000", "= TEME")], None, there),
        ([("= LAST", "= FIRST")], there, from_j2000),
        ([("= A2B", "= B2A")], back, from_j2000),
        ([("REF_FRAME_A = EME2000", "REF_FRAME_A = SC_BODY_1"),
          ("REF_FRAME_B = SC_BODY_1", "REF_FRAME_B = EME2000")], back, from_j2000),
    ):  # fmt: skip
        curve = read_aem(message(path, *edits, rows=rows), EPOCH, 40.0)
        apart = attitude.error_angle(curve.attitude(np.arange(0.0, 50.0, 10.0)), expected)
        assert apart.max() < 1e-9, edits


@pytest.mark.parametrize(
    ("edits", "duration", "message_text"),
    [
        ([("= EME2000", "= ITRF-97")], 40.0, "its frames are ITRF-97 and SC_BODY_1; the body's"),
        ([("= SC_BODY_1", "= INSTRUMENT_1")], 40.0, "frames are EME2000 and INSTRUMENT_1"),
        ([("= UTC", "= TAI")], 40.0, "TIME_SYSTEM is TAI; UTC is read"),
        ([("= QUATERNION\n", "= EULER_ANGLE\n")], 40.0, "ATTITUDE_TYPE is EULER_ANGLE; QUATERNION"),
        ([("CCSDS_AEM_VERS", "CCSDS_OEM_VERS")], 40.0, "an AEM begins with CCSDS_AEM_VERS"),
        ([("OBJECT_ID = 2026", "OBJECT ID 2026")], 40.0, "line 7: 'OBJECT ID 2026-001A' is no KEY"),
        ([("12:00:20 ", "noon ")], 40.0, "line 22: a time and four numbers are wanted"),
        ([("12:00:20", "12:00:05")], 40.0, "times must rise, but 5 s follows on 10 s"),
        ([], 41.0, "covers 0 to 40 s of the flight, which lasts from 0 to 41 s"),
    ],
)
def test_messages_that_say_something_else_are_refused(
    tmp_path: Path, edits: list[tuple[str, str]], duration: float, message_text: str
) -> None:
    path = message(tmp_path / "m.aem", *edits)
    with pytest.raises(SettingsError, match=f"--reference '.*m.aem'.*{message_text}"):
        read_aem(path, EPOCH, duration)


def changed(**values: Any) -> Array:
    rows = np.column_stack([T, attitudes(T)])
    for column, (row, value) in values.items():
        rows[row, "tw".index(column)] = value
    return rows


@pytest.mark.parametrize(
    ("rows", "duration", "message_text"),
    [
        (changed(t=(20, 200.0)), 90.0, "has a gap from 95 to 200 s, where attitudes are 5 s apart"),
        (changed(t=(4, 15.0)), 90.0, "times must rise, but 15 s follows on 15 s"),
        (changed(w=(3, 9.0)), 90.0, "the attitude at t = 15 s has length 9"),
        (changed(w=(3, np.nan)), 90.0, "a number that isn't finite"),
        (changed()[:3], 10.0, "has 3 attitudes, 4 are the least"),
        (changed()[2:], 90.0, "covers 10 to 100 s of the flight"),
        (changed(), 101.0, "covers 0 to 100 s of the flight, which lasts from 0 to 101 s"),
        (
            np.column_stack([T, np.eye(4)[np.arange(21) % 2]]),
            90.0,
            "turns by 180 deg, more than",
        ),
    ],
)
def test_tables_with_gaps_or_without_attitudes_are_refused(
    tmp_path: Path, rows: Array, duration: float, message_text: str
) -> None:
    path = table(tmp_path / "a.csv", rows)
    with pytest.raises(SettingsError, match=f"--reference '.*a.csv'.*{message_text}"):
        read_table(path, duration)


@pytest.mark.parametrize(
    ("text", "message_text"),
    [
        ("", "its first row must be t_s,.*it is empty"),
        ("time,w,x,y,z\n", "it is time,w,x,y,z"),
        ("t_s,q_w,q_x,q_y,q_z\n", "has no rows"),
        ("t_s,q_w,q_x,q_y,q_z\n0,1,0,0\n", "line 2: 5 numbers are wanted"),
        ("t_s,q_w,q_x,q_y,q_z\n0,1,0,0,a\n", "line 2: 5 numbers are wanted"),
        (
            "dwell_s,q_w,q_x,q_y,q_z\n0,1,0,0,0\n",
            "every dwell_s must be a finite number above z",
        ),
        ("dwell_s,q_w,q_x,q_y,q_z\n9,2,0,0,0\n", "every target must be a unit quaternion"),
        ("dwell_s,q_w,q_x,q_y,q_z\n9,1,0,0,0\n", "its dwells end after 9 s, the flight lasts 20"),
        (None, "can't be read: .*No such file"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, text: str | None, message_text: str) -> None:
    path = tmp_path / "a.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(SettingsError, match=message_text):
        read_table(path, 20.0)
