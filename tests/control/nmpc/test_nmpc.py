"""The planner: against LQR, at saddles, at limits, from bad starts, and when the solver fails."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternion, Vector3, WheelVector
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.interface.blind import BlindStatus
from simsat.control.interface.measurement import History, Measurement
from simsat.control.nmpc.guess import Guess
from simsat.control.nmpc.planner import (
    Memory,
    Nmpc,
    NmpcSettings,
    PlanStatus,
    build_nmpc,
    damping_torque,
    torque_scale,
)
from simsat.control.solver import SolverSettings, roll_out
from tests.ocp_cases import THREE_WHEELS, TWO_WHEELS, spacecraft

REST = np.array([0.0, 0.0, 0.0])
INTERPRETED = SolverSettings(backend="interpreted")


def measured(
    q: Quaternion,
    omega: Vector3 = REST,
    speed: WheelVector | None = None,
    torque: WheelVector | None = None,
    wheels: int = 2,
) -> Measurement:
    speed = np.zeros(wheels) if speed is None else speed
    torque = np.zeros(wheels) if torque is None else torque
    return Measurement(0.0, q, omega, speed, torque,
                       History(np.zeros(1), omega[None], speed[None]))  # fmt: skip


@pytest.fixture(scope="module")
def planner() -> Nmpc:
    return build_nmpc(TWO_WHEELS, NmpcSettings(), attitude.IDENTITY)


def flown(
    planner: Nmpc, start: Measurement, periods: int, watch: Callable[[Array], None] | None = None
) -> Array:
    """States (periods + 1, nx) when the planner's own model is the plant."""
    states, memory, now = [planner.state(start)], None, start
    for _ in range(periods):
        plan, memory = planner.plan(now, memory)
        x, _ = roll_out(planner.ocp, planner.state(now), _held(planner, plan.torque), np.zeros(3))
        now = measured(attitude.normalized(x[1][:4]), x[1][4:7],
                       x[1][7 : 7 + len(plan.torque)], plan.torque)  # fmt: skip
        states.append(x[1])
    return np.array(states)


def _held(planner: Nmpc, torque: WheelVector) -> Array:
    return np.tile(torque, (planner.ocp.N, 1))


def cost_of_coasting(planner: Nmpc, start: Measurement) -> float:
    nothing, p = np.zeros((planner.ocp.N, planner.ocp.nu)), np.zeros(3)
    return roll_out(planner.ocp, planner.state(start), nothing, p, planner.settings.solver)[1]


def error_deg(states: Array) -> Array:
    return np.degrees(2.0 * np.arctan2(np.linalg.norm(states[:, 1:4], axis=1), states[:, 0]))


def test_the_first_command_is_lqrs_near_the_target() -> None:
    """Fully actuated and 0.1 deg away, no limit matters: the infinite-horizon LQR gain of the
    linearised spacecraft, by SciPy, to 1 %."""
    settings = NmpcSettings(solver=INTERPRETED)
    craft = replace(THREE_WHEELS, torque_rate_max=np.full(3, np.inf))
    planner = build_nmpc(craft, settings, attitude.IDENTITY)
    w, T, inverse = settings.weights, settings.stage, np.linalg.inv(craft.J_hub)
    zero, eye = np.zeros((3, 3)), np.eye(3)
    M = np.block([[zero, eye, zero], [zero, zero, -inverse], [np.zeros((3, 9))]])
    step = expm(T * M)  # state (phi, omega) under a held torque
    A = np.block([[step[:6, :6], np.zeros((6, 3))], [np.zeros((3, 9))]])
    B = np.vstack([step[:6, 6:], eye])
    u2 = 1.0 / 0.05**2
    Q = np.diag([w.attitude] * 3 + [w.rate] * 3 + [w.increment * u2] * 3)
    R, S = (w.effort + w.increment) * u2 * eye, np.zeros((9, 3))
    S[6:] = -w.increment * u2 * eye
    P = solve_discrete_are(A, B, Q, R, s=S)
    gain = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A + S.T)
    rng = np.random.default_rng(0)
    for _ in range(4):
        phi, omega = 1.7e-3 * rng.normal(size=3), 1e-4 * rng.normal(size=3)
        q = attitude.from_axis_angle(phi, float(np.linalg.norm(phi)))
        plan, _ = planner.plan(measured(q, omega, wheels=3), None)
        lqr = -gain @ np.concatenate([phi, omega, np.zeros(3)])
        assert np.linalg.norm(plan.torque - lqr) < 0.01 * np.linalg.norm(lqr)


@pytest.mark.parametrize("seed", range(3))
def test_both_signs_of_a_quaternion_get_the_same_command(planner: Nmpc, seed: int) -> None:
    rng = np.random.default_rng(seed)
    q = attitude.normalized(rng.normal(size=4))
    target = attitude.normalized(rng.normal(size=4))
    turned = replace(planner, target=target)
    omega, speed = 0.05 * rng.normal(size=3), 100.0 * rng.normal(size=2)
    plan, _ = turned.plan(measured(q, omega, speed), None)
    other, _ = turned.plan(measured(-q, omega, speed), None)
    np.testing.assert_array_equal(plan.torque, other.torque)
    third, _ = replace(turned, target=-target).plan(measured(q, omega, speed), None)
    np.testing.assert_array_equal(plan.torque, third.torque)


def test_half_a_turn_is_begun_the_same_way_by_both_signs(planner: Nmpc) -> None:
    """Neither sign is nearer there, and at rest only the first guess chooses a side."""
    q = np.array([0.0, 1.0, 0.0, 0.0])
    plan, _ = planner.plan(measured(q), None)
    other, _ = planner.plan(measured(-q), None)
    assert plan.evidence.guess is Guess.TURN
    np.testing.assert_array_equal(plan.torque, other.torque)


@pytest.mark.parametrize("angle_deg", [75.0, -75.0, 125.0, -125.0, 180.0, -180.0])
def test_rotations_about_the_unactuated_axis_leave_the_saddle(
    planner: Nmpc, angle_deg: float
) -> None:
    """Coasting is stationary there and costs twice the optimum; the target is reached."""
    q = attitude.from_axis_angle(np.array([0.0, 0.0, 1.0]), np.radians(angle_deg))
    plan, _ = planner.plan(measured(q), None)
    coasting = cost_of_coasting(planner, measured(q))
    assert plan.evidence is not None
    assert plan.evidence.guess in (Guess.LOOP_LEFT, Guess.LOOP_RIGHT)
    assert plan.evidence.solution.objective < 0.7 * coasting
    states = flown(planner, measured(q), 160)
    assert error_deg(states)[-1] < 0.5


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (1, 1, 0), (1, -2, 0.5)])
def test_half_a_turn_about_any_axis_reaches_the_target(
    planner: Nmpc, axis: tuple[float, float, float]
) -> None:
    q = attitude.from_axis_angle(np.array(axis, float), np.pi)
    assert error_deg(flown(planner, measured(q), 160))[-1] < 0.5


def test_a_plan_that_went_to_sleep_is_not_believed(planner: Nmpc) -> None:
    """The same saddle met with a previous plan of zeros."""
    q = attitude.from_axis_angle(np.array([0.0, 0.0, 1.0]), 1.0)
    plan, _ = planner.plan(measured(q), Memory(np.zeros((24, 2)), 23))
    assert np.max(np.abs(plan.torque)) > 0.01  # Nm


@pytest.mark.parametrize("seed", range(3))
def test_limits_hold_along_the_plan(seed: int) -> None:
    """Torque and torque rate (here slow enough to bind) to round-off, wheel speed along a flight
    that needs more than there is."""
    rng = np.random.default_rng(seed)
    craft = replace(
        TWO_WHEELS, torque_rate_max=np.full(2, 0.03), speed_max=np.full(2, 60.0)
    )  # Nm/s, rad/s
    planner = build_nmpc(craft, NmpcSettings(solver=INTERPRETED), attitude.IDENTITY)
    q = attitude.from_axis_angle(rng.normal(size=3), 2.0)
    plan, _ = planner.plan(measured(q), None)
    assert plan.evidence is not None
    u = np.vstack([np.zeros(2), plan.evidence.solution.u])
    assert np.max(np.abs(u)) <= 0.05 + 1e-9
    assert np.max(np.abs(np.diff(u, axis=0))) == pytest.approx(0.015, abs=1e-9)  # 0.03 Nm/s * 0.5 s
    speed = plan.evidence.solution.x[:, 7:9]
    assert np.max(np.abs(speed)) == pytest.approx(60.0, abs=1e-6)


def test_a_body_rate_limit_is_kept_when_asked_for() -> None:
    settings = NmpcSettings(keep_rate_below_deg_s=2.0, solver=INTERPRETED)
    q = attitude.from_axis_angle(np.array([1.0, 0.4, 0.2]), 1.5)
    fast = build_nmpc(TWO_WHEELS, NmpcSettings(solver=INTERPRETED), attitude.IDENTITY)
    slow = build_nmpc(TWO_WHEELS, settings, attitude.IDENTITY)
    rates = []
    for planner in (fast, slow):
        plan, _ = planner.plan(measured(q), None)
        assert plan.evidence is not None
        rates.append(np.degrees(np.max(np.abs(plan.evidence.solution.x[:, 4:7]))))
    assert rates[0] > 3.0
    assert rates[1] < 2.0 + 1e-6


def test_wheels_beyond_their_limit_are_brought_back(planner: Nmpc) -> None:
    q = attitude.from_axis_angle(np.array([1.0, 0.4, 0.2]), 0.5)
    plan, _ = planner.plan(measured(q, speed=np.array([660.0, -640.0])), None)
    assert plan.status is PlanStatus.NEAREST_REST
    assert plan.evidence is not None
    assert np.all(np.abs(plan.evidence.solution.x[4:, 7:9]) < 628.3 + 1e-6)


def test_a_tumbling_bus_is_caught(planner: Nmpc) -> None:
    """7 deg/s about axes that wheels can push, the wheels holding the opposite momentum: they give
    it back, and the craft comes to rest at the target."""
    omega = np.radians([5.0, -5.0, 0.0])
    speed = -(TWO_WHEELS.J @ omega)[:2] / TWO_WHEELS.Js
    states = flown(planner, measured(attitude.IDENTITY, omega, speed), 160)
    assert error_deg(states).max() > 9.0
    assert error_deg(states)[-1] < 0.5
    assert np.degrees(np.linalg.norm(states[-1, 4:7])) < 0.1


def test_failures_fly_the_previous_plan_and_then_damp(planner: Nmpc) -> None:
    """A measurement that is not a number fails the solver."""
    blind = measured(np.array([np.nan, 0.0, 0.0, 0.0]), np.array([0.1, 0.0, 0.0]))
    rng = np.random.default_rng(0)
    previous = Memory(0.05 * rng.uniform(-1, 1, (24, 2)), 2)
    plan, memory = planner.plan(blind, previous)
    assert plan.status is PlanStatus.SHIFTED
    np.testing.assert_array_equal(plan.torque, previous.torque[0])
    plan, memory = planner.plan(blind, memory)
    assert plan.status is PlanStatus.SHIFTED
    np.testing.assert_array_equal(plan.torque, previous.torque[1])
    plan, memory = planner.plan(blind, memory)
    assert plan.status is PlanStatus.DAMPING
    assert memory is None
    assert plan.torque[0] > 0.0 == plan.torque[1]
    seeing = measured(attitude.from_axis_angle(np.array([1.0, 1.0, 1.0]), 0.5))
    assert planner.plan(seeing, memory)[0].status is PlanStatus.OPTIMAL


def test_without_a_measurement_the_previous_plan_is_flown_on_and_then_no_torque(
    planner: Nmpc,
) -> None:
    seeing = measured(attitude.from_axis_angle(np.array([1.0, 1.0, 1.0]), 1.5))
    plan, memory = planner.plan(seeing, None)
    ahead = plan.evidence.solution.u
    for k in range(1, planner.settings.horizon):
        plan, memory = planner.fly_on(np.zeros(2), memory)
        assert plan.status is BlindStatus.FLOWN_ON
        assert not plan.failed
        np.testing.assert_array_equal(plan.torque, ahead[k])
    plan, memory = planner.fly_on(np.zeros(2), memory)
    assert plan.status is BlindStatus.NO_TORQUE
    np.testing.assert_array_equal(plan.torque, 0.0)
    assert memory is None
    assert planner.plan(seeing, memory)[0].status is PlanStatus.OPTIMAL


def test_damping_takes_energy_out_of_the_bus() -> None:
    """omega' J omega falls at once, inside the torque limit, on any set of wheels."""
    rng = np.random.default_rng(2)
    for craft in (
        TWO_WHEELS,
        THREE_WHEELS,
        spacecraft(attitude.normalized(rng.normal(size=(4, 3))).T),
    ):
        omega = 0.1 * rng.normal(size=3)
        torque = damping_torque(craft, measured(attitude.IDENTITY, omega, wheels=craft.wheels), 0.5)
        assert np.all(np.abs(torque) <= craft.torque_max)
        assert omega @ (-craft.A @ torque) < 0.0


def test_damping_spares_a_wheel_at_its_limit() -> None:
    measurement = measured(attitude.IDENTITY, np.array([0.1, 0.1, 0.0]), np.array([629.0, -629.0]))
    torque = damping_torque(TWO_WHEELS, measurement, 0.5)
    assert torque[0] == 0.0
    assert torque[1] > 0.0


def test_a_few_iterations_still_fly_a_feasible_plan() -> None:
    settings = NmpcSettings(solver=replace(INTERPRETED, max_iterations=1))
    planner = build_nmpc(TWO_WHEELS, settings, attitude.IDENTITY)
    plan, _ = planner.plan(measured(attitude.from_axis_angle(np.array([1.0, 1.0, 1.0]), 2.0)), None)
    assert plan.status is PlanStatus.UNFINISHED
    assert np.max(np.abs(plan.torque)) <= 0.05


def test_the_residual_torque_is_in_the_prediction() -> None:
    """At the target with a torque on the body, three wheels take it up: u = tau_d, so that the body
    stays; without being told the plan does nothing."""
    tau_d = np.array([4e-4, -3e-4, 2e-4])  # Nm
    planner = build_nmpc(THREE_WHEELS, NmpcSettings(solver=INTERPRETED), attitude.IDENTITY)
    told, _ = planner.plan(measured(attitude.IDENTITY, wheels=3), None, tau_d)
    untold, _ = planner.plan(measured(attitude.IDENTITY, wheels=3), None)
    np.testing.assert_allclose(untold.torque, 0.0, atol=1e-9)
    assert told.evidence is not None
    middle = told.evidence.solution.u[8:16].mean(axis=0)
    np.testing.assert_allclose(middle, tau_d, rtol=0.1)


def axes(wheels: int) -> Array:
    rng = np.random.default_rng(wheels)
    return attitude.normalized(rng.normal(size=(wheels, 3))).T


@pytest.mark.parametrize("wheels", range(1, 7))
def test_any_number_of_skewed_wheels_is_flown(wheels: int) -> None:
    """One period's plan lowers the cost of coasting inside all limits."""
    craft = spacecraft(axes(wheels))
    settings = NmpcSettings(solver=INTERPRETED, horizon=12)
    planner = build_nmpc(craft, settings, attitude.IDENTITY)
    start = measured(attitude.from_axis_angle(np.array([0.3, -1.0, 0.6]), 1.3), wheels=wheels)
    plan, _ = planner.plan(start, None)
    coasting = cost_of_coasting(planner, start)
    assert plan.evidence is not None
    assert plan.evidence.solution.objective < 0.999 * coasting
    assert np.max(np.abs(plan.torque)) <= 0.05


def test_two_skewed_wheels_leave_their_own_saddle() -> None:
    """Axes neither orthogonal nor along the body's: the unactuated direction is their normal."""
    craft = spacecraft(axes(2))
    planner = build_nmpc(craft, NmpcSettings(solver=INTERPRETED), attitude.IDENTITY)
    n = craft.unactuated
    assert n is not None
    start = measured(attitude.from_axis_angle(n, 1.3))
    coasting = cost_of_coasting(planner, start)
    plan, _ = planner.plan(start, None)
    assert plan.evidence is not None
    assert plan.evidence.solution.objective < 0.8 * coasting


def test_a_craft_without_limits_is_scaled_by_what_a_slew_needs() -> None:
    free = np.full(2, np.inf)
    craft: Spacecraft = replace(TWO_WHEELS, torque_max=free, torque_rate_max=free, speed_max=free)
    settings = NmpcSettings(solver=INTERPRETED)
    np.testing.assert_allclose(torque_scale(craft, settings), 4 * 1.6 * (np.pi / 2) / 6.0**2)
    planner = build_nmpc(craft, settings, attitude.IDENTITY)
    assert len(planner.ocp.limits.lower) == 0
    plan, _ = planner.plan(measured(attitude.from_axis_angle(np.array([1.0, 1.0, 1.0]), 1.0)), None)
    assert plan.status is PlanStatus.OPTIMAL
