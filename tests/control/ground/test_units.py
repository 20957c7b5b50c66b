"""A craft's own units: what they are, that they are consistent, and that they change no motion."""

from dataclasses import dataclass
from typing import Annotated

import casadi as ca
import numpy as np
import pytest

from simsat.control.ground.own import Own, in_units, own, resolved
from simsat.control.ground.settings import Positive, Settings
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.ground.units import Units, units_for
from simsat.control.interface.measurement import History, Measurement
from simsat.control.interface.plan import Plan
from simsat.control.model.dynamics import build_dynamics
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS

HUBBLE = Units(55.0, 5e4)


def shipped(name: str) -> Spacecraft:
    return read_model(MODELS / name / f"{name}.xml").spacecraft


@pytest.mark.parametrize("name", ["two_wheel", "two_wheel_friction", "two_wheel_skewed"])
def test_the_benchmark_is_its_own_unit(name: str) -> None:
    assert shipped(name).own_units == Units(1.0, 1.0)  # to the last bit: numbers stay as they were


def test_the_natural_time_is_the_root_of_inertia_over_torque() -> None:
    """Hubble of 42's demo: J 73,267 kg m^2 and 0.82 Nm make T0 = 299 s."""
    units = units_for(73_267.0, 0.82)
    assert units.natural_time == pytest.approx(np.sqrt(73_267.0 / 0.82), rel=1e-8)
    assert units.torque * 0.05 == pytest.approx(0.82, rel=1e-8)  # as the benchmark's in its own


def test_without_a_torque_limit_the_own_second_is_the_second() -> None:
    assert units_for(14.6, np.inf) == Units(1.0, 10.0)


def test_motion_is_the_same_in_own_units() -> None:
    """The equations of motion in both: rates of change, converted, agree."""
    craft, u = shipped("two_wheel_friction"), HUBBLE
    rng = np.random.default_rng(0)
    q, omega, speed = rng.normal(size=4), rng.normal(size=3), 300.0 * rng.normal(size=2)
    torque = 0.05 * rng.normal(size=2)
    rates = build_dynamics(craft)(np.concatenate([q, omega, speed]), torque, np.zeros(3))
    own_state = np.concatenate([q, omega / u.rate, speed / u.rate])
    own_rates = build_dynamics(craft.in_units(u))(own_state, torque / u.torque, np.zeros(3))
    scale = np.repeat([1.0 / u.time, u.rate / u.time], (4, 5))
    np.testing.assert_allclose(np.array(own_rates).ravel() * scale, ca.DM(rates).full().ravel(),
                               rtol=1e-10)  # fmt: skip


def test_every_number_of_a_spacecraft_is_converted_and_comes_back() -> None:
    craft = shipped("two_wheel_friction")
    there = craft.in_units(HUBBLE)
    assert there.coulomb == pytest.approx(craft.coulomb * 55.0**2 / 5e4)  # Nm
    assert there.viscous == pytest.approx(craft.viscous * 55.0 / 5e4)  # Nms/rad
    assert there.torque_rate_max == pytest.approx(craft.torque_rate_max * 55.0**3 / 5e4)  # Nm/s
    assert there.momentum_max == pytest.approx(craft.momentum_max * 55.0 / 5e4)  # Nms
    back = there.in_units(HUBBLE.back)
    for name in ("J", "Js", "torque_max", "torque_rate_max", "speed_max", "viscous", "coulomb"):
        np.testing.assert_allclose(getattr(back, name), getattr(craft, name), rtol=1e-14)


def test_a_measurement_is_converted() -> None:
    omega, speed, torque = np.array([0.1, 0.2, 0.3]), np.array([10.0, 20.0]), np.array([5.0, -5.0])
    history = History(np.array([109.0, 110.0]), np.tile(omega, (2, 1)), np.tile(speed, (2, 1)))
    told = Measurement(110.0, np.array([1.0, 0.0, 0.0, 0.0]), omega, speed, torque, history)
    there = told.in_units(HUBBLE)
    assert there.t == pytest.approx(2.0)
    assert there.omega == pytest.approx(55.0 * omega)  # a rad in an own second is slower
    assert there.torque == pytest.approx(torque * 55.0**2 / 5e4)
    np.testing.assert_allclose(there.history.t, [109.0 / 55.0, 2.0])
    np.testing.assert_allclose(there.history.wheel_speed, 55.0 * history.wheel_speed)


def test_a_plan_leaves_in_si_by_the_units_in_its_signals_names() -> None:
    signals = {
        "time_to_go_s": 2.0,
        "unactuated_momentum_Nms": 1.0,
        "phi_n_deg": 3.0,
        "filter_restarts": 4.0,
        "rate_deg_s": 55.0,
    }
    plan = Plan(np.array([1.0]), signals=signals).in_units(HUBBLE.back)
    assert plan.torque == pytest.approx(5e4 / 55.0**2)
    assert plan.signals == pytest.approx(
        {
            "time_to_go_s": 110.0,
            "unactuated_momentum_Nms": 5e4 / 55.0,
            "phi_n_deg": 3.0,
            "filter_restarts": 4.0,
            "rate_deg_s": 1.0,
        }
    )


@dataclass(frozen=True)
class Inner(Settings, group="inner"):
    hold_s: Annotated[Positive | None, Own("time", 80.0)] = None
    limit_deg_s: Annotated[Positive | None, Own("rate")] = None
    share: float = 0.5


@dataclass(frozen=True)
class Outer(Settings):
    inner: Inner = Inner()


def test_a_setting_that_is_not_given_stands_for_so_many_own_units() -> None:
    asked = Outer()
    assert own(asked.inner, "hold_s") == 80.0
    assert resolved(asked, HUBBLE).inner == Inner(80.0 * 55.0, None, 0.5)
    assert in_units(asked, HUBBLE) == asked


def test_a_setting_that_is_given_is_in_si() -> None:
    asked = Outer(Inner(hold_s=110.0, limit_deg_s=2.0))
    assert resolved(asked, HUBBLE) == asked
    there = in_units(asked, HUBBLE)
    assert own(there.inner, "hold_s") == pytest.approx(2.0)
    assert there.inner.limit_deg_s == pytest.approx(110.0)
    assert there.inner.share == 0.5
