"""Every spacecraft in models/ from 75 and 125 degrees: python -m tests.bench.zoo [CONTROLLER]."""

import sys
from pathlib import Path
from typing import Any

from simsat.flight.mission import prepare
from simsat.mjcf.shipped import shipped_models
from simsat.results.metrics import judge
from simsat.settings import FlightSettings

NAMES = shipped_models()
ANGLES_DEG = (75.0, 125.0)


def flown(name: str, angle_deg: float, controller: str) -> dict[str, Any]:
    """Metrics of one flight about the default axis."""
    mission = prepare(FlightSettings(model=Path(name), angle_deg=angle_deg, controller=controller))
    return judge(mission.fly(), mission.target)


def cells(metrics: dict[str, Any]) -> str:
    """Settling time, steady-state and final error, as table cells."""
    final = f"{metrics['final_error_deg']:.2g}"
    if not metrics["converged"]:
        return f"no | - | {final}"
    return f"{metrics['settling_time_s']:.1f} | {metrics['steady_state_rmse_deg']:.2g} | {final}"


def main() -> None:
    """Print the table."""
    controller = sys.argv[1] if len(sys.argv) > 1 else "nmpc"
    heads = [f"{a:g} deg: settled s | SS RMSE deg | final deg" for a in ANGLES_DEG]
    print(f"| {controller} | {' | '.join(heads)} |")
    print("| --- " * (1 + 3 * len(ANGLES_DEG)) + "|")
    for name in NAMES:
        row = [cells(flown(name, angle, controller)) for angle in ANGLES_DEG]
        print(f"| {name} | {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
