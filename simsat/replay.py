"""Play a wheel-torque profile open loop: python -m simsat.replay PROFILE.npz --help.

Someone's flight data or another simulator's profile goes in; the plant, its limits and the
environment are a run's, and so are the outputs.
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from simsat.command import command, parse
from simsat.control.ground.own import Own
from simsat.control.ground.settings import Positive, Settings
from simsat.control.ground.spacecraft import nominal
from simsat.control.reference.reference import Inertial
from simsat.environment import EnvironmentSettings, OrbitSettings, build_environment
from simsat.flight.loop import Flight, Watch, ending_early
from simsat.flight.mission import Mission, State
from simsat.flight.profile import Profile, read_profile
from simsat.flight.timing import checked_timing, sample_of
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS, find_model
from simsat.plant.plant import Plant, whole_steps
from simsat.run import OutputSettings, fly_into
from simsat.settings import FlightSettings


@dataclass(frozen=True)
class ReplaySettings(Settings):
    """Play a torque profile on a spacecraft, without any controller, and keep what a run keeps."""

    profile: Annotated[Path, tyro.conf.Positional]
    """NumPy archive: u (rows, wheels) in Nm on the rotors, wheels in the order of the model's
    actuators; dt_u, the length of a row in s; optional q0, w0 (rad/s) and Om0 (rad/s)."""
    model: Path = MODELS / "two_wheel" / "two_wheel.xml"
    """The spacecraft: an MJCF file, or the name of one in models/ (two_wheel, pyramid, ...)."""
    target: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Attitude that the error is measured from, body -> inertial quaternion w x y z."""
    sample_s: Annotated[Positive | None, Own("time", 0.05)] = None
    """Interval between samples and environment updates, s: divides the rows of the profile; some
    0.05 of the craft's own seconds unless given."""
    output: Annotated[OutputSettings, tyro.conf.arg(name="")] = field(
        default_factory=OutputSettings
    )
    orbit: OrbitSettings = field(default_factory=OrbitSettings)
    environment: EnvironmentSettings = field(default_factory=EnvironmentSettings)


@dataclass(frozen=True, kw_only=True)
class Replay(Mission):
    """A flight that nobody steers."""

    profile: Profile

    @property
    def title(self) -> str:
        """One line for pictures and recordings."""
        rows, _ = self.profile.torque.shape
        return f"{self.model.spacecraft.name}, replay of {rows} rows of {self.profile.row_s:g} s"

    def fly(self, watch: Watch = lambda flight: None) -> Flight:
        """Play the profile."""
        return play(self.build_plant(), self.profile, watch)


def prepare_replay(settings: ReplaySettings) -> Replay:
    """Read model and profile, build plant and environment.

    Raises `ModelError` or `SettingsError` with one sentence on bad input.
    """
    flight = FlightSettings(
        model=settings.model,
        controller="replay",
        target=settings.target,
        sample_s=settings.sample_s,
        orbit=settings.orbit,
        environment=settings.environment,
    )
    model = read_model(find_model(settings.model))
    profile = read_profile(settings.profile, model.spacecraft)
    what = "row dt_u of the profile"
    sample = sample_of(flight, profile.row_s, model, what)
    whole_steps(profile.row_s, sample, f"{what} in --sample-s")
    environment = build_environment(model.spacecraft, settings.orbit, settings.environment)
    rows, units = len(profile.torque), model.spacecraft.own_units
    return Replay(
        settings=flight,
        model=model,
        believed=nominal(model.spacecraft),
        environment=environment,
        pilot=None,
        timing=checked_timing(units, sample, profile.row_s, rows),
        start=State(profile.q, profile.omega, profile.wheel_speed),
        reference=Inertial(flight.q_target),
        profile=profile,
    )


def play(plant: Plant, profile: Profile, watch: Watch = lambda flight: None) -> Flight:
    """Fly a profile from its own start; a flight that diverges ends early and says why."""
    ticks = whole_steps(profile.row_s, plant.tick, "row dt_u of the profile")
    flight = Flight(plant, ticks)
    plant.reset(profile.q, profile.omega, profile.wheel_speed)
    with ending_early(flight):
        for torque in profile.torque:
            flight.commands.append(torque)
            plant.advance(torque, ticks)
            watch(flight)
    return flight


def replay(settings: ReplaySettings) -> int:
    """Play, record, judge; the exit code says whether the profile was played to its end."""
    return fly_into(prepare_replay(settings), settings.output, "replay", settings)


def main() -> int:
    """The command line."""
    return replay(parse(ReplaySettings, __doc__))


if __name__ == "__main__":
    sys.exit(command(main))
