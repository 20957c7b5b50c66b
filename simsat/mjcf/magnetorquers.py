"""Magnetic rods of a file: the sites of its tuple 'magnetorquers', each with its dipole limit.

    <custom><tuple name="magnetorquers">
      <element objtype="site" objname="rod_x" prm="0.2"/>
    </tuple></custom>

A rod lies along its site's z axis (`zaxis` sets it); `prm` is its largest dipole in A m^2. Its
place changes no torque, but tells two rods on one axis from one that was written twice.
"""

from collections.abc import Iterator

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.ground.magnetorquers import NO_RODS, Magnetorquers
from simsat.mjcf.custom import RODS

SAME = 1e-6  # m, and of unit vectors: rods closer than this in place and axis are one rod
DIPOLE_MAX = 1e5  # A m^2: Hubble's largest bars have 3,900


def read_rods(m: mujoco.MjModel, d: mujoco.MjData, bus: int) -> Magnetorquers:
    """The rods in the order of the tuple, axes in bus axes; none without such a tuple."""
    entries = _entries(m)
    if not entries:
        return NO_RODS
    R_BN = d.xmat[bus].reshape(3, 3).T
    return Magnetorquers(
        names=tuple(m.site(site).name for _, site, _ in entries),
        axes=np.stack([R_BN @ _axis(d, site) for _, site, _ in entries], axis=1),
        dipole_max=np.array([limit for *_, limit in entries]),
    )


def _entries(m: mujoco.MjModel) -> list[tuple[int, int, float]]:
    """(kind of object, its index, prm) of every element of the tuple."""
    index = mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_TUPLE, RODS)
    if index < 0:
        return []
    first = int(m.tuple_adr[index])
    rows = slice(first, first + int(m.tuple_size[index]))
    return [
        (int(kind), int(site), float(limit))
        for kind, site, limit in zip(
            m.tuple_objtype[rows], m.tuple_objid[rows], m.tuple_objprm[rows], strict=True
        )
    ]


def wrong_rods(m: mujoco.MjModel, d: mujoco.MjData, bus: int) -> Iterator[str]:
    """What is wrong with the file's rods."""
    lines: dict[int, Array] = {}
    for kind, index, limit in _entries(m):
        if kind != mujoco.mjtObj.mjOBJ_SITE:
            name = mujoco.mj_id2name(m, mujoco.mjtObj(kind), index)
            yield f"tuple '{RODS}': '{name}' is no site; a rod is a site of the bus"
            continue
        rod = f"rod '{m.site(index).name}'"
        yield from _wrong_limit(rod, limit)
        body = int(m.site_bodyid[index])
        if m.body_weldid[body] != m.body_weldid[bus]:
            where = m.body(body).name
            yield f"{rod} sits on '{where}', which is not fixed to the bus; move its site there"
        if index in lines:
            yield f"{rod} is listed twice in tuple '{RODS}'; leave one"
            continue
        lines[index] = np.concatenate([d.site_xpos[index], _axis(d, index)])
        for other in lines.keys() - {index}:
            if _same(lines[index], lines[other]):
                yield (
                    f"{rod} lies where rod '{m.site(other).name}' does, along the same axis; "
                    "leave one, or give it a place of its own"
                )


def _wrong_limit(rod: str, limit: float) -> Iterator[str]:
    if limit == 0.0:
        yield f"{rod} has no dipole limit; give its largest dipole in A m^2, as in prm='0.2'"
    elif not 0.0 < limit <= DIPOLE_MAX:
        yield (
            f"{rod} has the dipole limit {limit:g} A m^2 (prm), it must be above zero and up to "
            f"{DIPOLE_MAX:g}"
        )


def _same(a: Array, b: Array) -> bool:
    """Whether two rods, (place, axis) each, are one, wound either way."""
    apart = np.abs(np.stack([a - b, a - b * np.repeat([1.0, -1.0], 3)])).max(axis=1)
    return bool(apart.min() < SAME)


def _axis(d: mujoco.MjData, site: int) -> Array:
    axis: Array = d.site_xmat[site].reshape(3, 3)[:, 2]
    return axis
