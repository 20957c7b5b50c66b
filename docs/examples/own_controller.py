"""Controllers of your own, a PD law and an LQR, on three wheels; then a campaign against `nmpc`.

    <three_wheel, own_controller:PD: 75 deg about (0.48, -0.64, 0.60): settled at 16.8 s, ...>
    |  | nmpc | own_controller:PD | own_controller:LQR |
    | converged | 4 / 4 | 4 / 4 | 4 / 4 |

The same from the command line, in the folder of this file:
`python -m simsat.run --model three_wheel --controller own_controller:PD`
"""

import numpy as np
from scipy.linalg import solve_discrete_are

import simsat
from simsat.control.ground.attitude import error_quaternion


class PD:
    """Wheel torques against the attitude error and the body rate."""

    def __init__(self, brief):
        J, self.target = brief.nominal.J, brief.target
        self.to_wheels = np.linalg.pinv(brief.nominal.A)
        self.stiffness, self.damping = 0.16 * J, 0.6 * J

    def __call__(self, now):
        """Torque of each motor on its rotor, Nm; the hub feels the opposite."""
        error = 2 * error_quaternion(now.q, self.target)[1:]
        return self.to_wheels @ (self.stiffness @ error + self.damping @ now.omega)


class LQR:
    """The same feedback, with gains that are optimal near the target."""

    def __init__(self, brief):
        self.target, period, one = brief.target, brief.period, np.eye(3)
        push = -np.linalg.solve(brief.nominal.J_hub, brief.nominal.A)
        F = np.block([[one, period * one], [0 * one, one]])
        G = np.vstack([period**2 / 2 * push, period * push])
        Q, R = np.eye(6), 20 * np.eye(brief.nominal.wheels)
        P = solve_discrete_are(F, G, Q, R)
        self.gain = np.linalg.solve(R + G.T @ P @ G, G.T @ P @ F)

    def __call__(self, now):
        """Torque of each motor on its rotor, Nm."""
        error = 2 * error_quaternion(now.q, self.target)[1:]
        return -self.gain @ np.concatenate([error, now.omega])


if __name__ == "__main__":
    flight = simsat.fly("three_wheel", controller=PD, angle_deg=75)
    print(flight)
    flight.plot().savefig("own_controller.png", dpi=110)

    folder = simsat.compare(
        ["nmpc", PD, LQR],
        attitudes=4,
        out="comparison",
        workers=2,
        recordings="none",
        model="three_wheel",
        duration_s=40,
    )
    print((folder / "table.md").read_text().partition("\n\n")[0])
