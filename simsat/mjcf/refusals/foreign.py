"""The door: whatever a file sets that nobody here interprets must be as MuJoCo leaves it.

Every number of the compiled model is either in a list of `allowed`, or must equal what MuJoCo gives
a file that doesn't mention it. A field that a later MuJoCo adds is on no list: set, it is refused.
"""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cache
from typing import NamedTuple

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array
from simsat.mjcf.refusals.allowed import (
    ALLOWED,
    CAUSES,
    DEFAULTS,
    FIRST_ONLY,
    GROUPS,
    HELD_ANYWAY,
    READ,
)

KINDS = {
    "body": ("body", mujoco.mjtObj.mjOBJ_BODY),
    "jnt": ("joint", mujoco.mjtObj.mjOBJ_JOINT),
    "dof": ("joint", mujoco.mjtObj.mjOBJ_JOINT),
    "geom": ("geom", mujoco.mjtObj.mjOBJ_GEOM),
    "tendon": ("tendon", mujoco.mjtObj.mjOBJ_TENDON),
    "actuator": ("actuator", mujoco.mjtObj.mjOBJ_ACTUATOR),
    "eq": ("equality constraint", mujoco.mjtObj.mjOBJ_EQUALITY),
}
"""Of which element a field's rows tell, by the first part of its name."""


class Setting(NamedTuple):
    """A row of a field that no element of a file without settings has."""

    field: str
    row: int
    numbers: str


def foreign_settings(m: mujoco.MjModel, idle: Collection[int] = ()) -> Iterator[str]:
    """Every setting of a model that nobody interprets, one sentence per cause.

    `idle` are the indices of actuators that drive no wheel, held at zero or refused as a whole:
    of theirs only `HELD_ANYWAY` acts.
    """
    causes: dict[str, list[Setting]] = {}
    for field, value in fields(m).items():
        if field not in ALLOWED and not GROUPS.fullmatch(field):
            found = list(_foreign_rows(m, field, value, idle))
            if found:
                causes.setdefault(_template(field), []).extend(found)
    for template, found in causes.items():
        yield _told(m, template, found)


def not_finite(m: mujoco.MjModel, warnings: Collection[str] = ()) -> Iterator[str]:
    """A sentence that names the fields that hold nan or inf, which no bound would stop.

    MuJoCo warns of a nan in a file and takes its default in some places: that is refused too.
    """
    found = [
        field
        for field, value in fields(m).items()
        if value.dtype.kind == "f" and not GROUPS.fullmatch(field) and not np.isfinite(value).all()
    ]
    stated = [field for field in found if field in READ] or found  # the rest follows from these
    if stated:
        yield f"numbers that are not finite, in {', '.join(map(_spelled, stated))}; mend them first"
    elif any("NaN" in warning for warning in warnings):
        yield "a number is given as 'nan', for which MuJoCo would take another; write the number"


def fields(m: mujoco.MjModel) -> Mapping[str, Array]:
    """Every number of a compiled model by name, options and statistics as opt.x and stat.x."""
    values: dict[str, Array] = {}
    for prefix, part in (("", m), ("opt.", m.opt), ("stat.", m.stat)):
        for name in dir(part):
            if name.startswith("_"):
                continue
            value = getattr(part, name)
            if isinstance(value, (bool, int, float, np.generic, np.ndarray)):
                values[prefix + name] = np.asarray(value)
    return values


@cache
def _defaults() -> Mapping[str, Array]:
    return fields(mujoco.MjModel.from_xml_string(DEFAULTS))


def _told(m: mujoco.MjModel, template: str, found: Sequence[Setting]) -> str:
    """The sentence of a cause: the elements it is found in, and the first of the settings."""
    first = found[0]
    owned = [setting for setting in found if setting.field.split("_")[0] in KINDS]
    names = dict.fromkeys(_owner(m, setting) for setting in owned)
    kind = KINDS[owned[0].field.split("_")[0]][0] if owned else ""
    return template.format(
        who=f"{kind}{'s' if len(names) > 1 else ''} {', '.join(names)}",
        has="have" if len(names) > 1 else "has",
        field=_spelled(first.field),
        attribute=first.field.partition("_")[2],
        value=first.numbers,
    )


def _template(field: str) -> str:
    for pattern, template in CAUSES:
        if re.fullmatch(pattern, field):
            return template
    whose = "{who}: {field} is" if field.split("_")[0] in KINDS else "{field} is"
    return f"{whose} {{value}}, which is not interpreted here; leave it at MuJoCo's default"


def _spelled(field: str) -> str:
    group, _, name = field.partition(".")
    return {"opt": f"<option {name}>", "stat": f"<statistic {name}>"}.get(group, field)


def _foreign_rows(
    m: mujoco.MjModel, field: str, value: Array, idle: Collection[int]
) -> Iterator[Setting]:
    held = _rows_of(m, field, idle) if field not in HELD_ANYWAY else ()
    first = 1 if field in FIRST_ONLY else 0
    usual = {tuple(row[first:]) for row in _table(_defaults().get(field, np.empty(0)))}
    for i, row in enumerate(_table(value)[:, first:]):
        if i not in held and tuple(row) not in usual:
            yield Setting(field, i, " ".join(f"{number:g}" for number in row))


def _table(value: Array) -> Array:
    """A row per element; a lone number is one row, an empty field none."""
    if value.size == 0:
        return np.empty((0, 1))
    return value.reshape(len(value) if value.ndim else 1, -1)


def _rows_of(m: mujoco.MjModel, field: str, actuators: Collection[int]) -> Collection[int]:
    """Rows of an actuator field that belong to these actuators; a gear has a row per output."""
    if not field.startswith("actuator_"):
        return ()
    if field != "actuator_gear":
        return actuators
    return {
        int(m.actuator_outadr[i]) + k for i in actuators for k in range(int(m.actuator_outnum[i]))
    }


def _owner(m: mujoco.MjModel, setting: Setting) -> str:
    """Name of the element that a row of a field belongs to, its number where it has none."""
    prefix = setting.field.split("_")[0]
    index = int(m.dof_jntid[setting.row]) if prefix == "dof" else setting.row
    name = mujoco.mj_id2name(m, KINDS[prefix][1], index)
    return f"'{name}'" if name else f"number {index + 1}"
