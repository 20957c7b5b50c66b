"""orbit.png: a flight of hours on one page, with what the orbit brings."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.environment.earth import sun_direction
from simsat.environment.solar_pressure import sunlit
from simsat.flight.loop import Flight
from simsat.flight.mission import Mission
from simsat.mjcf.wheels import RPM
from simsat.results.metrics import CONVERGED_BELOW_DEG, error_deg
from simsat.results.pictures.lettering import for_picture
from simsat.results.pictures.summary_picture import LIMIT, SMALLEST_DEG, WHEELS
from simsat.results.pointing import unactuated_momentum

POINTS = 5000  # a curve has no more: a page is 1000 dots wide
SHADOW = "#d9d9d9"


def draw_orbit(flight: Flight, mission: Mission) -> Figure:
    """Error (log axis), momentum along the axis without a wheel, dipoles, wheel speeds, and how far
    the field lies across that axis, |b x n|; grey is the Earth's shadow. What a craft doesn't have
    is left out."""
    plant, craft = flight.plant, mission.model.spacecraft
    rows = slice(None, None, -(-plant.log.rows // POINTS))
    t, hours = plant.log.t[rows], plant.log.t[rows] / 3600.0
    n, rods = craft.unactuated, craft.rods
    panels = 2 + 2 * (n is not None) + bool(rods.count)
    figure = Figure(figsize=(9.0, 2.0 * panels), layout="constrained")
    axes: list[Axes] = list(figure.subplots(panels, 1, sharex=True))
    figure.suptitle(for_picture(mission.title), fontsize=11)
    panel = iter(axes)
    _error(next(panel), hours, error_deg(flight, mission.references(flight))[rows])
    if n is not None:
        along = 1e3 * unactuated_momentum(flight)[rows, None]
        _curves(next(panel), hours, along, [""], "momentum along n, mNms")
    if rods.count:
        _curves(next(panel), hours, plant.dipoles[rows], rods.names, "dipole, A m$^2$")
    speeds = plant.wheel_speeds[rows] / RPM
    _curves(next(panel), hours, speeds, craft.wheel_names, "wheel speed, rpm")
    if n is not None:
        across = field_across(mission, t, plant.attitudes[rows], n)
        _curves(next(panel), hours, across[:, None], [""], "|b x n|")
        axes[-1].set_ylim(0.0, 1.05)
    for ax in axes:
        _shade(ax, hours, in_shadow(mission, t))
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("time, h")
    axes[-1].set_xlim(0.0, max(float(hours[-1]), plant.tick / 3600.0))
    return figure


def field_across(mission: Mission, t: Array, q: Array, n: Array) -> Array:
    """|b x n|: how much of the rods' torque can lie along n, 0 to 1; at t (k,), attitudes q (k, 4),
    n in body axes."""
    b = attitude.normalized(mission.environment.field_N(t))
    return np.linalg.norm(np.cross(b, attitude.rotation_matrix(q) @ n), axis=1)


def in_shadow(mission: Mission, t: Array) -> Array:
    """1 in the Earth's shadow, else 0, at t (k,)."""
    orbit = mission.environment.orbit
    sun = sun_direction(orbit.epoch_days)  # stands still, as for the torque of its light
    lit = sunlit(orbit.direction(t), sun, orbit.radius_at(t))
    return 1.0 - np.broadcast_to(np.asarray(lit), t.shape)


def _error(ax: Axes, hours: Array, error: Array) -> None:
    ax.semilogy(hours, np.maximum(error, SMALLEST_DEG), color="black", linewidth=0.9)
    ax.axhline(CONVERGED_BELOW_DEG, **LIMIT)
    ax.set_ylabel("error, deg")


def _curves(ax: Axes, hours: Array, values: Array, names: Sequence[str], label: str) -> None:
    for i, name in enumerate(names):
        color = WHEELS[i % len(WHEELS)]
        ax.plot(hours, values[:, i], color=color, label=for_picture(name), linewidth=0.9)
    ax.set_ylabel(label)
    if names[0]:
        ax.legend(loc="upper right", fontsize=8, ncols=4)


def _shade(ax: Axes, hours: Array, shadow: Array) -> None:
    ax.fill_between(
        hours, 0.0, 1.0, where=shadow > 0.5, transform=ax.get_xaxis_transform(), color=SHADOW,
        alpha=0.5, step="mid", linewidth=0.0, zorder=0.0,
    )  # fmt: skip
