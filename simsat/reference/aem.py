"""Attitude ephemeris messages: CCSDS 504.0-B, versions 1 and 2, in the KVN notation.

A message's quaternion turns frame A into frame B; with A inertial and B the body's it is this
project's body -> inertial one, number by number.
"""

import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternions
from simsat.control.ground.errors import SettingsError
from simsat.control.reference.reference import Curve
from simsat.environment import earth
from simsat.reference.frames import j2000_in_date
from simsat.reference.samples import curve_through

J2000_FRAMES = ("EME2000", "J2000", "ICRF")
DATE_FRAMES = ("TEME", "MOD", "TOD")  # nutation apart this project's own
BODY = re.compile(r"(SC_BODY|SC_BODY_\d+)")
VERSION = re.compile(r"\s*CCSDS_AEM_VERS\s*=\s*(\S+)")
KEY = re.compile(r"\s*([A-Z_][A-Z0-9_]*)\s*=\s*(.*?)\s*(\[.*\])?\s*")
SCALAR_LAST, SCALAR_FIRST = "LAST", "FIRST"
OUTSIDE = ("META_START", "META_STOP", "DATA_START", "DATA_STOP")


def read_aem(path: Path, epoch_utc: str, duration: float) -> Curve:
    """The reference of a message, t = 0 at the epoch.

    Raises `SettingsError` in one sentence if it is none, its frames are others than an inertial one
    and the body's, its times are not UTC, or its attitudes don't cover the flight without gaps.
    """
    name = f"--reference '{path}'"
    try:
        lines = path.read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"{name} can't be read: {error}") from error
    if not lines or not VERSION.match(lines[0]):
        raise SettingsError(f"{name}: an AEM begins with CCSDS_AEM_VERS = 1.0 or 2.0")
    start = earth.J2000 + np.timedelta64(round(earth.days_since_j2000(epoch_utc) * 86400e6), "us")
    t: list[float] = []
    q: list[Quaternions] = []
    for number, meta, data in _segments(name, lines):
        times, values = _numbers(name, number, data, start)
        t += times
        q.append(_to_date(name, meta, values, earth.days_since_j2000(epoch_utc)))
    if not t:
        raise SettingsError(f"{name} holds no attitudes")
    times_s, attitudes = np.array(t), np.concatenate(q)
    fresh = np.concatenate([[True], np.diff(times_s) != 0.0])  # segments share their ends
    return curve_through(name, times_s[fresh], attitudes[fresh], duration)


Segment = tuple[int, dict[str, str], list[str]]


def _segments(name: str, lines: list[str]) -> list[Segment]:
    """(line of its first attitude, metadata, lines of attitudes) of each segment."""
    found: list[Segment] = []
    meta: dict[str, str] = {}
    where = ""
    for number, line in enumerate(lines, 1):
        word = line.strip()
        if word in OUTSIDE:
            where = word
            if word == "META_START":
                meta = {}
            if word == "DATA_START":
                found.append((number + 1, meta, []))
        elif word.startswith("COMMENT") or not word:
            if where == "DATA_START":
                found[-1][2].append("")
        elif where == "DATA_START":
            found[-1][2].append(word)
        elif where == "META_START":
            pair = KEY.fullmatch(line)
            if pair is None:
                raise SettingsError(f"{name}, line {number}: '{word}' is no KEYWORD = value")
            meta[pair[1]] = pair[2].upper()
    return found


def _to_date(name: str, meta: dict[str, str], q: Array, days: float) -> Quaternions:
    """Attitudes of a segment, body -> this project's inertial axes, scalar first."""
    kind = meta.get("ATTITUDE_TYPE", "")
    if not kind.startswith("QUATERNION"):
        raise SettingsError(f"{name}: ATTITUDE_TYPE is {kind or 'missing'}; QUATERNION is read")
    if meta.get("TIME_SYSTEM") != "UTC":
        raise SettingsError(f"{name}: TIME_SYSTEM is {meta.get('TIME_SYSTEM')}; UTC is read")
    if meta.get("QUATERNION_TYPE", SCALAR_LAST) != SCALAR_FIRST:
        q = np.roll(q, 1, axis=1)
    frames = meta.get("REF_FRAME_A", ""), meta.get("REF_FRAME_B", "")
    backwards = meta.get("ATTITUDE_DIR", "A2B") == "B2A"
    if BODY.fullmatch(frames[0]):  # written from the body's side
        frames, backwards = (frames[1], frames[0]), not backwards
    inertial, body = frames
    if not BODY.fullmatch(body) or inertial not in (*J2000_FRAMES, *DATE_FRAMES):
        raise SettingsError(
            f"{name}: its frames are {' and '.join(f or 'none' for f in frames)}; the body's "
            f"(SC_BODY_1) and one of {', '.join((*J2000_FRAMES, *DATE_FRAMES))} are read"
        )
    q = attitude.conjugate(q) if backwards else q
    return attitude.multiply(j2000_in_date(days), q) if inertial in J2000_FRAMES else q


def _numbers(
    name: str, first: int, lines: list[str], start: np.datetime64
) -> tuple[list[float], Array]:
    t, q = [], []
    for number, line in enumerate(lines, first):
        if not line:
            continue
        parts = line.split()
        try:
            moment = np.datetime64(_calendar(parts[0]), "us")
            values = [float(part) for part in parts[1:5]]
        except ValueError:
            values = []
        if len(values) != 4:
            raise SettingsError(f"{name}, line {number}: a time and four numbers are wanted")
        t.append(float((moment - start) / np.timedelta64(1, "us")) * 1e-6)
        q.append(values)
    return t, np.array(q, float).reshape(-1, 4)


def _calendar(text: str) -> str:
    """A CCSDS time, also as a day of the year, without the Z of UTC."""
    text = text.rstrip("Z")
    day = re.fullmatch(r"(\d{4})-(\d{3})T(.*)", text)
    if day is None:
        return text
    date = datetime(int(day[1]), 1, 1, tzinfo=UTC) + timedelta(days=int(day[2]) - 1)
    return f"{date:%Y-%m-%d}T{day[3]}"


def write_aem(path: Path, name: str, t: Array, q: Quaternions, epoch_utc: str) -> None:
    """Write attitudes q (k, 4), body -> inertial, at t (k,), s from the epoch, as a message of
    version 2 in TEME. Raises `OSError`."""
    start = np.datetime64(epoch_utc, "us")
    stamps = [str(start + np.timedelta64(round(s * 1e6), "us")) for s in t]
    head = [
        "CCSDS_AEM_VERS = 2.0",
        f"CREATION_DATE = {datetime.now(UTC):%Y-%m-%dT%H:%M:%S}",
        "ORIGINATOR = SIMSAT",
        "META_START",
        f"OBJECT_NAME = {name}",
        f"OBJECT_ID = {name}",
        "REF_FRAME_A = TEME",
        "REF_FRAME_B = SC_BODY_1",
        "TIME_SYSTEM = UTC",
        f"START_TIME = {stamps[0]}",
        f"STOP_TIME = {stamps[-1]}",
        "ATTITUDE_TYPE = QUATERNION",
        "META_STOP",
        "DATA_START",
    ]
    rows = [
        f"{stamp} {x:.15g} {y:.15g} {z:.15g} {w:.15g}"
        for stamp, (w, x, y, z) in zip(stamps, q.tolist(), strict=True)
    ]
    path.write_text("\n".join([*head, *rows, "DATA_STOP", ""]), "utf-8")
