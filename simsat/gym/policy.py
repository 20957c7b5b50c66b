"""A policy that was learned in the environment, as a controller of `simsat.fly`."""

from collections.abc import Callable
from typing import Any

from simsat.control.ground.arrays import Array, WheelVector
from simsat.control.interface.measurement import Measurement
from simsat.gym.senses import senses_of


def follow_policy(
    policy: Callable[[Array], Any], brief: Any
) -> Callable[[Measurement], WheelVector]:
    """The control law that asks policy(observation) -> action at every control instant.

        def learned(brief):
            return follow_policy(policy, brief)

        simsat.fly("three_wheel", controller=learned)

    Observation and action are the environment's (`senses`), and so is the flight, bit for bit. A
    model of Stable-Baselines3 is the policy `lambda seen: model.predict(seen)[0]`.
    """
    senses = senses_of(brief)
    return lambda now: senses.torque(policy(senses.observe(now)))
