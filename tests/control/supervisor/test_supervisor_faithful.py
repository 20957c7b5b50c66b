"""The paper's rule: its closed form, and the hole in it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simsat.control.interface.verdict import Decision, Reason
from simsat.control.supervisor.faithful import FaithfulSettings, faithful_alpha, supervise_faithful
from simsat.control.supervisor.lyapunov import Energy, dot, energy, energy_rate
from tests.supervisor_cases import fly, random_cases

PAPER = FaithfulSettings()


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_closed_form_agrees_with_a_search_over_alpha(seed: int) -> None:
    """100 draws of 100 cases, a tenth of the rates and of the powers exactly zero."""
    rng = np.random.default_rng(seed)
    sign = rng.choice([1.0, -1.0, 0.0], (2, 100), p=[0.45, 0.45, 0.1])
    rate, power = sign * 10.0 ** rng.uniform(-6, 0, (2, 100))
    grid = np.linspace(0.0, 1.0, 1001)
    found = np.where(rate[:, None] - 2.0 * grid * power[:, None] <= 0.0, grid, 0.0).max(axis=1)
    alpha = faithful_alpha(rate, power)
    assert (alpha >= found - 1e-12).all()
    assert (alpha <= found + 1e-3 + 1e-12).all()  # the grid's step


def test_what_it_accepts_passes_its_own_test_and_no_larger_share_would() -> None:
    case = random_cases(np.random.default_rng(4), 10_000)
    plan, correction = -case.u_plan @ case.A.T, -case.u_correction @ case.A.T
    rate = energy_rate(Energy.SQUARED, case.q_BT, case.omega, plan, PAPER.gain)
    alpha = faithful_alpha(rate, dot(case.omega, correction))

    def tested(share: np.ndarray) -> np.ndarray:
        torque = plan - 2.0 * share[:, None] * correction
        return energy_rate(Energy.SQUARED, case.q_BT, case.omega, torque, PAPER.gain)

    assert (tested(alpha)[alpha > 0] <= 1e-15).all()
    attenuated = (alpha > 0) & (alpha < 1)
    assert attenuated.sum() > 200
    assert (tested(alpha + 1e-6)[attenuated] > 0).all()


def test_a_correction_it_accepts_in_full_may_still_add_energy() -> None:
    """The hole: the torque that acts is +alpha tau_corr, the torque that is tested -2 alpha."""
    q_BT, J = np.array([1.0, 0.0, 0.0, 0.0]), np.diag([1.6, 1.5, 1.3])
    omega, plan = np.array([0.05, 0.0, 0.0]), np.array([0.01, 0.0, 0.0])
    correction = np.array([0.012, 0.0, 0.0])
    verdict = supervise_faithful(q_BT, omega, plan, correction, J, PAPER)
    assert verdict.decision is Decision.ACCEPTED
    assert verdict.rate_bound < 0.0  # what it believes
    applied = energy_rate(Energy.SQUARED, q_BT, omega, plan + correction, PAPER.gain)
    assert applied == pytest.approx(0.05 * 0.022)  # what happens, W


def test_the_hole_is_met_by_chance_too_and_the_energy_does_rise_over_the_period() -> None:
    case = random_cases(np.random.default_rng(5), 4000)
    rate = energy_rate(Energy.SQUARED, case.q_BT, case.omega, -case.u_plan @ case.A.T, 0.1)
    alpha = faithful_alpha(rate, dot(case.omega, -case.u_correction @ case.A.T))
    u = case.u_plan + alpha[:, None] * case.u_correction
    before = energy(Energy.SQUARED, case.q_BT, case.omega, case.J_hub, 0.1)
    after = energy(Energy.SQUARED, *fly(case, u, u_start=u), case.J_hub, 0.1)
    full = alpha == 1.0
    risen = full & (after > before)
    assert risen.sum() > 0.02 * full.sum()


def decide(plan: float, correction: float) -> tuple[Decision, Reason]:
    """At q_0 = 1 with a rate of 0.1 rad/s along x, so that V' = 0.1 tau_x."""
    verdict = supervise_faithful(
        np.array([1.0, 0.0, 0.0, 0.0]),
        np.array([0.1, 0.0, 0.0]),
        np.array([plan, 0.0, 0.0]),
        np.array([correction, 0.0, 0.0]),
        np.eye(3),
        PAPER,
    )
    assert 0.0 <= verdict.alpha <= 1.0
    return verdict.decision, verdict.reason


def test_the_verdict_names_its_reason() -> None:
    assert decide(-0.02, 0.01) == (Decision.ACCEPTED, Reason.SAFE)
    assert decide(-0.01, -0.01) == (Decision.ATTENUATED, Reason.LIMITED)
    assert decide(0.01, -0.01) == (Decision.REJECTED, Reason.PLAN_RISES)
    assert decide(-0.02, np.nan) == (Decision.REJECTED, Reason.NOT_FINITE)
    assert decide(-0.02, np.inf) == (Decision.REJECTED, Reason.NOT_FINITE)


def test_the_verdict_reports_the_energy_and_its_rate() -> None:
    q_BT = np.array([np.cos(0.5), 0.0, np.sin(0.5), 0.0])
    verdict = supervise_faithful(
        q_BT,
        np.array([0.0, 0.2, 0.0]),
        np.array([0.0, 0.0, 0.0]),
        np.array([0.0, 0.0, 0.0]),
        np.diag([1.0, 2.0, 3.0]),
        PAPER,
    )
    k = PAPER.gain
    assert verdict.certificate == pytest.approx(0.04 + 0.5 * k * np.sin(0.5) ** 2)
    # The error grows: q_0 q_v'w > 0, so V' > 0 without torque.
    assert verdict.rate == pytest.approx(0.25 * k * np.sin(1.0) * 0.2)
