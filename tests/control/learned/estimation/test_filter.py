from dataclasses import replace

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.ground.magnetorquers import Magnetorquers
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.learned.estimation.balance import measurement_noise
from simsat.control.learned.estimation.consistency import consistent, monitored_update
from simsat.control.learned.estimation.estimate import HIDES_TORQUE, ModelEstimate
from simsat.control.learned.estimation.external_torque import PAIRS, torque_map
from simsat.control.learned.estimation.filter import filtered
from simsat.control.learned.estimation.filters import choose_filter
from simsat.control.learned.estimation.prior import initial_estimate
from simsat.control.learned.estimation.samples import Samples, integrate_back, samples_of
from tests.compiler_cases import needs_compiler
from tests.learned_cases import (
    NOMINAL_J,
    SKEWED,
    TARGET,
    TRUE_J,
    Flown,
    craft,
    flown,
    matrix,
    slewing,
    times,
)

Q = np.array([0.8, -0.36, 0.48, 0.0])
NOISE = 1e-6  # rad/s
MU_R3 = 3.0 * 1.226e-6  # 3 mu / r^3, 1/s^2


def samples_from(f: Flown, spacecraft: Spacecraft, noise: float = 0.0, seed: int = 0) -> Samples:
    omega = f.omega + noise * np.random.default_rng(seed).normal(size=f.omega.shape)
    return samples_of(f.q[-1], f.t, omega, f.speed, spacecraft)


def learned(f: Flown, truth: Spacecraft, noise: float = 0.0) -> ModelEstimate:
    nominal = replace(truth, J=NOMINAL_J)
    parts = [slice(k, k + 11) for k in range(0, len(f.t) - 1, 10)]
    rng = np.random.default_rng(1)
    omega = f.omega + noise * rng.normal(size=f.omega.shape)
    start: ModelEstimate | None = None
    estimate: ModelEstimate | None = None
    for part in parts:
        samples = samples_of(f.q[part][-1], f.t[part], omega[part], f.speed[part], nominal)
        start = initial_estimate(nominal, samples, NOISE) if start is None else start
        estimate = start if estimate is None else consistent(start, estimate, samples, NOISE)
        estimate = filtered(estimate, samples, NOISE)
    assert estimate is not None
    return estimate


def five_numbers(J: Array, n: Array | None) -> tuple[Array, Array]:
    """J_bar and r: all that matters at zero momentum (the scale of n'Jn does not)."""
    assert n is not None
    tilt = J @ n / (n @ J @ n)
    return J - np.outer(tilt, tilt) * (n @ J @ n), tilt


@pytest.mark.parametrize("A", [None, SKEWED])
def test_the_inertia_that_matters_is_found_in_two_seconds(A: Array | None) -> None:
    truth = craft(A=A)
    estimate = learned(flown(truth, slewing, times(41), Q), truth)
    for found, true in zip(
        five_numbers(estimate.J, truth.unactuated),
        five_numbers(TRUE_J, truth.unactuated),
        strict=True,
    ):
        assert np.max(np.abs(found - true)) < 2e-4


def test_all_of_the_inertia_is_found_when_the_wheels_turn_every_axis() -> None:
    truth = craft(A=np.eye(3))

    def torque(t: float) -> Array:
        return 0.03 * np.array([np.cos(0.8 * t), np.sin(t), np.cos(0.5 * t + 1.0)])

    estimate = learned(flown(truth, torque, times(81), Q), truth)
    assert np.max(np.abs(estimate.J - TRUE_J)) < 2e-4


def test_with_gyro_noise_the_error_is_small_and_inside_the_covariance() -> None:
    truth = craft()
    f = flown(truth, slewing, times(201), Q)
    estimate = learned(f, truth, noise=1e-4)
    bar, tilt = five_numbers(estimate.J, truth.unactuated)
    true_bar, true_tilt = five_numbers(TRUE_J, truth.unactuated)
    assert np.max(np.abs(bar - true_bar)) < 0.005 * 1.6  # THEORY: 0.26 % in 10 s, 1 sigma
    assert np.max(np.abs(tilt - true_tilt)) < 4e-3
    sigma = np.sqrt(np.diag(estimate.covariance)[[4, 5]]) / estimate.J[2, 2]
    assert np.max(np.abs(tilt - true_tilt)[:2] / sigma) < 4.0
    assert estimate.J[2, 2] == pytest.approx(NOMINAL_J[2, 2], rel=1e-6)  # not pulled to zero


def test_a_stored_momentum_is_found_with_the_inertia() -> None:
    truth = craft()
    f = flown(truth, slewing, times(81), Q, speed0=np.array([120.0, -60.0]))
    true_h = matrix(f.q[0]) @ truth.angular_momentum(f.omega[0], f.speed[0])
    assert np.max(np.abs(learned(f, truth).h_N - true_h)) < 1e-4 * np.linalg.norm(true_h)


def test_a_gravity_gradient_is_linear_in_the_field() -> None:
    nadir = np.array([0.6, 0.0, 0.8])
    S = MU_R3 * np.outer(nadir, nadir)
    field = np.r_[[S[pair] for pair in PAIRS], np.zeros(9)]
    R = matrix(Q)
    nadir_B = R.T @ nadir
    textbook = R @ (MU_R3 * np.cross(nadir_B, TRUE_J @ nadir_B))
    assert np.max(np.abs(torque_map(Q, TRUE_J) @ field - textbook)) < 1e-20


def test_a_force_beside_the_centre_of_mass_is_linear_in_the_field() -> None:
    arm_B, force_N = np.array([0.02, -0.01, 0.03]), np.array([1e-5, -2e-5, 3e-5])
    field = np.r_[np.zeros(6), np.outer(arm_B, force_N).ravel()]
    R = matrix(Q)
    textbook = R @ np.cross(arm_B, R.T @ force_N)
    assert np.max(np.abs(torque_map(Q, TRUE_J) @ field - textbook)) < 1e-20


def test_the_external_torque_at_the_target_is_learned_on_the_way_there() -> None:
    truth, nadir = craft(), np.array([0.6, 0.0, 0.8])
    arm_B, force_N = np.array([0.012, -0.01, 0.012]), np.array([-2e-5, 1e-5, 1.5e-5])

    def external(t: float, R: Array) -> Array:
        o = R.T @ nadir
        return R @ (MU_R3 * np.cross(o, truth.J @ o) + np.cross(arm_B, R.T @ force_N))

    f = flown(truth, slewing, times(321), TARGET, external_N=external)
    estimate = learned(f, truth)
    n = np.array([0.0, 0.0, 1.0])
    there = f.q[-1]
    R = matrix(there)
    found, true = estimate.external_torque(there), external(0.0, R)
    assert abs(n @ R.T @ (found - true)) < 0.1 * np.linalg.norm(true)
    h = R @ truth.angular_momentum(f.omega[-1], f.speed[-1])
    assert abs(n @ R.T @ (estimate.h_N - h)) < 0.05 * np.linalg.norm(h)


@needs_compiler
@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_in_c_it_is_what_numpy_says(noise: float) -> None:
    """Over a slew with stored momentum, a wobble, and a rest."""
    truth = craft()

    def torque(t: float) -> Array:
        return slewing(t) if t < 12.0 else np.zeros(2)

    f = flown(truth, torque, times(321), Q, speed0=np.array([20.0, -10.0]))
    wobble = 1e-4 * np.sin(7.0 * f.t)[:, None] * np.array([1.0, -0.7, 0.5])
    rate = f.omega + wobble + noise * np.random.default_rng(1).normal(size=f.omega.shape)
    nominal = replace(truth, J=NOMINAL_J)
    histories = []
    for backend in ("auto", "interpreted"):
        chosen = choose_filter(backend)
        history: list[ModelEstimate] = []
        assert (chosen is filtered) == (backend == "interpreted")
        start: ModelEstimate | None = None
        for k in range(0, 320, 10):
            part = slice(k, k + 11)
            samples = samples_of(f.q[part][-1], f.t[part], rate[part], f.speed[part], nominal)
            start = start or initial_estimate(nominal, samples, NOISE)
            before = history[-1] if history else start
            history.append(monitored_update(start, before, samples, NOISE, chosen))
        histories.append(history)
    for compiled, interpreted in zip(*histories, strict=True):
        scale = np.sqrt(np.diag(interpreted.covariance)) + 1e-30
        assert np.max(np.abs(compiled.mean - interpreted.mean) / scale) < 1e-6  # of a sigma
        assert np.max(np.abs(compiled.J - interpreted.J)) < 1e-9
        assert np.max(np.abs(compiled.h_N - interpreted.h_N)) < 1e-9
        apart = (compiled.covariance - interpreted.covariance) / np.outer(scale, scale)
        assert np.max(np.abs(apart)) < 1e-6
        assert np.max(np.abs(compiled.deflection - interpreted.deflection)) < 1e-9
        assert compiled.t == interpreted.t
        assert compiled.restarts == interpreted.restarts
        assert np.max(np.abs(compiled.torque_map - interpreted.torque_map)) < 1e-9


def test_noise_is_told_from_motion() -> None:
    truth = craft()
    f = flown(truth, slewing, times(401), Q)
    quiet, noisy = (
        measurement_noise(TRUE_J, samples_from(f, truth, noise), 1e-9) for noise in (0.0, 1e-4)
    )
    size = np.linalg.norm(truth.J) / np.sqrt(3.0)  # sigma of J w, per axis
    assert quiet < 1e-6
    assert noisy == pytest.approx(1e-4 * size, rel=0.1)


def test_attitudes_are_integrated_back_from_the_rates() -> None:
    f = flown(craft(), slewing, times(11), Q, omega0=np.array([0.05, 0.1, -0.08]))
    back = integrate_back(f.q[-1], f.t, f.omega)
    assert np.max(np.abs(back - f.q)) < 2e-6


def test_external_torque_is_relied_upon_only_where_little_swings() -> None:
    truth = craft()
    known = learned(flown(truth, slewing, times(101), Q), truth)
    assert known.torque_confidence > 0.999
    half = replace(known, flexibility=HIDES_TORQUE)
    assert half.torque_confidence == pytest.approx(0.5)
    assert replace(known, flexibility=1e-3).torque_confidence < 1e-3  # panels


def test_the_torque_of_rods_is_known_and_taken_for_no_other() -> None:
    truth = replace(
        craft(), rods=Magnetorquers(("rod",), np.array([[0.6], [0.0], [0.8]]), np.ones(1))
    )
    B_N, dipole = np.array([2e-5, -3e-5, 1e-5]), np.array([20.0])  # a hundred times a real rod's

    def rods(t: float, R: Array) -> Array:
        return np.cross(R @ truth.rods.moment(dipole), B_N)

    f = flown(truth, slewing, times(201), Q, external_N=rods)
    true_h = matrix(f.q[-1]) @ truth.angular_momentum(f.omega[-1], f.speed[-1])
    errors = []
    for moment in (truth.rods.moment(dipole), None):
        estimate = start = None
        for part in (slice(k, k + 11) for k in range(0, 200, 10)):
            q = f.q[part][-1]
            samples = samples_of(
                q, f.t[part], f.omega[part], f.speed[part], replace(truth, J=NOMINAL_J),
                moment, matrix(q).T @ B_N,
            )  # fmt: skip
            start = start or initial_estimate(replace(truth, J=NOMINAL_J), samples, NOISE)
            estimate = filtered(estimate or start, samples, NOISE)
        assert estimate is not None
        outside = float(np.linalg.norm(estimate.external_torque(f.q[-1])))
        errors.append((float(np.linalg.norm(estimate.h_N - true_h)), outside))
    told, untold = errors
    assert told[0] < 2e-5
    assert told[1] < 5e-6
    assert untold[0] > 1e-3
