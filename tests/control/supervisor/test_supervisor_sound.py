"""The sound rule keeps its promise on the true motion, and its closed form is the largest share."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simsat.control.ground.arrays import Array, WheelVector
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.verdict import Decision, Reason, Verdict
from simsat.control.supervisor.lyapunov import Energy, dot, energy, energy_rate
from simsat.control.supervisor.sound import (
    PlantBounds,
    SoundSettings,
    build_plant_bounds,
    margin,
    sound_alpha,
    sound_share,
    supervise_sound,
    worst_power,
)
from tests.supervisor_cases import (
    DELTA,
    DISTURBANCE,
    PERIOD,
    RATE_MAX,
    Cases,
    craft,
    fly,
    random_cases,
)

RULE = SoundSettings(inertia_uncertainty=DELTA, disturbance_max=DISTURBANCE)


def bounds_of(case: Cases) -> PlantBounds:
    """The rule is told the nominal inertia only."""
    return build_plant_bounds(craft(case.J_nominal, case.A, case.Js), RULE, PERIOD)


def shares(case: Cases) -> Array:
    moment = case.q_BT, case.omega, case.wheel_speed
    torques = case.u_prev, case.u_plan, case.u_correction
    return sound_share(*moment, *torques, bounds_of(case), RULE).alpha


def supervised(case: Cases, i: int, bounds: PlantBounds) -> Verdict:
    """The rule on case i."""
    moment = case.q_BT[i], case.omega[i], case.wheel_speed[i]
    torques = case.u_prev[i], case.u_plan[i], case.u_correction[i]
    return supervise_sound(*moment, *torques, bounds, RULE)


def rise(case: Cases, u: WheelVector) -> Array:
    """V one period later minus V now, J, on the true spacecraft, ramp and disturbance included."""
    k = RULE.gain
    before = energy(Energy.SQUARED, case.q_BT, case.omega, case.J_hub, k)
    after = fly(case, u, u_start=case.u_prev, disturbance=DISTURBANCE)
    return energy(Energy.SQUARED, *after, case.J_hub, k) - before


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), wheels=st.integers(1, 4), s=st.floats(-2.0, 1.0))
def test_no_accepted_correction_ever_raises_the_energy_over_a_period(
    seed: int, wheels: int, s: float
) -> None:
    """20 spacecraft, 500 moments and true inertias each; at s = -2, s = 1 and an s between."""
    case = random_cases(np.random.default_rng(seed), 500, wheels)
    alpha = shares(case)
    accepted = alpha > 0.0
    for factor in (RULE.s_lo, s, RULE.s_hi):
        u = case.u_plan + factor * alpha[:, None] * case.u_correction
        assert (rise(case, u)[accepted] <= 0.0).all()


def test_the_promise_is_not_empty_and_the_margin_is_needed() -> None:
    case = random_cases(np.random.default_rng(7), 3000)
    alpha = shares(case)
    assert (alpha > 0.0).sum() > 150
    assert ((alpha > 0.0) & (alpha < 1.0)).sum() > 20
    # Without sigma (V' <= 0 at the period's start alone) the energy does rise.
    plan, correction = -case.u_plan @ case.A.T, -case.u_correction @ case.A.T
    rate = energy_rate(Energy.SQUARED, case.q_BT, case.omega, plan, RULE.gain)
    power = worst_power(dot(case.omega, correction), RULE)
    naive = sound_alpha(rate, power, np.zeros((3000, 3)))[:, None]
    risen = rise(case, case.u_plan + naive * case.u_correction) > 1e-6  # J
    assert (risen & (naive[:, 0] > 0.0)).sum() > 100


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), power_zero=st.booleans(), kept=st.integers(0, 7))
def test_the_closed_form_agrees_with_a_search_over_alpha(
    seed: int, power_zero: bool, kept: int
) -> None:
    """100 draws of 100 cases; some coefficients exactly zero."""
    rng = np.random.default_rng(seed)
    rate = -(10.0 ** rng.uniform(-6, 0, 100)) * rng.choice([1.0, -1.0, 0.0], 100, p=[0.8, 0.1, 0.1])
    power = (0.0 if power_zero else 1.0) * 10.0 ** rng.uniform(-6, 0, 100)
    sigma = 10.0 ** rng.uniform(-6, 0, (100, 3)) * [bool(kept & bit) for bit in (1, 2, 4)]
    grid = np.linspace(0.0, 1.0, 1001)
    c0, c1, c2 = (sigma[:, [i]] for i in range(3))
    g = rate[:, None] + power[:, None] * grid + c0 + c1 * grid + c2 * grid**2
    found = np.where(g <= 0.0, grid, 0.0).max(axis=1)
    alpha = sound_alpha(rate, power, sigma)
    assert (alpha >= found - 1e-9).all()
    assert (alpha <= found + 1e-3 + 1e-9).all()  # the grid's step


@pytest.mark.parametrize("power", [-0.3, 0.0, 0.3])
def test_the_worst_power_is_that_of_the_worst_factor(power: float) -> None:
    searched = max(s * power for s in np.linspace(RULE.s_lo, RULE.s_hi, 301))
    assert worst_power(np.array(power), RULE) == pytest.approx(searched, abs=1e-15)


def written_out(case: Cases, i: int, alpha: float, bounds: PlantBounds) -> float:
    """sigma(alpha) of the proof, each line spelled out in scalars."""
    k, Ts, D = RULE.gain, PERIOD, bounds.disturbance
    w = float(np.sqrt(sum(x * x for x in case.omega[i])))
    prev, plan, corr = case.u_prev[i], case.u_plan[i], case.u_correction[i]
    norm_A = float(np.sqrt(np.linalg.eigvalsh(case.A.T @ case.A)[-1]))

    def torque(share: float) -> float:
        first = np.sqrt(sum(max(abs(a), abs(b)) ** 2 for a, b in zip(prev, plan, strict=True)))
        return norm_A * float(first + 2.0 * share * np.sqrt(sum(x * x for x in corr)))

    lo, hi = bounds.hub_min, bounds.hub_max
    W = np.sqrt(hi / lo) * w + Ts * (torque(1.0) + D) / lo
    H = case.J_nominal @ case.omega[i] + case.A @ (case.Js * case.wheel_speed[i])
    h = np.linalg.norm(H) + DELTA * np.linalg.eigvalsh(case.J_nominal)[-1] * w + Ts * D
    T = torque(alpha)
    F_rate = (T + D + W * h) / lo * (T + k / 4) + k / 4 * W**2
    ramps = sum(
        (abs(b - a) + 2.0 * alpha * abs(c)) ** 2 / (2.0 * RATE_MAX)
        for a, b, c in zip(prev, plan, corr, strict=True)
    )
    return float(Ts / 2 * F_rate + W * ramps / Ts + W * D)


def test_the_margin_is_the_one_of_the_proof() -> None:
    case = random_cases(np.random.default_rng(8), 40, wheels=3)
    bounds = bounds_of(case)
    for i in range(40):
        moment = case.omega[i], case.wheel_speed[i]
        torques = case.u_prev[i], case.u_plan[i], case.u_correction[i]
        sigma = margin(*moment, *torques, bounds, RULE)
        assert (sigma >= 0.0).all()
        for alpha in (0.0, 0.3, 1.0):
            mine = float(sigma @ [1.0, alpha, alpha**2])
            assert mine == pytest.approx(written_out(case, i, alpha, bounds), rel=1e-9)


def test_the_verdict_is_about_the_torque_that_wheels_put_on_the_hub() -> None:
    case = random_cases(np.random.default_rng(11), 300)
    plan, correction = -case.u_plan @ case.A.T, -case.u_correction @ case.A.T
    bounds = bounds_of(case)
    for i in range(300):
        verdict, k = supervised(case, i, bounds), RULE.gain

        def rate(torque: Array, i: int = i, k: float = k) -> float:
            return float(energy_rate(Energy.SQUARED, case.q_BT[i], case.omega[i], torque, k))

        assert verdict.rate == pytest.approx(rate(plan[i]))
        worst = max(
            rate(plan[i] + s * verdict.alpha * correction[i]) for s in (RULE.s_lo, RULE.s_hi)
        )
        expected = worst + written_out(case, i, verdict.alpha, bounds)
        assert verdict.rate_bound == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_the_bounds_hold_over_the_inertia_set_and_are_met_on_its_edge() -> None:
    for seed in range(20):
        case = random_cases(np.random.default_rng(seed), 300)
        bounds, rotors = bounds_of(case), case.Js * case.A @ case.A.T
        moments = np.linalg.eigvalsh(case.J_hub)
        assert bounds.hub_min <= moments[:, 0].min() + 1e-12
        assert moments[:, 2].max() <= bounds.hub_max + 1e-12
        spread = np.linalg.norm(case.J - case.J_nominal, 2, axis=(1, 2))
        assert spread.max() <= bounds.J_spread + 1e-12
        low, high = (f * case.J_nominal - rotors for f in (1 - DELTA, 1 + DELTA))
        assert bounds.hub_min == pytest.approx(np.linalg.eigvalsh(low)[0])
        assert bounds.hub_max == pytest.approx(np.linalg.eigvalsh(high)[2])


def test_wheels_without_a_torque_rate_limit_need_no_margin_for_ramps() -> None:
    J, A = np.diag([1.5, 1.6, 1.2]), np.eye(3)[:, :2]
    jump = build_plant_bounds(
        replace(craft(J, A), torque_rate_max=np.full(2, np.inf)), RULE, PERIOD
    )
    ramp = build_plant_bounds(craft(J, A), RULE, PERIOD)
    moment = np.array([0.05, 0.0, 0.0]), np.zeros(2), np.array([-0.05, 0.0])
    torques = np.array([0.05, 0.0]), np.array([0.01, 0.0])
    assert np.isfinite(margin(*moment, *torques, jump, RULE)).all()
    assert (margin(*moment, *torques, jump, RULE) < margin(*moment, *torques, ramp, RULE)).all()


def decide(plan: float, correction: float) -> tuple[Decision, Reason]:
    """A braking slew about x at 0.1 rad/s; wheel torque u pushes the hub by -u."""
    J, A = np.diag([1.5, 1.6, 1.2]), np.eye(3)[:, :2]
    verdict = supervise_sound(
        np.array([1.0, 0.0, 0.0, 0.0]),
        np.array([0.1, 0.0, 0.0]),
        np.zeros(2),
        np.array([plan, 0.0]),
        np.array([plan, 0.0]),
        np.array([correction, 0.0]),
        build_plant_bounds(craft(J, A), RULE, PERIOD),
        RULE,
    )
    if verdict.alpha > 0.0:
        assert verdict.rate_bound <= 1e-15  # W, round-off
    return verdict.decision, verdict.reason


def test_the_verdict_names_its_reason() -> None:
    assert decide(0.04, 0.001) == (Decision.ACCEPTED, Reason.SAFE)
    assert decide(0.04, 0.015) == (Decision.ATTENUATED, Reason.LIMITED)
    assert decide(-0.04, 0.015) == (Decision.REJECTED, Reason.PLAN_RISES)
    assert decide(0.04, np.nan) == (Decision.REJECTED, Reason.NOT_FINITE)


def test_settings_that_would_void_the_promise_are_refused() -> None:
    with pytest.raises(SettingsError, match=r"--sound\.s-hi is 0\.5: give .* from 1 up$"):
        SoundSettings(s_hi=0.5)
    with pytest.raises(SettingsError, match=r"is 1: give a finite number from 0 to below 1$"):
        SoundSettings(inertia_uncertainty=1.0)
    A = np.eye(3)[:, :2]
    heavy = craft(np.diag([1.5, 1.6, 1.2]), A, Js=1.0)
    with pytest.raises(SettingsError, match=r"0\.5 allows a hub without inertia: take less"):
        build_plant_bounds(heavy, replace(RULE, inertia_uncertainty=0.5), PERIOD)
    endless = replace(craft(np.eye(3), A), viscous=np.full(2, 2e-6), speed_max=np.full(2, np.inf))
    with pytest.raises(SettingsError, match="wheel without a speed limit"):
        build_plant_bounds(endless, RULE, PERIOD)


def test_friction_at_full_speed_widens_the_disturbance() -> None:
    A = np.eye(3)[:, :1]
    rubbing = replace(craft(np.eye(3), A), coulomb=np.array([1e-3]), viscous=np.array([2e-6]))
    bounds = build_plant_bounds(rubbing, RULE, PERIOD)
    assert bounds.disturbance == pytest.approx(1e-5 + 1e-3 + 2e-6 * 628.3)
