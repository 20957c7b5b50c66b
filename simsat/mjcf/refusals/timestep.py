"""Refusals of the time step: its range, and motions of the spacecraft that it can't follow."""

import itertools
import math
from collections.abc import Iterator, Mapping

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Spacecraft
from simsat.mjcf.rotors import Rotor

# In the craft's own seconds (`control.ground.units`), the benchmark's 1 s:
SHORTEST = 1e-5  # a flight of 100 takes 80 s, and Ctrl-C or SIGTERM is heard in half a second
LONGEST = 0.05  # the usual interval between samples, which a step must divide
USUAL = 0.01
STEP_TURNS = 1.0 / 20.0  # of a turn, or of a decay time over 2 pi, per step: RK4 errs by 2e-5 of it
TURNS_UNLIMITED = 100.0  # per s; how fast a wheel without a speed limit is taken to turn
OUT_OF_BALANCE = 0.01
"""Imbalance from which a turning body is no wheel (see `Rotor.imbalance`). J moves by this share of
the spin inertia, unknown to every controller. Reaction wheels are made to 1e-4; at 1e-2 a rotor of
0.8 kg at 6000 rpm pulls with 130 N at its bearing. A panel driven at its edge has 0.9, a sheet that
turns about its own middle line 1."""
ROUND = 1e-9
"""Imbalance below which a rotor is round. At 6000 rpm and 10 ms a product of inertia of 1e-6 spin
inertias leaks 2e-4 Nm, one of 1e-8 costs 0.015 deg in 100 s, one of 1e-9 0.0015 deg: less than a
gravity gradient that is held over a sample does."""


def wrong_timestep(m: mujoco.MjModel) -> Iterator[str]:
    """A step that is no time."""
    step = float(m.opt.timestep)
    if not step > 0.0:
        yield f"<option timestep='{step:g}'>: it must be above zero, usually {USUAL:g} s"


def unsuited_timestep(m: mujoco.MjModel, craft: Spacecraft) -> Iterator[str]:
    """A step that never ends a flight of this spacecraft, or is longer than a sample of it."""
    step, second = float(m.opt.timestep), craft.own_units.time
    if not SHORTEST <= step / second <= LONGEST:
        yield (
            f"<option timestep='{step:g}'>: for {craft.name} it must be from "
            f"{SHORTEST * second:.3g} to {LONGEST * second:.3g} s, usually {USUAL * second:.1g}"
        )


def unseen_turns(
    m: mujoco.MjModel, rotors: Mapping[str, Rotor], speed_max: Mapping[str, float]
) -> Iterator[str]:
    """Rotors out of balance that turn too far in a step, those of no wheel (`rotors`) left out.

    `speed_max` in rad/s, both by the names of the wheels.
    """
    for name, rotor in rotors.items():
        speed = speed_max[name]
        turns = speed / (2.0 * math.pi) if math.isfinite(speed) else TURNS_UNLIMITED
        longest = STEP_TURNS / turns
        unbalanced = ROUND < rotor.imbalance <= OUT_OF_BALANCE
        if unbalanced and m.opt.timestep > longest * (1.0 + 1e-9):
            how, remedy = describe_imbalance(m, rotor, ROUND)
            yield (f"wheel '{name}' is imbalanced ({how}): {remedy}, else {_too_long(m, longest)}")


def describe_imbalance(m: mujoco.MjModel, rotor: Rotor, allowed: float) -> tuple[str, str]:
    """The first way in which a rotor is further out of balance than allowed, and its remedy."""
    body = m.body(int(m.jnt_bodyid[rotor.joint])).name
    if rotor.eccentricity > allowed:
        off, share = float(np.linalg.norm(rotor.offset)), 100.0 * rotor.eccentricity
        return (
            f"the centre of mass of '{body}' is {off:.3g} m off its hinge, {share:.2g} % of its "
            "radius of gyration"
        ), "move it onto the axis"
    if rotor.wobble > allowed:
        return (
            f"its axis is no principal axis of '{body}', product of inertia {rotor.product:.2g} "
            "kg m^2"
        ), "tilt the rotor's <body zaxis='...'>, not its joint"
    return (
        f"the moments of inertia of '{body}' across the axis differ by "
        f"{100.0 * rotor.flatness:.2g} % of that about it"
    ), "make it round"


def unseen_swings(m: mujoco.MjModel, M: Array) -> Iterator[str]:
    """Springs and dampers whose motion, the rest held or not, is too fast for the step.

    Undamped frequencies are the roots of det(K - w^2 M), decay rates those of det(D - r M), `M` the
    joint-space mass matrix at the reference.
    """
    stiffness = np.zeros(m.nv)
    for j in np.flatnonzero(m.jnt_stiffness):
        stiffness[m.jnt_dofadr[j]] = m.jnt_stiffness[j]
    swing, fastest = _fastest(stiffness, M)
    decay, heaviest = _fastest(m.dof_damping, M)
    for rate, dof, verb in ((math.sqrt(swing), fastest, "swings"), (decay, heaviest, "is braked")):
        longest = 2.0 * math.pi * STEP_TURNS / rate if rate > 0.0 else math.inf
        if m.opt.timestep > longest:
            name = m.joint(int(m.dof_jntid[dof])).name or f"number {int(m.dof_jntid[dof]) + 1}"
            yield f"joint '{name}' {verb} at {rate:.3g} rad/s: {_too_long(m, longest)}"


def unseen_nutation(m: mujoco.MjModel, craft: Spacecraft) -> Iterator[str]:
    """A spacecraft that its wheels, all at their speed limits, make nutate too fast for the step.

    A gyrostat with wheel momentum h nutates at |h| over the geometric mean of the moments of
    inertia across h, here the two smallest of the hub. MuJoCo damps it numerically, and keeps the
    momentum while doing so.
    """
    if not np.isfinite(craft.momentum_max).all():
        return
    signs = np.array(list(itertools.product((1.0, -1.0), repeat=craft.wheels)))
    most = float(np.linalg.norm((signs * craft.momentum_max) @ craft.A.T, axis=1).max())
    smallest, second, _ = np.linalg.eigvalsh(craft.J_hub)
    rate = most / math.sqrt(smallest * second)
    longest = 2.0 * math.pi * STEP_TURNS / rate
    if m.opt.timestep > longest:
        yield (
            f"with its wheels at their speed limits the spacecraft nutates at {rate:.3g} rad/s: "
            f"{_too_long(m, longest)}"
        )


def _too_long(m: mujoco.MjModel, longest: float) -> str:
    """What the step must be, rounded down, or that none is short enough."""
    digit = 10.0 ** (math.floor(math.log10(longest)) - 2)
    rounded = math.floor(longest / digit * (1.0 + 1e-9)) * digit
    if rounded < SHORTEST:
        return f"no step from {SHORTEST:g} s up is short enough, is its unit right?"
    return f"<option timestep='{m.opt.timestep:g}'> must be at most {rounded:.3g} s"


def _fastest(coefficients: Array, M: Array) -> tuple[float, int]:
    """Largest root of det(diag(coefficients) - r M), and the degree of freedom that moves most."""
    active = np.flatnonzero(coefficients > 0.0)
    if len(active) == 0:
        return 0.0, 0
    root = np.sqrt(coefficients[active])
    compliance = np.linalg.inv(M)[np.ix_(active, active)]
    values, vectors = np.linalg.eigh(root[:, None] * compliance * root)
    return float(max(values[-1], 0.0)), int(active[np.argmax(np.abs(vectors[:, -1]))])
