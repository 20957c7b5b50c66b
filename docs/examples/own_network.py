"""An estimator of your own in the place of the network: least squares on what the model misses.

Prints:

    least squares explains 99.6 % of the residual torque on a flight it has not seen
    nmpc       settled at t = 77.40 s, 0.0973 deg at the end
    nmpc-pinn  settled at t = 85.45 s, 0.0136 deg at the end
"""

import matplotlib.pyplot as plt
import numpy as np

import simsat


class LeastSquares:
    """Reads the weights that the script wrote, in every worker anew."""

    def __init__(self, brief):
        self.weights = np.load("own_network.npy")

    def __call__(self, now, torque, previous):
        """Torque on each wheel's axis, Nm, that makes up for the residual."""
        return features(torque[None], now.omega[None])[0] @ self.weights


def features(torque, omega):
    """What the residual may be linear in, a row per control period."""
    return np.hstack([torque, omega, omega**2, omega * np.roll(omega, 1, axis=1)])


def examples(flight):
    """Features of every control period of a flight, and its true residual torques (Nm)."""
    steps, table = flight.steps, flight.table
    torque, residual = (
        np.column_stack([steps[f"torque_{kind}_wheel_{wheel}"] for wheel in "xy"])
        for kind in ("plan", "residual")
    )
    omega = np.column_stack([table[f"omega_{axis}"] for axis in "xyz"])
    return features(torque, omega[:-1:10]), residual


if __name__ == "__main__":
    axes = np.random.default_rng(0).normal(size=(6, 3))
    flown = [examples(simsat.fly(axis=axis, angle_deg=100, duration_s=40)) for axis in axes]
    x, y = map(np.concatenate, zip(*flown, strict=True))
    weights = np.linalg.lstsq(x, y)[0]
    np.save("own_network.npy", weights)

    baseline = simsat.fly()
    flight = simsat.fly(controller="nmpc-pinn", network=LeastSquares)
    x, y = examples(baseline)
    share = 100 * (1 - np.sum((y - x @ weights) ** 2) / np.sum(y**2))
    print(
        f"least squares explains {share:.1f} % of the residual torque on a flight it has not seen"
    )
    for result in (baseline, flight):
        name, figures = result.mission.settings.controller, result.metrics
        print(
            f"{name:10} {figures['convergence']}, {figures['final_error_deg']:.4f} deg at the end"
        )

    figure, axis = plt.subplots(layout="constrained")
    axis.plot(baseline.steps["t_s"], 1e3 * y[:, 0], color="#0072B2", label="true")
    axis.plot(
        baseline.steps["t_s"], 1e3 * x @ weights[:, 0], "--", color="#D55E00", label="estimate"
    )
    axis.set(xlabel="time, s", ylabel="residual torque on wheel_x, mNm", xlim=(0, 40))
    axis.legend()
    figure.savefig("own_network.png")
