"""A fault's text says what happens, and a text that is none is refused in a sentence."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simsat.control.ground.errors import SettingsError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.faults.fault import Fault, Kind, acting, read_fault, read_faults
from simsat.flight.mission import prepare
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS
from simsat.settings import FlightSettings

CRAFT: Spacecraft = read_model(MODELS / "three_wheel" / "three_wheel.xml").spacecraft


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("wheel_z:seize@4", Fault("wheel_z", Kind.SEIZE, (), 4.0)),
        ("wheel_x:dead@6-20.5", Fault("wheel_x", Kind.DEAD, (), 6.0, 20.5)),
        ("wheel_y:weak=0.3@0", Fault("wheel_y", Kind.WEAK, (0.3,), 0.0)),
        ("wheel_y:friction=2e3@1", Fault("wheel_y", Kind.FRICTION, (2000.0,), 1.0)),
        ("tracker:out@10-40", Fault("tracker", Kind.OUT, (), 10.0, 40.0)),
        ("gyro_z:bias=0.1@5", Fault("gyro_z", Kind.BIAS, (0.1,), 5.0)),
        ("body:inertia=1.3 1.2 1.1@8", Fault("body", Kind.INERTIA, (1.3, 1.2, 1.1), 8.0)),
    ],
)
def test_a_text_is_read_as_it_says(text: str, fault: Fault) -> None:
    assert read_fault(text, CRAFT) == fault


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("wheel_z", "is no fault: give PART:KIND@START"),
        ("wheel_z:seize", "is no fault"),
        ("wheel_w:seize@4", "'three_wheel' has no 'wheel_w'; there are: wheel_x, wheel_y, wheel_z, "
         "tracker, gyro_x"),
        ("wheel_z:out@4", "'wheel_z' can be dead, seize, weak, friction, tachometer, not 'out'"),
        ("wheel_z:seize@4-8", "has an end, but 'seize' is for good"),
        ("wheel_z:seize=1@4", "'seize' takes no value"),
        ("wheel_z:weak@4", "'weak' takes a share of 0 to 1, as weak=VALUE"),
        ("wheel_z:weak=1.1@4", "'weak' takes a share of 0 to 1"),
        ("wheel_z:weak=nan@4", "'weak' takes a share of 0 to 1"),
        ("wheel_z:friction=0@4", "'friction' takes a torque in Nm, above 0"),
        ("body:inertia=1 2@4", "'inertia' takes one or three factors above 0"),
        ("wheel_z:dead@soon", "'soon' is no time: give seconds from 0 up"),
        ("wheel_z:dead@nan", "'nan' is no time"),
        ("wheel_z:dead@8-8", "ends at 8 s, not after its start"),
    ],
)  # fmt: skip
def test_what_is_no_fault_is_refused(text: str, sentence: str) -> None:
    with pytest.raises(SettingsError, match=sentence):
        read_fault(text, CRAFT)
    with pytest.raises(SettingsError, match=sentence):
        prepare(FlightSettings(model=Path("three_wheel"), fault=(text,)))


def test_an_inertia_that_no_body_has_is_refused() -> None:
    with pytest.raises(SettingsError, match="the largest must not exceed the sum of the others"):
        prepare(FlightSettings(fault=("body:inertia=1 1 9@4",)))


@given(st.text(max_size=30))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        fault = read_fault(text, CRAFT)
    except SettingsError:
        return
    assert read_fault(fault.text, CRAFT) == fault


@given(
    st.sampled_from(["wheel_x:dead", "gyro_y:stuck", "tracker:out", "wheel_z:weak=0.25"]),
    st.integers(0, 500), st.none() | st.integers(501, 900),
)  # fmt: skip
def test_a_fault_writes_what_it_reads(what: str, start: int, end: int | None) -> None:
    text = f"{what}@{start}" + ("" if end is None else f"-{end}")
    fault = read_fault(text, CRAFT)
    assert fault.text == text
    assert fault.end == (math.inf if end is None else end)


def test_faults_are_in_order_and_said_while_they_act() -> None:
    faults = read_faults(["wheel_z:dead@6-9", "gyro_x:stuck@2"], CRAFT)
    assert [fault.start for fault in faults] == [2.0, 6.0]
    said = [acting(faults, t) for t in (0.0, 2.0, 6.0, 9.0)]
    assert said == ["", "gyro_x stuck", "gyro_x stuck, wheel_z dead", "gyro_x stuck"]
    assert np.isinf(faults[0].end)
