"""A campaign's pictures, worth putting in a paper: trajectories, paired errors, sphere, settling.

Rows are those of `statistics` with the columns axis_x, axis_y, axis_z and angle_deg; trajectories
are a table with the columns run, controller, attitude, t_s, q_w..q_z and error_deg.
"""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import matplotlib
import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from simsat.comparison.statistics import FINAL_ERROR, STEADY_STATE, Metric, Row
from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import continuous
from simsat.results.files import write_picture
from simsat.results.metrics import CONVERGED_BELOW_DEG
from simsat.results.pictures.lettering import for_picture

COLORS = ("#4c566a", "#d08770", "#2e7d6b", "#5e81ac", "#b48ead", "#8c564b")
PARTS = (("q_w", "#7f7f7f"), ("q_x", "#d62728"), ("q_y", "#2ca02c"), ("q_z", "#1f77b4"))
SMALLEST_DEG = 1e-4  # foot of logarithmic error axes
WIDTH = 4.2  # inches of a panel


def draw_campaign(rows: Sequence[Row], trajectories: pa.Table, folder: Path) -> list[Path]:
    """Write every picture that the rows allow; returns their paths in reading order."""
    matplotlib.use("Agg")
    pictures = {
        "trajectories": draw_trajectories(trajectories),
        "distributions": draw_distributions(rows),
        "sphere": draw_sphere(rows),
        "settling": draw_settling(rows),
    }
    paths = []
    for name, figure in pictures.items():
        if figure is not None:
            paths.append(folder / f"{name}.png")
            write_picture(paths[-1], figure, dpi=130)
    return paths


def by_controller(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Rows of each controller, in the order of their first appearance."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(str(row["controller"]), []).append(row)
    return groups


def draw_trajectories(trajectories: pa.Table) -> Figure | None:
    """Every component of every run's attitude quaternion, a panel per controller.

    The paper's figure. Of q and -q a run starts with the one whose q_w is not negative and goes on
    without a jump.
    """
    if len(trajectories) == 0:
        return None
    table = trajectories.to_pydict()
    controller, run = np.array(table["controller"]), np.array(table["run"])
    names = list(dict.fromkeys(table["controller"]))
    figure, axes = _panels(len(names), 2.9)
    q = np.stack([np.array(table[part]) for part, _ in PARTS], axis=1)
    t = np.array(table["t_s"])
    for ax, name in zip(axes, names, strict=True):
        mine = controller == name
        breaks = np.flatnonzero(np.diff(run[mine])) + 1
        times = np.split(t[mine], breaks)
        histories = [continuous(history) for history in np.split(q[mine], breaks)]
        for i, (part, color) in enumerate(PARTS):
            for k, (time, history) in enumerate(zip(times, histories, strict=True)):
                label = f"${part}$" if k == 0 else None
                ax.plot(time, history[:, i], color=color, linewidth=0.5, alpha=0.45, label=label)
        ax.set(
            title=f"{for_picture(name)}, {len(breaks) + 1} runs",
            xlabel="time, s",
            ylim=(-1.05, 1.05),
        )
        ax.set_xlim(0.0, float(t.max()))
        legend = ax.legend(loc="lower right", ncols=4, fontsize=8)
        for line in legend.get_lines():
            line.set(linewidth=2.0, alpha=1.0)
        ax.set_ylabel("attitude quaternion")
    return figure


def draw_distributions(rows: Sequence[Row]) -> Figure:
    """Final error and SS RMSE of every run: a dot per run, a line joins runs of one attitude."""
    groups = by_controller(rows)
    figure, axes = _panels(2, 4.0, width=max(WIDTH, 1.6 * len(groups)))
    for ax, metric in zip(axes, (FINAL_ERROR, STEADY_STATE), strict=True):
        _paired(ax, groups, metric)
    return figure


def _paired(ax: Axes, groups: dict[str, list[Row]], metric: Metric) -> None:
    places = {name: dict(_known(group, metric)) for name, group in groups.items()}
    names = list(places)
    for k, (left, right) in enumerate(pairwise(names)):
        for attitude in places[left].keys() & places[right].keys():
            pair = places[left][attitude], places[right][attitude]
            ax.plot((k, k + 1), pair, color="#b0b0b0", linewidth=0.5, alpha=0.6, zorder=1)
    for k, name in enumerate(names):
        values = np.array(list(places[name].values()))
        if values.size == 0:
            continue
        color = COLORS[k % len(COLORS)]
        ax.scatter(np.full(values.size, k), values, s=9, color=color, alpha=0.7, zorder=2)
        low, middle, high = np.percentile(values, [25, 50, 75])
        ax.plot((k - 0.22, k + 0.22), (middle, middle), color="black", linewidth=2.0, zorder=3)
        ax.plot((k, k), (low, high), color="black", linewidth=1.2, zorder=3)
    ax.axhline(CONVERGED_BELOW_DEG, color="#b22222", linestyle="--", linewidth=0.9)
    ax.set_yscale("log")
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_formatter(NullFormatter())
    ax.set_xticks(range(len(names)), _wrapped(names))
    ax.set_xlim(-0.5, len(names) - 0.5)
    ax.set(ylabel=f"{metric.label}, {metric.unit}")
    ax.set_title("runs paired by attitude; median, quartiles", fontsize=9)


def draw_sphere(rows: Sequence[Row]) -> Figure:
    """The initial rotation axes on an equal-area map of the sphere, coloured by final error.

    Longitude runs along the equator, body z is up; the ring around a dot is the smaller angle,
    the dot inside it the larger. A cross marks a run that did not converge.
    """
    groups = by_controller(rows)
    across, down = _grid(len(groups))
    figure = Figure(figsize=(1.2 * WIDTH * across + 0.8, 2.9 * down), layout="constrained")
    known = [float(r[FINAL_ERROR.name]) for r in rows if r.get(FINAL_ERROR.name) is not None]
    norm = LogNorm(max(min(known, default=0.01), SMALLEST_DEG), max([*known, 1.0]))
    dots = None
    for k, (name, group) in enumerate(groups.items()):
        ax = figure.add_subplot(down, across, k + 1, projection="mollweide")
        angles = sorted({float(row["angle_deg"]) for row in group})
        for j, angle in enumerate(angles):
            chosen = [row for row in group if float(row["angle_deg"]) == angle]
            longitude, latitude = _map(chosen)
            values = [
                np.nan if (v := row.get(FINAL_ERROR.name)) is None else max(v, SMALLEST_DEG)
                for row in chosen
            ]
            size = 120.0 / (1 + 3 * j)
            dots = ax.scatter(
                longitude, latitude, c=values, s=size, norm=norm, cmap="viridis",
                edgecolors="white", linewidths=0.6, zorder=2 + j, plotnonfinite=True,
            )  # fmt: skip
            lost = np.array([not row["converged"] for row in chosen])
            ax.scatter(longitude[lost], latitude[lost], marker="x", color="#b22222", s=60, zorder=9)
        ax.set_title(f"{for_picture(name)}\n{_angles(angles)}", fontsize=9)
        ax.grid(alpha=0.3)
        ax.tick_params(labelsize=5)
    if dots is not None:
        figure.colorbar(dots, ax=figure.axes, label="final error, deg", shrink=0.8, aspect=30)
    return figure


def _angles(angles: Sequence[float]) -> str:
    return ", ".join(f"{a:g} deg" for a in angles) + (" (inner)" if len(angles) > 1 else "")


def _map(rows: Sequence[Row]) -> tuple[Array, Array]:
    """Longitude and latitude of the initial axes, rad."""
    axes = np.array([[row["axis_x"], row["axis_y"], row["axis_z"]] for row in rows], float)
    axes = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    return np.arctan2(axes[:, 1], axes[:, 0]), np.arcsin(np.clip(axes[:, 2], -1.0, 1.0))


def draw_settling(rows: Sequence[Row]) -> Figure:
    """Share of runs that have settled below 0.5 deg for good, over time."""
    figure, (ax,) = _panels(1, 3.2, width=6.5)
    latest = 1.0
    for k, (name, group) in enumerate(by_controller(rows).items()):
        times = np.sort([float(r[c]) for r in group if r.get(c := "settling_time_s") is not None])
        share = 100.0 * np.arange(times.size + 1) / len(group)
        color = COLORS[k % len(COLORS)]
        label = f"{for_picture(name)} ({times.size} of {len(group)})"
        ax.step([0.0, *times, 1e6], [*share, share[-1]], where="post", color=color, label=label)
        latest = max([latest, *times])
    ax.set(xlim=(0.0, 1.05 * latest), ylim=(0.0, 103.0))
    ax.set(xlabel="time, s", ylabel="runs settled, %", title="Settled below 0.5 deg for good")
    figure.legend(loc="outside lower center", ncols=3, fontsize=8)
    return figure


def _panels(count: int, height: float, width: float = WIDTH) -> tuple[Figure, list[Axes]]:
    across, down = _grid(count)
    figure = Figure(figsize=(width * across, height * down), layout="constrained")
    axes = list(np.ravel(figure.subplots(down, across, squeeze=False)))
    for ax in axes[count:]:
        ax.remove()
    for ax in axes[:count]:
        ax.grid(alpha=0.25)
        ax.spines[["top", "right"]].set_visible(False)
    return figure, axes[:count]


def _grid(count: int) -> tuple[int, int]:
    """Panels across and down: at most three beside each other, four as two by two."""
    across = 2 if count == 4 else min(count, 3)
    return across, -(-count // across)


def _known(rows: Sequence[Row], metric: Metric) -> list[tuple[object, float]]:
    """(attitude, value) of the rows that have the metric."""
    return [
        (row["attitude"], max(float(value), SMALLEST_DEG))
        for row in rows
        if (value := row.get(metric.name)) is not None
    ]


def _wrapped(names: Sequence[str]) -> list[str]:
    return [for_picture(name).replace("-", "-\n", 2) for name in names]
