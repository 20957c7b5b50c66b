"""summary.png: a flight on one page."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.ground.magnetorquers import Magnetorquers
from simsat.flight.loop import Flight
from simsat.flight.mission import Mission
from simsat.mjcf.wheels import RPM
from simsat.plant.plant import Plant
from simsat.results.files import write_picture
from simsat.results.metrics import CONVERGED_BELOW_DEG, error_deg, settling_sample
from simsat.results.pictures.lettering import for_picture

SMALLEST_DEG = 1e-4  # foot of the logarithmic error axis
# Okabe and Ito's colours (Color Universal Design, 2008), which all eyes tell apart
AXES = ("#D55E00", "#009E73", "#0072B2")
WHEELS = ("#E69F00", "#56B4E9", "#CC79A7", "#000000", "#009E73", "#7f7f7f")
LIMIT: dict[str, Any] = {"color": "#b22222", "linestyle": "--", "linewidth": 0.9}


def draw_summary(flight: Flight, mission: Mission) -> Figure:
    """Quaternion, error (log axis, 0.5 deg line), rates, wheel speeds and torques with limits, the
    dipoles where there are rods, the correction where there is one, the supervisor's
    certificate."""
    supervised = any(step.correction is not None for step in flight.steps)
    judged = any(step.verdict is not None for step in flight.steps)
    rods = mission.model.spacecraft.rods
    rows = 5 + bool(rods.count) + supervised + judged
    figure = Figure(figsize=(9.0, 2.2 * rows), layout="constrained")
    axes: list[Axes] = list(figure.subplots(rows, 1, sharex=True))
    figure.suptitle(for_picture(_title(flight, mission)), fontsize=11)
    plant, craft = flight.plant, mission.model.spacecraft
    t, names = plant.log.t, tuple(map(for_picture, craft.wheel_names))
    references = mission.references(flight)
    error = attitude.error_quaternion(plant.attitudes, references)
    _quaternion(axes[0], t, attitude.continuous(error))
    _error(axes[1], flight, error_deg(flight, references))
    _curves(axes[2], t, np.degrees(plant.rates), "xyz", AXES, "body rate, deg/s")
    _curves(axes[3], t, plant.wheel_speeds / RPM, names, WHEELS, "wheel speed, rpm")
    _limits(axes[3], craft.speed_max / RPM)
    _curves(axes[4], t, 1e3 * plant.torques, names, WHEELS, "wheel torque, mNm")
    _limits(axes[4], 1e3 * craft.torque_max)
    further = iter(axes[5:])
    if rods.count:
        _dipoles(next(further), plant, rods)
    if supervised:
        _correction(next(further), flight, names)
    if judged:
        _certificate(next(further), flight)
    axes[-1].set_xlabel("time, s")
    axes[-1].set_xlim(0.0, max(float(t[-1]), flight.plant.tick))
    for ax in axes:
        ax.grid(alpha=0.3)
    return figure


def save_picture(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, without a screen."""
    FigureCanvasAgg(figure)
    write_picture(path, figure, dpi=110)


def _title(flight: Flight, mission: Mission) -> str:
    return f"{mission.title}\n{flight.reason}" if flight.reason else mission.title


def _quaternion(ax: Axes, t: Array, q: Array) -> None:
    _curves(ax, t, q, ("$q_0$", "$q_1$", "$q_2$", "$q_3$"), ("#7f7f7f", *AXES), "attitude error")
    ax.set_ylim(-1.05, 1.05)


def _error(ax: Axes, flight: Flight, error: Array) -> None:
    t = flight.plant.log.t
    ax.semilogy(t, np.maximum(error, SMALLEST_DEG), color="black", linewidth=1.2)
    ax.axhline(CONVERGED_BELOW_DEG, **LIMIT, label=f"{CONVERGED_BELOW_DEG:g} deg")
    settled = settling_sample(flight, error)
    if settled:
        ax.axvline(t[settled], color=AXES[1], linewidth=0.9, label=f"settled, {t[settled]:.1f} s")
    ax.set_ylabel("error, deg")
    ax.legend(loc="upper right", fontsize=8)


def _curves(
    ax: Axes, t: Array, values: Array, names: Sequence[str], colors: Sequence[str], y: str
) -> None:
    for i, name in enumerate(names):
        ax.plot(t, values[:, i], color=colors[i], label=name, linewidth=1.1)
    ax.set_ylabel(y)
    ax.legend(loc="upper right", fontsize=8, ncols=4)


def _limits(ax: Axes, limits: Array) -> None:
    for limit in sorted({round(float(value), 9) for value in limits if np.isfinite(value)}):
        ax.axhline(limit, **LIMIT)
        ax.axhline(-limit, **LIMIT)


def _dipoles(ax: Axes, plant: Plant, rods: Magnetorquers) -> None:
    names = tuple(map(for_picture, rods.names))
    colors = [WHEELS[i % len(WHEELS)] for i in range(rods.count)]
    _curves(ax, plant.log.t, plant.dipoles, names, colors, "dipole, A m$^2$")
    _limits(ax, rods.dipole_max)


def _correction(ax: Axes, flight: Flight, names: tuple[str, ...]) -> None:
    steps = [step for step in flight.steps if step.correction is not None]
    t = np.array([step.t for step in steps])
    torque = 1e3 * np.array([step.correction.torque for step in steps if step.correction])
    for i, name in enumerate(names):
        ax.step(t, torque[:, i], where="post", color=WHEELS[i], label=name, linewidth=1.1)
    ax.set_ylabel("correction, mNm")
    handles, labels = ax.get_legend_handles_labels()
    verdicts = [step.verdict for step in steps if step.verdict is not None]
    if verdicts:
        share = ax.twinx()
        share.fill_between(
            t, [verdict.alpha for verdict in verdicts], step="post", color=AXES[1], alpha=0.18,
            label="share accepted",
        )  # fmt: skip
        share.set_ylim(0.0, 1.05)
        share.set_ylabel("alpha")
        more = share.get_legend_handles_labels()
        handles, labels = handles + more[0], labels + more[1]
    ax.legend(handles, labels, loc="upper right", fontsize=8, ncols=4)


def _certificate(ax: Axes, flight: Flight) -> None:
    """V, and its rate under the plan alone beside what the supervisor's test holds it to."""
    verdicts = [(step.t, step.verdict) for step in flight.steps if step.verdict is not None]
    t = np.array([time for time, _ in verdicts])
    rate = np.array([(verdict.rate, verdict.rate_bound) for _, verdict in verdicts])
    scale = np.nanmax(np.abs(rate), initial=0.0)
    for values, name, color in zip(
        rate.T, ("$V'$ of the plan", "$V'$ as bounded"), ("#7f7f7f", AXES[1]), strict=True
    ):
        ax.step(t, values, where="post", color=color, label=name, linewidth=1.1)
    ax.set_yscale("symlog", linthresh=max(1e-4 * scale, 1e-12))
    ax.set_ylabel("$V'$")
    certificate = ax.twinx()
    V = np.array([verdict.certificate for _, verdict in verdicts])
    certificate.semilogy(t, np.maximum(V, 1e-12), color="black", linewidth=0.9, label="$V$")
    certificate.set_ylabel("$V$")
    more = certificate.get_legend_handles_labels()
    own = ax.get_legend_handles_labels()
    ax.legend(own[0] + more[0], own[1] + more[1], loc="upper right", fontsize=8, ncols=3)
