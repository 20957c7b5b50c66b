"""Orbits from elements: Vallado's vectors, Skyfield's ground track, and files that are refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from skyfield.api import EarthSatellite, load, wgs84

from simsat.control.ground.errors import SettingsError
from simsat.environment import OrbitSettings
from simsat.environment.atmosphere import geodetic
from simsat.environment.environment import build_orbit
from simsat.environment.orbits.tle import read_orbit

# The first case of Vallado et al., Revisiting Spacetrack Report 3 (SGP4-VER.TLE, tcppver.out).
VANGUARD = (
    "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753",
    "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667",
)
# A Sun-synchronous craft near 500 km, made up: checksums computed.
LOW = (
    "1 99001U 26001A   26079.50000000  .00001000  00000-0  50000-4 0  9998",
    "2 99001  97.4000  40.0000 0011000  90.0000 295.0000 15.21936719    10",
)
OMM = {
    "OBJECT_NAME": "LOW", "OBJECT_ID": "2026-001A", "EPOCH": "2026-03-20T12:00:00.000000",
    "MEAN_MOTION": "15.21936719", "ECCENTRICITY": ".0011", "INCLINATION": "97.4",
    "RA_OF_ASC_NODE": "40", "ARG_OF_PERICENTER": "90", "MEAN_ANOMALY": "295",
    "EPHEMERIS_TYPE": "0", "CLASSIFICATION_TYPE": "U", "NORAD_CAT_ID": "99001",
    "ELEMENT_SET_NO": "999", "REV_AT_EPOCH": "1", "BSTAR": ".5e-4", "MEAN_MOTION_DOT": ".1e-4",
    "MEAN_MOTION_DDOT": "0",
}  # fmt: skip
EPOCH = "2026-03-20T12:00:00"


def written(folder: Path, text: str, name: str = "craft.tle") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def with_checksum(line: str) -> str:
    total = sum(int(c) if c.isdigit() else c == "-" for c in line[:68])
    return f"{line[:68]}{total % 10}"


def low(folder: Path) -> Path:
    return written(folder, "LOW\n" + "\n".join(map(with_checksum, LOW)) + "\n")


def test_sgp4_answers_vallado_s_vectors(tmp_path: Path) -> None:
    path = written(tmp_path, "\n".join(VANGUARD))
    epoch = "2000-06-27T18:50:19.733568"
    orbit = read_orbit(path, epoch)
    np.testing.assert_allclose(
        np.array(orbit.position(0.0)), [7022465.29266, -1400082.96755, 39.95155], atol=0.1
    )  # m
    np.testing.assert_allclose(
        np.array(orbit.velocity(0.0)), [1893.841015, 6405.893759, 4534.807250], atol=1e-3
    )  # m/s
    six_hours = np.stack(orbit.position(np.array([0.0, 21600.0])), axis=1)[1]
    np.testing.assert_allclose(
        six_hours, [-7154031.20202, -3783176.82504, -3536194.12294], atol=0.1
    )


def test_the_ground_track_is_skyfield_s(tmp_path: Path) -> None:
    """Longitude, latitude and height below the craft for a day, through Skyfield's own frames."""
    path = low(tmp_path)
    orbit = read_orbit(path, EPOCH)
    t = np.arange(0.0, 86400.0, 617.0)
    longitude, latitude, altitude = geodetic(t, orbit)
    times = load.timescale(builtin=True).utc(2026, 3, 20, 12, 0, t)
    below = wgs84.geographic_position_of(
        EarthSatellite(*path.read_text().splitlines()[1:]).at(times)
    )
    east = (longitude - below.longitude.degrees + 180.0) % 360.0 - 180.0
    slack = 0.03 / np.cos(np.deg2rad(latitude))  # deg: nutation, UT1, first order in flattening
    assert np.all(np.abs(east) < slack)
    np.testing.assert_allclose(latitude, below.latitude.degrees, atol=0.02)
    np.testing.assert_allclose(altitude, below.elevation.km, atol=0.15)


def test_position_velocity_and_directions_agree(tmp_path: Path) -> None:
    orbit = read_orbit(low(tmp_path), EPOCH)
    t, h = np.linspace(0.0, 7000.0, 11), 0.5
    before, after = (np.stack(orbit.position(t + s)) for s in (-h, h))
    velocity = np.stack(orbit.velocity(t))
    np.testing.assert_allclose((after - before) / (2.0 * h), velocity, atol=0.02)  # m/s of 7600
    np.testing.assert_allclose(np.stack(orbit.direction(t)) * orbit.radius_at(t),
                               np.stack(orbit.position(t)), rtol=1e-12)  # fmt: skip
    np.testing.assert_allclose(orbit.speed_at(t), np.linalg.norm(velocity, axis=0), rtol=1e-12)
    assert orbit.period == pytest.approx(86400.0 / 15.21936719)


@pytest.mark.parametrize("kind", ["csv", "json", "xml"])
def test_an_omm_is_the_same_orbit(tmp_path: Path, kind: str) -> None:
    tags = "".join(f"<{name}>{value}</{name}>" for name, value in OMM.items())
    text = {
        "csv": ",".join(OMM) + "\n" + ",".join(OMM.values()) + "\n",
        "json": json.dumps([OMM]),
        "xml": f"<ndm><omm><body><segment><metadata/><data><meanElements>{tags}</meanElements>"
        "<tleParameters/></data></segment></body></omm></ndm>",
    }[kind]
    orbit = read_orbit(written(tmp_path, text, f"craft.{kind}"), EPOCH)
    lines = read_orbit(low(tmp_path), EPOCH)
    there, expected = np.array(orbit.position(5000.0)), np.array(lines.position(5000.0))
    np.testing.assert_allclose(there, expected, atol=1.0)  # m


def test_the_setting_flies_it(tmp_path: Path) -> None:
    orbit = build_orbit(OrbitSettings(tle=low(tmp_path), epoch_utc=EPOCH))
    assert 480e3 < float(orbit.radius_at(0.0)) - 6378136.6 < 530e3


@pytest.mark.parametrize(
    ("edit", "epoch", "message"),
    [
        (("97.4000", "97.5000"), EPOCH, r"checksum as \d but in fact tallies to \d"),
        (("2 99001", "3 99001"), EPOCH, "1 lines of elements where one pair is wanted"),
        (("LOW\n1 ", "LOW\n1"), EPOCH, "1 lines of elements where one pair is wanted"),
        (
            ("LOW", "LOW"),
            "2026-04-20T12:00:00",
            "31.0 days older than --orbit.epoch-utc 2026-04",
        ),
        (("LOW", "LOW"), "2026-01-01T00:00:00", "78.5 days younger than --orbit.epoch-utc"),
    ],
)
def test_elements_that_are_wrong_or_out_of_date_are_refused(
    tmp_path: Path, edit: tuple[str, str], epoch: str, message: str
) -> None:
    path = low(tmp_path)
    path.write_text(path.read_text().replace(*edit))
    with pytest.raises(SettingsError, match=rf"--orbit\.tle '.*': .*{message}"):
        read_orbit(path, epoch)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("none.tle", None, "can't be read: .*No such file"),
        ("empty.tle", "", "0 lines of elements"),
        ("short.tle", "1 a\n2 b\n", "a line of elements has 69 characters"),
        ("no.json", "{}", "the message has no 'EPOCH'"),
        ("no.xml", "<a>", "no elements could be read"),
        ("no.csv", "", "0 messages where one is wanted"),
        ("two.json", json.dumps([OMM, OMM]), "2 messages where one is wanted"),
        (
            "frame.json",
            json.dumps([{**OMM, "REF_FRAME": "GCRF"}]),
            "TEME are wanted, not in GCRF",
        ),
        ("low.json", json.dumps(OMM | {"MEAN_MOTION": "16.9"}), "km high at t = 0|decayed"),
    ],
)
def test_files_without_elements_are_refused(
    tmp_path: Path, name: str, content: str | None, message: str
) -> None:
    path = tmp_path / name if content is None else written(tmp_path, content, name)
    with pytest.raises(SettingsError, match=message):
        read_orbit(path, EPOCH)
