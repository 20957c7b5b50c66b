"""The filter is right (a batch least squares, a Riccati equation), honest (chi-square over 100
runs), takes late fixes at their own time, and is not led astray."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from simsat.control.estimator.mekf import Mekf
from simsat.control.estimator.propagation import process_noise, propagated, transition
from simsat.control.estimator.state import BIAS, GAIN, TURN, FilterState, first_state
from simsat.control.estimator.update import with_fix, with_sighting
from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import (
    conjugate,
    error_angle,
    multiply,
    rotation_matrix,
    rotation_vector,
    scalar_last,
)
from simsat.control.ground.turn import turned
from simsat.control.interface.measurement import Fix, Measurement, Sighting
from tests.control.estimator.cases import (
    ARCSEC,
    COVARIANCE,
    DEG_H,
    GYRO,
    TICK,
    Case,
    measurement,
    slew,
)


def filtered(told: list[Measurement]) -> list[FilterState]:
    """The estimate after each measurement."""
    mekf, timeline, states = Mekf(GYRO), None, []
    for measured in told:
        _, timeline = mekf.estimate(measured, timeline)
        assert timeline is not None
        states.append(timeline[-1].state)
    return states


def errors(case: Case, state: FilterState) -> Array:
    """The 15 errors."""
    row = round(state.t / TICK)
    turn = rotation_vector(multiply(conjugate(state.q), case.q[row]))
    gain = (case.gain_error - state.gain_error).ravel()
    return np.concatenate([turn, case.bias[row] - state.bias, gain])


def test_the_transition_is_the_slope_of_the_flow() -> None:
    """Central differences of the estimate propagated from 15 neighbours."""
    rng = np.random.default_rng(0)
    reading = np.array([0.3, -0.2, 0.25])
    start = replace(
        first_state(Fix(0.0, np.array([0.5, 0.5, -0.5, 0.5]), COVARIANCE), GYRO),
        bias=1e-3 * rng.standard_normal(3), gain_error=1e-3 * rng.standard_normal((3, 3)),
    )  # fmt: skip
    dt, step = 0.5, 1e-5

    def flow(error: Array) -> tuple[Array, Array, Array]:
        moved = replace(
            start, q=turned(start.q, error[TURN]), bias=start.bias + error[BIAS],
            gain_error=start.gain_error + error[GAIN].reshape(3, 3),
        )  # fmt: skip
        after = propagated(moved, dt, reading, reading, GYRO)
        return after.q, after.bias, after.gain_error

    q0, _, _ = flow(np.zeros(15))
    F = np.zeros((15, 15))
    for k, unit in enumerate(np.eye(15)):
        (qp, bp, ep), (qm, bm, em) = flow(step * unit), flow(-step * unit)
        turn = [rotation_vector(multiply(conjugate(q0), q)) for q in (qp, qm)]
        F[:, k] = np.concatenate([turn[0] - turn[1], bp - bm, (ep - em).ravel()]) / (2.0 * step)
    expected = transition(start.rate(reading), dt)
    np.testing.assert_allclose(expected, F, atol=3e-3 * dt)  # first order in E: 1e-3
    np.testing.assert_allclose(expected[:3, :3], F[:3, :3], atol=1e-8)


def test_the_covariance_settles_where_the_riccati_equation_has_it() -> None:
    """At rest with a fix every 0.5 s; SciPy solves for the covariance before an update."""
    gyro = replace(GYRO, gain_deviation=np.zeros((3, 3)), rate_random_walk=1e-5)
    state = first_state(Fix(0.0, np.array([1.0, 0.0, 0.0, 0.0]), COVARIANCE), gyro)
    nothing = np.array([0.0, 0.0, 0.0])
    for k in range(1, 4001):
        state = propagated(state, 0.1 * k, nothing, nothing, gyro)
        before = state.covariance[:6, :6]
        if k % 5 == 0:
            state = with_fix(state, Fix(state.t, state.q, COVARIANCE))
    H = np.eye(3, 6)
    F = np.linalg.matrix_power(transition(nothing, 0.1), 5)[:6, :6]
    Q, one = np.zeros((6, 6)), transition(nothing, 0.1)[:6, :6]
    for _ in range(5):
        Q = one @ Q @ one.T + process_noise(gyro, 0.1)[:6, :6]
    expected = solve_discrete_are(F.T, H.T, Q, COVARIANCE)
    np.testing.assert_allclose(before, expected, rtol=1e-3, atol=1e-18)


def test_a_batch_least_squares_says_the_same() -> None:
    """All of a slew at once, Gauss-Newton on SciPy's rotations: unknown are the first errors and
    the noise of every step; the last attitude and bias must be the filter's."""
    case = slew(3, seconds=12.0)
    state = filtered(case.measurements())[-1]
    steps, fixes = len(case.t) - 1, case.fixes[1:]
    q0 = Rotation.from_quat(scalar_last(case.fixes[0].q))
    L_first = np.linalg.cholesky(first_state(case.fixes[0], GYRO).covariance)
    L_step = np.linalg.cholesky(process_noise(GYRO, TICK)[:6, :6])
    mean = 0.5 * (case.readings[:-1] + case.readings[1:])

    def flown(x: Array) -> tuple[Array, Rotation, Array]:
        """Whitened residuals of the fixes, last attitudes and biases; x of shape (n, unknowns)."""
        first, noise = x[:, :15] @ L_first.T, x[:, 15:].reshape(len(x), steps, 6) @ L_step.T
        bias, gain = first[:, BIAS], np.eye(3) + first[:, GAIN].reshape(-1, 3, 3)
        now, off = q0 * Rotation.from_rotvec(first[:, TURN]), []
        for k in range(steps):
            omega = np.linalg.solve(gain, (mean[k] - bias)[..., None])[..., 0]
            now = now * Rotation.from_rotvec(omega * TICK) * Rotation.from_rotvec(noise[:, k, :3])
            bias = bias + noise[:, k, 3:]
            for fix in fixes:
                if round(fix.t / TICK) == k + 1:
                    seen = Rotation.from_quat(scalar_last(fix.q))
                    off.append((now.inv() * seen).as_rotvec() / np.sqrt(np.diag(COVARIANCE)))
        return np.concatenate(off, axis=1), now, bias

    x = np.zeros(15 + 6 * steps)
    for _ in range(3):
        step = 1e-2  # of a standard deviation
        up, down = (flown(x + sign * step * np.eye(len(x)))[0] for sign in (1.0, -1.0))
        slope, off = (up - down).T / (2.0 * step), flown(x[None])[0][0]
        stacked = np.vstack([np.eye(len(x)), slope])
        x = x - np.linalg.lstsq(stacked, np.concatenate([x, off]))[0]
    _, now, bias = flown(x[None])
    turn = (now.inv() * Rotation.from_quat(scalar_last(state.q))).as_rotvec()[0]
    sigma = np.sqrt(np.diag(state.covariance))
    assert np.abs(turn / sigma[TURN]).max() < 0.02
    assert np.abs((bias[0] - state.bias) / sigma[BIAS]).max() < 0.02


def test_errors_are_as_large_as_the_covariance_says() -> None:
    """Normalised errors squared over 100 slews with a blackout, within 99.9 % of chi-square
    (Bar-Shalom, Li and Kirubarajan, section 5.4.2)."""
    runs = [
        (case := slew(seed, 14.0, 2.0), filtered(case.measurements(latency=2)))
        for seed in range(100)
    ]
    instants = len(runs[0][1])
    assert any(state.t - state.t_trusted > 5.0 for state in runs[0][1])
    for part, degrees in ((TURN, 3), (slice(0, 6), 6), (slice(0, 15), 15)):
        low, high = chi2.ppf([5e-4, 1.0 - 5e-4], 100 * degrees) / 100.0
        for k in (2, instants // 3, instants // 2, instants - 1):
            nees = []
            for case, states in runs:
                e, P = errors(case, states[k])[part], states[k].covariance[part, part]
                nees.append(float(e @ np.linalg.solve(P, e)))
            assert low < np.mean(nees) < high, (degrees, k)


@pytest.mark.parametrize("latency", [1, 4, 7, 12])
def test_a_late_fix_counts_as_one_of_its_own_time(latency: int) -> None:
    """Once it is there, the estimate is that of a filter that had it at once."""
    case = slew(5, 20.0)
    prompt, late = filtered(case.measurements()), filtered(case.measurements(latency=latency))
    quiet = Case(case.t, case.q, case.bias, case.gain_error, case.readings, case.fixes[:-4])
    prompt, late = filtered(quiet.measurements()), filtered(quiet.measurements(latency=latency))
    assert error_angle(prompt[-1].q, late[-1].q) < 1e-12
    np.testing.assert_allclose(late[-1].bias, prompt[-1].bias, atol=1e-15)
    np.testing.assert_allclose(late[-1].covariance, prompt[-1].covariance, rtol=1e-9, atol=1e-20)


def test_a_fix_between_two_readings_is_placed_between_them() -> None:
    case = slew(6, 12.0)
    k = 60
    early = 0.75 * case.readings[k] + 0.25 * case.readings[k + 1]  # mean rate of the first half
    halfway = turned(case.q[k], 0.5 * TICK * early)
    sharp = 1e-12 * np.eye(3)
    fixes = (*case.fixes[:12], Fix(case.t[k] + 0.05, halfway, sharp))
    states = filtered(replace(case, fixes=fixes).measurements())
    at = next(state for state in states if state.t > case.t[k] + 0.05)
    assert error_angle(at.q, case.q[round(at.t / TICK)]) < 3.0 * GYRO.angle_random_walk


def test_outliers_change_nothing() -> None:
    case = slew(7, 30.0)
    rng = np.random.default_rng(0)
    wrong = tuple(
        replace(f, q=turned(f.q, rng.standard_normal(3) * 0.05)) if k % 6 == 3 else f
        for k, f in enumerate(case.fixes)
    )
    right = tuple(f for k, f in enumerate(case.fixes) if k % 6 != 3)
    with_outliers = filtered(replace(case, fixes=wrong).measurements())[-1]
    without = filtered(replace(case, fixes=right).measurements())[-1]
    np.testing.assert_array_equal(with_outliers.q, without.q)
    np.testing.assert_array_equal(with_outliers.bias, without.bias)


def test_a_filter_that_is_wrong_gives_way_to_its_fixes() -> None:
    """A gyro whose bias jumps by 0.2 deg/s, which is beyond anything the filter allows for."""
    case = slew(8, 40.0)
    jump = np.where(case.t[:, None] > 20.0, np.radians([0.2, 0.0, -0.1]), 0.0)
    states = filtered(replace(case, readings=case.readings + jump).measurements())
    assert error_angle(states[-1].q, case.q[-1]) < 60.0 * ARCSEC
    off = states[-1].bias - case.bias[-1] - jump[-1]
    assert np.abs(off).max() < 30.0 * DEG_H
    at = [error_angle(s.q, case.q[round(s.t / TICK)]) for s in states if s.t > 20.0]
    assert max(at) < np.radians(1.0)


def test_readings_that_are_missing_widen_the_covariance() -> None:
    case = slew(9, 20.0, 2.0)
    told = case.measurements()
    del told[14:16]  # a second of the slew
    states = filtered(told)
    assert states[14].turn_deviation > 3.0 * states[13].turn_deviation
    off = errors(case, states[14])[TURN]
    assert np.linalg.norm(off) < 3.0 * states[14].turn_deviation


def test_before_the_first_fix_nothing_is_changed() -> None:
    case = slew(10, 5.0)
    told = measurement(case.t[:1], case.readings[:1], ())
    out, timeline = Mekf(GYRO).estimate(told, None)
    assert out is told
    assert timeline is None


def test_rates_and_history_are_told_without_bias_and_gain_error() -> None:
    case = slew(11, 40.0)
    mekf, timeline = Mekf(GYRO), None
    for told in case.measurements():
        out, timeline = mekf.estimate(told, timeline)
    assert timeline is not None
    state = timeline[-1].state
    expected = np.linalg.inv(np.eye(3) + state.gain_error) @ (told.omega - state.bias)
    np.testing.assert_allclose(out.omega, expected, atol=1e-15)
    np.testing.assert_allclose(out.history.omega[-1], out.omega, atol=1e-15)
    np.testing.assert_array_equal(out.history.wheel_speed, told.history.wheel_speed)


def test_known_directions_alone_hold_the_attitude() -> None:
    """The Sun and a field line, 0.5 deg each, against a gyro with a bias of 50 deg/h."""
    rng = np.random.default_rng(1)
    case = slew(12, 60.0)
    wild = case.readings + np.radians([0.01, -0.01, 0.005])
    sigma, directions = np.radians(0.5), (np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.6, 0.8]))
    told, bare = [], []
    for measured in replace(case, readings=wild, fixes=case.fixes[:1]).measurements():
        R = rotation_matrix(case.q[round(measured.t / TICK)])
        seen = tuple(
            Sighting(measured.t, unit(R.T @ d + sigma * np.cross(R.T @ d, rng.standard_normal(3))),
                     d, sigma)
            for d in directions
        )  # fmt: skip
        told.append(replace(measured, sightings=seen))
        bare.append(measured)
    gyro = replace(GYRO, bias_deviation=40.0 * DEG_H)
    ends = []
    for series in (told, bare):
        mekf, timeline = Mekf(gyro), None
        for measured in series:
            _, timeline = mekf.estimate(measured, timeline)
        assert timeline is not None
        ends.append(np.degrees(error_angle(timeline[-1].state.q, case.q[-1])))
    assert ends[0] < 0.3
    assert ends[1] > 0.5


def unit(v: Array) -> Array:
    return v / np.linalg.norm(v)


def test_a_sighting_from_behind_is_doubted() -> None:
    state = first_state(Fix(0.0, np.array([1.0, 0.0, 0.0, 0.0]), 1e-2 * np.eye(3)), GYRO)
    x = np.array([1.0, 0.0, 0.0])
    assert with_sighting(state, Sighting(0.0, -x, x, 0.01)) is state
    assert with_sighting(state, Sighting(0.0, x, x, 0.01)) is not state
