"""Spacecraft parts as rerun shapes."""

from typing import Any

import numpy as np
import rerun as rr

from simsat.control.ground import attitude
from simsat.mjcf import Shape
from simsat.recording.layout import AXIS_COLORS


def axes(length: float, frame: str, alpha: int) -> rr.Arrows3D:
    """The axes of a frame as labelled arrows; alpha from 0 (unseen) to 255."""
    return rr.Arrows3D(
        vectors=length * np.eye(3),
        colors=[(*color, alpha) for color in AXIS_COLORS],
        labels=[f"{axis}_{frame}" for axis in "xyz"],
        radii=length / (90.0 if frame == "B" else 180.0),
    )


def archetype(shape: Shape) -> Any:
    """The rerun shape of a geom, in its body's frame."""
    color = [round(255 * float(part)) for part in shape.rgba]
    place: dict[str, Any] = {
        "centers": [shape.position],
        "quaternions": [attitude.scalar_last(shape.quaternion)],
        "colors": [color],
    }
    a, b = float(shape.size[0]), float(shape.size[1])
    if shape.kind == "box":
        return rr.Boxes3D(half_sizes=[shape.size], fill_mode="solid", **place)
    if shape.kind == "cylinder":
        return rr.Cylinders3D(radii=[a], lengths=[2 * b], fill_mode="solid", **place)
    if shape.kind == "capsule":
        offset = attitude.rotation_matrix(shape.quaternion) @ np.array([0.0, 0.0, -b])
        return rr.Capsules3D(radii=[a], lengths=[2 * b], translations=[shape.position + offset],
                             quaternions=place["quaternions"], colors=[color])  # fmt: skip
    half = shape.size if shape.kind == "ellipsoid" else np.full(3, a)
    return rr.Ellipsoids3D(half_sizes=[half], fill_mode="solid", **place)
