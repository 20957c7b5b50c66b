"""Draw what a network of the panels' momentum does on arrival: docs/learned_panels.png.

    python -m tests.bench.panels_picture [file]

One turn of `flexible_panels` under `nmpc`, under `nmpc-learned` without a network and with it; and,
below, how far the body's rate is from that of a rigid craft at rest: the panels' vibration.
"""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from simsat.control.learned.settings import LearnedSettings
from simsat.flight.mission import prepare
from simsat.results.metrics import CONVERGED_BELOW_DEG, error_deg
from simsat.settings import FlightSettings

TURN = FlightSettings(
    model=Path("flexible_panels"), axis=(0.53, 0.48, 0.7), angle_deg=75.0, duration_s=60.0
)
FLIGHTS = {
    "nmpc": (replace(TURN, controller="nmpc"), "#4c566a"),
    "nmpc-learned, no network": (
        replace(TURN, controller="nmpc-learned", learned=LearnedSettings(network="none")),
        "#d08770",
    ),
    "nmpc-learned, network": (replace(TURN, controller="nmpc-learned"), "#2e7d6b"),
}


def main() -> None:
    """Fly and draw."""
    matplotlib.use("Agg")
    path = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/learned_panels.png")
    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    top, below = figure.subplots(2, 1, sharex=True)
    for name, (settings, color) in FLIGHTS.items():
        mission = prepare(settings)
        flight = mission.fly()
        t = flight.plant.log.t
        rate = np.degrees(np.linalg.norm(flight.plant.rates, axis=1))
        top.semilogy(t, error_deg(flight, mission.target), color=color, label=name)
        below.semilogy(t, rate, color=color)
    top.axhline(CONVERGED_BELOW_DEG, color="#b22222", linestyle="--", linewidth=0.8)
    top.set_ylabel("pointing error, deg")
    below.set_ylabel("body rate, deg/s")
    below.set_xlabel("time, s")
    below.set_ylim(bottom=1e-4)
    top.legend(loc="lower left", fontsize=8)
    for ax in (top, below):
        ax.grid(alpha=0.25)
        ax.spines[["top", "right"]].set_visible(False)
    top.set_title("flexible_panels: 75 deg, two panels of 0.5 Hz and 0.5 % damping", fontsize=10)
    figure.savefig(path, dpi=130)
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
