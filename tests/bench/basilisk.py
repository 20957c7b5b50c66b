"""The reference cases flown live by Basilisk and by the plant: python -m tests.bench.basilisk.

Needs Basilisk (`pip install bsk`), which is no dependency of the project. Its MJScene is MuJoCo and
would judge nothing; this is its own spacecraft with balanced wheels. Two tables: how far both are
from each other and from the DOP853 reference, and their speed at the same accuracy.
"""

import time
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from Basilisk.architecture import messaging
from Basilisk.simulation import (
    GravityGradientEffector,
    reactionWheelStateEffector,
    spacecraft,
    svIntegrators,
)
from Basilisk.utilities import SimulationBaseClass, macros, simIncludeGravBody, simIncludeRW

from simsat.control.ground.arrays import Array
from simsat.environment import build_environment
from simsat.environment.earth import MU
from simsat.mjcf import interpret
from simsat.plant.plant import Plant
from tests.reference_cases import NAMES, Case, angle_deg, load_case

REPEATS = 5
RPM = 2.0 * np.pi / 60.0


@dataclass(frozen=True)
class Trajectory:
    """States at the reference's times, and what they took."""

    q: Array
    omega: Array
    wheel_speed: Array
    seconds: float


def by_plant(case: Case, step: float) -> Trajectory:
    """Our plant, RK4 at `step` (s), torques held over ticks of 50 ms."""
    model = interpret(mujoco.MjModel.from_xml_string(case.xml), case.name)
    model.mj.opt.timestep = step
    env = build_environment(model.spacecraft, case.orbit, case.environment)
    u, ticks = case.data["u"], round(float(case.data["dt_u"]) / 0.05)
    plant = Plant(model, 0.05, len(u) * ticks, env.torque if env.models else None)
    plant.reset(case.data["q0"], case.data["w0"], case.data["Om0"])
    started = time.process_time()
    for row in u:
        plant.advance(row, ticks)
    seconds = time.process_time() - started
    rows = np.rint(case.data["t"] / 0.05).astype(int)
    return Trajectory(plant.attitudes[rows], plant.rates[rows], plant.wheel_speeds[rows], seconds)


def by_basilisk(case: Case, step: float) -> Trajectory:
    """Basilisk's spacecraft with balanced wheels, RK4 at `step` (s), without its logging."""
    data, m = case.data, len(case.data["g"])
    sim = SimulationBaseClass.SimBaseClass()
    sim.CreateNewProcess("p").addTask(sim.CreateNewTask("t", macros.sec2nano(step)))
    craft = spacecraft.Spacecraft()
    craft.hub.mHub = 50.0
    craft.hub.IHubPntBc_B = data["J"].tolist()
    q0 = data["q0"]
    craft.hub.sigma_BNInit = (q0[1:] / (1.0 + q0[0]))[:, None].tolist()
    craft.hub.omega_BN_BInit = data["w0"][:, None].tolist()
    wheels = simIncludeRW.rwFactory()
    for i in range(m):
        wheels.create(
            "custom", data["g"][i].tolist(), Omega=float(data["Om0"][i] / RPM),
            Js=float(data["Js"]), useMaxTorque=False, RWModel=messaging.BalancedWheels,
            useRWfriction="fric_torque" in data, cViscous=4e-6 if "fric_torque" in data else 0.0,
        )  # fmt: skip
    rotors = reactionWheelStateEffector.ReactionWheelStateEffector()
    wheels.addToSpacecraft("wheels", rotors, craft)
    command = messaging.ArrayMotorTorqueMsg()
    rotors.rwMotorCmdInMsg.subscribeTo(command)
    if "r_N" in data:
        _add_gravity(sim, craft, data)
    integrator = svIntegrators.svIntegratorRK4(craft)
    craft.setIntegrator(integrator)
    sim.AddModelToTask("t", rotors)
    sim.AddModelToTask("t", craft)
    sim.InitializeSimulation()
    states = [_state(craft, data["Om0"], m)]
    started = time.process_time()
    for k, row in enumerate(data["u"]):
        command.write(messaging.ArrayMotorTorqueMsgPayload(motorTorque=row.tolist()), 0)
        stop = macros.sec2nano((k + 1) * float(data["dt_u"]))
        sim.ConfigureStopTime(stop)
        sim.ExecuteSimulation()
        rotors.WriteOutputMessages(stop)  # else its speeds are one step old
        states.append(_state(craft, rotors.rwSpeedOutMsg.read().wheelSpeeds, m))
    seconds = time.process_time() - started
    sigma, omega, speed = (np.array(part) for part in zip(*states, strict=True))
    square = np.sum(sigma**2, axis=1, keepdims=True)
    q = np.concatenate([1.0 - square, 2.0 * sigma], axis=1) / (1.0 + square)
    return Trajectory(q, omega, speed, seconds)


def _add_gravity(sim: Any, craft: Any, data: dict[str, Array]) -> None:
    """Point-mass Earth, the reference's orbit and its gravity-gradient torque."""
    bodies = simIncludeGravBody.gravBodyFactory()
    earth = bodies.createEarth()
    earth.isCentralBody = True
    earth.mu = MU
    bodies.addBodiesTo(craft)
    craft.hub.r_CN_NInit = data["r_N"][0][:, None].tolist()
    craft.hub.v_CN_NInit = data["v_N"][0][:, None].tolist()
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)
    craft.addDynamicEffector(gradient)
    sim.AddModelToTask("t", gradient)


def _state(craft: Any, wheel_speeds: Array, m: int) -> tuple[Array, Array, Array]:
    message = craft.scStateOutMsg.read()
    return (
        np.array(message.sigma_BN),
        np.array(message.omega_BN_B),
        np.array(wheel_speeds[:m], float),
    )


def main() -> None:
    """Print both tables."""
    print("| case | plant - Basilisk, deg | rad/s | wheels rad/s | plant - DOP853, deg | "
          "Basilisk - DOP853, deg |")  # fmt: skip
    print("| --- | --- | --- | --- | --- | --- |")
    for name in NAMES:
        case = load_case(name)
        ours, theirs = by_plant(case, 0.01), by_basilisk(case, 0.01)
        print(
            f"| {name} | {angle_deg(ours.q, theirs.q).max():.1e} | "
            f"{np.abs(ours.omega - theirs.omega).max():.1e} | "
            f"{np.abs(ours.wheel_speed - theirs.wheel_speed).max():.1e} | "
            f"{angle_deg(ours.q, case.data['q']).max():.1e} | "
            f"{angle_deg(theirs.q, case.data['q']).max():.1e} |"
        )
    case = load_case("f_bias_2rw")
    print("\n| f_bias_2rw, RK4 | attitude error, deg | simulated s per processor s |")
    print("| --- | --- | --- |")
    for step in (0.05, 0.01):
        for label, fly in (("plant", by_plant), ("Basilisk", by_basilisk)):
            flights = [fly(case, step) for _ in range(REPEATS)]
            error = angle_deg(flights[0].q, case.data["q"]).max()
            speed = float(case.data["t"][-1]) / min(flight.seconds for flight in flights)
            print(f"| {label}, {1e3 * step:g} ms | {error:.1e} | {speed:.0f} |")


if __name__ == "__main__":
    main()
