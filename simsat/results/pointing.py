"""How well a flight points once it has settled, over hours and from target to target."""

from typing import Any

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.reference.reference import Reference, Sequence
from simsat.flight.loop import Flight


def first_settled(t: Array, error: Array, bound: float, stay_s: float) -> int | None:
    """First sample from which the error stays below the bound for so long; None without one."""
    inside = error < bound
    starts = np.flatnonzero(inside & ~np.concatenate([[False], inside[:-1]]))
    ends = np.flatnonzero(inside & ~np.concatenate([inside[1:], [False]]))
    long = t[ends] - t[starts] >= stay_s - 1e-9
    return int(starts[np.argmax(long)]) if long.any() else None


def pointing_metrics(flight: Flight, error: Array, bound: float, stay_s: float) -> dict[str, Any]:
    """Share of the time below the bound, largest excursion, median and 95th percentile of the error
    from the first settling on; None without one. What drifts through the target does not settle:
    `stay_s` is the least that counts."""
    t = flight.plant.log.t
    first = first_settled(t, error, bound, stay_s)
    after = error[first:] if first is not None else np.array([])
    figures: dict[str, Any] = {
        "first_settled_s": None if first is None else float(t[first]),
        "share_in_bounds": float(np.mean(after < bound)) if after.size else None,
        "largest_excursion_deg": float(after.max()) if after.size else None,
        "median_error_deg": float(np.median(after)) if after.size else None,
        "p95_error_deg": float(np.percentile(after, 95)) if after.size else None,
    }
    return figures | _rods(flight) | _unactuated(flight)


def _rods(flight: Flight) -> dict[str, Any]:
    dipoles = flight.plant.dipoles
    return {"peak_dipole_Am2": float(np.abs(dipoles).max())} if dipoles.shape[1] else {}


def _unactuated(flight: Flight) -> dict[str, Any]:
    """Momentum along the axis without a wheel, n'H."""
    plant, craft = flight.plant, flight.plant.model.spacecraft
    if craft.unactuated is None:
        return {}
    along = unactuated_momentum(flight)
    assert len(along) == len(plant.log.t)
    return {
        "unactuated_momentum_Nms": {
            "largest": float(np.abs(along).max()),
            "final": float(along[-1]),
        }
    }


def unactuated_momentum(flight: Flight) -> Array:
    """n'H at every sample, Nms, of the craft as a rigid body; shape (rows,)."""
    plant, craft = flight.plant, flight.plant.model.spacecraft
    assert craft.unactuated is not None
    return craft.angular_momentum(plant.rates, plant.wheel_speeds) @ craft.unactuated


def settling_by_target(
    flight: Flight, error: Array, reference: Reference, bound: float, stay_s: float
) -> dict[str, Any]:
    """For each target of a sequence when it began to count and how long the craft took to settle
    there for good, s; None where it did not. Nothing for other references."""
    if not isinstance(reference, Sequence):
        return {}
    t = flight.plant.log.t
    counts = reference.index(t)
    rows = []
    for target in range(int(counts[-1]) + 1):
        here = np.flatnonzero(counts == target)
        if not len(here):
            continue
        outside = np.flatnonzero(error[here] >= bound)
        settled = int(outside[-1]) + 1 if len(outside) else 0
        stays = settled < len(here) and t[here[-1]] - t[here[settled]] >= stay_s - 1e-9
        start = float(reference.starts[target])
        took = float(t[here[settled]]) - start if stays else None
        rows.append({"start_s": start, "settling_time_s": took})
    return {"targets": rows}
