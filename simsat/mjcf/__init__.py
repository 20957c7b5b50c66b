"""The model reader: a spacecraft's MJCF file in, its numbers and its compiled MuJoCo model out."""

from simsat.mjcf.reader import Model, interpret, read_compiled, read_model
from simsat.mjcf.shapes import Shape
from simsat.mjcf.wheels import Drive, WheelDrive

__all__ = ["Drive", "Model", "Shape", "WheelDrive", "interpret", "read_compiled", "read_model"]
