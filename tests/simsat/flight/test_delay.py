"""Commands on their way: when they act, what the controller is told, and what it makes of it."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import simsat
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.foresight import Foresight
from simsat.flight.delay import DelaySettings, empty_line
from simsat.flight.mission import prepare
from simsat.settings import FlightSettings

RAMP = 0.125  # s from rest to the torque limit


class Heard:
    """A control law that asks for a torque of its own each period, and notes what it is told."""

    def __init__(self, brief: Any):
        self.told: list[Any] = []
        HEARD.append(self)

    def __call__(self, measurement: Any) -> Any:
        self.told.append(measurement)
        return np.array([1.0, -1.0]) * (0.01 + 0.002 * (len(self.told) - 1))


HEARD: list[Heard] = []


def flown(**settings: Any) -> tuple[Any, Heard]:
    HEARD.clear()
    flight = simsat.fly("two_wheel", controller=Heard, duration_s=6.0, **settings).flight
    return flight, HEARD[-1]


@pytest.mark.parametrize("delay", [0.05, 0.2, 0.5, 0.6, 1.0])
def test_a_command_acts_so_much_later(delay: float) -> None:
    """The torque is there once its ramp is over, and not before the delay is."""
    flight, _ = flown(delay={"computation_s": delay})
    torque, tick = flight.plant.torques[:, 0], flight.plant.tick
    for k in range(6):
        sent, asked = 0.5 * k, 0.01 + 0.002 * k
        begins = round((sent + delay) / tick)
        assert torque[begins] != pytest.approx(asked, abs=1e-9)
        assert torque[begins + 1] == pytest.approx(asked, abs=1e-9)  # 2 mNm ramp within a sample


def test_computation_and_actuation_add_up() -> None:
    both, _ = flown(delay={"computation_s": 0.2, "actuation_s": 0.15})
    one, _ = flown(delay={"computation_s": 0.35})
    np.testing.assert_array_equal(both.plant.attitudes, one.plant.attitudes)


@pytest.mark.parametrize("delay", [0.2, 0.5, 0.7])
def test_the_controller_is_told_the_state_in_which_its_command_acts(delay: float) -> None:
    flight, heard = flown(
        delay={"computation_s": delay}, nominal={"mismatch": 0.0},
        environment={"drag": False, "gravity_gradient": False},
    )  # fmt: skip
    plant = flight.plant
    for told in heard.told[:10]:
        row = round((told.t + delay) / plant.tick)
        # rad/s: the plant ramps in whole steps of 10 ms, 2 mNm take 5
        np.testing.assert_allclose(told.omega, plant.rates[row], atol=1e-5)
        np.testing.assert_allclose(told.wheel_speed, plant.wheel_speeds[row], atol=5e-3)
        assert abs(abs(told.q @ plant.attitudes[row]) - 1.0) < 1e-10
        sensed = told.sensed
        np.testing.assert_array_equal(sensed.q, plant.attitudes[round(told.t / plant.tick)])
        np.testing.assert_array_equal(sensed.history.omega, told.history.omega)


def test_without_foresight_it_is_told_what_is_past() -> None:
    flight, heard = flown(delay={"computation_s": 0.25, "foresight": False})
    for told in heard.told:
        np.testing.assert_array_equal(told.q, flight.plant.attitudes[round(told.t / 0.05)])


@pytest.mark.parametrize("delay", [0.1, 0.25, 0.5])
def test_the_learned_controller_settles_within_a_tenth_of_no_delay(delay: float) -> None:
    none, late = (
        simsat.fly("two_wheel", controller="nmpc-learned", duration_s=45.0, angle_deg=75.0,
                   delay={"computation_s": seconds}).metrics["settling_time_s"]
        for seconds in (0.0, delay)
    )  # fmt: skip
    assert late < 1.1 * none


def test_without_foresight_a_quarter_of_a_second_more_than_doubles_it() -> None:
    none, late = (
        simsat.fly("two_wheel", controller="nmpc-learned", duration_s=60.0, angle_deg=75.0,
                   delay={"computation_s": seconds, "foresight": False}).metrics["settling_time_s"]
        for seconds in (0.0, 0.25)
    )  # fmt: skip
    assert late is None or late > 2.0 * none


def test_the_line_says_what_is_on_its_way() -> None:
    """Seven ticks of delay, periods of five: a command of two instants ago is acting for two more
    ticks."""
    line = empty_line(7, 5, 1, 0)
    for k in range(1, 5):
        line.send((np.array([float(k)]), np.zeros(0)))
    now = line.transit(0.1)
    assert now.acting == 3.0
    assert [(round(s, 9), float(u[0])) for s, u in now.pending] == [(0.2, 3.0), (0.5, 4.0)]
    assert now.acted == pytest.approx(0.4 * 2.0 + 0.6 * 3.0)


def test_a_delay_is_a_whole_number_of_samples() -> None:
    with pytest.raises(SettingsError, match=r"delay of --delay\.computation-s in --sample-s: 0"):
        prepare(FlightSettings(delay=delay_of(0.07)))
    mission = prepare(FlightSettings(model=Path("two_wheel"), delay=delay_of(0.1)))
    assert mission.pilot is not None
    assert isinstance(mission.pilot.foresight, Foresight)


def delay_of(seconds: float) -> DelaySettings:
    return DelaySettings(computation_s=seconds)
