"""The plant against bare mj_step at the same step: python -m tests.bench.plant_speed.

Same file, same number of steps, rounds interleaved in one process, processor time. The bare loop is
a Python call per step and nothing else; with a wrench on the bus MuJoCo itself has more to do. The
plant adds torque ramps, limits and the log of every tick, and the environment.
"""

import statistics
import time
from collections.abc import Callable

import mujoco
import numpy as np

from simsat.environment import EnvironmentSettings, OrbitSettings, build_environment
from simsat.mjcf import Model, read_model
from simsat.mjcf.shipped import MODELS
from simsat.plant.plant import ExternalTorque, Plant

SECONDS, TICK, PERIOD = 100.0, 0.05, 0.5
REPEATS = 15


def bare(model: Model, torque: float) -> float:
    """Seconds for the physics steps alone, under a torque (Nm) on the bus."""
    m, d = model.mj, mujoco.MjData(model.mj)
    d.qvel[:] = 0.05  # at rest MuJoCo skips work
    d.act[:] = 0.01
    d.xfrc_applied[model.bus, 3] = torque
    steps = round(SECONDS / m.opt.timestep)
    started = time.process_time()
    for _ in range(steps):
        mujoco.mj_step(m, d)
    return time.process_time() - started


def flown(model: Model, external: ExternalTorque | None) -> float:
    """Seconds for the plant under half-second steps of torque, logging every tick."""
    periods, ticks = round(SECONDS / PERIOD), round(PERIOD / TICK)
    plant = Plant(model, TICK, periods * ticks, external)
    plant.reset(np.array([0.8, 0.0, 0.6, 0.0]))
    torque = 0.02 * np.random.default_rng(1).uniform(-1.0, 1.0, (periods, model.spacecraft.wheels))
    started = time.process_time()
    for row in torque:
        plant.advance(row, ticks)
    return time.process_time() - started


def main() -> None:
    """Print the table."""
    model = read_model(MODELS / "two_wheel" / "two_wheel.xml")
    env = build_environment(model.spacecraft, OrbitSettings(), EnvironmentSettings())
    cases: dict[str, Callable[[], float]] = {
        "bare mj_step": lambda: bare(model, 0.0),
        "bare mj_step, a wrench on the bus": lambda: bare(model, 1e-6),
        "plant": lambda: flown(model, None),
        "plant, gravity gradient and drag": lambda: flown(model, env.torque),
    }
    times: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(REPEATS):
        for name, case in cases.items():
            times[name].append(case())
    steps = round(SECONDS / model.mj.opt.timestep)
    reference = min(times["bare mj_step"])
    print(f"| {SECONDS:g} s, {steps} RK4 steps | fastest s | median s | us a step | speed |")
    print("| --- | --- | --- | --- | --- |")
    for name, seconds in times.items():
        fastest = min(seconds)
        print(
            f"| {name} | {fastest:.4f} | {statistics.median(seconds):.4f} | "
            f"{1e6 * fastest / steps:.2f} | {100.0 * reference / fastest:.0f} % |"
        )


if __name__ == "__main__":
    main()
