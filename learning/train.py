"""Train a spacecraft's network from nothing, data included: python -m learning.train --help."""

import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import torch
import tyro

from simsat.command import command, parse
from simsat.comparison.markdown import literal
from simsat.control.correction.features import feature_count
from simsat.control.correction.network import Network
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.own import Own, resolved
from simsat.control.ground.settings import Count, CountOrNone, Positive, Settings
from simsat.control.ground.spacecraft import Spacecraft, nominal
from simsat.control.model.rates import RateModel, build_rate_model
from simsat.flight.timing import timing_of
from simsat.mjcf import read_model
from simsat.mjcf.shipped import find_model
from simsat.networks.correction import origin, write_network
from simsat.results.files import write_json, write_text
from simsat.settings import FlightSettings, NominalSettings

from .correction.data import FleetSettings, fly_fleet, sixths
from .correction.fit import (
    FitSettings,
    PinnState,
    RoundData,
    best_network,
    build_round_data,
    held_out_loss,
    next_round,
    run_epoch,
    start,
)
from .correction.linear import fit_linear
from .correction.pinn import Pinn, build_pinn
from .correction.report import draw_curves, draw_flight, draw_scores, score, score_table
from .correction.windows import Windows, cut, joined, shifted
from .identity import trained_with
from .progress import CHECKPOINT, restored, run_round
from .resumable import train_resumably


@dataclass(frozen=True)
class TrainSettings(Settings):
    """Fly training flights, train, fly again under the correction, train on, and report."""

    model: Path = FlightSettings.model
    """The spacecraft: an MJCF file, or the name of one in models/."""
    nominal: NominalSettings = field(default_factory=NominalSettings)
    flights: tuple[int, int] = (48, 24)
    """Flights of the first round, under the baseline, and of the second, under its network."""
    duration_s: Annotated[Positive | None, Own("time", 40.0)] = None
    """Length of each flight, s: as long as the error is usually above a degree; some 40 of the
    craft's own seconds unless given."""
    fit: FitSettings = field(default_factory=FitSettings)
    seed: CountOrNone = 0
    """Decides starting attitudes, first weights and the order of windows."""

    def check(self) -> None:
        """Enough flights to hold some out."""
        if min(self.flights) < 6:
            raise SettingsError(f"--flights needs at least 6 per round, got {self.flights}")


@dataclass(frozen=True)
class TrainCommand(Settings):
    """Fly training flights, train, fly again under the correction, train on, and report.

    Writes pinn.safetensors and linear.safetensors, report.json, report.md and pictures. An
    interrupted or killed training goes on where it stood when called again.
    """

    training: Annotated[TrainSettings, tyro.conf.arg(name="")] = field(
        default_factory=TrainSettings
    )
    out: Path = Path("runs/training")
    """Folder to write."""
    workers: Count = 2
    """Processes to fly in; the result doesn't depend on it."""


@dataclass(frozen=True)
class Fleet:
    """The flights of all rounds so far, split by whole flights."""

    training: Windows
    held_out: Windows
    """For early stopping."""
    unseen: Windows
    """For the report alone."""


def train(settings: TrainSettings, out: Path, workers: int) -> None:
    """Train from nothing, or go on with what the folder holds."""
    torch.set_num_threads(1)
    model = read_model(find_model(settings.model))
    craft = model.spacecraft
    settings = replace(settings, fit=resolved(settings.fit, craft.own_units))
    belief = nominal(craft, settings.nominal.inertia_factors, settings.nominal.mismatch)
    believed = build_rate_model(belief, friction=False)
    about = origin(craft, belief, friction=False) | trained_with(settings.model)
    period = timing_of(FlightSettings(model=settings.model), model).period_s
    first = _fly(settings, 1, out, workers, craft, believed, period)
    data = build_round_data(first.training, first.held_out, believed)
    state = _begin(out, data, settings)
    if state.round == 1:
        _run_round(state, data, settings, out)
        write_network(out / "round_1.safetensors", best_network(state), about)
    second = _fly(settings, 2, out, workers, craft, believed, period)
    fleet = Fleet(*(joined(a, b) for a, b in zip(_parts(first), _parts(second), strict=True)))
    data = build_round_data(fleet.training, fleet.held_out, believed)
    if state.round == 1:
        next_round(state, settings.fit)
    _run_round(state, data, settings, out)
    networks = {"linear": fit_linear(fleet.training, believed), "pinn": best_network(state)}
    for name, network in networks.items():
        write_network(out / f"{name}.safetensors", network, about)
    _report(out, networks, state, data, fleet, believed, craft)


def _fly(
    settings: TrainSettings,
    number: int,
    out: Path,
    workers: int,
    craft: Spacecraft,
    believed: RateModel,
    period: float,
) -> Fleet:
    """A round's flights: a sixth held out, a sixth unseen."""
    fleet = FleetSettings(
        settings.model,
        settings.nominal,
        settings.flights[number - 1],
        settings.duration_s,
        2 * settings.seed + number - 1,
    )
    pilot = ("nmpc-pinn", str(out / "round_1.safetensors")) if number == 2 else ()
    telemetry = fly_fleet(out / f"flights_{number}", fleet, workers, *pilot)
    windows = cut(telemetry, period, believed, craft.torque_rate_max)
    return Fleet(*(windows.pick(index) for index in sixths(windows.flights)))


def _parts(fleet: Fleet) -> tuple[Windows, Windows, Windows]:
    return fleet.training, fleet.held_out, fleet.unseen


def _begin(out: Path, data: RoundData, settings: TrainSettings) -> PinnState:
    """From the checkpoint if there is one, else from first weights."""
    windows, fit = data.training, settings.fit
    x = windows.features(shifted(windows.residual), data.believed)
    x = x.reshape(-1, feature_count(windows.torque.shape[-1]))
    pinn: Pinn = build_pinn(x, windows.torque.shape[-1], fit.hidden, fit.bound, settings.seed)
    return restored(out / CHECKPOINT, lambda _: start(pinn, fit))


def _run_round(state: PinnState, data: RoundData, settings: TrainSettings, out: Path) -> None:
    run_round(
        state,
        settings.fit.epochs,
        out / CHECKPOINT,
        lambda: run_epoch(state, data, settings.fit, settings.seed),
    )


def _report(
    out: Path,
    networks: dict[str, Network],
    state: PinnState,
    data: RoundData,
    fleet: Fleet,
    believed: RateModel,
    craft: Spacecraft,
) -> None:
    scores = score(networks, fleet.unseen, believed)
    losses = {name: held_out_loss(network, data) for name, network in networks.items()}
    counts = [windows.flights for windows in _parts(fleet)]
    write_json(
        out / "report.json",
        {
            "spacecraft": craft.name,
            "fingerprint": craft.fingerprint,
            "flights_training_held_out_unseen": counts,
            "windows_training": int(np.prod(fleet.training.torque.shape[:2])),
            "loss_held_out": losses,
            "unseen_flights": scores,
            "curves": state.curves,
        },
    )
    table = score_table(scores)
    write_text(out / "report.md", f"# {literal(craft.name)}: {counts[2]} unseen flights\n\n{table}")
    draw_curves(state.curves, losses["linear"], out / "curves.png")
    draw_scores(scores, out / "scores.png")
    draw_flight(networks, fleet.unseen, believed, craft.wheel_names, out / "flight.png")
    print(table)


def main() -> int:
    """The command line."""
    arguments = parse(TrainCommand, __doc__)
    done = (
        f"network in {arguments.out}; fly it with --controller nmpc-pinn --network {arguments.out}"
    )
    return train_resumably(arguments.training, arguments.out, arguments.workers, train, done)


if __name__ == "__main__":
    sys.exit(command(main))
