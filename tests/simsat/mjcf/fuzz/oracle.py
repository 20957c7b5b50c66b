"""Is what was accepted flown as it was read? Judged by other means than the reader's self-test.

J, A and Js from each body's own mass, inertia and place in NumPy, not from MuJoCo's mass matrix.
Momentum from each body's velocity, over a longer flight through the plant with its limits and
ramps; and, which the self-test doesn't look at, the energy that the motors put in.
"""

from collections.abc import Iterator
from itertools import pairwise

import mujoco
import numpy as np
from numpy.typing import NDArray

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.mjcf import Model
from simsat.mjcf.rotors import read_rotor
from simsat.plant.plant import Plant

STEPS = 500
NUMBERS = 1e-6  # relative
MOMENTUM = 1e-5  # of the flight's momentum, per 5 s
GAIN = 5e-3  # of the impulse: Coulomb friction is a soft constraint
RATES = 3e-2  # of the rates: nutation at the longest step allowed is 2e-2 late after STEPS steps
ENERGY = 2e-2  # of the energy that went in and out


def objections(model: Model, seed: int = 0) -> Iterator[str]:
    """What is wrong with an accepted model, if anything is."""
    yield from _numbers(model)
    plant = _flown(model, np.random.default_rng(seed))
    yield from _momentum(model, plant)
    yield from _gains(model, plant)
    if not model.passive_joints:
        yield from _energy(model, plant)
        yield from _rates(model, plant)


def _own(m: mujoco.MjModel, bus: int) -> list[int]:
    """Bodies of the spacecraft."""
    return [b for b in range(m.nbody) if m.body_rootid[b] == bus]


def _numbers(model: Model) -> Iterator[str]:
    m, craft, d = model.mj, model.spacecraft, mujoco.MjData(model.mj)
    mujoco.mj_kinematics(m, d)
    own = _own(m, model.bus)
    mass = sum(m.body_mass[b] for b in own)
    centre = sum(m.body_mass[b] * d.xipos[b] for b in own) / mass
    R = d.xmat[model.bus].reshape(3, 3)
    J = R.T @ sum(_inertia_about(m, d, b, centre) for b in own) @ R
    if not abs(mass - craft.mass) <= NUMBERS * mass:
        yield f"mass {craft.mass}, bodies {mass}"
    if not np.abs(J - craft.J).max() <= NUMBERS * np.abs(J).max():
        yield f"J {craft.J}, bodies {J}"
    for i, wheel in enumerate(model.wheels):
        axis, hinge = d.xaxis[wheel.joint], d.xanchor[wheel.joint]
        root = m.jnt_bodyid[wheel.joint]
        turning = [b for b in own if root in _ancestors(m, b)]
        spin = sum(axis @ _inertia_about(m, d, b, hinge) @ axis for b in turning)
        if not abs(spin - craft.Js[i]) <= NUMBERS * spin:
            yield f"Js of '{wheel.name}' {craft.Js[i]}, bodies {spin}"
        if not np.allclose(R.T @ axis, craft.A[:, i], atol=NUMBERS):
            yield f"axis of '{wheel.name}' {craft.A[:, i]}, joint {R.T @ axis}"


def _ancestors(m: mujoco.MjModel, body: int) -> set[int]:
    line = {body}
    while body:
        body = int(m.body_parentid[body])
        line.add(body)
    return line


def _inertia_about(m: mujoco.MjModel, d: mujoco.MjData, body: int, point: Array) -> Array:
    R, r = d.ximat[body].reshape(3, 3), d.xipos[body] - point
    own = (R * m.body_inertia[body]) @ R.T
    return own + m.body_mass[body] * (r @ r * np.eye(3) - np.outer(r, r))


def _flown(model: Model, rng: np.random.Generator) -> Plant:
    """Body rates, wheel bias, passive joints at rest; a random torque every 50 steps."""
    craft, step = model.spacecraft, float(model.mj.opt.timestep)
    plant = Plant(model, step, STEPS)
    fastest = np.minimum(craft.speed_max, 0.3 * np.linalg.eigvalsh(craft.J)[0] / craft.Js)
    plant.reset(
        attitude.normalized(rng.normal(size=4)),
        0.05 * rng.normal(size=3),
        0.5 * np.minimum(fastest, 600.0) * rng.uniform(-1.0, 1.0, craft.wheels),
    )
    gentle = 0.1 * craft.Js * np.maximum(np.minimum(fastest, 600.0), 1.0) / (STEPS * step)
    for _ in range(STEPS // 50):
        plant.advance(np.minimum(craft.torque_max, gentle) * rng.uniform(-1, 1, craft.wheels), 50)
    return plant


def _momentum(model: Model, plant: Plant) -> Iterator[str]:
    m, d = model.mj, mujoco.MjData(model.mj)
    H, P, size = [], [], 0.0
    for row in np.linspace(0, STEPS, 11).astype(int):
        d.qpos[:], d.qvel[:] = plant.log.qpos[row], plant.log.qvel[row]
        mujoco.mj_kinematics(m, d)
        mujoco.mj_comPos(m, d)
        mujoco.mj_comVel(m, d)
        spin, linear, parts = _momentum_now(m, d, model.bus)
        H.append(spin)
        P.append(linear)
        size = max(size, parts)
    gyration = np.sqrt(np.trace(model.spacecraft.J) / model.spacecraft.mass)
    for what, series, scale in (("momentum", H, size), ("linear momentum", P, size / gyration)):
        change = np.abs(np.array(series) - series[0]).max()
        if not change <= MOMENTUM * scale:
            yield f"{what} changes by {change:g} of {scale:g}"


def _momentum_now(m: mujoco.MjModel, d: mujoco.MjData, bus: int) -> tuple[Array, Array, float]:
    """About the centre of mass; linear; and the sum of the sizes of what makes up the first."""
    own, velocity = _own(m, bus), np.zeros(6)
    mass = sum(m.body_mass[b] for b in own)
    centre = sum(m.body_mass[b] * d.xipos[b] for b in own) / mass
    parts, linear = [], []
    for b in own:
        mujoco.mj_objectVelocity(m, d, mujoco.mjtObj.mjOBJ_BODY, b, velocity, 0)
        R = d.ximat[b].reshape(3, 3)
        spin = (R * m.body_inertia[b]) @ R.T @ velocity[:3]
        linear.append(m.body_mass[b] * velocity[3:])
        parts.append(spin + np.cross(d.xipos[b] - centre, linear[-1]))
    total = np.sum(linear, axis=0)
    return np.sum(parts, axis=0), total, float(np.linalg.norm(parts, axis=1).sum())


def _gains(model: Model, plant: Plant) -> Iterator[str]:
    """Each rotor's momentum about its axis: its motor's impulse less viscous and dry friction."""
    if _shaky(model) or _at_limit(model, plant):
        return
    craft, step = model.spacecraft, plant.tick
    spin = craft.Js * (plant.wheel_speeds + plant.rates @ craft.A)
    impulse = step * (0.5 * (plant.torques[1:] + plant.torques[:-1])).sum(axis=0)
    given = step * np.abs(plant.torques).sum(axis=0)
    viscous = (
        step
        * craft.viscous
        * (0.5 * (plant.wheel_speeds[1:] + plant.wheel_speeds[:-1])).sum(axis=0)
    )
    left = spin[-1] - spin[0] - impulse + viscous  # what dry friction took
    dry = craft.coulomb * step * STEPS
    allowed = GAIN * (given + np.abs(viscous) + dry) + 1e-6 * np.abs(spin).max(axis=0)
    for i in np.flatnonzero(np.abs(left) > dry + allowed):
        yield f"rotor of '{craft.wheel_names[i]}' gains {left[i]:g} Nms too much"
    for i in np.flatnonzero(_spinning(plant) & (np.abs(np.abs(left) - dry) > allowed)):
        yield f"dry friction of '{craft.wheel_names[i]}' takes {left[i]:g} Nms, stated {dry[i]:g}"


def _energy(model: Model, plant: Plant) -> Iterator[str]:
    """Kinetic energy against the work of motors and bearings, while no bearing sticks."""
    craft, step = model.spacecraft, plant.tick
    w, speed = plant.rates, plant.wheel_speeds
    sticks = np.any((craft.coulomb > 0.0) & ~_spinning(plant))
    if _shaky(model) or _at_limit(model, plant) or sticks:
        return
    kinetic = 0.5 * np.einsum("ki,ij,kj->k", w, craft.J_hub, w)
    kinetic = kinetic + (0.5 * craft.Js * (speed + w @ craft.A) ** 2).sum(axis=1)
    power = (plant.torques * speed - craft.viscous * speed**2 - craft.coulomb * np.abs(speed)).sum(
        axis=1
    )
    work = step * (0.5 * (power[1:] + power[:-1])).sum()
    moved = step * np.abs(plant.torques * speed).sum() + step * (
        craft.viscous * speed**2 + craft.coulomb * np.abs(speed)
    ).sum()  # fmt: skip
    off = kinetic[-1] - kinetic[0] - work
    if not abs(off) <= ENERGY * moved + 1e-6 * kinetic.max():
        yield f"energy changes by {off:g} J more than the work of {work:g} J"


def _rates(model: Model, plant: Plant) -> Iterator[str]:
    """Body rates against Euler's equation, integrated anew with the torques of the log.

    (J - A Js A') w' = -A (u - c Omega - d sign Omega) - w x (J w + A Js Omega), fourth order, two
    steps in one of the plant's.
    """
    craft, step = model.spacecraft, plant.tick
    if _shaky(model) or np.any(craft.coulomb > 0.0):
        return
    A, Js, inverse = craft.A, craft.Js, np.linalg.inv(craft.J_hub)

    def slope(w: Array, speed: Array, u: Array) -> tuple[Array, Array]:
        net = u - craft.viscous * speed
        turn = inverse @ (-A @ net - np.cross(w, craft.J @ w + A @ (Js * speed)))
        return turn, net / Js - A.T @ turn

    w, speed, h = plant.rates[0], plant.wheel_speeds[0], 0.5 * step
    for before, after in pairwise(plant.torques):
        for first in (0.0, 0.5):
            u = [before + (after - before) * (first + part) for part in (0.0, 0.25, 0.5)]
            a, p = slope(w, speed, u[0])
            b, q = slope(w + 0.5 * h * a, speed + 0.5 * h * p, u[1])
            c, r = slope(w + 0.5 * h * b, speed + 0.5 * h * q, u[1])
            d, s = slope(w + h * c, speed + h * r, u[2])
            w = w + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
            speed = speed + h / 6.0 * (p + 2.0 * q + 2.0 * r + s)
    off, most = np.linalg.norm(plant.rates[-1] - w), np.linalg.norm(plant.rates, axis=1).max()
    if not off <= RATES * most and not _at_limit(model, plant):
        yield f"body rates are {off:g} off Euler's equation, of {most:g} rad/s"


def _spinning(plant: Plant) -> NDArray[np.bool_]:
    """Which wheels turn all the time: where dry friction holds one, it creeps."""
    speed = np.abs(plant.wheel_speeds)
    return np.asarray(speed.min(axis=0) > 0.01 * speed.max(axis=0))


def _at_limit(model: Model, plant: Plant) -> bool:
    """Near its speed limit a wheel's torque changes within a step, unseen by the log."""
    return bool(np.any(np.abs(plant.wheel_speeds) > 0.8 * model.spacecraft.speed_max))


def _shaky(model: Model) -> bool:
    """Rotors out of balance swap momentum and energy with the bus at wheel speed."""
    return any(read_rotor(model.mj, wheel.joint).imbalance > 1e-6 for wheel in model.wheels)
