"""The closed loop: sense, plan, correct, supervise, actuate, record."""

import gc
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from simsat.control.ground.arrays import Array, RodVector, WheelVector
from simsat.control.ground.errors import DivergedError, PluginError
from simsat.control.ground.magnetorquers import Magnetorquers
from simsat.control.ground.spacecraft import Spacecraft, with_rods_on_for
from simsat.control.interface.belief import Belief
from simsat.control.interface.blind import NO_VERDICT, no_correction, plan_blind
from simsat.control.interface.door import Refusal, admit
from simsat.control.interface.layers import Correction, InTransit, Memory, Pilot
from simsat.control.interface.measurement import History, Measurement
from simsat.control.interface.plan import Plan
from simsat.control.interface.verdict import Verdict
from simsat.flight.delay import empty_line
from simsat.plant.plant import Plant

SOLVER_PATIENCE = 40  # consecutive control periods without a solved plan before giving up


class Ending(Enum):
    """How a flight ended; the value is a sentence."""

    COMPLETE = "flown to the end"
    DIVERGED = "the simulation diverged"
    INTERRUPTED = "interrupted from outside"
    SOLVER_LOST = "the planner found no solution for too long"
    PLUGIN_FAILED = "code of the user's own failed"


@dataclass(frozen=True)
class Step:
    """What was decided at one control instant."""

    t: float
    plan: Plan
    correction: Correction | None
    verdict: Verdict | None
    command: WheelVector
    """Plan plus accepted correction inside the torque limits, Nm."""
    plan_time_s: float
    """Wall time the planner took."""
    dipole: RodVector
    """The plan's dipoles inside the rods' limits, A m^2; empty without rods."""
    refusal: Refusal | None = None
    """Why the measurement was refused, if it was."""
    seen: Measurement | None = None
    """What the layers were told, unless it was refused."""
    estimator: Mapping[str, float] = field(default_factory=dict)
    """What the estimator has to say."""


@dataclass(frozen=True)
class Memories:
    """What each layer remembers; None is a layer that has just been switched on."""

    planner: Memory = None
    corrector: Memory = None
    supervisor: Memory = None
    seen: Measurement | None = None
    """The measurement that was admitted last (see `door`)."""
    estimator: Memory = None
    belief: Belief | None = None
    """What the planner has learned of the craft."""


@dataclass
class Flight:
    """A flight so far: the plant with its log of the truth, and every decision."""

    plant: Plant
    ticks_per_period: int
    steps: list[Step] = field(default_factory=list)
    commands: list[WheelVector] = field(default_factory=list)
    """Mean torque commanded to act over each period, Nm; a replay has these and no steps."""
    ending: Ending = Ending.COMPLETE
    reason: str = Ending.COMPLETE.value

    def held_commands(self) -> Array:
        """The command in force at every sample, Nm, shape (rows, m); the last one is repeated."""
        return self.held_commands_since(0)

    def held_commands_since(self, row: int) -> Array:
        """The same from a row of the log on."""
        log = self.plant.log
        if not self.commands:
            return np.zeros((log.rows - row, log.torque.shape[1]))
        ticks = np.arange(row, log.rows) * round(log.tick / self.plant.tick)
        first = row * round(log.tick / self.plant.tick) // self.ticks_per_period
        recent = np.array(self.commands[min(first, len(self.commands) - 1) :])
        return recent[np.minimum(ticks // self.ticks_per_period - first, len(recent) - 1)]


Sense = Callable[[Plant, int, WheelVector], Measurement]
"""(plant, samples since the last control instant, torque commanded since) -> measurement."""

Watch = Callable[[Flight], None]
"""Called after every period: progress and recording."""


def sense_truth(plant: Plant, samples: int, torque: WheelVector) -> Measurement:
    """The state as it is: no noise, no delay."""
    state = plant.state()
    seen = plant.recent(samples + 1)
    history = History(seen.t, seen.omega, seen.wheel_speed)
    dipole = plant.commanded_dipole
    return Measurement(state.t, state.q, state.omega, state.wheel_speed, torque, history, dipole)


def fly(
    plant: Plant,
    pilot: Pilot,
    periods: int,
    ticks_per_period: int,
    sense: Sense = sense_truth,
    watch: Watch = lambda flight: None,
    quiet: int = 0,
    delay: int = 0,
) -> Flight:
    """Fly the plant from where it stands for so many control periods, rods off in the last `quiet`
    ticks of each.

    A command acts `delay` samples after the measurement that it is computed from.
    A flight that diverges, loses its planner or is interrupted ends early with everything up to
    there in the log, and says why in `reason`.
    """
    flight = Flight(plant, ticks_per_period)
    memories = Memories()
    craft = with_rods_on_for(1.0 - quiet / ticks_per_period, plant.model.spacecraft)
    line = empty_line(delay, ticks_per_period, craft.wheels, craft.rods.count)
    torque, second = np.zeros(craft.wheels), craft.own_units.time
    with ending_early(flight), undisturbed():
        for _ in range(periods):
            sensed = sense(plant, min(ticks_per_period, plant.sampled - 1), torque)
            transit = line.transit(plant.tick) if delay else None
            now = Instant(plant.t, ticks_per_period * plant.tick, torque, second, transit)
            step, memories = take(pilot, sensed, now, memories, craft)
            flight.steps.append(step if plant.keeps_all else without_evidence(step))
            line.send((step.command, step.dipole))
            torque = line.mean_torque
            flight.commands.append(torque)
            line.advance(plant, quiet)
            watch(flight)
            if _planner_lost(flight):
                _end(flight, Ending.SOLVER_LOST, _lost_sentence(flight))
                break
    return flight


def without_evidence(step: Step) -> Step:
    """The step without what its plan was taken from, which is by far the most of it."""
    return replace(step, plan=replace(step.plan, evidence=None))


@contextmanager
def undisturbed() -> Iterator[None]:
    """The garbage collector leaves alone what was there before the block: going through all of it
    takes 20 to 80 ms, more than the longest plan, and frees nothing."""
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


@contextmanager
def ending_early(flight: Flight) -> Iterator[None]:
    """A divergence, an error of the user's code or an interruption inside the block ends the flight
    and is noted in it."""
    try:
        yield
    except DivergedError as error:
        _end(flight, Ending.DIVERGED, str(error))
    except PluginError as error:
        _end(flight, Ending.PLUGIN_FAILED, str(error))
    except KeyboardInterrupt:
        _end(flight, Ending.INTERRUPTED, f"interrupted at t = {flight.plant.t:.2f} s")


@dataclass(frozen=True)
class Instant:
    """What the controller knows of a control instant without sensing anything."""

    t: float
    period: float
    """Length of a control period, s."""
    torque: WheelVector
    """Commanded over the period that ends now, Nm."""
    second: float = 1.0
    """The craft's own (see `control.ground.units`), s."""
    transit: InTransit | None = None
    """Commands on their way, where they take time."""


def take(
    pilot: Pilot, sensed: Measurement, now: Instant, memories: Memories, craft: Spacecraft
) -> tuple[Step, Memories]:
    """One control instant: what was sensed is admitted and decided on, or refused and flown
    through."""
    admitted = admit(sensed, now.t, now.period, memories.seen, craft.wheels, now.second)
    if isinstance(admitted, Refusal):
        return fly_through(pilot, now, admitted, memories, craft)
    seen, signals = admitted, dict[str, float]()
    if pilot.estimator is not None:
        seen, estimator = pilot.estimator.estimate(admitted, memories.estimator)
        memories = replace(memories, estimator=estimator)
        signals = dict(pilot.estimator.signals(estimator))
    if pilot.foresight is not None and now.transit is not None:
        seen = pilot.foresight.foreseen(seen, now.transit, memories.belief)
    step, memories = decide(pilot, seen, memories, craft)
    return replace(step, estimator=signals), replace(memories, seen=admitted)


def fly_through(
    pilot: Pilot, now: Instant, refusal: Refusal, memories: Memories, craft: Spacecraft
) -> tuple[Step, Memories]:
    """A control instant without a measurement (see `blind`): the planner alone, nothing learned."""
    started = time.perf_counter()
    plan, planner = plan_blind(pilot.planner, now.torque, memories.planner)
    plan_time = time.perf_counter() - started
    correction = None if pilot.corrector is None else no_correction(craft.wheels)
    verdict = None if pilot.supervisor is None or correction is None else NO_VERDICT
    command = np.clip(plan.torque, -craft.torque_max, craft.torque_max)
    dipole = commanded_dipole(plan, craft.rods)
    step = Step(now.t, plan, correction, verdict, command, plan_time, dipole, refusal)
    return step, replace(memories, planner=planner)


def decide(
    pilot: Pilot, measurement: Measurement, memories: Memories, craft: Spacecraft
) -> tuple[Step, Memories]:
    """One pass through the three layers: plan, correct, supervise.

    A correction that isn't finite is left out, supervised or not.
    """
    started = time.perf_counter()
    plan, planner = pilot.planner.plan(measurement, memories.planner)
    plan_time = time.perf_counter() - started
    correction, corrector = None, None
    verdict, supervisor = None, None
    command = plan.torque
    if pilot.corrector is not None:
        asked, corrector = pilot.corrector.correct(measurement, plan, memories.corrector)
        correction = within_limits(asked, plan, craft)
        share = 1.0
        if pilot.supervisor is not None:
            verdict, supervisor = pilot.supervisor.supervise(
                measurement, plan, correction, memories.supervisor
            )
            share = verdict.alpha
        if share > 0.0 and np.isfinite(correction.torque).all():
            command = plan.torque + share * correction.torque
    command = np.clip(command, -craft.torque_max, craft.torque_max)  # round-off, and bare plans
    dipole = commanded_dipole(plan, craft.rods)
    step = Step(
        measurement.t, plan, correction, verdict, command, plan_time, dipole, seen=measurement
    )
    after = replace(memories, planner=planner, corrector=corrector, supervisor=supervisor)
    return step, replace(after, belief=plan.belief)


def commanded_dipole(plan: Plan, rods: Magnetorquers) -> RodVector:
    """The dipoles that a plan asks for cut to what the rods can give, zero if it asks for none."""
    if plan.dipole is None:
        return np.zeros(rods.count)
    return np.clip(plan.dipole, -rods.dipole_max, rods.dipole_max)


def within_limits(correction: Correction, plan: Plan, craft: Spacecraft) -> Correction:
    """The correction cut to what the wheels can give on top of the plan.

    Cut before it is supervised: then any share of what was judged stays inside the limits.
    """
    total = np.clip(plan.torque + correction.torque, -craft.torque_max, craft.torque_max)
    return replace(correction, torque=total - plan.torque)


def _planner_lost(flight: Flight) -> bool:
    recent = flight.steps[-SOLVER_PATIENCE:]
    return len(recent) == SOLVER_PATIENCE and not any(not step.plan.failed for step in recent)


def _lost_sentence(flight: Flight) -> str:
    last = flight.steps[-1]
    return (
        f"the planner found no solution in the {SOLVER_PATIENCE} periods up to t = {last.t:.2f} s; "
        f"last: {last.plan.status}"
    )


def _end(flight: Flight, ending: Ending, reason: str) -> None:
    flight.ending, flight.reason = ending, reason
