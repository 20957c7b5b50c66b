"""The NMPC in the axes of a moving reference: the disturbance makes its equations the true ones."""

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.interface.measurement import History, Measurement
from simsat.control.nmpc.following import FollowingNmpc
from simsat.control.nmpc.planner import NmpcSettings, build_nmpc
from simsat.control.reference.reference import Curve
from simsat.mjcf import Model


def turning(t: object) -> Array:
    """An attitude that turns faster and faster about a tilted axis."""
    half = np.asarray(0.03 * np.asarray(t) + 0.002 * np.asarray(t) ** 2)[..., None]
    return np.concatenate([np.cos(half), np.sin(half) * np.array([0.6, 0.0, 0.8])], axis=-1)


def test_relative_equations_are_the_true_ones_seen_from_the_reference(two_wheel: Model) -> None:
    """J_hub w_e' = -A u - w_e x H_e + d must hold of w_e = w - R_BT w_ref, its derivative taken
    numerically along the true motion J_hub w' = -A u - w x H."""
    craft = two_wheel.spacecraft
    reference = Curve(turning, lambda t: (turning(np.asarray(t) + 1e-5)
                                          - turning(np.asarray(t) - 1e-5)) / 2e-5)  # fmt: skip
    q = attitude.normalized(np.array([0.7, -0.2, 0.5, 0.3]))
    omega, speed = np.array([0.05, -0.08, 0.03]), np.array([300.0, -150.0])
    H = craft.angular_momentum(omega, speed)
    omega_dot = np.linalg.solve(craft.J_hub, -np.cross(omega, H))  # no torque on the wheels
    t, h = 4.0, 1e-4

    def relative(s: float) -> Array:
        """w_e at time s from t, along the true motion, to second order."""
        rate = omega + s * omega_dot
        turn = omega + 0.5 * s * omega_dot
        there = attitude.multiply(
            q, attitude.from_axis_angle(turn, s * float(np.linalg.norm(turn)))
        )
        error = attitude.error_quaternion(there, reference.attitude(t + s))
        return rate - attitude.rotation_matrix(error).T @ reference.rate(t + s)

    slope = (relative(h) - relative(-h)) / (2.0 * h)
    omega_e = relative(0.0)
    expected = craft.J_hub @ slope + np.cross(omega_e, craft.angular_momentum(omega_e, speed))
    asked: dict[str, Array] = {}

    class Asked(FollowingNmpc):
        def _disturbance(self, *values: object) -> Array:
            asked["d"] = super()._disturbance(*values)  # type: ignore[arg-type]
            return asked["d"]

    history = History(np.array([t]), omega[None], speed[None])
    now = Measurement(t, q, omega, speed, np.zeros(2), history)
    planner = build_nmpc(craft, NmpcSettings(), attitude.IDENTITY)
    Asked(planner, reference).plan(now, None)
    np.testing.assert_allclose(asked["d"], expected, atol=1e-5)  # Nm of 0.04
    assert np.abs(expected).max() > 5e-3
