"""What training reached: errors of the predicted body rates on flights never trained on."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import torch
from torch import Tensor

from control.learned.appendage import AppendageNetwork
from learning.appendage_rollout import (
    Appendage,
    build_rollouts,
    rate_errors,
    without_network,
)
from learning.appendage_series import Series
from simsat.arrays import Array

matplotlib.use("Agg")
import matplotlib.pyplot as plt

AHEAD = (1, 4, 16)
"""Control periods ahead for which the report gives errors."""
Scores = dict[str, list[float]]
"""Rate error, rad/s RMS, 1, 2, ... periods ahead, by estimator."""


def score(modules: dict[str, Appendage], unseen: Series) -> Scores:
    """Errors of every roll-out of some flights from exactly measured momenta.

    The estimators without a network take the inertia of the first module.
    """
    rollouts = build_rollouts(unseen, max(AHEAD), 0.0, 0)
    first = next(iter(modules.values()))
    steps: dict[str, tuple[Appendage, Callable[[Tensor], Tensor]]] = {
        "no network": (first, without_network),
        "c held": (first, _held),
        **{name: (module, module) for name, module in modules.items()},
    }
    scores = {}
    for name, (module, step) in steps.items():
        with torch.no_grad():
            error, _ = rate_errors(module, rollouts, step)
        scores[name] = (error**2).sum(dim=-1).mean(dim=0).sqrt().tolist()
    return scores


def score_table(scores: Scores) -> str:
    """The scores as a Markdown table."""
    ahead = ", ".join(str(k) for k in AHEAD)
    lines = [
        f"| estimator | rate error {ahead} periods ahead, 1e-6 rad/s RMS |",
        "| --- | --- |",
    ]
    for name, errors in scores.items():
        row = " / ".join(f"{1e6 * errors[k - 1]:.1f}" for k in AHEAD)
        lines.append(f"| {name} | {row} |")
    return "\n".join(lines)


def verdict(linear: float, tanh: float, kept: bool) -> str:
    """Whether the tanh layer earns its place, from both held-out losses, as a sentence."""
    cut = 100.0 * (1.0 - tanh / linear)
    fate = "kept" if kept else "left out, and the network is linear"
    return (
        f"The tanh layer takes the held-out loss from {linear:.5f} to {tanh:.5f}, "
        f"{cut:.1f} % less: it is {fate}."
    )


def draw_scores(scores: Scores, path: Path) -> None:
    """Rate error over the periods ahead."""
    figure, axis = plt.subplots(figsize=(7, 3.8), layout="constrained")
    for name, errors in scores.items():
        axis.semilogy(np.arange(1, len(errors) + 1), errors, marker=".", label=name)
    axis.set(xlabel="control periods ahead", ylabel="rate error, rad/s RMS")
    axis.set_title("Rates predicted on flights never trained on")
    axis.grid(alpha=0.3)
    axis.legend()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _held(x: Tensor) -> Tensor:
    """The recursion that says c stays."""
    return torch.cat([x[..., :3], x[..., :3]], dim=-1)


def facts(network: AppendageNetwork, scores: Scores) -> dict[str, Any]:
    """Figures for JSON."""
    ahead: Array = np.array(AHEAD)
    return {
        "J_kg_m2": network.J.tolist(),
        "periods_ahead": ahead.tolist(),
        "rate_error_rms_rad_s": {
            name: [errors[k - 1] for k in AHEAD] for name, errors in scores.items()
        },
    }
