"""Bad networks fail the way their names say, and the supervisors keep them from mattering."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from simsat.bad_network_study import (
    StudySettings,
    fly_with,
    prepare_with,
    study,
    table_md,
)
from simsat.bad_networks.estimators import (
    Adversarial,
    Constant,
    Flipped,
    LateCorrector,
    NotFinite,
    Random,
    Stuck,
)
from simsat.control.correction.corrector import CorrectionSettings, ResidualCorrector
from simsat.control.ground.arrays import WheelVector
from simsat.control.ground.attitude import (
    IDENTITY,
    error_angle,
    error_quaternion,
    from_axis_angle,
    multiply,
)
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.layers import Correction
from simsat.control.interface.measurement import History, Measurement
from simsat.control.interface.plan import Plan
from simsat.control.model.rates import build_rate_model
from simsat.control.nmpc.planner import NmpcSettings, PlanStatus, build_nmpc
from simsat.control.supervisor.lyapunov import Energy, energy
from simsat.control.supervisor.supervisors import (
    FaithfulSupervisor,
    SoundSupervisor,
    ValueSupervisor,
)
from simsat.flight.controllers import Brief, choose_supervisor
from simsat.flight.loop import within_limits
from simsat.flight.mission import prepare
from simsat.results.metrics import judge
from simsat.results.pictures.summary_picture import draw_summary, save_picture
from simsat.settings import FlightSettings
from tests.supervisor_cases import PERIOD, craft

SPACECRAFT = craft(np.diag([1.5, 1.6, 1.2]), np.eye(3)[:, :2])
STILL = History(np.zeros(1), np.array([[0.0, 0.0, 0.0]]), np.zeros((1, 2)))
NO_PLAN = Plan(np.zeros(2), PlanStatus.OPTIMAL)


def at(t: float, angle: float = 1.0) -> Measurement:
    q = from_axis_angle(np.array([1.0, 0.5, 0.2]), angle)
    return Measurement(t, q, np.array([0.03, -0.02, 0.0]), np.zeros(2), np.zeros(2), STILL)


@dataclass(frozen=True)
class Clock:
    """An estimator that answers the time."""

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        return np.full(2, measurement.t / 1000.0)


def ask(estimator: object, t: float, previous: float = 0.0) -> WheelVector:
    return estimator.estimate(at(t), np.array([0.01, 0.0]), np.full(2, previous))  # type: ignore


def test_each_fails_in_its_own_way() -> None:
    np.testing.assert_array_equal(ask(Flipped(Clock()), 2.0), [-2e-3, -2e-3])
    np.testing.assert_array_equal(ask(Constant(0.015), 2.0), [0.015, 0.015])
    np.testing.assert_array_equal(ask(Stuck(Clock(), 5.0), 4.5), [4.5e-3, 4.5e-3])
    np.testing.assert_array_equal(ask(Stuck(Clock(), 5.0), 5.0, 4.5e-3), [4.5e-3, 4.5e-3])
    assert np.isnan(ask(NotFinite(), 2.0)).all()


def test_noise_repeats_with_its_seed_and_fills_its_range() -> None:
    draws = np.array([ask(Random(0.015), 0.5 * k) for k in range(400)])
    np.testing.assert_array_equal(ask(Random(0.015), 7.5), draws[15])
    assert np.abs(draws).max() <= 0.015
    assert draws.min() < -0.014 < 0.014 < draws.max()
    assert (ask(Random(0.015, seed=1), 7.5) != draws[15]).all()


def test_the_adversary_finds_the_worst_corner() -> None:
    model, now, torque = (
        build_rate_model(SPACECRAFT, friction=False),
        at(0.0),
        np.array([0.01, 0.0]),
    )
    rate_max = SPACECRAFT.torque_rate_max
    adversary = Adversarial(model, rate_max, IDENTITY, 0.015, PERIOD)
    chosen = adversary.estimate(now, torque, np.zeros(2))
    # The error grows fastest when the hub is pushed along it, and the hub feels -A u.
    np.testing.assert_array_equal(chosen, [-0.015, -0.015])


def test_the_late_one_answers_a_period_later_and_keeps_its_switch() -> None:
    inner = ResidualCorrector(Clock(), CorrectionSettings(), IDENTITY)
    late, memory = LateCorrector(inner), None
    torques = []
    for t in (1.0, 1.5, 2.0):
        correction, memory = late.correct(at(t), NO_PLAN, memory)
        torques.append(float(correction.torque[0]))
    assert torques == pytest.approx([0.0, 1e-3, 1.5e-3])


def test_the_supervisor_sees_a_correction_that_the_wheels_can_give() -> None:
    plan = replace(NO_PLAN, torque=np.array([0.045, -0.02]))
    asked = Correction(np.array([0.015, 0.01]), np.zeros(2), True)
    limited = within_limits(asked, plan, SPACECRAFT)
    np.testing.assert_allclose(limited.torque, [0.005, 0.01])
    assert limited.active
    for share in (0.0, 0.3, 1.0):
        assert (np.abs(plan.torque + share * limited.torque) <= 0.05).all()


@pytest.mark.parametrize(
    ("rule", "kind"),
    [("faithful", FaithfulSupervisor), ("sound", SoundSupervisor), ("value", ValueSupervisor)],
)
def test_the_settings_choose_the_supervisor(rule: str, kind: type) -> None:
    settings = replace(FlightSettings(), supervisor=rule)  # type: ignore[arg-type]
    mission = prepare(settings)
    truth, world = mission.model.spacecraft, mission.environment
    brief = Brief(SPACECRAFT, settings, IDENTITY, truth, world, mission.reference)
    planner = build_nmpc(SPACECRAFT, NmpcSettings(), IDENTITY)
    assert isinstance(choose_supervisor(brief, planner), kind)


def test_a_saturated_network_ruins_the_flight_unless_it_is_supervised() -> None:
    settings = FlightSettings(axis=(1.0, 1.0, 0.3), angle_deg=60.0)
    alone = fly_with(settings, "constant", "none")
    assert not alone["converged"]
    assert alone["final_error_deg"] > 1.0
    watched = fly_with(settings, "constant", "sound")
    assert watched["converged"]
    assert watched["corrections_attenuated"] > 0
    assert watched["corrections_rejected"] > 0


@pytest.mark.parametrize("network", ["adversarial", "constant"])
def test_the_sound_promise_holds_in_mujoco(network: str) -> None:
    """V of the true spacecraft, a period after every step that let some of the network act."""
    settings = FlightSettings(axis=(1.0, 1.0, 0.3), angle_deg=100.0, duration_s=40.0)
    mission = prepare_with(settings, network, "sound")
    flight = mission.fly()
    craft, gain = mission.model.spacecraft, settings.sound.gain
    rows = slice(None, None, mission.ticks_per_period)
    q, omega = flight.plant.attitudes[rows], flight.plant.rates[rows]
    V = energy(Energy.SQUARED, error_quaternion(q, mission.target), omega, craft.J_hub, gain)
    acted = np.array([step.verdict is not None and step.verdict.alpha > 0 for step in flight.steps])
    assert acted.sum() > 10
    assert (np.diff(V)[acted] <= 0.0).all()
    assert (np.diff(V)[~acted] > 0.0).any()  # the plan's own rises are not its business


def test_nan_changes_nothing_supervised_or_not() -> None:
    settings = FlightSettings(axis=(1.0, 1.0, 0.3), angle_deg=60.0, duration_s=20.0)
    plain, watched = (fly_with(settings, network, "sound") for network in ("nmpc", "not a number"))
    assert watched["final_error_deg"] == plain["final_error_deg"]
    assert watched["verdict_reasons"] == {"not_finite": watched["corrections_active"]}
    alone = fly_with(settings, "not a number", "none")
    assert alone["final_error_deg"] == plain["final_error_deg"]
    assert alone["corrections_not_finite"] == alone["control_steps"]


def test_metrics_and_picture_show_what_the_supervisor_did(tmp_path: Path) -> None:
    settings = FlightSettings(axis=(1.0, 1.0, 0.3), angle_deg=60.0, duration_s=5.0)
    mission = prepare_with(settings, "oracle", "value")
    flight = mission.fly()
    metrics = judge(flight, mission.target)
    counts = [metrics[f"corrections_{d}"] for d in ("accepted", "attenuated", "rejected")]
    assert sum(counts) == metrics["corrections_active"] == 10
    assert sum(metrics["verdict_reasons"].values()) == 10
    assert 0.0 <= metrics["model_health"] <= 1.0
    verdicts = [step.verdict for step in flight.steps]
    mean = np.mean([verdict.alpha for verdict in verdicts if verdict is not None])
    assert metrics["mean_alpha"] == pytest.approx(mean)
    save_picture(draw_summary(flight, mission), tmp_path / "summary.png")
    assert (tmp_path / "summary.png").stat().st_size > 50_000


def test_the_study_writes_its_table_and_picture(tmp_path: Path) -> None:
    out = tmp_path / "study"
    assert study(StudySettings(out, attitudes=1, networks=("flipped",), rules=("sound",))) == 0
    rows = json.loads((out / "results.json").read_text())
    assert [row["network"] for row in rows] == ["nmpc", "nmpc, start 0.1 deg further", "flipped"]
    assert (out / "picture.png").stat().st_size > 10_000
    assert "| flipped | sound | " in (out / "table.md").read_text()


def test_the_table_counts_what_a_network_cost() -> None:
    def row(network: str, attitude: int, converged: bool, final: float) -> dict[str, object]:
        return {
            "network": network,
            "rule": "none",
            "attitude": attitude,
            "converged": converged,
            "final_error_deg": final,
            "steady_state_rmse_deg": 0.1 if converged else None,
            "settling_time_s": 40.0 if converged else None,
        }

    plain = [row("nmpc", 0, True, 0.1), row("nmpc", 2, True, 0.2), row("nmpc", 4, False, 0.6)]
    bad = [row("x", 0, True, 0.05), row("x", 2, False, 3.0), row("x", 4, False, 0.7)]
    line = table_md([*plain, *bad]).splitlines()[3]
    assert line == "| x | none | 1 / 3 | 1 | 1.250 / 3.000 | +2.800 | 0.100 | 40.0 | none |"


def test_unknown_networks_and_counts_are_refused() -> None:
    with pytest.raises(SettingsError, match=r"no bad network 'evil'; there are: oracle, flipped"):
        StudySettings(networks=("evil",))
    with pytest.raises(SettingsError, match="--attitudes must be 1 to 100, got 0"):
        StudySettings(attitudes=0)


def test_the_adversary_knows_the_sense_of_the_error() -> None:
    """After its torque the error is larger than after the opposite one."""
    model, now = build_rate_model(SPACECRAFT, friction=False), at(0.0, angle=0.5)
    adversary = Adversarial(model, SPACECRAFT.torque_rate_max, IDENTITY, 0.015, PERIOD)
    corner = adversary.estimate(now, np.zeros(2), np.zeros(2))
    push = -SPACECRAFT.A @ corner / np.diag(SPACECRAFT.J)
    worse, better = (
        error_angle(multiply(now.q, from_axis_angle(sign * push, 1e-3)), IDENTITY)
        for sign in (1, -1)
    )
    assert worse > better
