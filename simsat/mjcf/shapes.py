"""Geoms of an MJCF file: shapes to draw, and outer faces for drag and solar pressure.

A geom is an outer face if it is in group 0 (MuJoCo's default), on the spacecraft and not on
anything that turns with a rotor; any other group is decoration. Boxes give six flat faces; spheres,
ellipsoids, cylinders and capsules are cut into facets; meshes and planes are drawn at most, never
faces. One face doesn't shadow another.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Surface
from simsat.mjcf.custom import number, numbers

FACE_GROUP = 0
COEFFICIENTS = {"drag_coefficient": 10.0, "reflectivity": 1.0}
"""Largest value of each: drag is 2 to 4 in free molecular flow, the other is a share."""
RING = 24  # facets around a round geom: its projected area is within 0.6 % of the true one


@dataclass(frozen=True)
class Shape:
    """A geom to draw, in the frame of its body."""

    name: str
    body: int
    kind: str
    """'box', 'sphere', 'capsule', 'ellipsoid' or 'cylinder'."""
    size: Array
    """MuJoCo's sizes: half-lengths and radii, m."""
    position: Array
    quaternion: Array
    """Geom -> body, scalar first."""
    rgba: Array


DRAWN = {
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
}


def read_shapes(m: mujoco.MjModel) -> tuple[Shape, ...]:
    """Every drawable geom of the file."""
    return tuple(
        Shape(
            name=m.geom(g).name or f"geom_{g}",
            body=int(m.geom_bodyid[g]),
            kind=DRAWN[mujoco.mjtGeom(m.geom_type[g])],
            size=m.geom_size[g].copy(),
            position=m.geom_pos[g].copy(),
            quaternion=m.geom_quat[g].copy(),
            rgba=m.geom_rgba[g].astype(float),
        )
        for g in range(m.ngeom)
        if mujoco.mjtGeom(m.geom_type[g]) in DRAWN
    )


def read_surface(
    m: mujoco.MjModel, d: mujoco.MjData, bus: int, turning: Collection[int]
) -> Surface:
    """Outer faces in bus axes, positions from the centre of mass of the whole spacecraft.

    What stands in the world is scenery, and `turning` bodies sit inside the hull: no faces.
    """
    R_BN, com = d.xmat[bus].reshape(3, 3).T, d.subtree_com[bus]
    centres, normals, areas = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros(0)]
    for g in hull(m, bus, turning):
        kind = mujoco.mjtGeom(m.geom_type[g])
        if kind not in DRAWN:
            continue
        centre, normal, area = _facets(DRAWN[kind], m.geom_size[g])
        R_BG = R_BN @ d.geom_xmat[g].reshape(3, 3)
        centres.append(R_BN @ (d.geom_xpos[g] - com) + centre @ R_BG.T)
        normals.append(normal @ R_BG.T)
        areas.append(area)
    given = {name: value for name in COEFFICIENTS if (value := number(m, name)) is not None}
    return Surface(np.concatenate(centres), np.concatenate(normals), np.concatenate(areas), **given)


def hull(m: mujoco.MjModel, bus: int, turning: Collection[int]) -> Iterator[int]:
    """Indices of the geoms that make the spacecraft's outside."""
    for g in range(m.ngeom):
        body = int(m.geom_bodyid[g])
        own = m.body_rootid[body] == bus and body not in turning
        if own and m.geom_group[g] == FACE_GROUP:
            yield g


def wrong_coefficients(m: mujoco.MjModel) -> Iterator[str]:
    """Coefficients of the surface that push the wrong way, or that are not one number."""
    for name, most in COEFFICIENTS.items():
        values = numbers(m, name)
        if values is not None and not (len(values) == 1 and 0.0 <= values[0] <= most):
            shown = " ".join(f"{value:g}" for value in values)
            yield f"numeric '{name}' is {shown}, it must be one number from 0 to {most:g}"


def _facets(kind: str, size: Array) -> tuple[Array, Array, Array]:
    """(centre, outward normal, area) of each facet in the geom's own frame."""
    if kind == "box":
        return _box(size)
    if kind == "cylinder":
        return _revolution(np.array([[0, -1], [1, -1], [1, 1], [0, 1.0]]) * size[:2], RING)
    polar = np.linspace(-np.pi / 2, np.pi / 2, RING // 2 + 1)
    profile = np.stack([np.cos(polar), np.sin(polar)], axis=1)
    if kind == "capsule":
        lower, upper = profile[polar <= 0] * size[0], profile[polar >= 0] * size[0]
        lower[:, 1] -= size[1]
        upper[:, 1] += size[1]
        return _revolution(np.concatenate([lower, upper]), RING)
    radii = size if kind == "ellipsoid" else np.full(3, size[0])
    return _revolution(profile, RING, radii)


def _box(half: Array) -> tuple[Array, Array, Array]:
    normal = np.concatenate([np.eye(3), -np.eye(3)])
    area = 4.0 * np.prod(half) / half
    return normal * half, normal, np.tile(area, 2)


def _revolution(
    profile: Array, ring: int, scale: Array | None = None
) -> tuple[Array, Array, Array]:
    """Facets of the body that a (radius, height) profile, listed upwards, sweeps about z."""
    angle = np.linspace(0.0, 2.0 * np.pi, ring + 1)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = np.concatenate(
        [
            profile[:, None, :1] * circle[None],
            np.broadcast_to(profile[:, None, 1:], (len(profile), ring + 1, 1)),
        ],
        axis=2,
    )
    if scale is not None:
        points = points * scale
    a, b = points[:-1, :-1], points[:-1, 1:]
    c, e = points[1:, 1:], points[1:, :-1]
    vector = 0.5 * np.cross(c - a, e - b).reshape(-1, 3)  # area vector of the quadrilateral
    centre = (0.25 * (a + b + c + e)).reshape(-1, 3)
    area = np.linalg.norm(vector, axis=1)
    keep = area > 1e-12
    vector, centre, area = vector[keep], centre[keep], area[keep]
    return centre, vector / area[:, None], area
