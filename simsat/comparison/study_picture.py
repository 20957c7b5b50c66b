"""study.png: how each controller's results change with the varied setting."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from simsat.campaign.study import label
from simsat.comparison.pictures import COLORS
from simsat.comparison.statistics import FINAL_ERROR, SETTLING, STEADY_STATE, Metric
from simsat.comparison.study_rows import StudyRow
from simsat.results.files import write_picture
from simsat.results.pictures.lettering import for_picture

STYLES = ("-", "--", ":", "-.")


def draw_study(table: list[StudyRow], path: Path) -> None:
    """Converged share, final error, SS RMSE and settling time over the first setting that varies:
    means as lines, worst runs as small triangles; further settings by line style."""
    matplotlib.use("Agg")
    figure = Figure(figsize=(11.0, 6.8), layout="constrained")
    axes: list[Axes] = list(figure.subplots(2, 2, sharex=True).flat)
    for (controller, rest), rows in curves(table).items():
        _draw(axes, controller, rest, rows, table)
    name = abscissa(table)
    for axis in axes:
        places, values = _ticks(table, name)
        axis.set_xticks(places, [for_picture(value) for value in values])
        axis.grid(alpha=0.3)
    for axis in axes[2:]:
        axis.set_xlabel(for_picture(name))
    axes[0].set(ylabel="converged, %", ylim=(-3.0, 103.0))
    for axis, text in zip(axes[1:3], ("final error, deg", "SS RMSE, deg"), strict=True):
        _plain_log(axis, text)
    axes[3].set(ylabel="settling time, s", ylim=(0.0, None))
    figure.suptitle("mean of the runs (lines) and worst run (triangles)", fontsize=10)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, fontsize=9)
    write_picture(path, figure, dpi=130)


def abscissa(table: list[StudyRow]) -> str:
    """The first setting that takes several values, or the first one if none does."""
    names = list(table[0].point)
    varied = (name for name in names if len({str(row.point[name]) for row in table}) > 1)
    return next(varied, names[0])


def curves(table: list[StudyRow]) -> dict[tuple[str, str], list[StudyRow]]:
    """Rows by controller and by the settings that are not the abscissa."""
    found: dict[tuple[str, str], list[StudyRow]] = {}
    for row in table:
        rest = {name: value for name, value in row.point.items() if name != abscissa(table)}
        found.setdefault((row.result.controller, label(rest)), []).append(row)
    return found


def _draw(
    axes: list[Axes], controller: str, rest: str, rows: list[StudyRow], table: list[StudyRow]
) -> None:
    controllers = list(dict.fromkeys(row.result.controller for row in table))
    rests = list(dict.fromkeys(key[1] for key in curves(table)))
    color = COLORS[controllers.index(controller) % len(COLORS)]
    style = STYLES[rests.index(rest) % len(STYLES)]
    name = abscissa(table)
    places, values = _ticks(table, name)
    x = [places[values.index(row.point[name])] for row in rows]
    share = [100.0 * row.result.converged / row.result.runs for row in rows]
    text = for_picture(f"{controller}, {rest}" if rest else controller)
    axes[0].plot(x, share, style, color=color, marker="o", markersize=4, label=text)
    for axis, metric in zip(axes[1:], (FINAL_ERROR, STEADY_STATE, SETTLING), strict=True):
        mean, maximum = _means(rows, metric), _maxima(rows, metric)
        axis.plot(x, mean, style, color=color, marker="o", markersize=4)
        axis.plot(x, maximum, linestyle="none", color=color, marker="^", markersize=4, alpha=0.6)


def _means(rows: list[StudyRow], metric: Metric) -> list[float]:
    return [row.result.summaries[metric.name].mean for row in rows]


def _maxima(rows: list[StudyRow], metric: Metric) -> list[float]:
    return [row.result.summaries[metric.name].maximum for row in rows]


def _plain_log(axis: Axes, text: str) -> None:
    """A logarithmic axis that reads 0.1, 0.2, 0.5 instead of powers; linear if it stays empty."""
    axis.set_ylabel(text)
    if not any(np.isfinite(line.get_ydata()).any() for line in axis.lines):
        return
    axis.set_yscale("log")
    axis.yaxis.set_major_formatter("{x:g}")
    axis.yaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
    axis.yaxis.set_minor_formatter("{x:g}")


def _ticks(table: list[StudyRow], name: str) -> tuple[list[float], list[str]]:
    """Places and labels of a setting's values: to scale if they are numbers, else side by side."""
    values = list(dict.fromkeys(row.point[name] for row in table))
    try:
        places = [float(value) for value in values]
    except ValueError:
        places = [float(i) for i in range(len(values))]
    return places, values
