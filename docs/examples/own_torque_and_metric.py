"""A torque of your own, a leaking thruster, and a metric of your own: the momentum it leaves.

Prints:

    momentum the leak brings in  2.993 mNms
    momentum gained in flight    2.993 mNms
    at the end the attitude is 0.002 deg off
"""

import matplotlib.pyplot as plt
import numpy as np

import simsat

LEAK = np.array([1e-5, 2e-5, 3e-5])


def leak(t, q):
    """Torque in body axes (Nm), from t = 20 s on."""
    return LEAK if t > 20 else 0 * LEAK


def momentum_gained_mNms(flight):
    """Length of the change of total angular momentum."""
    H = np.column_stack([flight.table[f"momentum_N_{axis}"] for axis in "xyz"])
    return 1e3 * np.linalg.norm(H[-1] - H[0])


if __name__ == "__main__":
    flight = simsat.fly(
        "three_wheel",
        torques=[leak],
        metrics=[momentum_gained_mNms],
        environment={"gravity_gradient": False, "drag": False},
        angle_deg=30,
    )
    gained = flight.metrics["own_torque_and_metric:momentum_gained_mNms"]
    print(f"momentum the leak brings in  {1e3 * 80 * np.linalg.norm(LEAK):.3f} mNms")
    print(f"momentum gained in flight    {gained:.3f} mNms")
    print(f"at the end the attitude is {flight.metrics['final_error_deg']:.3f} deg off")
    flight.save("own_torque_and_metric")
    flight.record("own_torque_and_metric.rrd")

    figure, axis = plt.subplots(layout="constrained")
    for name, color in zip("xyz", ("#D55E00", "#009E73", "#0072B2"), strict=True):
        momentum = 1e3 * np.array(flight.table[f"momentum_N_{name}"])
        axis.plot(flight.table["t_s"], momentum, color=color, label=f"inertial {name}")
    axis.set(xlabel="time, s", ylabel="total angular momentum, mNms")
    axis.legend()
    figure.savefig("own_torque_and_metric.png")
