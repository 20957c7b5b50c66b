"""A flight's clock: sample, control period and length, in the craft's own seconds unless given.

An own second is the benchmark's (see `control.ground.units`), so that a craft of any size is flown
in as many periods as the benchmark. What isn't given is rounded to what the model file's time step
divides: a sample to whole time steps, a period to whole samples, a flight to whole periods. A
flight whose length is given ends with the period in which that is over.
"""

import math
from dataclasses import dataclass, replace

from simsat.control.ground.errors import SettingsError
from simsat.control.ground.own import own, resolved
from simsat.control.ground.units import Units
from simsat.mjcf import Model
from simsat.plant.plant import whole_steps
from simsat.settings import SAMPLES_MAX, FlightSettings

SAMPLES_PER_PERIOD = 10
SLACK = 1e-9  # of a period: a flight of whole ones stays as long
ROUNDED_UP = 0.1
"""Of a step: what isn't given is at most so much longer than in own seconds, else shorter."""
LARGEST = 1.0 / (1.0 - ROUNDED_UP) + 1e-9  # of the own sample; one time step may be more


@dataclass(frozen=True)
class Timing:
    """What the settings came to."""

    units: Units
    """The craft's own."""
    sample_s: float
    """Interval between samples and environment updates, s."""
    ticks_per_period: int
    """Samples in a control period."""
    period_s: float
    """Length of a control period, s."""
    periods: int
    """Control periods in the flight."""

    @property
    def samples(self) -> int:
        """Samples of the flight after its start."""
        return self.periods * self.ticks_per_period

    @property
    def duration_s(self) -> float:
        """Length of the flight, s."""
        return self.samples * self.sample_s

    def in_periods(self, duration: float) -> float:
        """So many own seconds as whole control periods, s."""
        return _fitting(duration * self.units.time, self.period_s) * self.period_s


def timing_of(settings: FlightSettings, model: Model) -> Timing:
    """The clock of a flight.

    Raises `SettingsError` on lengths that don't divide each other, or more samples than memory
    holds.
    """
    units = model.spacecraft.own_units
    sample = sample_of(settings, settings.nmpc.period, model)
    period = _period(settings, sample, units)
    if settings.duration_s is None:
        periods = _fitting(own(settings, "duration_s") * units.time, period)
    elif settings.nmpc.period is None:  # of a length that nobody asked for: nothing is refused
        periods = max(1, math.ceil(settings.duration_s / period - SLACK))
    else:
        periods = whole_steps(settings.duration_s, period, "flight of --duration-s")
    return checked_timing(units, sample, period, periods, settings.keep_s)


def checked_timing(
    units: Units, sample: float, period: float, periods: int, keep_s: float | None = None
) -> Timing:
    """The clock of so many periods (s) in samples (s), of which one is kept every `keep_s`, or all.
    Raises `SettingsError` likewise."""
    ticks = whole_steps(period, sample, "control period --nmpc.period in --sample-s")
    flag, interval = ("--sample-s", sample) if keep_s is None else ("--keep-s", keep_s)
    kept = periods * period / interval
    if kept > SAMPLES_MAX:
        raise SettingsError(
            f"{periods * period:g} s in samples of {flag} {interval:g} s make {kept:.3g} samples, "
            f"more than {SAMPLES_MAX:g}"
        )
    return Timing(units, sample, ticks, period, periods)


def sample_of(
    settings: FlightSettings,
    period: float | None,
    model: Model,
    what: str = "control period --nmpc.period",
) -> float:
    """The interval between samples, s; one that divides the period (s), if that is given (`what`
    says as what).

    Raises `SettingsError` if the time step doesn't divide it.
    """
    step = float(model.mj.opt.timestep)
    if settings.sample_s is not None:
        whole_steps(settings.sample_s, step, "sample interval")
        return settings.sample_s
    steps = _fitting(own(settings, "sample_s") * model.spacecraft.own_units.time, step)
    if period is not None:
        within = whole_steps(period, step, what)
        steps = max(n for n in range(1, min(steps, within) + 1) if within % n == 0)
    return steps * step


def with_timing(settings: FlightSettings, timing: Timing) -> FlightSettings:
    """The settings with a number for everything that wasn't given, in SI."""
    settings = resolved(settings, timing.units)
    return replace(
        settings,
        sample_s=timing.sample_s,
        duration_s=timing.duration_s,
        nmpc=replace(settings.nmpc, period=timing.period_s),
    )


def _period(settings: FlightSettings, sample: float, units: Units) -> float:
    if settings.nmpc.period is not None:
        return settings.nmpc.period
    if settings.sample_s is None and sample <= own(settings, "sample_s") * units.time * LARGEST:
        return SAMPLES_PER_PERIOD * sample
    return _fitting(settings.nmpc.stage * units.time, sample) * sample


def _fitting(span: float, step: float) -> int:
    """How many whole steps make about the span, at least one."""
    return max(1, math.floor(span / step + ROUNDED_UP))
