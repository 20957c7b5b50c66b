"""What a wrong network costs `nmpc-learned`, with and without the choice by the plan's value.

    python -m tests.bench.bad_appendages [model] [attitudes] [workers]

Each wrong network is flown twice from the same attitudes: always believed (`--learned.prediction
network`), and under the choice (`chosen`); beside them no network at all. Prints a table.
"""

import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from simsat.campaign.attitudes import spiral_attitudes
from simsat.control.learned.settings import LearnedSettings
from simsat.control.model.appendage import AppendageNetwork
from simsat.flight.mission import prepare
from simsat.mjcf import read_model
from simsat.mjcf.shipped import find_model
from simsat.networks.appendage import read_appendage, shipped_appendage, write_appendage
from simsat.parallel.pool import WorkerLostError, run_all
from simsat.parallel.processes import local_pool
from simsat.results.metrics import judge
from simsat.settings import FlightSettings

Spoil = Callable[[AppendageNetwork], AppendageNetwork]


def scaled(network: AppendageNetwork, by: float) -> AppendageNetwork:
    """All outputs times a factor."""
    return replace(network, output_scale=by * network.output_scale)


def flipped(network: AppendageNetwork) -> AppendageNetwork:
    """The right size, the wrong sign."""
    return replace(network, W=-network.W, V=-network.V, B=-network.B)


def shuffled(network: AppendageNetwork) -> AppendageNetwork:
    """Random weights of the same size."""
    random = np.random.default_rng(0)
    size = float(np.sqrt(np.mean(network.W**2)))
    return replace(network, W=size * random.standard_normal(network.W.shape))


def frozen(network: AppendageNetwork) -> AppendageNetwork:
    """What swings now stays as it is."""
    W = np.zeros_like(network.W)
    W[:3, :3] = W[3:, :3] = np.eye(3)
    return replace(network, W=W, V=0.0 * network.V, B=0.0 * network.B)


def explosive(network: AppendageNetwork) -> AppendageNetwork:
    """The prediction leaves the finite numbers within a plan."""
    return scaled(network, 1e30)


def wrong_inertia(network: AppendageNetwork) -> AppendageNetwork:
    """A sound recursion beside an inertia that is 20 % off."""
    return replace(network, J=network.J * np.array([[1.2, 1.0, 1.0], [1.0, 0.8, 1.0], [1.0] * 3]))


SPOILT: dict[str, Spoil] = {
    "as trained": lambda network: network,
    "sign flipped": flipped,
    "twice too strong": lambda network: scaled(network, 2.0),
    "random weights": shuffled,
    "frozen": frozen,
    "explosive": explosive,
    "inertia 20 % off": wrong_inertia,
}


def fly(settings: FlightSettings) -> dict[str, Any]:
    """Metrics of one flight."""
    mission = prepare(settings)
    return judge(mission.fly(), mission.target)


def main() -> None:
    """The table."""
    model = Path(sys.argv[1] if len(sys.argv) > 1 else "flexible_panels")
    attitudes = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    workers = int(sys.argv[3]) if len(sys.argv) > 3 else 2
    craft = read_model(find_model(model)).spacecraft
    base = FlightSettings(model=model, controller="nmpc-learned")
    shipped = shipped_appendage(model)
    if shipped is None:
        sys.exit(f"no appendage network comes with '{model}'")
    good = read_appendage(shipped, craft, base.nmpc.stage)
    with tempfile.TemporaryDirectory() as folder:
        cases = {("none", ""): LearnedSettings(network="none")}
        for name, spoil in SPOILT.items():
            file = Path(folder) / f"{name.replace(' ', '_')}.safetensors"
            write_appendage(file, spoil(good), craft)
            cases[name, "always"] = LearnedSettings(network=str(file), prediction="network")
            cases[name, "chosen"] = LearnedSettings(network=str(file))
        flights = [
            replace(base, axis=start.axis, angle_deg=start.angle_deg, learned=learned)
            for learned in cases.values()
            for start in spiral_attitudes(attitudes)
        ]
        flown = dict[FlightSettings, dict[str, Any]]()
        for flight, metrics in run_all(local_pool(workers), fly, flights):
            if isinstance(metrics, WorkerLostError):
                raise metrics
            flown[flight] = metrics
        results = [flown[flight] for flight in flights]
    print("| network | believed | converged | settling mean, s | SS RMSE mean / max, deg |"
          " final mean / max, deg |\n" + "| --- " * 6 + "|")  # fmt: skip
    for k, (name, believed) in enumerate(cases):
        rows = results[k * attitudes : (k + 1) * attitudes]
        print(f"| {name} | {believed} | {line(rows)} |")


def line(rows: list[dict[str, Any]]) -> str:
    """A row's figures."""
    converged = [row for row in rows if row["converged"]]
    final = [row["final_error_deg"] for row in rows]
    settling = [row["settling_time_s"] for row in converged] or [np.nan]
    steady = [row["steady_state_rmse_deg"] for row in converged] or [np.nan]
    return (
        f"{len(converged)} / {len(rows)} | {np.mean(settling):.1f} | "
        f"{np.mean(steady):.3f} / {max(steady):.3f} | {np.mean(final):.3f} / {max(final):.3f}"
    )


if __name__ == "__main__":
    main()
