"""Train an appendage network from nothing: python -m learning.train_appendage --help."""

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
import torch
import tyro

from simsat.command import command, parse
from simsat.comparison.markdown import literal
from simsat.control.ground.arrays import Matrix3
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.own import Own
from simsat.control.ground.settings import Count, CountOrNone, Positive, Settings
from simsat.control.ground.spacecraft import Spacecraft, nominal
from simsat.control.model.appendage import AppendageNetwork, spectral_radius
from simsat.flight.timing import Timing, timing_of
from simsat.mjcf import read_model
from simsat.mjcf.shipped import find_model
from simsat.networks.appendage import FILE, write_appendage
from simsat.results.files import write_json, write_text
from simsat.settings import FlightSettings, NominalSettings

from .appendage.fit import (
    AppendageFitSettings,
    AppendageState,
    Fleet,
    TrainedLayer,
    TrainingProblem,
    begin,
    build_training_problem,
    layers_to_train,
    run_epoch,
)
from .appendage.report import AHEAD, draw_scores, facts, score, score_table, verdict
from .appendage.rollout import Appendage, as_network
from .appendage.series import Series, build_series, joined, swing_of
from .correction.data import FleetSettings, fly_fleet, sixths
from .identity import trained_with
from .progress import best_module, restored, run_round
from .resumable import train_resumably

PILOTS = ("nmpc", "nmpc-learned")
"""Who flies each round: the learned controller excites the modes as the network will meet them."""


@dataclass(frozen=True)
class AppendageSettings(Settings):
    """Fly training flights, learn the momentum of what bends and swings, and report."""

    model: Path = Path("flexible_panels")
    """The spacecraft: an MJCF file, or the name of one in models/."""
    nominal: NominalSettings = field(default_factory=NominalSettings)
    flights: tuple[int, int] = (24, 48)
    """Flights under the baseline and under the learned controller."""
    duration_s: Annotated[Positive | None, Own("time", 40.0)] = None
    """Length of each flight, s: a slew and the rest after it; some 40 of the craft's own seconds
    unless given."""
    fit: AppendageFitSettings = field(default_factory=AppendageFitSettings)
    seed: CountOrNone = 0
    """Decides starting attitudes, first weights and noise."""

    def check(self) -> None:
        """Enough flights to hold some out."""
        if min(self.flights) < 6:
            raise SettingsError(f"--flights needs at least 6 per round, got {self.flights}")


@dataclass(frozen=True)
class AppendageCommand(Settings):
    """Fly training flights, learn the momentum of what bends and swings, and report.

    Writes appendage.safetensors, what each layer came to (linear.safetensors, gate.safetensors,
    tanh.safetensors), report.json, report.md and scores.png. An interrupted or killed training
    goes on where it stood when called again.
    """

    training: Annotated[AppendageSettings, tyro.conf.arg(name="")] = field(
        default_factory=AppendageSettings
    )
    out: Path = Path("runs/appendage")
    """Folder to write."""
    workers: Count = 2
    """Processes to fly in; the result doesn't depend on it."""


def train(settings: AppendageSettings, out: Path, workers: int) -> None:
    """Train from nothing, or go on with what the folder holds."""
    torch.set_num_threads(1)
    craft, timing = begun(settings)
    J_0 = nominal(craft, settings.nominal.inertia_factors, settings.nominal.mismatch).J
    fleet = fly(settings, out, workers, craft, J_0, timing.period_s)
    problem = build_training_problem(fleet, craft, J_0, settings.fit, settings.seed)
    rounds = run_rounds(settings, out, problem)
    about = trained_with(settings.model)
    for trained in rounds:
        network = as_network(trained.module, timing.period_s)
        write_appendage(out / f"{trained.layer}.safetensors", network, craft, about)
    module = [trained.module for trained in rounds if trained.kept][-1]
    chosen = as_network(module, timing.period_s)
    write_appendage(out / FILE, chosen, craft, about)
    _report(out, chosen, problem, rounds, fleet, craft)


def begun(settings: AppendageSettings) -> tuple[Spacecraft, Timing]:
    """The spacecraft, and the clock of its flights.

    Raises `SettingsError` on flights that are shorter than the report looks ahead.
    """
    model = read_model(find_model(settings.model))
    timing = timing_of(FlightSettings(model=settings.model), model)
    least = max(AHEAD) * timing.period_s
    if settings.duration_s is not None and settings.duration_s < least:
        raise SettingsError(
            f"--duration-s is {settings.duration_s:g}: give {max(AHEAD)} control periods, "
            f"{least:g} s, or more"
        )
    return model.spacecraft, timing


def run_rounds(
    settings: AppendageSettings, out: Path, problem: TrainingProblem
) -> list[TrainedLayer]:
    """A round for each layer, upon those kept so far."""
    module, rounds = problem.first, list[TrainedLayer]()
    for number, layer in enumerate(layers_to_train(settings.fit), 1):
        state = _run_round(number, layer, module, settings, out, problem)
        best = best_module(state)
        losses = (problem.held_out_loss(best), problem.held_out_loss(module))
        rounds.append(TrainedLayer(layer, best, *losses, state.curves))
        module = best if rounds[-1].kept else module
    return rounds


def _run_round(
    number: int,
    layer: str,
    before: Appendage,
    settings: AppendageSettings,
    out: Path,
    problem: TrainingProblem,
) -> AppendageState:
    """A round's last state; it goes on with what its checkpoint holds."""
    path, fit = out / f"checkpoint_{layer}.pt", settings.fit
    state = restored(path, lambda _: begin(number, layer, before, fit, settings.seed))
    run_round(state, fit.epochs, path, lambda: run_epoch(state, problem, fit))
    return state


def fly(
    settings: AppendageSettings,
    out: Path,
    workers: int,
    craft: Spacecraft,
    J_0: Matrix3,
    period: float,
) -> Fleet:
    """The flights of both rounds; a sixth of each is held out, a sixth unseen."""
    parts: tuple[list[Series], ...] = ([], [], [])
    for number, (pilot, flights) in enumerate(zip(PILOTS, settings.flights, strict=True)):
        fleet = FleetSettings(
            settings.model,
            settings.nominal,
            flights,
            settings.duration_s,
            2 * settings.seed + number,
        )
        telemetry = fly_fleet(out / f"flights_{number + 1}", fleet, workers, pilot)
        swing = swing_of(build_series(telemetry, craft, J_0, period))
        series = build_series(telemetry, craft, J_0, period, swing)
        for part, index in zip(parts, sixths(flights), strict=True):
            part.append(series.pick(index))
    return Fleet(*(joined(part) for part in parts))


def _report(
    out: Path,
    chosen: AppendageNetwork,
    problem: TrainingProblem,
    rounds: list[TrainedLayer],
    fleet: Fleet,
    craft: Spacecraft,
) -> None:
    modules = {
        "least squares": problem.first,
        **{trained.layer: trained.module for trained in rounds},
    }
    scores = score(modules, fleet.unseen)
    counts = [series.flights for series in (fleet.training, fleet.held_out, fleet.unseen)]
    write_json(
        out / "report.json",
        {
            "spacecraft": craft.name,
            "fingerprint": craft.fingerprint,
            "flights_training_held_out_unseen": counts,
            "width": chosen.width,
            "gates": chosen.gates,
            "growth_per_period": spectral_radius(chosen, np.zeros(craft.wheels)),
            "loss_held_out": {
                name: problem.held_out_loss(module) for name, module in modules.items()
            },
            **facts(chosen, scores),
            "curves": [row for trained in rounds for row in trained.curves],
        },
    )
    text = "\n".join([score_table(scores), *(f"{verdict(trained)}\n" for trained in rounds[1:])])
    title = f"# {literal(craft.name)}: {counts[2]} unseen flights"
    write_text(out / "report.md", f"{title}\n\n{text}")
    draw_scores(scores, out / "scores.png")
    print(text)


def main() -> int:
    """The command line."""
    arguments = parse(AppendageCommand, __doc__)
    flags = f"--controller nmpc-learned --learned.network {arguments.out}"
    done = f"network in {arguments.out / FILE}; fly it with {flags}"
    return train_resumably(arguments.training, arguments.out, arguments.workers, train, done)


if __name__ == "__main__":
    sys.exit(command(main))
