"""The door: what is refused and why, what passes as it is, and what is left out of a history."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simsat.control.ground.attitude import from_axis_angle
from simsat.control.interface.blind import BlindStatus, no_correction, plan_blind
from simsat.control.interface.door import RATE_MAX, Refusal, admit
from simsat.control.interface.measurement import History, Measurement
from simsat.control.interface.plan import Plan
from tests.door_cases import spoilt

PERIOD, CLOCK = 0.5, 7.0
SENSED = ("t", "q", "omega", "wheel_speed", "torque")


def measured(t: float = CLOCK) -> Measurement:
    """A sound one: eleven samples of a body that turns."""
    times = t - PERIOD + 0.05 * np.arange(11.0)
    omega = 0.01 + 1e-3 * np.outer(times, [1.0, -2.0, 0.5])
    speed = np.outer(times, [3.0, -5.0])
    q = from_axis_angle(np.array([0.3, -0.8, 0.5]), 0.1 * t)
    return Measurement(t, q, omega[-1], speed[-1], np.array([0.01, -0.02]),
                       History(times, omega, speed))  # fmt: skip


def asked(measurement: Measurement, last: Measurement | None = None) -> Measurement | Refusal:
    return admit(measurement, CLOCK, PERIOD, last, 2)


def test_a_sound_measurement_passes_as_it_is() -> None:
    """The very same object, so that no number can change."""
    now = measured()
    assert asked(now) is now
    assert asked(now, measured(CLOCK - PERIOD)) is now
    first = replace(now, history=History(*(x[-1:] for x in vars(now.history).values())))
    assert asked(first) is first


@given(
    name=st.sampled_from(SENSED),
    component=st.integers(0, 3),
    value=st.sampled_from([np.nan, np.inf, -np.inf]),
)
def test_what_is_not_finite_is_refused(name: str, component: int, value: float) -> None:
    assert asked(spoilt(measured(), name, component, value)) is Refusal.NOT_FINITE


@pytest.mark.parametrize(
    ("changes", "refusal"),
    [
        ({"q": np.zeros(4)}, Refusal.NO_ATTITUDE),
        ({"q": np.array([1.0, 1.0, 0.0, 0.0])}, Refusal.NO_ATTITUDE),
        ({"q": np.array([1.0 + 2e-6, 0.0, 0.0, 0.0])}, Refusal.NO_ATTITUDE),
        ({"q": np.full(4, 1e200)}, Refusal.NO_ATTITUDE),
        ({"q": np.full(4, 1e-200)}, Refusal.NO_ATTITUDE),
        ({"q": np.array([1.0, 0.0, 0.0])}, Refusal.INCOMPLETE),
        ({"q": None}, Refusal.INCOMPLETE),
        ({"q": np.array(["1", "0", "0", "0"])}, Refusal.INCOMPLETE),
        ({"t": None}, Refusal.INCOMPLETE),
        ({"omega": np.zeros(0)}, Refusal.INCOMPLETE),
        ({"omega": np.zeros((3, 3))}, Refusal.INCOMPLETE),
        ({"wheel_speed": np.zeros(3)}, Refusal.INCOMPLETE),
        ({"torque": np.zeros(3)}, Refusal.INCOMPLETE),
        ({"omega": np.array([0.0, 1e300, 0.0])}, Refusal.IMPOSSIBLE),
        ({"omega": np.array([0.0, 0.0, -1.001 * RATE_MAX])}, Refusal.IMPOSSIBLE),
        ({"wheel_speed": np.array([0.0, 1e6])}, Refusal.IMPOSSIBLE),
        ({"t": CLOCK - PERIOD}, Refusal.WRONG_TIME),
        ({"t": CLOCK + 2e-3}, Refusal.WRONG_TIME),
        ({"t": -1e300}, Refusal.WRONG_TIME),
    ],
)
def test_what_cannot_be_is_refused(changes: dict[str, Any], refusal: Refusal) -> None:
    assert asked(replace(measured(), **changes)) is refusal


def test_a_history_that_does_not_fit_is_refused() -> None:
    now = measured()
    short = replace(now.history, omega=now.history.omega[1:])
    assert asked(replace(now, history=short)) is Refusal.INCOMPLETE


def test_single_precision_and_a_millisecond_of_jitter_pass() -> None:
    now = measured()
    rough = replace(now, q=now.q.astype(np.float32).astype(float), t=CLOCK - 0.9e-3)
    assert isinstance(asked(rough), Measurement)


def test_what_repeats_while_the_body_turns_is_stuck() -> None:
    """At rest the same numbers come again and are true."""
    last = measured(CLOCK - PERIOD)
    stuck = replace(last, t=CLOCK)
    assert asked(stuck, last) is Refusal.STUCK
    assert asked(replace(stuck, q=measured().q), last) is not Refusal.STUCK
    still = replace(last, omega=np.array([0.0, 0.0, 0.0]))
    assert asked(replace(still, t=CLOCK), still) is not Refusal.STUCK


@given(
    name=st.sampled_from(["history.t", "history.omega", "history.wheel_speed"]),
    rows=st.sets(st.integers(0, 10)),
    value=st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1e300]),
)
def test_an_unsound_sample_is_left_out_of_the_history(
    name: str, rows: set[int], value: float
) -> None:
    now, inner = measured(), name.removeprefix("history.")
    history = {key: x.copy() for key, x in vars(now.history).items()}
    history[inner][list(rows)] = value
    seen = asked(replace(now, history=History(**history)))
    assert isinstance(seen, Measurement)
    sound = [k for k in range(11) if k not in rows]
    if sound:
        np.testing.assert_array_equal(seen.history.t, now.history.t[sound])
        np.testing.assert_array_equal(seen.history.omega, now.history.omega[sound])
        np.testing.assert_array_equal(seen.history.wheel_speed, now.history.wheel_speed[sound])
    else:  # the current sample stands in
        np.testing.assert_array_equal(seen.history.omega, [now.omega])
        assert seen.history.t == [CLOCK]


def test_samples_that_go_back_in_time_are_left_out() -> None:
    now = measured()
    t = now.history.t.copy()
    t[[3, 7]] = t[[2, 1]]
    seen = asked(replace(now, history=replace(now.history, t=t)))
    assert isinstance(seen, Measurement)
    np.testing.assert_array_equal(seen.history.t, np.delete(now.history.t, [3, 7]))


def test_a_planner_that_plans_no_further_gets_no_torque() -> None:
    class Law:
        def plan(self, measurement: Measurement, memory: Any) -> tuple[Plan, Any]:
            raise AssertionError("asked without a measurement")

    plan, memory = plan_blind(Law(), np.array([0.03, -0.01]), "kept")
    assert plan.torque.tolist() == [0.0, 0.0]
    assert (plan.status, plan.failed, memory) == (BlindStatus.NO_TORQUE, False, "kept")
    assert no_correction(2).torque.tolist() == [0.0, 0.0]


def test_every_refusal_is_a_sentence() -> None:
    for sentence in (*(refusal.value for refusal in Refusal), *BlindStatus):
        assert sentence[0].isupper()
        assert sentence.endswith(".")


@pytest.mark.parametrize(
    "field", [np.full(3, np.nan), np.zeros(2), np.full(3, 1.0), np.array(["a", "b", "c"])]
)
def test_a_field_that_cannot_be_is_left_out_and_the_rest_is_believed(field: Any) -> None:
    told = replace(measured(), field_B=field)
    admitted = asked(told)
    assert isinstance(admitted, Measurement)
    assert admitted.field_B is None
    kept = replace(measured(), field_B=np.array([2e-5, -3e-5, 1e-5]))
    admitted = asked(kept)
    assert isinstance(admitted, Measurement)
    assert admitted.field_B is kept.field_B
