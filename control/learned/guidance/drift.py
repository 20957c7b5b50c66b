"""What external torque will do along the unactuated axis, and where to arrive because of it.

Along n wheels give no torque. With the wheels' plane held still, phi_n = n'J phi / n'J n moves as

    phi_n(t) = phi_n(0) + (h_n t + tau_n t^2 / 2) / (n'J n),      h_n = n'R'h_N

and steady coning against it would cost more error than it removes. So the hold lets it drift, and
the slew before arrives at minus a share b of the drift D to come. Where D grows as t^2,

    RMS = D sqrt(1/5 - 2 b/3 + b^2)      largest = D max(b, 1 - b)      last = D (1 - b)

b = 1/2 keeps the largest error least, but it is met at the end and grows on. b = 2/3 has the RMS
of an arrival on the target (b = 0) and ends at a third of D: a hold that goes on beyond the time
looked ahead stays longer in bounds. Where D grows as t, b = 1/2 also has the least RMS (0.29 D,
against 0.33 D for 2/3 and 0.58 D for 0).
"""

import numpy as np

from ...ground.arrays import Quaternion
from ...ground.attitude import error_quaternion, multiply, rotation_matrix
from ...model.momentum import MomentumModel
from ..estimation.estimate import ModelEstimate


def unactuated_error(model: MomentumModel, q: Quaternion, target: Quaternion) -> float:
    """phi_n of attitude q relative to the target, rad; 0 for a craft that wheels turn fully."""
    tilt = model.tilt
    return 0.0 if tilt is None else float(tilt @ (2.0 * error_quaternion(q, target)[1:]))


def unactuated_rate(model: MomentumModel, target: Quaternion) -> float:
    """phi_n' with the wheels' plane held still at the target, h_n / n'J n, rad/s."""
    n = model.spacecraft.unactuated
    if n is None:
        return 0.0
    return float(n @ rotation_matrix(target).T @ model.h_N / (n @ model.J @ n))


def predicted_drift(
    model: MomentumModel, estimate: ModelEstimate, target: Quaternion, delay: float, hold: float
) -> float:
    """Change of phi_n (rad) over `hold` seconds at the target that begin in `delay` seconds."""
    n = model.spacecraft.unactuated
    if n is None:
        return 0.0
    momentum = estimate.h_N + estimate.external_torque(target) * (delay + hold / 2.0)
    along = n @ rotation_matrix(target).T @ momentum
    return float(along * hold / (n @ model.J @ n))


def arrival_attitude(model: MomentumModel, target: Quaternion, bias: float) -> Quaternion:
    """The attitude whose phi_n relative to the target is `bias` (rad), all else zero."""
    n = model.spacecraft.unactuated
    if n is None:
        return target
    offset = np.concatenate([[1.0], 0.5 * bias * n])
    return multiply(target, offset / np.linalg.norm(offset))
