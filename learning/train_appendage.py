"""Train an appendage network from nothing: python -m learning.train_appendage --help."""

import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import torch

from control.learned.appendage import AppendageNetwork, growth
from learning.appendage_fit import (
    AppendageFitSettings,
    AppendageState,
    Course,
    Fleet,
    blank,
    build_course,
    next_round,
    run_epoch,
)
from learning.appendage_report import AHEAD, draw_scores, facts, score, score_table, verdict
from learning.appendage_rollout import Appendage, as_module, as_network
from learning.appendage_series import Series, build_series, joined, swing_of
from learning.data import FleetSettings, fly_fleet, sixths
from learning.files import claim_folder, write_bytes, write_json
from learning.progress import CHECKPOINT, INTERRUPTED, best_module, restored, run_round
from simsat.appendage_networks import FILE, read_appendage, write_appendage
from simsat.arrays import Matrix3
from simsat.command import command, parse
from simsat.errors import SettingsError, require
from simsat.mjcf import read_model
from simsat.settings import FlightSettings, NominalSettings, find_model
from simsat.spacecraft import Spacecraft, nominal

PILOTS = ("nmpc", "nmpc-learned")
"""Who flies each round: the learned controller excites the modes as the network will meet them."""
PERIOD = FlightSettings().nmpc.period  # s
LINEAR = "linear.safetensors"
LEAST_CUT = 0.05  # of the held-out loss, for which the tanh layer is kept: below, it is noise


@dataclass(frozen=True)
class AppendageSettings:
    """Fly training flights, learn the momentum of what bends and swings, and report."""

    model: Path = Path("flexible_panels")
    """The spacecraft: an MJCF file, or the name of one in models/."""
    nominal: NominalSettings = field(default_factory=NominalSettings)
    flights: tuple[int, int] = (24, 48)
    """Flights under the baseline and under the learned controller."""
    duration_s: float = 40.0
    """Length of each flight, s: a slew and the rest after it."""
    fit: AppendageFitSettings = field(default_factory=AppendageFitSettings)
    seed: int = 0
    """Decides starting attitudes, first weights and noise."""

    def __post_init__(self) -> None:
        if min(self.flights) < 6:
            raise SettingsError(f"--flights needs at least 6 per round, got {self.flights}")
        require(self, "", "duration_s", max(AHEAD) * PERIOD)
        require(self, "", "seed", 0)


@dataclass(frozen=True)
class AppendageCommand(AppendageSettings):
    """Fly training flights, learn the momentum of what bends and swings, and report.

    Writes appendage.safetensors, linear.safetensors, report.json, report.md and scores.png. An
    interrupted or killed training goes on where it stood when called again.
    """

    out: Path = Path("runs/appendage")
    """Folder to write."""
    workers: int = 2
    """Processes to fly in; the result doesn't depend on it."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "", "workers", 1)


def train(settings: AppendageSettings, out: Path, workers: int) -> None:
    """Train from nothing, or go on with what the folder holds."""
    torch.set_num_threads(1)
    craft = read_model(find_model(settings.model)).spacecraft
    J_0 = believed_inertia(craft, settings.nominal)
    fleet = fly(settings, out, workers, craft, J_0)
    course = build_course(fleet, craft, J_0, settings.fit, settings.seed)
    linear, state = _two_rounds(settings, out, course, craft, J_0)
    modules = {"least squares": course.first, "linear": as_module(linear, craft, J_0)}
    if state.round == 2:
        modules["network"] = best_module(state)
    with torch.no_grad():
        losses = {name: float(course.held_out(module)) for name, module in modules.items()}
    kept = state.round == 2 and losses["network"] < (1.0 - LEAST_CUT) * losses["linear"]
    chosen = as_network(modules["network"], PERIOD) if kept else linear
    write_appendage(out / FILE, chosen, craft)
    _report(out, chosen, modules, losses, state.curves, fleet, craft)


def _two_rounds(
    settings: AppendageSettings, out: Path, course: Course, craft: Spacecraft, J_0: Matrix3
) -> tuple[AppendageNetwork, AppendageState]:
    """The best linear network, and the state at the end of the round with the tanh layer."""
    state = restored(out / CHECKPOINT, lambda number: blank(number, course, craft, settings.fit))
    if state.round == 1:
        _run_round(state, course, settings, out)
        write_appendage(out / LINEAR, as_network(best_module(state), PERIOD), craft)
    linear = read_appendage(out / LINEAR, craft, PERIOD)
    if state.round == 1 and settings.fit.width:
        next_round(state, craft, settings.fit, settings.seed)
    if state.round == 2:
        _run_round(state, course, settings, out)
    return linear, state


def believed_inertia(craft: Spacecraft, settings: NominalSettings) -> Matrix3:
    """What a controller believes of J."""
    factors = settings.inertia_factors
    return nominal(craft, None if factors is None else np.array(factors), settings.mismatch).J


def fly(
    settings: AppendageSettings, out: Path, workers: int, craft: Spacecraft, J_0: Matrix3
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
        swing = swing_of(build_series(telemetry, craft, J_0, PERIOD))
        series = build_series(telemetry, craft, J_0, PERIOD, swing)
        for part, index in zip(parts, sixths(flights), strict=True):
            part.append(series.pick(index))
    return Fleet(*(joined(part) for part in parts))


def _run_round(
    state: AppendageState, course: Course, settings: AppendageSettings, out: Path
) -> None:
    run_round(
        state,
        settings.fit.epochs,
        out / CHECKPOINT,
        lambda: run_epoch(state, course, settings.fit),
    )


def _report(
    out: Path,
    chosen: AppendageNetwork,
    modules: dict[str, Appendage],
    losses: dict[str, float],
    curves: list[dict[str, float]],
    fleet: Fleet,
    craft: Spacecraft,
) -> None:
    scores = score(modules, fleet.unseen)
    counts = [series.flights for series in (fleet.training, fleet.held_out, fleet.unseen)]
    write_json(
        out / "report.json",
        {
            "spacecraft": craft.name,
            "fingerprint": craft.fingerprint,
            "flights_training_held_out_unseen": counts,
            "width": chosen.width,
            "growth_per_period": growth(chosen),
            "loss_held_out": losses,
            **facts(chosen, scores),
            "curves": curves,
        },
    )
    text = score_table(scores)
    if "network" in losses:
        text += f"\n\n{verdict(losses['linear'], losses['network'], chosen.width > 0)}"
    title = f"# {craft.name}: {counts[2]} unseen flights"
    write_bytes(out / "report.md", f"{title}\n\n{text}\n".encode())
    draw_scores(scores, out / "scores.png")
    print(text)


def main() -> int:
    """The command line."""
    asked = parse(AppendageCommand, __doc__)
    names = AppendageSettings.__dataclass_fields__
    settings = AppendageSettings(**{name: getattr(asked, name) for name in names})
    settings = replace(settings, model=find_model(settings.model).resolve())
    read_model(settings.model)  # a bad model is refused before a folder is claimed for it
    claim_folder(asked.out, settings)
    try:
        train(settings, asked.out, asked.workers)
    except KeyboardInterrupt:
        print(f"interrupted; the same command goes on where '{asked.out}' stands", file=sys.stderr)
        return INTERRUPTED
    print(f"\nnetwork in {asked.out / FILE}")
    return 0


if __name__ == "__main__":
    sys.exit(command(main))
