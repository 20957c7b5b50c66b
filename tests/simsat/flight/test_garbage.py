"""Garbage from the sensors costs the periods it lasts, whatever it is, and leaves no trace."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from simsat.control.correction.corrector import ResidualCorrector
from simsat.control.ground.arrays import WheelVector
from simsat.control.interface.blind import BlindStatus
from simsat.control.interface.layers import Pilot
from simsat.control.interface.measurement import History, Measurement
from simsat.flight.loop import Ending, Flight, fly, sense_truth
from simsat.flight.mission import Mission, Plugins, prepare
from simsat.results.metrics import judge
from simsat.results.summary import result_table
from simsat.settings import FlightSettings
from tests.door_cases import PILOTS, Damage, flown_with, mission_of, numbers_in, spoilt

QUICK = settings(
    max_examples=6, deadline=None, derandomize=True,
    suppress_health_check=list(HealthCheck),
)  # fmt: skip
THOROUGH = settings(QUICK, max_examples=60)
PERIODS = 24  # 12 s of each flight

SENSED = ("t", "q", "omega", "wheel_speed", "torque")
NOT_NUMBERS = (np.nan, np.inf, -np.inf)


def nothing(measurement: Measurement) -> Measurement:
    """All NaN."""
    h = measurement.history
    unknown = {name: np.full_like(getattr(measurement, name), np.nan) for name in SENSED[1:]}
    history = History(h.t * np.nan, h.omega * np.nan, h.wheel_speed * np.nan)
    return replace(measurement, t=np.nan, history=history, **unknown)


def component(name: str, place: int, value: float) -> Damage:
    return lambda measurement: spoilt(measurement, name, place, value)


def scaled(factor: float) -> Damage:
    return lambda measurement: replace(measurement, q=factor * measurement.q)


def late(by: float) -> Damage:
    return lambda measurement: replace(measurement, t=measurement.t + by)


def cut(name: str) -> Damage:
    return lambda measurement: replace(measurement, **{name: getattr(measurement, name)[1:]})


REFUSED: st.SearchStrategy[Damage] = st.one_of(
    st.builds(component, st.sampled_from(SENSED), st.integers(0, 3), st.sampled_from(NOT_NUMBERS)),
    st.builds(component, st.sampled_from(["omega", "wheel_speed"]), st.integers(0, 2),
              st.floats(1e6, 1.7e308) | st.floats(-1.7e308, -1e6)),
    st.builds(scaled, st.floats(0.0, 0.999) | st.floats(1.001, 1e300)),
    st.builds(late, st.floats(0.01, 1e12) | st.floats(-1e12, -0.01)),
    st.builds(cut, st.sampled_from(SENSED[1:])),
)  # fmt: skip
"""What the door can tell from a measurement."""

BELIEVED: st.SearchStrategy[Damage] = st.one_of(
    st.builds(component, st.just("omega"), st.integers(0, 2), st.floats(-900.0, 900.0)),
    st.builds(component, st.just("wheel_speed"), st.integers(0, 1), st.floats(-9e4, 9e4)),
    st.builds(component, st.just("torque"), st.integers(0, 1), st.floats(-1e9, 1e9)),
    st.builds(
        component, st.sampled_from(["history.t", "history.omega", "history.wheel_speed"]),
        st.integers(0, 2), st.floats(allow_nan=True, allow_infinity=True),
    ),
)  # fmt: skip
"""What it can't, and unsound samples between the control instants."""

WINDOW = st.builds(lambda first, n: range(first, first + n), st.integers(0, 12), st.integers(1, 8))


def check_commands(mission: Mission, steps: tuple[Any, ...]) -> None:
    commands = np.array([step.command for step in steps])
    assert np.isfinite(commands).all()
    assert (np.abs(commands) <= mission.model.spacecraft.torque_max).all()


def check_memories(memories: tuple[Any, ...]) -> None:
    broken = {place for m in memories for place, x in numbers_in(m) if not np.isfinite(x).all()}
    assert not broken


def garbage_does_not_matter(pilot: str, damage: Damage, window: range) -> None:
    """Two kinds of garbage at the same instants make the same flight, bit for bit."""
    mission = mission_of(pilot)
    flown = flown_with(mission, damage, window, PERIODS)
    blind = flown_with(mission, nothing, window, PERIODS)
    refused = [k for k, step in enumerate(flown.steps) if step.refusal is not None]
    assert refused == [k for k in window if k < PERIODS]
    check_commands(mission, flown.steps)
    check_memories(flown.memories)
    for step, other in zip(flown.steps, blind.steps, strict=True):
        np.testing.assert_array_equal(step.command, other.command)


def nothing_poisons(pilot: str, damage: Damage, window: range) -> None:
    """Not even what is believed."""
    mission = mission_of(pilot)
    flown = flown_with(mission, damage, window, PERIODS)
    check_commands(mission, flown.steps)
    check_memories(flown.memories)


@pytest.mark.parametrize("pilot", PILOTS)
@given(damage=REFUSED, window=WINDOW)
@QUICK
def test_what_the_garbage_is_does_not_matter(pilot: str, damage: Damage, window: range) -> None:
    garbage_does_not_matter(pilot, damage, window)


@pytest.mark.parametrize("pilot", PILOTS)
@given(damage=BELIEVED, window=WINDOW)
@QUICK
def test_what_is_believed_does_not_poison(pilot: str, damage: Damage, window: range) -> None:
    nothing_poisons(pilot, damage, window)


@pytest.mark.slow
@pytest.mark.parametrize("pilot", PILOTS)
@given(damage=REFUSED, window=WINDOW)
@THOROUGH
def test_no_kind_of_garbage_matters(pilot: str, damage: Damage, window: range) -> None:
    garbage_does_not_matter(pilot, damage, window)


@pytest.mark.slow
@pytest.mark.parametrize("pilot", PILOTS)
@given(damage=BELIEVED, window=WINDOW)
@THOROUGH
def test_nothing_believed_poisons(pilot: str, damage: Damage, window: range) -> None:
    nothing_poisons(pilot, damage, window)


@pytest.mark.parametrize("pilot", PILOTS)
def test_a_flight_converges_after_the_garbage(pilot: str) -> None:
    """Ten seconds of it in the middle of the slew: the 10 s, and at most half a minute to undo the
    drift of flying blind."""
    mission = mission_of(pilot)
    clean, flown = (
        settling_s(flown_with(mission, nothing, window, mission.periods).error_deg)
        for window in (range(0), range(5, 25))
    )
    assert flown < clean + 10.0 + 30.0


def test_the_learned_course_is_flown_on() -> None:
    """The torques that were planned at the last measurement, one by one."""
    flown = flown_with(mission_of("nmpc-learned"), nothing, range(6, 12), 12)
    ahead = flown.steps[5].plan.evidence.torque
    commands = np.array([step.command for step in flown.steps[6:]])
    np.testing.assert_array_equal(commands, ahead[1:7])


def settling_s(error_deg: Any) -> float:
    return 0.05 * (1 + np.flatnonzero(error_deg >= 0.5)[-1])


@pytest.mark.parametrize("pilot", PILOTS)
def test_one_bad_first_measurement_costs_one_period(pilot: str) -> None:
    """The craft starts at rest, so that the same flight begins half a second later."""
    mission = mission_of(pilot)
    clean = flown_with(mission, nothing, range(0), 8)
    late = flown_with(mission, nothing, range(1), 9)
    assert late.steps[0].plan.status is BlindStatus.NO_TORQUE
    np.testing.assert_array_equal(late.steps[0].command, 0.0)
    first, second = clean.steps[0].plan.torque, late.steps[1].plan.torque
    np.testing.assert_allclose(second, first, atol=2e-3)  # Nm; 0.5 s of drag lie between


def test_metrics_count_what_was_refused_and_say_nothing_without(two_wheel: Any) -> None:
    mission = mission_of("nmpc-pinn-supervisor, sound", 10.0)
    told = judge(flown_mission(mission, lambda k: k in (3, 4, 11)), mission.target)
    assert told["measurements_refused"] == 3
    assert told["refusals"] == {"not_finite": 3}
    assert told["solver_failures"] == 0
    assert "measurements refused  3 of 20" in result_table(told)
    clean = judge(flown_mission(mission, lambda k: False), mission.target)
    assert not {"measurements_refused", "refusals"} & set(clean)


def flown_mission(mission: Mission, bad: Callable[[int], bool]) -> Flight:
    instants = 0

    def sense(plant: Any, samples: int, torque: WheelVector) -> Measurement:
        nonlocal instants
        instants += 1
        told = sense_truth(plant, samples, torque)
        return nothing(told) if bad(instants - 1) else told

    assert mission.pilot is not None
    return fly(mission.build_plant(), mission.pilot, mission.periods, 10, sense)


def test_sensors_that_stay_dead_end_no_flight() -> None:
    mission = mission_of("nmpc-learned", 40.0)
    flight = flown_mission(mission, lambda k: k > 10)
    assert flight.ending is Ending.COMPLETE
    assert flight.steps[-1].plan.status is BlindStatus.NO_TORQUE


def test_a_controller_of_ones_own_never_sees_garbage() -> None:
    heard: list[Measurement] = []

    def make(brief: Any) -> Callable[[Measurement], WheelVector]:
        def law(measurement: Measurement) -> WheelVector:
            heard.append(measurement)
            return np.full(2, 0.01)

        return law

    plugins = Plugins(controller=make)
    mission = prepare(FlightSettings(duration_s=5.0, controller="own:law"), plugins=plugins)
    flight = flown_mission(mission, lambda k: k in (0, 4, 5))
    assert len(heard) == 7
    check_memories(tuple(heard))
    assert [float(step.command[0]) for step in flight.steps[3:7]] == [0.01, 0.0, 0.0, 0.01]


class Now:
    """An estimator whose answers are given beforehand."""

    def __init__(self, answers: list[float]):
        self.answers, self.previous = answers, list[float]()

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        self.previous.append(float(previous[0]))
        return np.full(2, self.answers[len(self.previous) - 1])


@pytest.mark.parametrize("supervised", [True, False])
@pytest.mark.parametrize("bad", NOT_NUMBERS)
def test_an_answer_that_is_no_number_is_left_out_and_forgotten(
    bad: float, supervised: bool
) -> None:
    mission = mission_of("nmpc-pinn-supervisor, sound", 4.0)
    assert mission.pilot is not None
    assert isinstance(mission.pilot.corrector, ResidualCorrector)
    estimator = Now([0.001, bad, 0.002, 0.003, bad, bad, 0.001, 0.001])
    pilot = Pilot(
        mission.pilot.planner,
        replace(mission.pilot.corrector, estimator=estimator),
        mission.pilot.supervisor if supervised else None,
    )
    flight = fly(mission.build_plant(), pilot, 8, 10)
    assert flight.ending is Ending.COMPLETE
    assert estimator.previous == [0.0, 0.001, 0.0, 0.002, 0.003, 0.0, 0.0, 0.001]
    for k in (1, 4, 5):
        np.testing.assert_array_equal(flight.commands[k], flight.steps[k].plan.torque)
    assert judge(flight, mission.target)["corrections_not_finite"] == 3
