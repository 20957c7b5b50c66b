"""Fly bad networks with and without a supervisor: python -m simsat.bad_network_study --help.

Every estimator of `bad_networks` flies from the same attitudes unsupervised and under each
supervisor, beside the plain `nmpc`. Writes results.json, table.md and picture.png.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

from tqdm import tqdm

from simsat.bad_networks.estimators import (
    Adversarial,
    Constant,
    Flipped,
    LateCorrector,
    NotFinite,
    Random,
    Stuck,
)
from simsat.bad_networks.picture import PLAIN, draw_bad_networks
from simsat.campaign.attitudes import PAPER_COUNT, InitialRotation, spiral_attitudes
from simsat.command import command, parse
from simsat.comparison.markdown import markdown_table
from simsat.control.correction.corrector import Estimator, OracleEstimator, ResidualCorrector
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.layers import Corrector, Pilot
from simsat.control.interface.own_units import InOwnUnits
from simsat.control.model.rates import build_rate_model
from simsat.flight.controllers import baseline, choose_supervisor
from simsat.flight.mission import Mission, prepare
from simsat.results.files import write_json, write_text
from simsat.results.folder import make_folder
from simsat.results.metrics import judge
from simsat.settings import FlightSettings

Rule = Literal["none", "faithful", "sound", "value"]
MOVED_DEG = 0.1
MOVED = f"{PLAIN}, start {MOVED_DEG:g} deg further"
FREEZES_AT = 5.0  # of the craft's own seconds: in the middle of the slew
NETWORKS = (
    "oracle",
    "flipped",
    "constant",
    "random",
    "stuck",
    "adversarial",
    "not a number",
    "late",
)
HEAD = (
    "network", "supervisor", "converged", "lost", "final error mean / max (deg)",
    "worst increase (deg)", "SS RMSE mean (deg)", "settling mean (s)", "share let through",
)  # fmt: skip


@dataclass(frozen=True)
class StudySettings:
    """Fly bad networks with and without a supervisor."""

    out: Path | None = None
    """Folder to write, which must not exist yet; default a new one under runs/."""
    model: Path = FlightSettings.model
    """The spacecraft: an MJCF file, or the name of one in models/."""
    attitudes: int = 20
    """Number of initial attitudes, spread over the campaign's hundred, at most 100."""
    networks: tuple[str, ...] = ()
    """Which bad networks to fly; all of them unless given."""
    rules: tuple[Rule, ...] = get_args(Rule)
    """Supervisors to fly them under."""

    def __post_init__(self) -> None:
        unknown = [name for name in self.networks if name not in NETWORKS]
        if unknown:
            raise SettingsError(f"no bad network '{unknown[0]}'; there are: {', '.join(NETWORKS)}")
        if not 1 <= self.attitudes <= PAPER_COUNT:
            raise SettingsError(f"--attitudes must be 1 to {PAPER_COUNT}, got {self.attitudes}")


def correctors(mission: Mission) -> dict[str, Corrector]:
    """The bad networks of a mission, by name, and the oracle that some of them spoil."""
    brief, craft, target = mission.brief, mission.model.spacecraft, mission.target
    settings, limit, period = brief.settings, brief.settings.correction.limit, brief.period
    truth = build_rate_model(craft, friction=True)
    believed = build_rate_model(mission.believed, settings.nmpc.friction)
    good = OracleEstimator(truth, believed, craft.torque_rate_max, mission.environment, period)
    estimators: dict[str, Estimator] = {
        "oracle": good,
        "flipped": Flipped(good),
        "constant": Constant(limit),
        "random": Random(limit),
        "stuck": Stuck(good, FREEZES_AT * brief.units.time),
        "adversarial": Adversarial(truth, craft.torque_rate_max, target, limit, period),
        "not a number": NotFinite(),
    }
    made: dict[str, Corrector] = {
        name: ResidualCorrector(estimator, settings.correction, target)
        for name, estimator in estimators.items()
    }
    return made | {"late": LateCorrector(ResidualCorrector(good, settings.correction, target))}


def prepare_with(settings: FlightSettings, network: str, rule: Rule) -> Mission:
    """The flight with a network under a rule; PLAIN and MOVED fly without any."""
    mission = prepare(settings)
    if network in (PLAIN, MOVED):
        return mission
    asked = replace(settings, supervisor="faithful" if rule == "none" else rule)
    brief = replace(mission, settings=asked).brief
    planner = baseline(brief)
    supervisor = None if rule == "none" else choose_supervisor(brief, planner)
    flown = InOwnUnits(planner, brief.units)
    return replace(mission, pilot=Pilot(flown, correctors(mission)[network], supervisor))


def fly_with(settings: FlightSettings, network: str, rule: Rule) -> dict[str, Any]:
    """Metrics of that flight."""
    mission = prepare_with(settings, network, rule)
    return judge(mission.fly(), mission.target)


def moved(start: InitialRotation) -> InitialRotation:
    """The same start, a little further round: how much `nmpc` scatters by itself."""
    return replace(start, angle_deg=start.angle_deg + MOVED_DEG)


def cases(settings: StudySettings) -> Iterator[tuple[str, Rule, InitialRotation]]:
    """Everything to fly."""
    every = 2 * (PAPER_COUNT // settings.attitudes)  # whole directions, both angles of each
    starts = [a for a in spiral_attitudes(PAPER_COUNT) if a.index % every < 2]
    networks = settings.networks or NETWORKS
    for start in starts[: settings.attitudes]:
        yield PLAIN, "none", start
        yield MOVED, "none", moved(start)
        for network in networks:
            for rule in settings.rules:
                yield network, rule, start


def study(settings: StudySettings) -> int:
    """Fly, then write the table and the picture."""
    folder = make_folder(settings.out, "bad-networks")
    flight = FlightSettings(model=settings.model)
    rows = []
    for network, rule, start in tqdm(list(cases(settings)), unit="flight", disable=None):
        there = replace(flight, axis=start.axis, angle_deg=start.angle_deg)
        metrics = fly_with(there, network, rule)
        rows.append({"network": network, "rule": rule, "attitude": start.index, **metrics})
    write_json(folder / "results.json", rows)
    table = table_md(rows)
    write_text(folder / "table.md", table)
    draw_bad_networks(rows, folder / "picture.png")
    print(f"{table}\nresults in {folder}")
    return 0


def table_md(rows: list[dict[str, Any]]) -> str:
    """A line per network and rule: what it did to convergence and final error."""
    plain = {row["attitude"]: row for row in rows if row["network"] == PLAIN}
    lines = []
    for network, rule in dict.fromkeys((row["network"], row["rule"]) for row in rows):
        group = [row for row in rows if (row["network"], row["rule"]) == (network, rule)]
        lines.append(_line(network, rule, group, plain))
    return markdown_table(HEAD, lines) + (
        "\nlost: attitudes on which nmpc alone converges and this does not. "
        "Worst increase: largest final error above that of nmpc from the same attitude.\n"
    )


def _line(
    network: str, rule: str, group: list[dict[str, Any]], plain: dict[int, dict[str, Any]]
) -> list[str]:
    final = [row["final_error_deg"] for row in group]
    increase = max(
        row["final_error_deg"] - plain[row["attitude"]]["final_error_deg"] for row in group
    )
    lost = sum(plain[r["attitude"]]["converged"] and not r["converged"] for r in group)
    converged = [row for row in group if row["converged"]]
    return [
        network,
        rule,
        f"{len(converged)} / {len(group)}",
        str(lost),
        f"{sum(final) / len(final):.3f} / {max(final):.3f}",
        f"{increase:+.3f}",
        _mean(converged, "steady_state_rmse_deg", 3),
        _mean(converged, "settling_time_s", 1),
        _mean([r for r in group if "mean_alpha" in r], "mean_alpha", 2),
    ]


def _mean(rows: list[dict[str, Any]], name: str, digits: int) -> str:
    return f"{sum(row[name] for row in rows) / len(rows):.{digits}f}" if rows else "none"


def main() -> int:
    """The command line."""
    return study(parse(StudySettings, __doc__))


if __name__ == "__main__":
    sys.exit(command(main))
