"""What bad networks do to the final error, without and with a supervisor, on one picture."""

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from simsat.results.files import write_picture
from simsat.results.metrics import CONVERGED_BELOW_DEG

PLAIN = "nmpc"
COLORS = {
    PLAIN: "#4c566a",
    "none": "#b22222",
    "faithful": "#d08770",
    "sound": "#2e7d6b",
    "value": "#5e81ac",
}
LABELS = {PLAIN: "no\nnetwork", "none": "unsuper-\nvised"}
SMALLEST_DEG = 1e-3
ACROSS = 4


def draw_bad_networks(rows: list[dict[str, Any]], path: Path) -> None:
    """A panel per network, a column of dots per supervisor, a dot per flight; a cross marks a
    flight that did not converge."""
    matplotlib.use("Agg")
    networks = [n for n in dict.fromkeys(row["network"] for row in rows) if not n.startswith(PLAIN)]
    down = -(-len(networks) // ACROSS)
    figure = Figure(figsize=(3.1 * ACROSS, 2.9 * down), layout="constrained")
    axes: list[Axes] = list(
        np.ravel(figure.subplots(down, ACROSS, sharex=True, sharey=True, squeeze=False))
    )
    plain = [row for row in rows if row["network"] == PLAIN]
    rules = list(dict.fromkeys(row["rule"] for row in rows))
    for ax, network in zip(axes, networks, strict=False):
        mine = [row for row in rows if row["network"] == network]
        _column(ax, 0, plain, COLORS[PLAIN])
        for k, rule in enumerate(rules, start=1):
            _column(ax, k, [row for row in mine if row["rule"] == rule], COLORS[rule])
        ax.axhline(CONVERGED_BELOW_DEG, color="#b22222", linestyle="--", linewidth=0.8)
        ax.set_yscale("log")
        ax.set_title(network, fontsize=10)
        names = [LABELS.get(name, name) for name in (PLAIN, *rules)]
        ax.set_xticks(range(len(names)), names, fontsize=8)
        ax.grid(alpha=0.25, axis="y")
        ax.spines[["top", "right"]].set_visible(False)
    for ax in axes[len(networks) :]:
        ax.remove()
    for ax in axes[::ACROSS]:
        ax.set_ylabel("final error, deg")
    write_picture(path, figure, dpi=130)


def _column(ax: Axes, place: int, rows: list[dict[str, Any]], color: str) -> None:
    """The dots of one supervisor, spread a little so that they do not hide each other."""
    spread = np.linspace(-0.22, 0.22, max(len(rows), 1))
    for converged, marker, size in ((True, "o", 11.0), (False, "x", 28.0)):
        chosen = [(x, row) for x, row in zip(spread, rows, strict=False)
                  if bool(row["converged"]) is converged]  # fmt: skip
        x = [place + x for x, _ in chosen]
        y = [max(row["final_error_deg"], SMALLEST_DEG) for _, row in chosen]
        ax.scatter(x, y, marker=marker, s=size, color=color, linewidths=1.2)
