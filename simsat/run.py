"""Fly one spacecraft once: python -m simsat.run --help."""

import argparse
import contextlib
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import tyro
from tqdm import tqdm

from simsat.command import BROKEN_OFF, command, parse
from simsat.control.ground.settings import Settings
from simsat.flight.interrupt import interrupts_noted
from simsat.flight.loop import Ending, Flight
from simsat.flight.mission import Mission, prepare
from simsat.identity.flight import mission_identity
from simsat.reference.demand import told as told_of
from simsat.results.copies import carry
from simsat.results.flight_result import FlightResult
from simsat.results.folder import RECORDING, make_folder, write_settings
from simsat.results.source import read_flight
from simsat.results.summary import describe_mission, recording_notes, result_table, viewer_command
from simsat.settings import FlightSettings


@dataclass(frozen=True)
class OutputSettings(Settings):
    """What a flight leaves."""

    out: Path | None = None
    """Folder to write, which must not exist yet; default a new one under runs/."""
    recording: bool = True
    """Write recording.rrd."""


@dataclass(frozen=True)
class RunSettings:
    """Fly one spacecraft once and keep a recording, a picture, metrics and time series."""

    source: Annotated[Path | None, tyro.conf.arg(name="from")] = None
    """Fly again what the folder of a run holds, or what a settings file says (TOML or JSON); the
    other flags override it."""
    output: Annotated[OutputSettings, tyro.conf.arg(name="")] = field(
        default_factory=OutputSettings
    )
    flight: Annotated[FlightSettings, tyro.conf.arg(name="")] = field(
        default_factory=FlightSettings
    )


def run(settings: RunSettings) -> int:
    """Fly, record, judge; the exit code says whether the flight reached its end."""
    mission = prepare(settings.flight)
    name = settings.flight.controller.rpartition(":")[2]
    return fly_into(mission, settings.output, name, settings.flight)


def fly_into(mission: Mission, output: OutputSettings, name: str, settings: Any) -> int:
    """Fly a mission into the run's folder (`name` labels a default one), with the settings to keep
    there, and print the result."""
    craft = mission.model.spacecraft
    folder = make_folder(output.out, f"{craft.name}-{name}")
    print(describe_mission(mission))
    if told := told_of(mission.reference, craft, mission.duration_s):
        print(f"  {told}")
    identity = mission_identity(mission, settings)
    carried = carry(folder, mission.settings, mission.model)
    write_settings(folder, settings, identity, carried, mission.came_to)
    flight = fly_recorded(mission, folder if output.recording else None)
    result = FlightResult(mission, flight)
    result.write(folder)
    print(f"\nresult in {folder}\n{result_table(result.metrics)}")
    recording = folder / RECORDING
    if output.recording and not recording.exists():
        print(f"error: the disk is full: '{folder}' has no {RECORDING}", file=sys.stderr)
        return BROKEN_OFF
    if output.recording:
        print(f"\nopen the recording:  {viewer_command(recording)}")
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
        bar.update(flight.plant.t - bar.n)
        stop_if_asked()

    with bar, interrupts_noted() as stop_if_asked:
        if folder is None:
            return mission.fly(show)
        from simsat.recording.recorder import Recorder  # a second to import, of no use unrecorded

        with Recorder(folder / RECORDING, mission, recording_notes(mission)) as recorder:

            def watch(flight: Flight) -> None:
                recorder.follow(flight)
                show(flight)

            return mission.fly(watch)


def main() -> int:
    """The command line."""
    source = named_source(sys.argv[1:])
    flight = FlightSettings() if source is None else read_flight(source)
    return run(parse(RunSettings, __doc__, RunSettings(source, flight=flight)))


def named_source(words: list[str]) -> Path | None:
    """What --from names on a command line: it decides the defaults of all other flags."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    parser.add_argument("--from", dest="source", type=Path)
    with contextlib.suppress(argparse.ArgumentError):  # named by the real parser
        known: Path | None = parser.parse_known_args(words)[0].source
        return known
    return None


if __name__ == "__main__":
    sys.exit(command(main))
