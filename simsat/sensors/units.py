"""The units of data sheets, in rad, s and rad/s."""

import math

ARCSECOND = math.radians(1.0 / 3600.0)
DEG_PER_HOUR = math.radians(1.0) / 3600.0  # in rad/s
DEG_PER_ROOT_HOUR = math.radians(1.0) / 60.0  # in rad/sqrt(s)
DEG_PER_HOUR_PER_ROOT_HOUR = DEG_PER_HOUR / 60.0  # in rad/s/sqrt(s)
PPM = 1e-6
