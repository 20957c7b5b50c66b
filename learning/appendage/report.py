"""What training reached: errors on flights never trained on, of the body rates and of the momentum
along the unactuated axis."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import matplotlib
import numpy as np
import torch
from torch import Tensor

from simsat.comparison.markdown import markdown_table
from simsat.control.ground.arrays import Array
from simsat.control.model.appendage import AppendageNetwork
from simsat.results.files import write_picture

from .fit import TrainedLayer
from .rollout import (
    Appendage,
    Recursion,
    Rollouts,
    build_rollouts,
    momentum_errors,
    without_network,
)
from .series import Series

matplotlib.use("Agg")
import matplotlib.pyplot as plt

AHEAD = (1, 4, 16)
"""Control periods ahead for which the report gives errors."""


@dataclass(frozen=True)
class Score:
    """Errors 1, 2, ... periods ahead of one estimator."""

    rate: list[float]
    """Of the body rates, rad/s RMS."""
    along: list[float]
    """Of c along the unactuated axis, Nms RMS; empty without one."""


Scores: TypeAlias = dict[str, Score]
"""By estimator."""


def score(modules: dict[str, Appendage], unseen: Series) -> Scores:
    """Errors of every roll-out of some flights from exactly measured momenta.

    The estimators without a network take the inertia of the first module.
    """
    rollouts = build_rollouts(unseen, max(AHEAD), 0.0, 0)
    first = next(iter(modules.values()))
    recursions: dict[str, tuple[Appendage, Recursion]] = {
        "no network": (first, without_network),
        "c held": (first, _held),
        **{name: (module, module) for name, module in modules.items()},
    }
    return {
        name: _score(module, rollouts, recursion)
        for name, (module, recursion) in recursions.items()
    }


def _score(module: Appendage, rollouts: Rollouts, recursion: Recursion) -> Score:
    with torch.no_grad():
        error, _ = momentum_errors(module, rollouts, recursion)
        rate = _rms(error @ module.to_rate().T)
        return Score(rate, [] if module.n is None else _rms(error @ module.n[:, None]))


def _rms(error: Tensor) -> list[float]:
    """Of the vectors in (n, horizon, .), by period ahead."""
    values: list[float] = (error**2).sum(dim=-1).mean(dim=0).sqrt().tolist()
    return values


def score_table(scores: Scores) -> str:
    """The scores as a Markdown table."""
    ahead = ", ".join(str(k) for k in AHEAD)
    head = f"rate error {ahead} periods ahead, 1e-6 rad/s RMS"
    rows = [[name, _row(one.rate), _row(one.along)] for name, one in scores.items()]
    return markdown_table(["estimator", head, "c along the unactuated axis, 1e-6 Nms RMS"], rows)


def _row(errors: list[float]) -> str:
    return " / ".join(f"{1e6 * errors[k - 1]:.1f}" for k in AHEAD) if errors else "none"


def verdict(trained: TrainedLayer) -> str:
    """Whether a layer earns its place, from both held-out losses, as a sentence."""
    cut = 100.0 * (1.0 - trained.loss / trained.before)
    return (
        f"The {trained.layer} layer takes the held-out loss from {trained.before:.5f} to "
        f"{trained.loss:.5f}, {cut:.1f} % less: it is {'kept' if trained.kept else 'left out'}."
    )


def draw_scores(scores: Scores, path: Path) -> None:
    """Rate error over the periods ahead."""
    figure, axis = plt.subplots(figsize=(7, 3.8), layout="constrained")
    for name, one in scores.items():
        axis.semilogy(np.arange(1, len(one.rate) + 1), one.rate, marker=".", label=name)
    axis.set(xlabel="control periods ahead", ylabel="rate error, rad/s RMS")
    axis.set_title("Rates predicted on flights never trained on")
    axis.grid(alpha=0.3)
    axis.legend()
    write_picture(path, figure, dpi=110)
    plt.close(figure)


def _held(x: Tensor, p: Tensor) -> Tensor:
    """The recursion that says c stays."""
    return torch.cat([x[..., :3], x[..., :3]], dim=-1)


def facts(network: AppendageNetwork, scores: Scores) -> dict[str, Any]:
    """Figures for JSON."""
    ahead: Array = np.array(AHEAD)
    return {
        "J_kg_m2": network.J.tolist(),
        "periods_ahead": ahead.tolist(),
        "rate_error_rms_rad_s": {
            name: [one.rate[k - 1] for k in AHEAD] for name, one in scores.items()
        },
        "unactuated_c_error_rms_Nms": {
            name: [one.along[k - 1] for k in AHEAD] for name, one in scores.items() if one.along
        },
    }
