"""A flown flight to look at: tables, metrics, pictures, a folder of results, a recording."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from simsat.appraisal.outcome import explain
from simsat.appraisal.preview import preview
from simsat.control.ground.errors import PluginError
from simsat.flight.loop import Flight
from simsat.flight.mission import Mission
from simsat.flight.plugins import named, shown
from simsat.identity.flight import mission_identity
from simsat.results.copies import carry
from simsat.results.files import write_json, write_table
from simsat.results.folder import (
    FULL,
    METRICS,
    RECORDING,
    SERIES,
    STEPS,
    make_folder,
    write_settings,
)
from simsat.results.metrics import CONVERGED_BELOW_DEG, error_deg, judge, minimum_stay_s
from simsat.results.pointing import settling_by_target
from simsat.results.steps import steps_table
from simsat.results.timeseries import timeseries

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PLAIN = (str, bool, int, float, type(None))


@dataclass(frozen=True)
class FlightResult:
    """What was flown, and everything that follows from it."""

    mission: Mission
    flight: Flight
    """The log of the truth and every decision."""

    @cached_property
    def table(self) -> pa.Table:
        """The truth at every sample (20 Hz); each column's unit and frame are in its metadata."""
        return timeseries(self.flight, self.mission.references(self.flight))

    @cached_property
    def steps(self) -> pa.Table:
        """What was decided at every control instant; likewise with units."""
        return steps_table(self.flight, self.mission)

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """The figures of merit, and the user's own by the names of their functions.

        One of those that fails is None, and `metric_errors` says why.
        """
        figures = self._judged()
        errors = {}
        for name, metric in self.mission.plugins.metrics.items():
            try:
                figures[name] = _own(name, metric, self)
            except PluginError as error:
                figures[name], errors[name] = None, str(error)
        return figures | ({"metric_errors": errors} if errors else {})

    def _judged(self) -> dict[str, Any]:
        """The figures of merit with their explanation, and the times they are to be seen in."""
        flight, targets = self.flight, self.mission.references(self.flight)
        figures = judge(flight, targets) | settling_by_target(
            flight, error_deg(flight, targets), self.mission.reference,
            CONVERGED_BELOW_DEG, minimum_stay_s(flight),
        )  # fmt: skip
        why, seen = explain(self.mission, self.flight), preview(self.mission)
        if why.cause:
            figures["convergence"] += f": {why.cause}"
        return figures | {
            "outcome": why.outcome.name.lower(),
            "natural_time_s": seen.natural_time,
            "own_second_s": seen.own_second,
            "period_s": seen.period,
            "horizon_s": seen.horizon,
            "expected_slew_s": seen.slew,
            "reach": seen.reach.reach.name.lower(),
        }

    @property
    def converged(self) -> bool:
        """Whether the flight settled at its target."""
        return bool(self.metrics["converged"])

    def plot(self) -> "Figure":
        """Attitude, error, rates, wheel speeds and torques on a page; a notebook shows it."""
        from simsat.results.pictures.summary_picture import draw_summary  # matplotlib: 0.5 s

        return draw_summary(self.flight, self.mission)

    def plot_orbit(self) -> "Figure":
        """Error, momentum along the axis without a wheel, dipoles, wheel speeds, how far the field
        lies across that axis, and the Earth's shadow: for flights of hours."""
        from simsat.results.pictures.orbit_picture import draw_orbit

        return draw_orbit(self.flight, self.mission)

    def save(self, folder: Path | str) -> Path:
        """Write settings.json, metrics.json, timeseries.parquet, steps.parquet, summary.png and,
        of an orbit at least, orbit.png into a new folder.

        Raises `OutputError` if it exists already or can't be written.
        """
        made, settings = make_folder(Path(folder), ""), self.mission.settings
        identity = mission_identity(self.mission, settings)
        carried = carry(made, settings, self.mission.model)
        write_settings(made, settings, identity, carried, self.mission.came_to)
        self.write(made)
        return made

    def write(self, folder: Path) -> None:
        """The same without the settings, into a folder that is there.

        On a full disk a recording in it gives way: it is by far the largest, and flying again makes
        it.
        """
        recording = folder / RECORDING
        try:
            self._write(folder)
        except OSError as error:
            if error.errno not in FULL or not recording.exists():
                raise
            recording.unlink()
            self._write(folder)

    def _write(self, folder: Path) -> None:
        from simsat.results.pictures.summary_picture import save_picture

        write_json(folder / METRICS, self.metrics)
        save_picture(self.plot(), folder / "summary.png")
        if self.flight.plant.t >= self.mission.environment.orbit.period:
            save_picture(self.plot_orbit(), folder / "orbit.png")
        write_table(folder / STEPS, self.steps)
        write_table(folder / SERIES, self.table)  # the largest, on a disk with no room

    def record(self, path: Path | str) -> Path:
        """Write the recording for the rerun viewer (.rrd)."""
        from simsat.recording.recorder import Recorder  # a second to import, of no use unrecorded
        from simsat.results.summary import recording_notes

        with Recorder(Path(path), self.mission, recording_notes(self.mission)) as recorder:
            recorder.follow(self.flight)
        return Path(path)

    def __repr__(self) -> str:
        settled = self.metrics["settling_time_s"]
        verdict = self.metrics["convergence"] if settled is None else f"settled at {settled:.4g} s"
        error = self.metrics["final_error_deg"]
        return f"<{self.mission.title}: {verdict}, final error {error:.4g} deg>"


def _own(name: str, metric: Callable[..., Any], result: FlightResult) -> Any:
    """A metric's value in plain numbers."""
    with named(f"metric '{name}'"):
        value = metric(result)
    return _plain(name, value)


def _plain(name: str, value: Any) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, dict):
        return {str(key): _plain(name, part) for key, part in value.items()}
    if not isinstance(value, PLAIN) or (isinstance(value, float) and not np.isfinite(value)):
        raise PluginError(
            f"metric '{name}' answered {shown(value)}: a finite number, a text, true, false, None "
            "or a dictionary of these is wanted"
        )
    return value
