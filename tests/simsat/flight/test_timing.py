"""A flight's clock: own seconds unless given, in whole time steps, samples and periods."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import pytest

from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import changed
from simsat.flight.mission import prepare
from simsat.flight.timing import Timing, timing_of, with_timing
from simsat.mjcf import Model, read_model
from simsat.mjcf.shipped import MODELS
from simsat.settings import FlightSettings


@cache
def benchmark() -> Model:
    return read_model(MODELS / "two_wheel" / "two_wheel.xml")


def model(second: float, step: float = 0.01) -> Model:
    """The benchmark with weaker wheels and another time step: its own second is `second`."""
    craft = benchmark().spacecraft
    m = mujoco.MjModel.from_xml_string("<mujoco/>")
    m.opt.timestep = step
    weaker = replace(craft, torque_max=craft.torque_max / second**2)
    return replace(benchmark(), spacecraft=weaker, mj=m)


def timing(second: float = 1.0, step: float = 0.01, **values: Any) -> Timing:
    return timing_of(changed(FlightSettings(), values), model(second, step))


def lengths(timing: Timing) -> tuple[float, float, float]:
    return timing.sample_s, timing.period_s, timing.duration_s


@pytest.mark.parametrize(
    ("second", "expected"),
    [
        (1.0, (0.05, 0.5, 100.0)),
        (0.9997, (0.05, 0.5, 100.0)),
        (1.137, (0.05, 0.5, 113.5)),  # rounded down to the time step
        (55.3, (2.76, 27.6, 5520.0)),
        (0.1, (0.01, 0.05, 10.0)),  # the time step is no shorter
        (0.02, (0.01, 0.01, 2.0)),
    ],
)
def test_lengths_are_own_seconds_in_whole_steps(second: float, expected: tuple[float, ...]) -> None:
    assert lengths(timing(second)) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"nmpc": {"period": 20.0}}, (2.5, 20.0, 5520.0)),  # the longest sample that divides it
        ({"sample_s": 5.0}, (5.0, 25.0, 5525.0)),
        ({"nmpc": {"period": 20.0}, "duration_s": 40.0}, (2.5, 20.0, 40.0)),
    ],
)
def test_what_is_given_is_kept(values: dict[str, Any], expected: tuple[float, ...]) -> None:
    assert lengths(timing(55.3, **values)) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        (
            {"duration_s": 0.7, "nmpc": {"period": 0.5}},
            "flight of --duration-s: 0.7 s is not a whole number of 0.5 s steps",
        ),
        ({"sample_s": 0.015}, "sample interval: 0.015 s is not a whole number of 0.01 s steps"),
        ({"nmpc": {"period": 0.505}}, "period --nmpc.period: 0.505 s is not .* 0.01 s steps"),
        ({"nmpc": {"period": 0.5}, "sample_s": 0.2}, "0.5 s is not a whole number of 0.2 s"),
        (
            {"duration_s": 1e7},
            r"1e\+07 s in samples of --sample-s 0.05 s make 2e\+08 samples, more than",
        ),
    ],
)
def test_lengths_that_do_not_divide_are_refused(values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(SettingsError, match=sentence):
        timing(**values)


def test_a_brief_has_a_number_for_everything_and_the_mission_what_was_asked() -> None:
    mission = prepare(FlightSettings())
    assert mission.settings == FlightSettings()
    told = mission.brief.settings
    assert (told.duration_s, told.sample_s, told.nmpc.period) == (100.0, 0.05, 0.5)
    assert (told.learned.hold_s, told.correction.limit_Nm) == (80.0, 0.015)
    there = with_timing(FlightSettings(), timing(55.3))
    assert there.correction.limit_Nm == pytest.approx(0.015 / 55.3**2)  # a third of weaker wheels


def test_rods_leave_no_drift_to_prepare_a_hold_for_unless_a_hold_is_given() -> None:
    mission = prepare(FlightSettings(model=Path("two_wheel_rods")))
    assert mission.settings.learned.hold_s is None
    assert mission.brief.settings.learned.hold_s == mission.came_to["learned.hold_s"] == 0.0
    given = replace(mission, settings=changed(mission.settings, {"learned.hold_s": 40.0}))
    assert given.brief.settings.learned.hold_s == 40.0
    unused = replace(mission, settings=changed(mission.settings, {"rods.enabled": False}))
    assert unused.brief.settings.learned.hold_s == 80.0


def test_a_given_length_ends_with_the_period_in_which_it_is_over() -> None:
    kept = timing(55.3, duration_s=1000.0)
    assert kept.duration_s - kept.period_s < 1000.0 <= kept.duration_s
    assert timing(1.0, duration_s=60.0).duration_s == pytest.approx(60.0, abs=1e-12)
