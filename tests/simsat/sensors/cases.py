"""A flight to look at with instruments."""

from functools import lru_cache

import numpy as np

from simsat.control.ground import attitude
from simsat.environment import OrbitSettings
from simsat.environment.environment import build_orbit
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS
from simsat.plant.plant import Plant

TICK, ROWS = 0.05, 401
ORBIT = build_orbit(OrbitSettings())


@lru_cache(maxsize=2)
def tumbling(rate_deg_s: float = 12.0) -> Plant:
    """Twenty seconds of turning about a skew axis, with wheels at speed."""
    model = read_model(MODELS / "two_wheel" / "two_wheel.xml")
    plant = Plant(model, TICK, ROWS - 1)
    q = attitude.from_axis_angle(np.array([0.3, -0.8, 0.5]), 2.0)
    axis = np.array([0.4, -0.7, 0.59])
    omega = np.radians(rate_deg_s) * axis / np.linalg.norm(axis)
    plant.reset(q, omega, np.array([200.0, -300.0]))
    plant.advance(np.zeros(2), ROWS - 1)
    return plant
