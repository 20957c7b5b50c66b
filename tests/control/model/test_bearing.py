"""Two smooth stand-ins for Coulomb friction: odd, below the true one, and the same when turning."""

import numpy as np
import pytest

from simsat.control.model.bearing import (
    COULOMB_RATIONAL_SPEED,
    COULOMB_TANH_SPEED,
    coulomb_rational,
    coulomb_tanh,
)

COULOMB = 1e-3  # Nm


@pytest.mark.parametrize(
    ("law", "speed"),
    [(coulomb_rational, COULOMB_RATIONAL_SPEED), (coulomb_tanh, COULOMB_TANH_SPEED)],
)
def test_each_is_coulomb_friction_away_from_standstill(law, speed: float) -> None:  # type: ignore[no-untyped-def]
    far = np.array([-400.0, -30.0, 30.0, 400.0]) * COULOMB_TANH_SPEED
    torque = np.array(law(COULOMB, far)).ravel()
    assert np.abs(torque - COULOMB * np.sign(far)).max() < 1e-3 * COULOMB
    assert float(law(COULOMB, 0.0)) == 0.0
    near = speed * np.linspace(-3.0, 3.0, 7)
    torque = np.array(law(COULOMB, near)).ravel()
    assert np.array_equal(torque, -torque[::-1])
    assert np.all(np.abs(torque) < COULOMB)
    assert np.all(np.diff(torque) > 0.0)
