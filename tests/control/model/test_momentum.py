import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.model.momentum import MomentumModel, actuated_basis, spin_momentum
from tests.learned_cases import SKEWED, TRUE_J, craft, flown, matrix, slewing


@pytest.mark.parametrize("A", [None, SKEWED])
@pytest.mark.parametrize("biased", [False, True])
def test_the_rate_follows_from_attitude_and_wheels(A: Array | None, biased: bool) -> None:
    spacecraft = craft(A=A)
    speed0 = np.array([150.0, -90.0]) if biased else None
    omega0 = np.array([0.02, -0.03, 0.05]) if biased else None
    f = flown(spacecraft, slewing, np.linspace(0.0, 8.0, 17), omega0=omega0, speed0=speed0)
    h_N = matrix(f.q[0]) @ spacecraft.angular_momentum(f.omega[0], f.speed[0])
    model = MomentumModel(spacecraft, TRUE_J, h_N)
    for q, omega, speed in zip(f.q, f.omega, f.speed, strict=True):
        error = model.rate(q, spin_momentum(spacecraft, omega, speed)) - omega
        assert np.max(np.abs(error)) < 1e-8  # rad/s


def test_the_motor_alone_changes_the_spin_momentum() -> None:
    spacecraft = craft(A=SKEWED)
    t = np.linspace(0.0, 5.0, 11)
    f = flown(spacecraft, slewing, t, speed0=np.array([80.0, 20.0]))
    p = spin_momentum(spacecraft, f.omega, f.speed)
    impulse = 0.03 * np.stack(
        [np.sin(0.8 * t) / 0.8, (np.cos(0.4) - np.cos(0.55 * t + 0.4)) / 0.55], axis=-1
    )
    assert np.max(np.abs(p - p[0] - impulse)) < 1e-9  # Nms


@pytest.mark.parametrize("A", [None, SKEWED])
def test_admissible_rates_at_zero_momentum_have_the_normal_Jn(A: Array | None) -> None:
    spacecraft = craft(A=A)
    model = MomentumModel(spacecraft, TRUE_J, np.array([0.0, 0.0, 0.0]))
    assert model.tilt is not None
    for p in np.eye(2):
        assert abs(model.tilt @ model.rate(np.array([1.0, 0, 0, 0]), p)) < 1e-15


def test_what_wheels_span() -> None:
    assert MomentumModel(craft(A=np.eye(3)), TRUE_J, np.array([0.0, 0.0, 0.0])).tilt is None
    B = actuated_basis(craft(A=SKEWED))
    assert B.shape == (3, 2)
    assert np.max(np.abs(B @ B.T @ SKEWED - SKEWED)) < 1e-14
