"""Attitude and gyro errors from gyro readings, late attitude fixes and known directions."""
