"""One run of a campaign: what is to be flown, and everything that is kept of it."""

import errno
import os
import platform
import time
import traceback
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from simsat.campaign.attitudes import InitialRotation
from simsat.campaign.study import Point, at_point, label
from simsat.control.ground.attitude import error_quaternion
from simsat.control.ground.errors import SettingsError, SimsatError
from simsat.flight.loop import Flight
from simsat.flight.mission import Mission, prepare
from simsat.identity.flight import Identity, expected_identity, mission_identity, under
from simsat.results.copies import carry
from simsat.results.flight_result import FlightResult
from simsat.results.folder import RECORDING, write_settings
from simsat.results.metrics import error_deg
from simsat.settings import CommonSettings, FlightSettings, as_json, flight_of

FAILED = "failed"
"""The `ending` of a run that raised instead of flying."""

RUNS_MAX = 200_000  # of a campaign, whose settings are all in memory

TIMING = ("solve_time_ms",)  # metrics that differ from one flying of the same run to the next


@dataclass(frozen=True)
class CampaignRun:
    """A flight with its place in the campaign."""

    index: int
    attitude: int
    """Index of the initial rotation: runs with the same one are compared with each other."""
    point: Point
    """The varied settings' values; empty without a study."""
    settings: FlightSettings
    flown_with: Identity
    """What the campaign began with; a flight made with something else is no row of it."""

    @property
    def name(self) -> str:
        """Unique, sorts in the order of the campaign, and says what was flown."""
        return f"{self.index:05d}-{self.settings.controller}-attitude-{self.attitude:03d}"


@dataclass(frozen=True)
class RunResult:
    """What is kept of a run."""

    record: dict[str, Any]
    """The run, its settings, its metrics, what it was flown with (`simsat.identity`; None if it
    failed) and, apart from those, its timing: plain JSON."""
    trajectory: pa.Table | None
    """At every control instant: t_s, the attitude of the body relative to the target q_w, q_x, q_y,
    q_z, and error_deg. None if the run failed."""


def plan_runs(
    base: CommonSettings,
    controllers: tuple[str, ...],
    starts: tuple[InitialRotation, ...],
    points: tuple[Point, ...],
) -> tuple[CampaignRun, ...]:
    """Every controller from every attitude at every point of the study: point by point, controller
    by controller, attitude by attitude.

    Raises `ModelError` or `SettingsError` for a model or a point that there isn't.
    """
    count = len(points) * len(controllers) * len(starts)
    if count > RUNS_MAX:
        raise SettingsError(f"{count} runs are more than one campaign can hold, {RUNS_MAX}")
    runs: list[CampaignRun] = []
    for point in points:
        there = at_point(base, point)
        identity = expected_identity(there)
        for controller in controllers:
            mine = under(controller, identity)
            for start in starts:
                settings = _settings(there, controller, start)
                runs.append(CampaignRun(len(runs), start.index, point, settings, mine))
    return tuple(runs)


def _settings(base: CommonSettings, controller: str, start: InitialRotation) -> FlightSettings:
    """The sensors' noise differs from attitude to attitude but not between controllers."""
    seed = np.random.SeedSequence((base.sensors.seed, start.index)).generate_state(1)[0]
    there = replace(
        base,
        sensors=replace(base.sensors, seed=int(seed)),
        model=_absolute(base.model),
        network=str(_absolute(Path(base.network))),
        learned=replace(base.learned, network=str(_absolute(Path(base.learned.network)))),
    )
    return flight_of(there, controller, start.axis, start.angle_deg)


def _absolute(path: Path) -> Path:
    """A file named from here, so that a worker elsewhere finds it; other names stay."""
    return path.resolve() if os.path.exists(path) else path


def fly_run(run: CampaignRun) -> RunResult:
    """Fly it and judge it. A run that raises is a result too, with its reason."""
    started, cpu_started = time.perf_counter(), time.process_time()
    try:
        mission = prepare(run.settings)
        identity = mission_identity(mission, run.settings)
        result = FlightResult(mission, mission.fly())
        metrics = dict(result.metrics)
    except Exception as error:  # whatever it is, the other runs go on and the row says why
        return failed(run, _reason(error), traceback.format_exc())
    timing = {name: metrics.pop(name) for name in TIMING if name in metrics}
    timing |= {
        "wall_s": time.perf_counter() - started,
        "cpu_s": time.process_time() - cpu_started,
        "worker": f"{platform.node()}:{os.getpid()}",
    }
    record = run_keys(run) | {"metrics": metrics, "flown_with": identity, "timing": timing}
    return RunResult(record, _trajectory(result.flight, mission))


def failed(run: CampaignRun, reason: str, evidence: str = "") -> RunResult:
    """The result of a run that has no flight to show."""
    metrics = {
        "converged": False,
        "settling_time_s": None,
        "steady_state_rmse_deg": None,
        "final_error_deg": None,
        "ending": FAILED,
        "reason": reason,
    }
    told = {"metrics": metrics, "flown_with": None, "timing": {}, "traceback": evidence}
    return RunResult(run_keys(run) | told, None)


def record_run(run: CampaignRun, folder: Path) -> dict[str, Any]:
    """Fly it again into a folder of its own, as `simsat.run` would; returns its metrics.

    Raises `OSError` on a full disk.
    """
    from simsat.recording.recorder import Recorder  # a second to import, of no use unrecorded
    from simsat.results.summary import recording_notes

    mission = prepare(run.settings)
    identity = mission_identity(mission, run.settings)
    carried = carry(folder, mission.settings, mission.model)
    write_settings(folder, run.settings, identity, carried, mission.came_to)
    recording = folder / RECORDING
    with Recorder(recording, mission, recording_notes(mission)) as recorder:
        flight = mission.fly(recorder.follow)
    result = FlightResult(mission, flight)
    result.write(folder)
    if not recording.exists():  # it gave way
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(recording))
    return repeatable(result.metrics)


def repeatable(metrics: dict[str, Any]) -> dict[str, Any]:
    """The metrics that flying again must give again."""
    return {name: value for name, value in metrics.items() if name not in TIMING}


def run_keys(run: CampaignRun) -> dict[str, Any]:
    """What a run's row says of the run before it is flown."""
    x, y, z = run.settings.axis
    return {
        "run": run.index,
        "study": label(run.point),
        "point": run.point,
        "controller": run.settings.controller,
        "attitude": run.attitude,
        "axis_x": x,
        "axis_y": y,
        "axis_z": z,
        "angle_deg": run.settings.angle_deg,
        "settings": as_json(run.settings),
    }


def _reason(error: Exception) -> str:
    return str(error) if isinstance(error, SimsatError) else f"{type(error).__name__}: {error}"


def _trajectory(flight: Flight, mission: Mission) -> pa.Table:
    plant, target = flight.plant, mission.references(flight)
    rows = slice(None, None, max(flight.ticks_per_period // mission.keep_ticks, 1))
    q = error_quaternion(plant.attitudes[rows], target[rows])
    columns = {f"q_{part}": q[:, i] for i, part in enumerate("wxyz")}
    error = error_deg(flight, target)[rows]
    return pa.table({"t_s": plant.log.t[rows], **columns, "error_deg": error})
