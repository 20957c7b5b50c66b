"""What a file holds that changes nothing here: said at the start, so that nobody counts on it."""

from collections.abc import Collection, Iterator

import mujoco

from simsat.mjcf.custom import names, unread_custom
from simsat.mjcf.shapes import DRAWN, hull


def without_effect(
    m: mujoco.MjModel, bus: int, turning: Collection[int], wheels: Collection[str]
) -> Iterator[str]:
    """Each kind of element that is drawn at most, with its names or their number.

    `turning` are the bodies of rotors, `wheels` the names of their joints.
    """
    object = mujoco.mjtObj
    for kind, count, what in (
        (object.mjOBJ_SENSOR, m.nsensor, "sensor"),
        (object.mjOBJ_KEY, m.nkey, "keyframe"),
        (object.mjOBJ_TENDON, m.ntendon, "tendon"),
        (object.mjOBJ_EQUALITY, m.neq, "inactive equality"),
        (object.mjOBJ_PAIR, m.npair, "contact pair"),
        (object.mjOBJ_EXCLUDE, m.nexclude, "contact exclusion"),
    ):
        if count:
            yield _listed(what, names(m, kind, count))
    scenery = [g for g in range(m.ngeom) if m.body_rootid[m.geom_bodyid[g]] != bus]
    if scenery:
        yield _listed("scenery", _geoms(m, scenery))
    faceless = [g for g in hull(m, bus, turning) if mujoco.mjtGeom(m.geom_type[g]) not in DRAWN]
    if faceless:
        yield _listed("no faces for drag and sunlight on", _geoms(m, faceless))
    yield from unread_custom(m, wheels)


def _geoms(m: mujoco.MjModel, geoms: list[int]) -> list[str]:
    return [m.geom(g).name for g in geoms]


MANY = 4


def _listed(what: str, entries: list[str]) -> str:
    """What, with names as long as they are few and there are any."""
    if len(entries) > MANY or not all(entries):
        return f"{what} ({len(entries)})"
    return f"{what} {', '.join(map(repr, entries))}"
