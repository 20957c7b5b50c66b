"""What a constant of the learned controller is worth: fly with half of it and with twice.

    python -m tests.bench.constants slosh INCONSISTENT INFLATION

Prints a row of docs/learned.md for each: settling time, steady-state RMSE and final error, means
over ten attitudes of the campaign. A factor near 1 (DECAYS) is halved and doubled in what it
lacks.
"""

import importlib
import pkgutil
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np

from simsat.campaign.attitudes import spiral_attitudes
from simsat.control import learned
from simsat.flight.mission import prepare
from simsat.results.metrics import judge
from simsat.settings import FlightSettings

DECAYS = ("LATE_DECAY", "FORGETTING")
ATTITUDES = range(0, 100, 11)  # of the campaign's 100: ten directions, either angle in turn


def modules() -> list[ModuleType]:
    """Every module of the learned controller."""
    names = pkgutil.walk_packages(learned.__path__, f"{learned.__name__}.")
    return [importlib.import_module(found.name) for found in names]


def flown(model: str) -> str:
    """The figures of the flights, as cells of a table."""
    starts = [spiral_attitudes(100)[k] for k in ATTITUDES]
    base = FlightSettings(model=Path(model), controller="nmpc-learned")
    rows = []
    for start in starts:
        mission = prepare(replace(base, axis=start.axis, angle_deg=start.angle_deg))
        figures = judge(mission.fly(), mission.target)
        names = ("settling_time_s", "steady_state_rmse_deg", "final_error_deg")
        rows.append([np.nan if figures[name] is None else figures[name] for name in names])
    settling, steady, final = np.mean(rows, axis=0)
    return f"{settling:.2f} | {steady:.4f} | {final:.4f}"


def scaled(name: str, value: float, factor: float) -> float:
    """The constant times a factor."""
    return 1.0 - factor * (1.0 - value) if name in DECAYS else factor * value


def main() -> None:
    """The table."""
    model, *names = sys.argv[1:]
    print("| constant | of | settling, s | SS RMSE, deg | final, deg |\n" + "| --- " * 5 + "|")
    print(f"| as it is | `{model}` | {flown(model)} |", flush=True)
    for name in names:
        users = [module for module in modules() if hasattr(module, name)]
        if not users:
            sys.exit(f"no constant '{name}' in control/learned")
        value = getattr(users[0], name)
        for factor in (0.5, 2.0):
            for module in users:
                setattr(module, name, scaled(name, value, factor))
            changed = scaled(name, value, factor)
            print(f"| `{name}` {changed:g} | `{model}` | {flown(model)} |", flush=True)
        for module in users:
            setattr(module, name, value)


if __name__ == "__main__":
    main()
