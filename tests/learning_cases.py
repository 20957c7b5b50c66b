"""Flights made up without a simulator: a craft whose truth is the nominal model with another
inertia, so that the residual torque is known and a training is quick."""

import numpy as np

from simsat.control.ground.spacecraft import nominal
from simsat.control.model.ramp import ramped_torques
from simsat.control.model.rates import RateModel, build_rate_model, predict_rate
from simsat.learning.correction.windows import Telemetry, Windows, cut
from simsat.mjcf import Model

PERIOD, SAMPLE, TICKS = 0.5, 0.05, 10


def believed_of(model: Model) -> RateModel:
    return build_rate_model(nominal(model.spacecraft), friction=False)


def made_up_flights(model: Model, count: int, periods: int, seed: int = 0) -> list[Telemetry]:
    """Random torques held over each period, integrated with the true inertia at 20 Hz."""
    craft = model.spacecraft
    truth = build_rate_model(craft, friction=False)
    random = np.random.default_rng(seed)
    flights = []
    for _ in range(count):
        torque = random.uniform(-0.05, 0.05, (periods, craft.wheels))
        omega, speed = np.zeros(3), np.zeros(craft.wheels)
        rates, speeds, before = [omega], [speed], np.zeros(craft.wheels)
        for command in torque:
            torques = ramped_torques(command, before, craft.torque_rate_max, PERIOD)
            for u in torques:
                after = predict_rate(truth, omega, speed, u[None], np.zeros(3), SAMPLE)
                speed = speed + u / craft.Js * SAMPLE - (after - omega) @ craft.A
                omega = after
                rates.append(omega)
                speeds.append(speed)
            before = command
        flights.append(Telemetry(SAMPLE, np.array(rates), np.array(speeds), torque))
    return flights


def made_up_windows(model: Model, count: int, periods: int, seed: int = 0) -> Windows:
    flights = made_up_flights(model, count, periods, seed)
    return cut(flights, PERIOD, believed_of(model), model.spacecraft.torque_rate_max)
