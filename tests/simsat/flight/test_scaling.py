"""A spacecraft scaled exactly, in inertia or in time, flies the same flight in its own units.

Dimensional analysis: without an environment, which has a size of its own, the equations of motion
hold no other scale. So nothing in plant, reader, door, planners and layers may have one either.
MuJoCo bears no number beyond 1e10: time can't be made shorter than 1e-3 of the benchmark's in its
plant (a rotor's acceleration goes with its inverse square, a torque rate with its cube), so the
quickest craft are shown what the benchmark measured instead.
"""

from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

import simsat
from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import nominal
from simsat.control.interface.layers import Pilot
from simsat.control.interface.measurement import History, Measurement
from simsat.control.interface.own_units import InOwnUnits
from simsat.control.interface.plan import Plan
from simsat.control.reference.reference import Inertial
from simsat.flight.controllers import Brief, baseline, build_pilot, choose_supervisor, nmpc_oracle
from simsat.flight.loop import Flight
from simsat.flight.mission import prepare
from simsat.flight.timing import Timing, with_timing
from simsat.settings import FlightSettings
from tests.scaled_cases import scaled_model, scaled_numbers

PERIODS = 50  # a slew and the beginning of the hold
SAME = 1e-6
ALONE = {"gravity_gradient": False, "drag": False}
SIZES = [(1e-6, 1.0), (1e6, 1.0), (1.0, 1e-3), (1.0, 1e6), (3.7, 0.013)]
"""(inertia, time): factors on the benchmark's."""


def flown(
    model: str, controller: Any, inertia: float, time: float, damping: float = 0.0, **settings: Any
) -> tuple[Array, Array, Array]:
    """Attitudes, rates in rad per own second and torques as shares of their limit."""
    spec = scaled_model(model, inertia, time, damping)
    options = {"controller": controller, "environment": ALONE, "angle_deg": 75, **settings}
    timing = simsat.prepare_mission(spec, **options).timing
    mission = simsat.prepare_mission(spec, **options, duration_s=PERIODS * timing.period_s)
    plant = simsat.fly(mission).flight.plant
    limit = plant.model.spacecraft.torque_max
    return plant.attitudes, plant.rates * time, plant.torques / limit


@cache
def benchmark(model: str, controller: Any, damping: float = 0.0, **settings: Any) -> Any:
    return flown(model, controller, 1.0, 1.0, damping, **settings)


def assert_same(expected: Any, found: Any) -> None:
    for one, other in zip(expected, found, strict=True):
        np.testing.assert_allclose(other, one, rtol=0.0, atol=SAME)


@pytest.mark.parametrize(("inertia", "time"), SIZES)
@pytest.mark.parametrize("controller", ["nmpc", "nmpc-learned"])
def test_a_planner_flies_any_size_alike(controller: str, inertia: float, time: float) -> None:
    found = flown("two_wheel", controller, inertia, time)
    assert_same(benchmark("two_wheel", controller), found)
    assert np.abs(found[0] - found[0][0]).max() > 0.3  # it has turned


@pytest.mark.parametrize("controller", ["nmpc", "nmpc-learned"])
def test_viscous_bearings_too(controller: str) -> None:
    expected = benchmark("three_wheel", controller, 1e-5)
    assert_same(expected, flown("three_wheel", controller, 40.0, 55.0, 1e-5))


def watched(brief: Brief) -> Pilot:
    """The baseline with the oracle's correction under the supervisor of the settings."""
    planner = baseline(brief)
    corrector = nmpc_oracle(brief).corrector
    return Pilot(InOwnUnits(planner, brief.units), corrector, choose_supervisor(brief, planner))


@pytest.mark.parametrize("rule", ["faithful", "sound", "value"])
def test_the_layers_above_decide_alike(rule: str) -> None:
    expected = benchmark("two_wheel", watched, supervisor=rule)
    alone = benchmark("two_wheel", "nmpc")
    assert_same(expected, flown("two_wheel", watched, 1e3, 20.0, supervisor=rule))
    assert np.abs(expected[2] - alone[2]).max() > 1e-3  # the correction has acted


def brief_of(controller: str, inertia: float, time: float) -> Brief:
    """The benchmark's brief at another size."""
    mission = prepare(FlightSettings(controller=controller, angle_deg=75.0))
    craft = scaled_numbers(mission.model.spacecraft, inertia, time)
    timing = Timing(craft.own_units, 0.05 * time, 10, 0.5 * time, 200)
    settings = with_timing(mission.settings, timing)
    reference = Inertial(mission.target)
    return Brief(nominal(craft), settings, mission.target, craft, mission.environment, reference)


def shown(told: Measurement, inertia: float, time: float) -> Measurement:
    """What a craft of another size would have measured."""
    h = told.history
    return replace(
        told,
        t=told.t * time,
        omega=told.omega / time,
        wheel_speed=told.wheel_speed / time,
        torque=told.torque * inertia / time**2,
        history=History(h.t * time, h.omega / time, h.wheel_speed / time),
    )


def measured(flight: Flight, k: int) -> Measurement:
    """What was measured at control instant k of a flight without noise."""
    plant, rows = flight.plant, slice(max(10 * (k - 1), 0), 10 * k + 1)
    before = flight.commands[k - 1] if k > 0 else np.zeros(2)
    history = History(plant.log.t[rows], plant.rates[rows], plant.wheel_speeds[rows])
    state = plant.state(10 * k)
    return Measurement(state.t, state.q, state.omega, state.wheel_speed, before, history)


@pytest.mark.parametrize(("inertia", "time"), [(1.0, 1e-6), (1e-6, 1e-6), (1e6, 1e-6), (1e6, 1e6)])
@pytest.mark.parametrize("controller", ["nmpc", "nmpc-learned"])
def test_a_planner_that_is_shown_the_same_commands_the_same(
    controller: str, inertia: float, time: float
) -> None:
    mission = prepare(FlightSettings(controller=controller, angle_deg=75.0, duration_s=10.0))
    flight = mission.fly()
    planner = build_pilot(brief_of(controller, inertia, time)).planner
    memory = None
    for k, step in enumerate(flight.steps):
        plan, memory = planner.plan(shown(measured(flight, k), inertia, time), memory)
        np.testing.assert_allclose(
            plan.torque * time**2 / inertia, step.plan.torque, rtol=0.0, atol=SAME * 0.05
        )
        assert_signals(plan, step.plan, inertia, time)


def assert_signals(found: Plan, expected: Plan, inertia: float, time: float) -> None:
    """Signals are in SI, whatever units the planner works in."""
    units = {"time_to_go_s": time, "unactuated_momentum_Nms": inertia / time}
    close = partial(pytest.approx, rel=SAME, abs=1e-9, nan_ok=True)
    for name, value in expected.signals.items():
        assert found.signals[name] / units.get(name, 1.0) == close(value), name
