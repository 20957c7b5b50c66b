"""Fly one spacecraft once: python -m simsat.run --help."""

import sys
from pathlib import Path
from typing import Protocol

from tqdm import tqdm

from simsat.command import BROKEN_OFF, command, parse
from simsat.flight.interrupt import interrupts_noted
from simsat.flight.loop import Ending, Flight
from simsat.flight.mission import Mission, prepare
from simsat.results.folder import make_folder, write_results, write_settings
from simsat.results.summary import describe, recording_notes, result_table, viewer_command
from simsat.settings import RunSettings


class Kept(Protocol):
    """Settings of a flight whose results are kept: a run's or a replay's."""

    @property
    def model(self) -> Path:
        """The spacecraft's file."""
        ...

    @property
    def out(self) -> Path | None:
        """The folder to make; None for a default one."""
        ...

    @property
    def recording(self) -> bool:
        """Whether to record."""
        ...


def run(settings: RunSettings) -> int:
    """Fly, record, judge; the exit code says whether the flight reached its end."""
    mission = prepare(settings)
    return fly_into(mission, settings, settings.controller)


def fly_into(mission: Mission, settings: Kept, name: str) -> int:
    """Fly a mission into the run's folder (`name` labels a default one) and print the result."""
    craft = mission.model.spacecraft
    folder = make_folder(settings.out, f"{craft.name}-{name}")
    print(describe(mission.model, mission.believed))
    write_settings(folder, settings, settings.model)
    flight = fly_recorded(mission, folder if settings.recording else None)
    metrics = write_results(folder, flight, mission)
    print(f"\nresult in {folder}\n{result_table(metrics)}")
    if settings.recording:
        print(f"\nopen the recording:  {viewer_command(folder / 'recording.rrd')}")
    return 0 if flight.ending is Ending.COMPLETE else BROKEN_OFF


def fly_recorded(mission: Mission, folder: Path | None) -> Flight:
    """The flight with a progress bar, recorded into the folder if one is given.

    Ctrl-C or SIGTERM ends it after the period under way.
    """
    bar = tqdm(
        total=mission.duration_s,
        unit="s",
        desc="simulated",
        bar_format="{desc} {percentage:3.0f}% |{bar}| {n:.0f}/{total:.0f} s, {remaining} left",
        disable=None,
    )

    def show(flight: Flight) -> None:
        bar.update(flight.plant.log.t[-1] - bar.n)
        stop_if_asked()

    with bar, interrupts_noted() as stop_if_asked:
        if folder is None:
            return mission.fly(show)
        from simsat.recording.recorder import Recorder  # a second to import, of no use unrecorded

        with Recorder(folder / "recording.rrd", mission, recording_notes(mission)) as recorder:

            def watch(flight: Flight) -> None:
                recorder.follow(flight)
                show(flight)

            return mission.fly(watch)


def main() -> int:
    """The command line."""
    return run(parse(RunSettings, __doc__))


if __name__ == "__main__":
    sys.exit(command(main))
