"""Random networks, and flights made up without a simulator: a rigid hub with two exact oscillators,
from rest."""

import numpy as np
from scipy.linalg import expm

from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.appendage import AppendageNetwork
from simsat.learning.correction.windows import Telemetry

PERIOD, SAMPLE, TICKS = 0.5, 0.05, 10

DELTA = np.array([[0.3, 0.05, -0.04], [0.02, 0.25, 0.06]])  # Nms per unit of modal rate
FREQUENCY = 2.0 * np.pi * np.array([0.45, 0.27])  # rad/s, hub held
DAMPING = np.array([0.01, 0.03])  # of critical


def random_network(width: int = 5, wheels: int = 2, gates: int = 4) -> AppendageNetwork:
    random = np.random.default_rng(4)
    inputs = 6 + 3 * wheels
    return AppendageNetwork(
        np.diag([2.0, 1.5, 1.9]),
        random.uniform(0.01, 0.1, inputs),
        random.uniform(0.1, 0.5, wheels),
        random.uniform(0.01, 0.1, 6),
        random.standard_normal((6, inputs)),
        random.standard_normal((width, inputs)),
        random.standard_normal((6, width)),
        random.standard_normal((gates, inputs)),
        random.standard_normal((gates, wheels)),
        random.standard_normal((6, gates)),
        PERIOD,
    )


def made_up_flights(
    craft: Spacecraft, count: int, periods: int, seed: int = 0
) -> tuple[list[Telemetry], Array]:
    """Random torques without ramps, zero momentum; the flights, and their true c (F, rows, 3).

    Modes of unit mass: eta'' + 2 zeta w eta' + w^2 eta + delta'omega' = 0, c = sum delta eta'.
    """
    random = np.random.default_rng(seed)
    advance = _transition(craft)
    J_hub = craft.J - (craft.A * craft.Js) @ craft.A.T
    flights, momenta = [], []
    for _ in range(count):
        torque = random.uniform(-0.05, 0.05, (periods, craft.wheels))
        x, states = np.zeros(4 + craft.wheels), []
        states.append(x)
        for u in np.repeat(torque, TICKS, axis=0):
            x = advance @ np.concatenate([x, u])
            states.append(x)
        path = np.array(states)
        c, p = path[:, 2:4] @ DELTA, path[:, 4:]
        omega = -(p @ craft.A.T + c) @ np.linalg.inv(J_hub)
        speed = p / craft.Js - omega @ craft.A
        flights.append(Telemetry(SAMPLE, omega, speed, torque))
        momenta.append(c)
    return flights, np.array(momenta)


def _transition(craft: Spacecraft) -> Array:
    """(eta, eta', p, u) -> (eta, eta', p) one sample later, exact."""
    m = craft.wheels
    J_hub = craft.J - (craft.A * craft.Js) @ craft.A.T
    gain = DELTA @ np.linalg.inv(J_hub)
    mass = np.eye(2) - gain @ DELTA.T
    system = np.zeros((4 + 2 * m, 4 + 2 * m))
    system[:2, 2:4] = np.eye(2)
    system[2:4, :2] = -np.linalg.solve(mass, np.diag(FREQUENCY**2))
    system[2:4, 2:4] = -np.linalg.solve(mass, np.diag(2.0 * DAMPING * FREQUENCY))
    system[2:4, 4 + m :] = np.linalg.solve(mass, gain @ craft.A)
    system[4 : 4 + m, 4 + m :] = np.eye(m)
    whole: Array = expm(SAMPLE * system)
    return whole[: 4 + m]
