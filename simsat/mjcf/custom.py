"""What simsat reads from <custom>: numbers, texts and tuples by name, and names it doesn't know."""

from collections.abc import Callable, Collection, Iterator
from difflib import get_close_matches
from typing import TypeVar

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import ModelError

T = TypeVar("T")

SPEED_LIMITS = ("speed_limit_rpm", "speed_limit_rad_s")  # of all wheels, or WHEEL.speed_limit_..
ENVELOPES = ("torque_envelope_rpm", "torque_envelope_rad_s")  # likewise
OF_A_WHEEL = (*SPEED_LIMITS, *ENVELOPES)
NUMBERS = (*OF_A_WHEEL, "nominal_inertia_factors", "drag_coefficient", "reflectivity")
UNUSED = "unused_actuators"
RODS = "magnetorquers"
FAILED = "failed_wheels"
LOCKED = "locked_wheels"
"""How a compiled model remembers the failed ones, whose joints it has no more."""
TEXTS = (UNUSED, FAILED, LOCKED)
SIMILAR = 0.75  # difflib's likeness from which a name is taken for a slip of a known one


def numbers(m: mujoco.MjModel, name: str) -> Array | None:
    """Values of <custom><numeric name=.../>, or None if the file has no such entry."""
    index = mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_NUMERIC, name)
    if index < 0:
        return None
    first = int(m.numeric_adr[index])
    return np.array(m.numeric_data[first : first + int(m.numeric_size[index])], float)


def number(m: mujoco.MjModel, name: str) -> float | None:
    """The one value of a numeric, or None. Raises `ModelError` if it has several."""
    values = numbers(m, name)
    if values is None:
        return None
    if values.shape != (1,):
        raise ModelError(f"numeric '{name}' has {len(values)} numbers, it must have one")
    return float(values[0])


def stated_once(
    m: mujoco.MjModel,
    wheel: str,
    quantities: tuple[str, ...],
    read: Callable[[mujoco.MjModel, str], T | None],
) -> tuple[str, T] | None:
    """Name and value, as `read` has it, of the numeric that states a quantity of a wheel, in one
    unit or another: its own, WHEEL.QUANTITY, else that of all; None without one.

    Raises `ModelError` if it is stated twice.
    """
    for prefix in (f"{wheel}.", ""):
        stated = {
            name: value
            for name in (prefix + quantity for quantity in quantities)
            if (value := read(m, name)) is not None
        }
        if len(stated) > 1:
            raise ModelError(f"numerics {' and '.join(map(repr, stated))}: give one of them")
        for entry in stated.items():
            return entry
    return None


def text(m: mujoco.MjModel, name: str) -> str | None:
    """Data of <custom><text name=.../>, or None if the file has no such entry."""
    index = mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_TEXT, name)
    if index < 0:
        return None
    first = int(m.text_adr[index])
    return m.text_data[first : first + int(m.text_size[index])].rstrip(b"\0").decode()


def names(m: mujoco.MjModel, kind: mujoco.mjtObj, count: int) -> list[str]:
    """Names of all objects of a kind, '' where one has none."""
    return [mujoco.mj_id2name(m, kind, i) or "" for i in range(count)]


def unused_actuators(m: mujoco.MjModel) -> frozenset[int]:
    """Indices of the actuators that the file declares unused.

    Raises `ModelError` on a name that no actuator has.
    """
    actuators = names(m, mujoco.mjtObj.mjOBJ_ACTUATOR, m.nactuator)
    declared = (text(m, UNUSED) or "").split()
    unknown = [name for name in declared if name not in actuators]
    if unknown:
        raise ModelError(
            f"text '{UNUSED}' names {listed(unknown)}, but the file's actuators are "
            f"{listed(filter(None, actuators))}{meant(unknown[0], actuators)}"
        )
    return frozenset(actuators.index(name) for name in declared)


def misspelt(m: mujoco.MjModel, wheels: Collection[str]) -> Iterator[str]:
    """Entries of <custom> that are nearly one that simsat reads, or speak of no wheel.

    `wheels` are the names of all, failed ones too.
    """
    for entry in names(m, mujoco.mjtObj.mjOBJ_NUMERIC, m.nnumeric):
        yield from _misspelt_number(m, entry, wheels)
    for entry in names(m, mujoco.mjtObj.mjOBJ_TEXT, m.ntext):
        if entry in NUMBERS:
            yield f"text '{entry}': it is a number, write <numeric name='{entry}' data='...'/>"
        elif entry not in TEXTS and (near := _nearest(entry, (UNUSED, FAILED))):
            yield f"text '{entry}' is not known; did you mean '{near}'?"
    for entry in names(m, mujoco.mjtObj.mjOBJ_TUPLE, m.ntuple):
        if entry != RODS and _nearest(entry, (RODS,)):
            yield f"tuple '{entry}' is not known; did you mean '{RODS}'?"


def _misspelt_number(m: mujoco.MjModel, entry: str, wheels: Collection[str]) -> Iterator[str]:
    if entry in NUMBERS:
        return
    owner, dot, quantity = entry.rpartition(".")
    if not dot:
        if near := _nearest(entry, NUMBERS):
            yield f"numeric '{entry}' is not known; did you mean '{near}'?"
    elif (near := _nearest(quantity, NUMBERS)) and near not in OF_A_WHEEL:
        yield f"numeric '{entry}' speaks of one wheel, '{near}' is the whole spacecraft's"
    elif near and quantity not in OF_A_WHEEL:
        yield f"numeric '{entry}' is not known; did you mean '{owner}.{near}'?"
    elif near and owner not in wheels and not _is_joint(m, owner):
        yield (
            f"numeric '{entry}': no wheel is named '{owner}', the wheels' joints are "
            f"{listed(wheels)}{meant(owner, wheels)}"
        )


def unread_custom(m: mujoco.MjModel, wheels: Collection[str]) -> Iterator[str]:
    """Names of the entries of <custom> that nobody reads, `wheels` as in `misspelt`."""
    for entry in names(m, mujoco.mjtObj.mjOBJ_NUMERIC, m.nnumeric):
        owner, _, quantity = entry.rpartition(".")
        if entry not in NUMBERS and not (quantity in OF_A_WHEEL and owner in wheels):
            yield f"numeric '{entry}'"
    for entry in names(m, mujoco.mjtObj.mjOBJ_TEXT, m.ntext):
        if entry not in TEXTS:
            yield f"text '{entry}'"
    for entry in names(m, mujoco.mjtObj.mjOBJ_TUPLE, m.ntuple):
        if entry != RODS:
            yield f"tuple '{entry}'"


def _is_joint(m: mujoco.MjModel, name: str) -> bool:
    return mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_JOINT, name) >= 0


def _nearest(name: str, known: Collection[str]) -> str | None:
    """The known name that this one is a slip of, if it is one; letter case is a slip too."""
    near = get_close_matches(name.lower().replace("-", "_"), known, 1, SIMILAR)
    return near[0] if near else None


def meant(name: str, known: Collection[str]) -> str:
    """A question after the known name that is nearest, if one is near."""
    near = get_close_matches(name, [k for k in known if k], 1, SIMILAR)
    return f"; did you mean '{near[0]}'?" if near else ""


def listed(entries: Collection[str] | Iterator[str]) -> str:
    """Names in quotes, 'none' without any."""
    return ", ".join(f"'{entry}'" for entry in entries) or "none"
