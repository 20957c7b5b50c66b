"""The estimator that settings ask for, with what it may know: the instruments' data sheet."""

import math

import numpy as np

from simsat.control.estimator.mekf import Mekf
from simsat.control.estimator.state import GyroKnowledge
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.layers import Estimator
from simsat.sensors.gyro import bias_instability_deviation
from simsat.sensors.settings import SensorSettings
from simsat.sensors.sheets import GyroSheet
from simsat.sensors.units import (
    DEG_PER_HOUR,
    DEG_PER_HOUR_PER_ROOT_HOUR,
    DEG_PER_ROOT_HOUR,
    PPM,
)


def build_estimator(name: str, sensors: SensorSettings, tick: float) -> Estimator | None:
    """The estimator by its name: mekf, none, or auto, which is mekf for instruments of a data sheet
    and none for what needs no filter.

    Raises `SettingsError` where there is nothing to estimate from.
    """
    if name == "none" or (name == "auto" and sensors.preset is None):
        return None
    if sensors.sheet is not None:
        return Mekf(knowledge_of(sensors.sheet.gyro, tick))
    if not sensors.enabled:
        raise SettingsError(
            "--estimator mekf has nothing to filter: the controller sees the truth; give "
            "--sensors.preset or --sensors.enabled"
        )
    return Mekf(knowledge_of_white_noise(sensors, tick))


def knowledge_of(sheet: GyroSheet, tick: float) -> GyroKnowledge:
    """What a data sheet tells a filter.

    The bias instability is to the filter a part of the first bias and of its random walk: over less
    than its correlation time T a Gauss-Markov process of deviation s walks by s sqrt(2 t / T).
    """
    unstable = bias_instability_deviation(sheet)
    walk = sheet.rate_random_walk_deg_h_sqrt_h * DEG_PER_HOUR_PER_ROOT_HOUR
    skew = 1e-3 * sheet.misalignment_mrad
    scale = sheet.scale_factor_ppm * PPM
    return GyroKnowledge(
        tick=tick,
        angle_random_walk=sheet.angle_random_walk_deg_sqrt_h * DEG_PER_ROOT_HOUR,
        rate_random_walk=math.hypot(walk, unstable * math.sqrt(2.0 / sheet.correlation_time_s)),
        bias_deviation=math.hypot(sheet.bias_deg_h * DEG_PER_HOUR, unstable),
        gain_deviation=np.where(np.eye(3) > 0.0, scale, skew),
    )


def knowledge_of_white_noise(sensors: SensorSettings, tick: float) -> GyroKnowledge:
    """What the settings of the white noise tell a filter; the delay and the relative noise they
    keep to themselves."""
    return GyroKnowledge(
        tick=tick,
        angle_random_walk=sensors.gyro_random_walk_deg_sqrt_h * DEG_PER_ROOT_HOUR,
        rate_random_walk=0.0,
        bias_deviation=sensors.gyro_bias_deg_h * DEG_PER_HOUR,
        gain_deviation=np.zeros((3, 3)),
    )
