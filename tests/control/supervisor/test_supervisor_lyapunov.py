"""V and V' against the derivative of V along the true motion, wheels spinning."""

import numpy as np
import pytest

from simsat.control.supervisor.lyapunov import Energy, energy, energy_rate
from tests.supervisor_cases import fly, random_cases

GAIN = 0.13  # Nm


@pytest.mark.parametrize("form", [Energy.SQUARED, Energy.LINEAR])
def test_the_rate_is_the_derivative_of_the_energy_whatever_the_gyroscopic_torque(
    form: Energy,
) -> None:
    case = random_cases(np.random.default_rng(1), 200)
    torque = -case.u_plan @ case.A.T
    h = 1e-4  # s
    ahead, behind = (
        fly(case, case.u_plan, u_start=case.u_plan, period=t, steps=1) for t in (h, -h)
    )
    change = energy(form, *ahead, case.J_hub, GAIN) - energy(form, *behind, case.J_hub, GAIN)
    rate = energy_rate(form, case.q_BT, case.omega, torque, GAIN)
    assert np.abs(change / (2 * h) - rate).max() < 1e-6 * max(1.0, np.abs(rate).max())


def test_the_printed_variant_pairs_one_energy_with_the_rate_of_the_other() -> None:
    case = random_cases(np.random.default_rng(2), 50)
    state = case.q_BT, case.omega
    printed = energy(Energy.PRINTED, *state, case.J_hub, GAIN)
    np.testing.assert_array_equal(printed, energy(Energy.LINEAR, *state, case.J_hub, GAIN))
    rate = energy_rate(Energy.PRINTED, *state, case.omega, GAIN)
    np.testing.assert_array_equal(rate, energy_rate(Energy.SQUARED, *state, case.omega, GAIN))
    assert np.abs(rate - energy_rate(Energy.LINEAR, *state, case.omega, GAIN)).max() > 1e-3


def test_only_the_squared_energy_is_blind_to_the_quaternion_sign() -> None:
    case = random_cases(np.random.default_rng(3), 50)
    V = {f: energy(f, case.q_BT, case.omega, case.J_hub, GAIN) for f in Energy}
    W = {f: energy(f, -case.q_BT, case.omega, case.J_hub, GAIN) for f in Energy}
    np.testing.assert_array_equal(V[Energy.SQUARED], W[Energy.SQUARED])
    assert (np.abs(V[Energy.LINEAR] - W[Energy.LINEAR]) > 1e-4).all()  # unwinding


def test_the_energy_is_that_of_a_rotor_and_a_spring() -> None:
    half_turn = np.array([0.0, 0.0, 1.0, 0.0])
    omega, J = np.array([0.0, 0.0, 2.0]), np.diag([1.0, 2.0, 3.0])
    assert energy(Energy.SQUARED, half_turn, omega, J, 0.5) == pytest.approx(6.0 + 0.25)
    assert energy(Energy.LINEAR, half_turn, omega, J, 0.5) == pytest.approx(6.0 + 0.5)
