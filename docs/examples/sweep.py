"""A sweep over the spacecraft itself: how soon two wheels turn it, by the torque they can give.

Prints:

    12.5 mNm  settled at t = 37.25 s
    25 mNm  settled at t = 26.65 s
    50 mNm  settled at t = 18.95 s
    100 mNm  settled at t = 13.70 s
    200 mNm  settled at t = 10.00 s
"""

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import simsat
from simsat.mjcf.shipped import find_model

limits_mNm = (12.5, 25, 50, 100, 200)
settling_s = []
for limit in limits_mNm:
    spec = mujoco.MjSpec.from_file(str(find_model("two_wheel")))
    for motor in spec.actuators:
        motor.actrange = np.array([-1e-3, 1e-3]) * limit
    flight = simsat.fly(spec, controller="nmpc-learned", duration_s=60)
    settling_s.append(flight.metrics["settling_time_s"])
    print(f"{limit:5} mNm  {flight.metrics['convergence']}")

figure, axis = plt.subplots(layout="constrained")
axis.loglog(limits_mNm, settling_s, "o-", color="#0072B2", label="nmpc-learned, 125 deg")
law = settling_s[2] * np.sqrt(limits_mNm[2] / np.array(limits_mNm))
axis.loglog(limits_mNm, law, ":", color="black", label="one over the square root of the limit")
axis.set(xlabel="torque limit of each wheel, mNm", ylabel="settling time, s")
axis.minorticks_off()
axis.set_xticks(limits_mNm, labels=limits_mNm)
axis.set_yticks([10, 20, 40], labels=[10, 20, 40])
axis.legend()
figure.savefig("sweep.png")
