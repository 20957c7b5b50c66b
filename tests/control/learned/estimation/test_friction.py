from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.learned.estimation.friction import (
    FrictionEstimate,
    friction_update,
    momentum_scatter,
    no_friction,
)
from simsat.control.model.momentum import spin_momentum
from simsat.control.model.ramp import ramped_impulse
from tests.learned_cases import craft, flown, ramped, times

COULOMB, VISCOUS = 1e-3, 2e-6
RATE = np.full(2, 0.4)  # Nm/s


def test_the_impulse_of_a_ramped_torque() -> None:
    plan, before = np.array([[0.05, -0.02]]), np.array([-0.05, 0.01])
    torque = ramped(plan, before, 0.4, 0.5)
    exact = [
        quad(lambda t, j=j: torque(t)[j], 0, 0.4999999, points=[0.075, 0.25])[0] for j in (0, 1)
    ]
    assert np.max(np.abs(ramped_impulse(plan[0], before, RATE, 0.5) - exact)) < 1e-7
    assert np.all(ramped_impulse(plan[0], before, np.inf * RATE, 0.5) == 0.5 * plan[0])


PLAN = np.repeat([[0.03, -0.02], [0.01, 0.02], [0.03, -0.04], [-0.02, -0.01]], 4, axis=0)


def learned(truth: Spacecraft, friction: FrictionEstimate, periods: int = 16) -> FrictionEstimate:
    """After so many periods of a slew with turning wheels."""
    before = np.vstack([np.zeros(2), PLAN])
    t = times(161)
    f = flown(truth, ramped(PLAN, before[0], 0.4, 0.5), t, speed0=np.array([60.0, -250.0]))
    p = spin_momentum(truth, f.omega, f.speed)
    for k in range(periods):
        part = slice(10 * k, 10 * k + 11)
        gave = ramped_impulse(PLAN[k], before[k], RATE, 0.5)
        lost = (gave - (p[part][-1] - p[part][0])) / 0.5
        ramp = np.abs(PLAN[k] - before[k])
        friction = friction_update(friction, lost, f.speed[part], ramp, np.zeros(2), 0.5, truth)
    return friction


def test_both_coefficients_are_found_from_a_slew() -> None:
    truth = craft(coulomb=COULOMB, viscous=VISCOUS)
    friction = learned(truth, no_friction(truth))
    speed = np.array([300.0, -300.0])
    true = COULOMB * np.sign(speed) + VISCOUS * speed
    assert np.max(np.abs(friction.torque(speed) - true)) < 0.03 * np.max(np.abs(true))
    assert np.all(friction.reserve(speed) >= np.abs(friction.torque(speed)))


def test_viscous_bearings_have_no_coulomb_friction() -> None:
    """1e-4 Nms/rad are more than all torque at the speed limit. With the prior at a twentieth of
    that, 3e-3 Nm of Coulomb friction were learned, which made a hold vibrate."""
    truth = craft(viscous=1e-4)
    friction = learned(truth, no_friction(truth))
    assert np.max(np.abs(friction.mean[:, 0])) < 1e-4  # Nm
    assert friction.mean[:, 1] == pytest.approx(1e-4, rel=0.01)


def test_one_speed_tells_the_sum_and_does_not_push_a_wheel_at_rest() -> None:
    truth = craft()
    speeds, lost = np.full((11, 2), 50.0), np.full(2, 2e-3)
    friction = friction_update(
        no_friction(truth), lost, speeds, np.zeros(2), np.zeros(2), 0.5, truth
    )
    assert friction.torque(speeds[0]) == pytest.approx(lost, rel=1e-3)
    apart = friction.mean[:, 0]
    assert np.all(apart > 5e-4)
    rest, wish = np.zeros(2), np.full(2, 1e-3)
    assert np.all(friction.breakaway(rest, wish) < 0.5 * apart)
    known = replace(friction, covariance=1e-6 * friction.covariance)
    assert known.breakaway(rest, wish) == pytest.approx(apart, rel=1e-3)


def test_what_new_periods_contradict_is_forgotten() -> None:
    """Friction believed to 1e-5 Nm, on bearings without any."""
    truth = craft()
    sure = np.tile(np.diag([1e-5**2, 1e-8**2]), (2, 1, 1))
    friction = learned(truth, FrictionEstimate(np.tile([5e-3, 1e-5], (2, 1)), sure))
    assert np.max(np.abs(friction.torque(np.full(2, 200.0)))) < 5e-5  # Nm


def test_friction_takes_and_never_gives() -> None:
    friction = FrictionEstimate(np.array([[-1e-3, 0.0]]), np.zeros((1, 2, 2)))
    assert np.all(friction.torque(np.array([100.0])) == 0.0)


def test_a_wheel_at_rest_or_at_its_limit_teaches_nothing() -> None:
    speeds = np.stack([np.linspace(-5.0, 5.0, 11), np.full(11, 628.0)], axis=-1)
    lost, ramp = np.full(2, 3e-3), np.zeros(2)
    before = no_friction(craft())
    after = friction_update(before, lost, speeds, ramp, ramp, 0.5, craft())
    assert np.all(after.mean == before.mean)


def test_no_friction_is_believed_until_seen() -> None:
    free = craft(torque_max=np.inf, speed_max=np.inf)
    for truth in (craft(), free):
        assert np.all(no_friction(truth).torque(np.array([100.0, -100.0])) == 0.0)
        assert np.all(np.isfinite(no_friction(truth).covariance))


def test_noise_of_the_wheels_is_seen_and_a_ramp_is_no_noise() -> None:
    """1 rpm on the wheel speed: with 1e-5 Nms assumed, friction was learned from it."""
    t, sigma = times(11), 1.5e-4  # Nms
    ramp = ramped(np.full((1, 400), 0.05), np.full(400, -0.05), 0.4, 0.5)
    p = np.cumsum([np.zeros(400), *(0.05 * ramp(time + 0.025) for time in t[:-1])], axis=0)
    assert np.max(momentum_scatter(p)) < 1e-12
    noisy = p + sigma * np.random.default_rng(0).normal(size=p.shape)
    assert np.mean(momentum_scatter(noisy)) == pytest.approx(
        sigma, rel=0.5
    )  # some with the ramp's end
    truth, speeds, none = craft(), np.full((11, 2), 50.0), np.zeros(2)
    seen = [
        friction_update(no_friction(truth), np.full(2, 4e-4), speeds, none, scatter, 0.5, truth)
        for scatter in (none, np.full(2, 1e-2))
    ]
    assert np.all(seen[0].torque(speeds[0]) > 3.9e-4)
    assert np.all(seen[1].torque(speeds[0]) < 1e-4)
