"""Refusals of <option>, <flag> and <statistic>: what free flight needs MuJoCo to do."""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array

FRICTION_TOLERANCE = 1e-12  # solver tolerance above which Coulomb friction leaks momentum
ITERATIONS = (100, 1000)  # of the solver: MuJoCo's default, fewer leave friction short of its
# value; a thousand take a millisecond per step
INERTIA_AGREES = 1e-6  # relative; a file may state what MuJoCo would find by itself

OFF = mujoco.mjtDisableBit
MAY_BE_OFF = (  # without effect on a flight without contacts, gravity and Euler steps
    OFF.mjDSBL_CONTACT,
    OFF.mjDSBL_AUTORESET,
    OFF.mjDSBL_GRAVITY,
    OFF.mjDSBL_SENSOR,
    OFF.mjDSBL_FILTERPARENT,
    OFF.mjDSBL_MIDPHASE,
    OFF.mjDSBL_NATIVECCD,
    OFF.mjDSBL_MULTICCD,
    OFF.mjDSBL_EULERDAMP,
    OFF.mjDSBL_ISLAND,
)
MAY_BE_ON = (mujoco.mjtEnableBit.mjENBL_ENERGY,)  # it is only computed


def wrong_options(m: mujoco.MjModel) -> Iterator[str]:
    """Every option under which free flight is wrong."""
    option = m.opt
    if option.integrator != mujoco.mjtIntegrator.mjINT_RK4:
        used = mujoco.mjtIntegrator(option.integrator).name.removeprefix("mjINT_")
        yield f"<option integrator='{used}'>: attitude drifts by degrees; use 'RK4'"
    if np.any(option.gravity != 0.0):
        yield (
            f"<option gravity='{_row(option.gravity)}'>: a spacecraft in orbit is in free fall; "
            "use gravity='0 0 0' (gravity gradient is added by the simulator)"
        )
    if option.density != 0.0 or option.viscosity != 0.0 or np.any(option.wind != 0.0):
        yield (
            "<option density/viscosity/wind>: MuJoCo's fluid is not a thin atmosphere; leave them "
            "at 0 (drag is added by the simulator)"
        )
    yield from _flags(m)
    yield from _solver(m)


def _flags(m: mujoco.MjModel) -> Iterator[str]:
    off, on = int(m.opt.disableflags), int(m.opt.enableflags)
    if not off & OFF.mjDSBL_AUTORESET:
        yield (
            "<flag autoreset>: MuJoCo would restart silently after a divergence; add "
            "<option><flag autoreset='disable'/></option>"
        )
    if not off & OFF.mjDSBL_CONTACT and _can_touch(m):
        yield (
            "<flag contact>: geoms of rotors and bus would collide; add "
            "<option><flag contact='disable'/></option>"
        )
    for name in _set_bits(off, OFF, MAY_BE_OFF):
        yield (
            f"<flag {name}='disable'>: friction, stops, springs, dampers and motors act here as "
            "the file states them; remove the flag, and what you don't want from the file"
        )
    for name in _set_bits(on, mujoco.mjtEnableBit, MAY_BE_ON):
        yield f"<flag {name}='enable'>: it is not interpreted here; remove the flag"


def _set_bits(flags: int, kinds: Any, allowed: tuple[int, ...]) -> Iterator[str]:
    """Names of the bits that are set and not allowed, of bits without a name their number."""
    names = {
        int(value): name.split("_")[1].lower()
        for name, value in kinds.__members__.items()
        if "_" in name  # not the count of flags
    }
    for bit in (1 << k for k in range(flags.bit_length())):
        if flags & bit and bit not in map(int, allowed):
            yield names.get(bit, f"number {bit.bit_length() - 1}")


def _can_touch(m: mujoco.MjModel) -> bool:
    pairs = np.any(m.geom_contype) and np.any(m.geom_conaffinity) and m.ngeom > 1
    return bool(pairs) or m.npair > 0


def _solver(m: mujoco.MjModel) -> Iterator[str]:
    """Coulomb friction and stops are constraints, as good as their solver's settings."""
    if np.any(m.dof_frictionloss > 0.0) and not m.opt.tolerance <= FRICTION_TOLERANCE:
        yield (
            f"<option tolerance='{m.opt.tolerance:g}'> with frictionloss leaks momentum; "
            f"use tolerance='1e-15' (at most {FRICTION_TOLERANCE:g})"
        )
    fewest, most = ITERATIONS
    if not fewest <= m.opt.iterations <= most:
        yield (
            f"<option iterations='{m.opt.iterations}'>: friction would be cut short or take for "
            f"ever; give {fewest} (MuJoCo's default) to {most}"
        )
    meant = float(np.mean(m.dof_M0)) if m.nv else 0.0
    if not abs(m.stat.meaninertia - meant) <= INERTIA_AGREES * meant:
        yield (
            f"<statistic meaninertia='{m.stat.meaninertia:g}'>: it tells the solver of friction "
            f"when to end, and the file's own mean is {meant:g}; remove it"
        )


def _row(values: Array) -> str:
    return " ".join(f"{v:g}" for v in values)
