import numpy as np
from scipy.integrate import quad

from simsat.control.learned.estimation.friction import friction_update, no_friction
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


def test_both_coefficients_are_found_from_a_slew() -> None:
    truth = craft(coulomb=COULOMB, viscous=VISCOUS)
    plan = np.repeat([[0.03, -0.02], [0.01, 0.02], [0.03, -0.04], [-0.02, -0.01]], 4, axis=0)
    before = np.vstack([np.zeros(2), plan])
    t = times(161)
    f = flown(truth, ramped(plan, before[0], 0.4, 0.5), t, speed0=np.array([60.0, -250.0]))
    p = spin_momentum(truth, f.omega, f.speed)
    friction = no_friction(2)
    for k in range(16):
        part = slice(10 * k, 10 * k + 11)
        gave = ramped_impulse(plan[k], before[k], RATE, 0.5)
        lost = (gave - (p[part][-1] - p[part][0])) / 0.5
        ramp = np.abs(plan[k] - before[k])
        friction = friction_update(friction, lost, f.speed[part], ramp, truth.speed_max)
    speed = np.array([300.0, -300.0])
    true = COULOMB * np.sign(speed) + VISCOUS * speed
    assert np.max(np.abs(friction.torque(speed) - true)) < 0.03 * np.max(np.abs(true))
    assert np.all(friction.reserve(speed) >= np.abs(friction.torque(speed)))


def test_a_wheel_at_rest_or_at_its_limit_teaches_nothing() -> None:
    speeds = np.stack([np.linspace(-5.0, 5.0, 11), np.full(11, 628.0)], axis=-1)
    lost, ramp = np.full(2, 3e-3), np.zeros(2)
    before = no_friction(2)
    after = friction_update(before, lost, speeds, ramp, np.full(2, 628.3))
    assert np.all(after.mean == before.mean)


def test_no_friction_is_believed_until_seen() -> None:
    assert np.all(no_friction(3).torque(np.array([100.0, -100.0, 0.0])) == 0.0)
