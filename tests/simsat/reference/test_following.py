"""Flights that follow a reference: what they are judged by, who may fly them, and what is said."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import simsat
from simsat.control.ground import attitude
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.plan import Plan
from simsat.control.reference.reference import Curve
from simsat.flight.mission import prepare
from simsat.mjcf import read_model
from simsat.reference.demand import demand_of, refuse_too_fast, told
from simsat.results.source import read_flight
from tests.places import MODELS

NADIR: dict[str, Any] = {"to": ("nadir",)}


@pytest.fixture(scope="module")
def nadir() -> simsat.FlightResult:
    """Three wheels that know their inertia, from a minute of orbit away."""
    return simsat.fly("three_wheel", reference=NADIR, angle_deg=20.0, duration_s=60.0,
                      nominal={"mismatch": 0.0})  # fmt: skip


def test_three_wheels_follow_nadir(nadir: simsat.FlightResult) -> None:
    """0.063 deg/s would leave 3 degrees a minute behind."""
    error = nadir.table["error_deg"].to_numpy()
    assert nadir.converged
    assert error[-200:].max() < 0.01
    rate = nadir.flight.plant.rates[-1]
    orbit = nadir.mission.environment.orbit
    np.testing.assert_allclose(rate, nadir.mission.reference.rate(60.0), atol=1e-6)
    assert np.linalg.norm(rate) == pytest.approx(2.0 * np.pi / orbit.period, rel=1e-3)


def test_error_and_table_are_about_the_moving_reference(nadir: simsat.FlightResult) -> None:
    q_ref = np.stack([nadir.table[f"q_ref_{part}"].to_numpy() for part in "wxyz"], axis=1)
    t = nadir.table["t_s"].to_numpy()
    np.testing.assert_array_equal(q_ref, nadir.mission.reference.attitude(t))
    apart = np.degrees(attitude.error_angle(nadir.flight.plant.attitudes, q_ref))
    np.testing.assert_array_equal(nadir.table["error_deg"].to_numpy(), apart)
    assert apart[0] == pytest.approx(20.0)  # the flight starts turned away from where it begins
    assert nadir.metrics["final_error_deg"] == apart[-1]


def test_a_sequence_is_judged_target_by_target(tmp_path: Path) -> None:
    path = tmp_path / "targets.csv"
    path.write_text("dwell_s,q_w,q_x,q_y,q_z\n40,1,0,0,0\n40,0.9,0.3,-0.3,0.1\n9,0.8,0.6,0,0\n")
    result = simsat.fly("three_wheel", reference={"to": (str(path),)}, duration_s=89.0)
    targets = result.metrics["targets"]
    assert [target["start_s"] for target in targets] == [0.0, 40.0, 80.0]
    t, error = result.table["t_s"].to_numpy(), result.table["error_deg"].to_numpy()
    for target, last in zip(targets[:2], (40.0, 80.0), strict=True):
        took = target["settling_time_s"]
        assert 3.0 < took < 25.0
        settled = (t >= target["start_s"] + took - 1e-9) & (t < last)
        assert error[settled].max() < 0.5
        assert error[np.argmax(settled) - 1] >= 0.5
    assert targets[2]["settling_time_s"] is None  # nine seconds are too few
    assert result.metrics["share_in_bounds"] < 1.0
    assert result.metrics["largest_excursion_deg"] > 30.0


def test_controllers_that_make_for_one_attitude_say_so_before_the_flight() -> None:
    for name in ("nmpc-pinn", "nmpc-pinn-supervisor", "nmpc-oracle"):
        with pytest.raises(SettingsError, match=f"'{name}' makes for one attitude, --reference na"):
            simsat.prepare_mission("two_wheel", controller=name, reference=NADIR)


def test_a_controller_of_one_s_own_is_told_the_reference() -> None:
    heard = []

    def law(brief: Any) -> Any:
        reference = brief.reference
        assert reference.moving

        def plan(now: Any) -> Plan:
            heard.append((reference.attitude(now.t), reference.rate(now.t)))
            return Plan(np.zeros(2))

        return plan

    simsat.fly(controller=law, reference=NADIR, duration_s=2.0)
    assert len(heard) == 4
    assert heard[0][0].shape == (4,)
    assert np.linalg.norm(heard[0][1]) == pytest.approx(1.1e-3, rel=0.02)


def test_a_reference_travels_with_the_run(tmp_path: Path, nadir: simsat.FlightResult) -> None:
    t = np.arange(0.0, 5.0)
    q = nadir.mission.reference.attitude(t)
    path = tmp_path / "mine.csv"
    np.savetxt(path, np.column_stack([t, q]), delimiter=",", header="t_s,q_w,q_x,q_y,q_z",
               comments="")  # fmt: skip
    flown = simsat.fly("three_wheel", reference={"to": (str(path),)}, duration_s=4.0)
    flown.save(tmp_path / "run")
    path.unlink()
    settings = read_flight(tmp_path / "run")
    assert settings.reference.file == tmp_path / "run" / "files" / "reference.to" / "mine.csv"
    assert simsat.fly(prepare(settings)).table.equals(flown.table)


def spinning(rate: float, wobble: float = 0.0) -> Curve:
    """About body x, with a swing of one rad/s^2 per rad/s."""

    def value(t: Any) -> Any:
        half = 0.5 * (rate * np.asarray(t) + wobble * np.sin(np.asarray(t)))
        return np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], axis=-1)

    def slope(t: Any) -> Any:
        return (value(np.asarray(t) + 1e-6) - value(np.asarray(t) - 1e-6)) / 2e-6

    return Curve(value, slope)


def test_what_following_takes_is_the_craft_s_inertia_times_its_motion() -> None:
    craft = read_model(MODELS / "two_wheel" / "two_wheel.xml").spacecraft
    demand = demand_of(spinning(0.1, 0.02), craft, 100.0)
    assert demand.rate == pytest.approx(0.12, rel=1e-3)
    assert demand.momentum_share[0] == pytest.approx(1.62 * 0.12 / 0.9, rel=1e-3)
    swing = np.sin(0.5) / 0.5  # of the difference that is taken for the acceleration
    assert demand.torque_share[0] > 1.62 * 0.02 * swing / 0.05 * 0.99
    assert demand.unactuated_momentum == pytest.approx(0.05 * 0.12, rel=1e-3)


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        (spinning(0.6), "up to 34.4 deg/s: following takes 1.08 times the momentum that wheel 'wh"),
        (spinning(0.0, 0.05), "times the torque that wheel 'wheel_x' can give"),
    ],
)
def test_a_reference_that_turns_faster_than_the_craft_can_is_refused(
    reference: Curve, message: str
) -> None:
    craft = read_model(MODELS / "two_wheel" / "two_wheel.xml").spacecraft
    with pytest.raises(SettingsError, match=message):
        refuse_too_fast(reference, craft, 100.0)
    refuse_too_fast(spinning(0.1), craft, 100.0)


def test_what_zero_momentum_cannot_follow_is_said_before_the_flight() -> None:
    for name, ending in (
        ("two_wheel", "wheels cannot bring it, and there are no rods"),
        ("two_wheel_rods", "rods have to bring it, with 0.2 A m^2 each"),
    ):
        mission = simsat.prepare_mission(name, reference=NADIR)
        craft = mission.model.spacecraft
        said = told(mission.reference, craft, mission.duration_s)
        assert said.startswith("the reference turns at up to 0.0634 deg/s and takes up to 7.7e-05")
        assert said.endswith(ending)
        across = {"to": ("nadir",), "boresight": (1.0, 0.0, 0.0), "second": (0.0, 1.0, 0.0)}
        mission = simsat.prepare_mission(name, reference=across)
        assert "0.0014 Nms" in told(mission.reference, craft, 100.0)  # J_nn w_orbit
    still = simsat.prepare_mission("two_wheel")
    assert told(still.reference, still.model.spacecraft, 100.0) == ""
