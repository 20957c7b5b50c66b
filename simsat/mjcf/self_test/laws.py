"""Does MuJoCo fly a model as it was read? Kicked for a few steps before any flight, some 2 ms.

Four laws of a spacecraft in free space, which hold whatever the file says and need no list of what
could break them:

1. Total momentum about the centre of mass is kept, linear momentum too.
2. It is H_B = J w + A (Js * Omega) with the J, A and Js that were read.
3. A rotor's own momentum Js (Omega + A'w) gains what its motor gives, less friction.
4. Half the step gives the same body rates: momentum is kept even where nutation is damped away.

Momenta come from MuJoCo's body velocities, J and Js from its mass matrix, so that one checks the
other. Every tolerance is a share of the spacecraft's own momenta: a craft of any size is judged
alike. Law 2 is asked of unit rates at the reference, and after a flight where nothing else moves;
law 1 with passive joints moving too. A rotor out of balance is forgiven what its imbalance does.
"""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array, WheelVector
from simsat.control.ground.spacecraft import Spacecraft
from simsat.mjcf.rotors import Rotor
from simsat.mjcf.self_test.bench import Bench, Motion
from simsat.mjcf.wheels import WheelDrive

STEPS = 20
# Rates and times are in the craft's own second (`control.ground.units`), the benchmark's 1 s.
BODY_RATE = 0.1  # rad/s; a fast slew
WHEEL_SPEED = 628.0  # rad/s; 6000 rpm, where the file states no limit
PUSH = 0.1  # rad; how far a push at most turns a wheel against the bus
KICK = np.array([0.48, -0.64, 0.6])  # along no axis in particular

AGREES = 1e-8  # of J or Js: two ways to the same number, through offsets from the body's origin
DRIFT = 1e-6  # of the momentum per s: 0.006 deg in 100 s
SWING = 1e-4  # the same of what swings: at the longest step that is allowed it errs by 2e-5
SHAKEN = 1e-5  # of what rotors out of balance shake: within a turn RK4 errs by 2e-6 of it
ROUNDING = 1e-11  # of the momentum, in STEPS steps
IMPULSE = 1e-3  # of a motor's or a bearing's; friction at a joint is a soft constraint
COARSE = 2e-3  # of BODY_RATE; a twentieth of a turn per step errs by 5e-4 in STEPS steps
SPINNING = 0.1  # of its momentum left: friction has not brought the rotor to a stop

FLOWN = "MuJoCo does not fly this file as it was read:"
REMEDY = "something acts that is not known here, or <option timestep> is too long"


def flown_otherwise(
    m: mujoco.MjModel,
    free: int,
    wheels: Sequence[WheelDrive],
    rotors: Sequence[Rotor],
    craft: Spacecraft,
) -> Iterator[str]:
    """How MuJoCo's flight differs from the model as it was read, one sentence per law broken.

    `m` is the model as the plant steps it (`stepped`).
    """
    bench = Bench(m, free, wheels, rotors, craft)
    yield from _wrong_numbers(bench)
    yield from _torque_not_given(bench)
    yield from _flight(bench, "coasting", _coast(bench), np.zeros(craft.wheels))
    yield from _flight(bench, "under torque", _rest(bench), _push(bench))
    yield from _too_coarse(bench)


def _wrong_numbers(bench: Bench) -> Iterator[str]:
    """J, A and Js against the momenta of unit rates."""
    craft, columns = bench.craft, bench.columns
    off = np.abs(columns[:, bench.turning] - craft.J).max() / np.abs(craft.J).max()
    if not off <= AGREES:
        yield f"{FLOWN} J is off by {100.0 * off:.2g} %"
    for i, name in enumerate(craft.wheel_names):
        missed = columns[:, bench.dofs[i]] - craft.A[:, i] * craft.Js[i]
        off = np.linalg.norm(missed) / craft.Js[i]
        if not off <= AGREES + bench.shake[i]:
            yield f"{FLOWN} the momentum of a turning '{name}' is off by {100.0 * off:.2g} %"


def _torque_not_given(bench: Bench) -> Iterator[str]:
    """At its limit every motor pushes its own joint, and nothing else, with that torque."""
    stated = np.where(np.isfinite(bench.craft.torque_max), bench.craft.torque_max, 1.0)
    expected = np.zeros(bench.m.nv)
    expected[bench.dofs] = stated
    off = np.abs(bench.force_of(stated) - expected)
    if not np.all(off <= AGREES * stated.max()):
        joint = bench.m.joint(int(bench.m.dof_jntid[int(np.argmax(off))])).name
        yield (
            f"{FLOWN} with the motors at their limits the force on joint '{joint}' is off by "
            f"{off.max():.3g} Nm"
        )


def _coast(bench: Bench) -> Array:
    """Rates of everything: body, wheels at their limits, passive joints, and a drift."""
    rates = np.zeros(bench.m.nv)
    rate = _body_rate(bench.craft)
    rates[bench.linear] = -rate * bench.gyration * KICK
    rates[bench.turning] = rate * KICK
    rates[bench.dofs] = _speeds(bench.craft)
    for dof in bench.passive:
        slides = bench.m.jnt_type[bench.m.dof_jntid[dof]] == mujoco.mjtJoint.mjJNT_SLIDE
        rates[dof] = rate * (bench.gyration if slides else 1.0)
    return rates


def _speeds(craft: Spacecraft) -> WheelVector:
    """Wheels at their speed limits, to and fro; without a limit at most the bus's own momentum."""
    most = WHEEL_SPEED * craft.own_units.rate
    free = np.minimum(most, _body_rate(craft) * np.linalg.eigvalsh(craft.J)[0] / craft.Js)
    speeds: WheelVector = np.where(np.isfinite(craft.speed_max), craft.speed_max, free)
    return speeds * np.resize([1.0, -0.9, 0.8], craft.wheels)


def _rest(bench: Bench) -> Array:
    """At rest, but for wheels with Coulomb friction, which need to turn to have a known one."""
    rates = np.zeros(bench.m.nv)
    rates[bench.dofs] = np.where(bench.craft.coulomb > 0.0, np.abs(_speeds(bench.craft)), 0.0)
    return rates


def _body_rate(craft: Spacecraft) -> float:
    return BODY_RATE * craft.own_units.rate


def _time(bench: Bench) -> float:
    return STEPS * float(bench.m.opt.timestep)


def _drift(bench: Bench) -> float:
    """Share of the momentum that may be lost in a flight."""
    return DRIFT * _time(bench) / bench.craft.own_units.time + ROUNDING


def _push(bench: Bench) -> WheelVector:
    """Torques, Nm, within all limits and gentle enough for the step."""
    craft, time = bench.craft, _time(bench)
    gentle = PUSH * craft.Js / time**2
    torque: WheelVector = np.minimum(gentle, craft.torque_max)
    return np.minimum(torque, craft.torque_rate_max * time)


def _flight(bench: Bench, how: str, rates: Array, torque: WheelVector) -> Iterator[str]:
    """Every law that a flight of a few steps breaks."""
    bench.start(rates)
    bench.command(torque, _time(bench))
    before = bench.motion()
    impulse = np.sum([bench.step() for _ in range(STEPS)], axis=0)
    if broken := bench.breakdown():
        yield f"{FLOWN} {how} it breaks down: {broken}"
        return
    after = bench.motion()
    yield from _momentum_changed(bench, how, before, after)
    yield from _wrong_gains(bench, how, before, after, impulse)


def _momentum_changed(bench: Bench, how: str, before: Motion, after: Motion) -> Iterator[str]:
    """Laws 1 and 2."""
    time, drift = _time(bench), _drift(bench)
    size, push = max(before.size, after.size), max(before.push, after.push)
    spin = np.maximum(np.abs(before.spin), np.abs(after.spin))
    swing = SWING * time * bench.craft.own_units.rate * max(before.swing, after.swing)
    swing += SHAKEN * float(bench.shake @ spin)
    for what, unit, change, of, forgiven in (
        ("momentum", "Nms", after.H_N - before.H_N, size, swing),
        ("linear momentum", "kg m/s", after.P_N - before.P_N, push, swing / bench.gyration),
    ):
        changed = float(np.linalg.norm(change))
        if not changed <= drift * of + forgiven:
            yield (
                f"{FLOWN} {how} the total {what} changes by {changed:.3g} {unit} in {time:g} s "
                f"(of {of:.3g}); {REMEDY}"
            )
    if len(bench.passive) > 0:
        return
    forgiven = 4.0 * float(bench.shake @ spin)
    off = float(np.linalg.norm(after.H_N - after.H_read))
    if not off <= (drift + AGREES) * size + forgiven:
        yield f"{FLOWN} {how} J w + A Js Omega misses {off:.3g} of {size:.3g} Nms; {REMEDY}"


def _wrong_gains(
    bench: Bench, how: str, before: Motion, after: Motion, impulse: WheelVector
) -> Iterator[str]:
    """Law 3: what dry friction took, its only unknown, against what it takes while turning."""
    craft, time = bench.craft, _time(bench)
    turned, gained = after.angle - before.angle, after.spin - before.spin
    viscous, dry = craft.viscous * turned, craft.coulomb * time
    taken = impulse - viscous - gained
    most = np.maximum(np.abs(before.spin), np.abs(after.spin))
    allowed = IMPULSE * (np.abs(impulse) + np.abs(viscous) + dry) + _drift(bench) * most
    allowed += bench.shake * craft.Js * _body_rate(craft) * (4.0 + 2.0 * np.abs(turned))
    spinning = after.spin * np.sign(before.spin) > SPINNING * np.abs(before.spin)
    off = np.where(
        spinning, np.abs(taken - dry * np.sign(turned)), np.maximum(np.abs(taken) - dry, 0.0)
    )
    for i in np.flatnonzero(~(off <= allowed)):
        yield (
            f"{FLOWN} {how} the rotor of '{craft.wheel_names[i]}' gains {gained[i]:.3g} Nms in "
            f"{time:g} s, which is {off[i]:.3g} off what motor and friction give; {REMEDY}"
        )


def _too_coarse(bench: Bench) -> Iterator[str]:
    """Law 4, unless a passive joint rubs or meets its stop: those yield with the step."""
    held = bench.m.dof_frictionloss[bench.passive].any() or bench.m.jnt_limited.any()
    if held:
        return
    step, ends = float(bench.m.opt.timestep), []
    for parts in (1, 2):
        bench.m.opt.timestep = step / parts
        bench.start(_coast(bench))
        mujoco.mj_step(bench.m, bench.d, nstep=STEPS * parts)
        ends.append(bench.d.qvel[bench.turning].copy())
    bench.m.opt.timestep = step
    off = float(np.linalg.norm(ends[1] - ends[0]))
    if not off <= COARSE * _body_rate(bench.craft):
        yield (
            f"{FLOWN} after {_time(bench):g} s with wheels at their limits the body rates are "
            f"{off:.2g} rad/s off those with half the step; <option timestep='{step:g}'> is too "
            "long"
        )
