"""What training reached: errors on flights never trained on, curves, and an estimate over time."""

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import torch

from simsat.comparison.markdown import markdown_table
from simsat.control.correction.network import Network
from simsat.control.ground.arrays import Array
from simsat.control.model.rates import RateModel, rate_effect
from simsat.results.files import write_picture
from simsat.results.pictures.lettering import for_picture

from ..sequence import self_fed
from .rollout import build_problem, rate_error
from .windows import Windows

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLORS = {"nominal": "0.6", "linear": "tab:green", "pinn": "tab:orange", "oracle": "black"}


def estimates_of(
    networks: dict[str, Network], windows: Windows, believed: RateModel
) -> dict[str, Array]:
    """Estimates (R, K, m) of each network, self-fed, between no estimate and the oracle's."""
    return {
        "nominal": np.zeros_like(windows.residual),
        **{name: self_fed(network, windows, believed) for name, network in networks.items()},
        "oracle": windows.residual,
    }


def rate_rms(estimates: Array, windows: Windows, believed: RateModel) -> Array:
    """Root mean square error of the rates one period ahead, rad/s, per body axis, shape (3,)."""
    problem = build_problem(windows, believed, 1.0)
    tau_hat = torch.as_tensor(estimates.reshape(-1, estimates.shape[-1]))
    error = rate_error(problem, tau_hat, torch.arange(len(tau_hat))).numpy()
    rms: Array = np.sqrt(np.mean(error**2, axis=0))
    return rms


def torque_rms(estimates: Array, windows: Windows) -> Array:
    """Root mean square error of the estimate per wheel axis, Nm, shape (m,)."""
    rms: Array = np.sqrt(np.mean((estimates - windows.residual) ** 2, axis=(0, 1)))
    return rms


def wheel_axis_rms(estimates: Array, windows: Windows, believed: RateModel) -> float:
    """Root mean square of the rate error that is left on the wheel axes, rad/s."""
    effect = rate_effect(believed, windows.period)
    left = (estimates - windows.residual) @ effect.T
    return float(np.sqrt(np.mean(np.sum(left**2, axis=-1))))


def score(
    networks: dict[str, Network], windows: Windows, believed: RateModel
) -> dict[str, dict[str, Any]]:
    """Figures of each estimator on some flights, ready for JSON."""
    estimates = estimates_of(networks, windows, believed)
    nominal = wheel_axis_rms(estimates["nominal"], windows, believed)
    scores = {}
    for name, values in estimates.items():
        left = wheel_axis_rms(values, windows, believed)
        scores[name] = {
            "rate_error_rms_rad_s": rate_rms(values, windows, believed).tolist(),
            "torque_error_rms_Nm": torque_rms(values, windows).tolist(),
            "rate_error_wheel_axes_rad_s": left,
            "cut_of_wheel_axis_error_percent": 100.0 * (1.0 - left / nominal),
        }
    return scores


def score_table(scores: dict[str, dict[str, Any]]) -> str:
    """The scores as a Markdown table."""
    head = (
        "estimator",
        "rate error after one period, x / y / z, 1e-6 rad/s",
        "on the wheel axes, 1e-6 rad/s",
        "cut",
    )
    rows = []
    for name, figures in scores.items():
        axes = " / ".join(f"{1e6 * value:.1f}" for value in figures["rate_error_rms_rad_s"])
        left = 1e6 * figures["rate_error_wheel_axes_rad_s"]
        cut = figures["cut_of_wheel_axis_error_percent"]
        rows.append([name, axes, f"{left:.1f}", f"{cut:.1f} %"])
    return markdown_table(head, rows)


def draw_curves(curves: list[dict[str, float]], linear: float, path: Path) -> None:
    """Training and held-out loss over all epochs, beside the linear baseline's."""
    figure, axis = plt.subplots(figsize=(8, 4.2), layout="constrained")
    epoch = np.arange(1, len(curves) + 1)
    for key, color, label in (
        ("training_loss", "tab:blue", "training flights"),
        ("held_out_loss", "tab:orange", "held-out flights, self-fed"),
    ):
        axis.semilogy(epoch, [row[key] for row in curves], color=color, label=label)
    axis.axhline(linear, color=COLORS["linear"], ls="--", label="least squares, held-out flights")
    starts = [k for k in range(1, len(curves)) if curves[k]["round"] != curves[k - 1]["round"]]
    for k in starts:
        axis.axvline(k + 0.5, color="0.7", lw=1)
        axis.text(k - 1, 0.04, "corrected flights join", transform=axis.get_xaxis_transform(),
                  ha="right", color="0.4")  # fmt: skip
    axis.set(xlabel="epoch", ylabel="loss", title="Roll-out loss (nominal model: 1)")
    axis.legend(loc="upper right")
    write_picture(path, figure, dpi=110)
    plt.close(figure)


def draw_flight(
    networks: dict[str, Network],
    windows: Windows,
    believed: RateModel,
    wheel_names: tuple[str, ...],
    path: Path,
) -> None:
    """Estimated against true residual torque over one flight, a row of axes per wheel."""
    one = windows.pick(np.arange(1))
    estimates = estimates_of(networks, one, believed)
    t = one.period * np.arange(one.torque.shape[1])
    figure, axes = plt.subplots(
        len(wheel_names), 1, figsize=(9, 2.6 * len(wheel_names)), sharex=True, squeeze=False,
        layout="constrained",
    )  # fmt: skip
    for wheel, (axis, name) in enumerate(zip(axes[:, 0], wheel_names, strict=True)):
        axis.step(t, 1e3 * estimates["oracle"][0, :, wheel], where="post", color="black", lw=2.2,
                  alpha=0.35, label="true residual")  # fmt: skip
        for network in networks:
            axis.step(t, 1e3 * estimates[network][0, :, wheel], where="post", lw=1,
                      color=COLORS.get(network), label=network)  # fmt: skip
        axis.set_ylabel(f"{for_picture(name)}, mNm")
        axis.grid(alpha=0.3)
    axes[0, 0].set_title("A flight never trained on: residual torque on the wheel axes")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncol=len(labels))
    axes[-1, 0].set_xlabel("t, s")
    write_picture(path, figure, dpi=110)
    plt.close(figure)


def draw_scores(scores: dict[str, dict[str, Any]], path: Path) -> None:
    """Rate error per axis of each estimator, as bars on a logarithmic scale."""
    figure, axis = plt.subplots(figsize=(7, 3.8), layout="constrained")
    width = 0.8 / len(scores)
    for k, (name, figures) in enumerate(scores.items()):
        values = 1e6 * np.array(figures["rate_error_rms_rad_s"])
        axis.bar(np.arange(3) + (k - 0.5 * len(scores) + 0.5) * width, values, width,
                 color=COLORS.get(name), label=name)  # fmt: skip
    axis.set_yscale("log")
    axis.set_xticks(range(3), ["body x", "body y", "body z"])
    axis.set_ylabel("rate error, 1e-6 rad/s RMS")
    axis.set_title("Rates one control period ahead, flights never trained on")
    axis.set_ylim(top=10.0 * axis.get_ylim()[1])
    axis.legend(ncol=len(scores), loc="upper center")
    write_picture(path, figure, dpi=110)
    plt.close(figure)
