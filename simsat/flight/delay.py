"""The time from what is sensed to what the motors do: settings, and the commands on their way.

A command that is computed from what was sensed at t acts from t + delay on, for one control period.
"""

from dataclasses import dataclass, field

import numpy as np

from simsat.control.ground.arrays import RodVector, WheelVector
from simsat.control.ground.settings import NotNegative, Settings
from simsat.control.interface.layers import InTransit
from simsat.plant.plant import Plant, whole_steps

Command = tuple[WheelVector, RodVector]
"""Torques, Nm, and dipoles, A m^2."""


@dataclass(frozen=True)
class DelaySettings(Settings, group="delay"):
    """Time between sensing and acting."""

    computation_s: NotNegative = 0.0
    """From the measurement to the command computed from it, s: a whole number of samples."""
    actuation_s: NotNegative = 0.0
    """From the command to the motors, s: a whole number of samples."""
    foresight: bool = True
    """Let the controller plan from where the craft will be when its command acts; without it the
    plan starts from a state that is past, and the command overshoots."""

    def samples(self, tick: float) -> int:
        """Both delays together. Raises `SettingsError` unless each is a whole number of them."""
        return sum(
            whole_steps(seconds, tick, f"delay of {self.flag(name)} in --sample-s")
            for name, seconds in (
                ("computation_s", self.computation_s),
                ("actuation_s", self.actuation_s),
            )
            if seconds > 0.0
        )


@dataclass
class Line:
    """Commands between controller and motors, ticks being the unit of time."""

    delay: int
    per_period: int
    nothing: Command
    """What acts before the first command arrives."""
    sent: list[Command] = field(default_factory=list)

    def send(self, command: Command) -> None:
        """Send the command of this instant."""
        self.sent.append(command)

    @property
    def mean_torque(self) -> WheelVector:
        """Commanded over the coming period, after this instant's command was sent, Nm."""
        return self._mean(*self._coming)

    def advance(self, plant: Plant, quiet: int = 0) -> None:
        """Fly the coming period, after this instant's command was sent, rods off in its last
        `quiet` ticks."""
        (old, new), ticks = self._coming, self.delay % self.per_period
        if ticks:
            plant.advance(old[0], ticks, old[1])
        left = self.per_period - ticks
        plant.advance(new[0], left, new[1], min(quiet, left - 1))

    @property
    def _coming(self) -> tuple[Command, Command]:
        newest = len(self.sent) - 1 - self.delay // self.per_period
        return self._command(newest - 1), self._command(newest)

    def transit(self, tick: float) -> InTransit:
        """What is on its way before this instant's command is sent; `tick` in s."""
        periods, ticks = divmod(self.delay, self.per_period)
        now, whole = len(self.sent), tick * self.per_period
        acting = self._command(now - periods - 1)
        waiting = [self._command(k)[0] for k in range(now - periods, now)]
        rest = [(tick * ticks, acting[0])] if ticks else []
        return InTransit(
            pending=(*rest, *((whole, torque) for torque in waiting)),
            acting=acting[0],
            acted=self._mean(self._command(now - periods - 2), acting),
        )

    def _mean(self, old: Command, new: Command) -> WheelVector:
        """Mean torque of a period in which the old command gives way to the new one."""
        share = (self.delay % self.per_period) / self.per_period
        return new[0] if share == 0.0 else share * old[0] + (1.0 - share) * new[0]

    def _command(self, number: int) -> Command:
        return self.sent[number] if number >= 0 else self.nothing


def empty_line(delay: int, per_period: int, wheels: int, rods: int) -> Line:
    """A line on which nothing was sent yet; delay and control period in ticks."""
    return Line(delay, per_period, (np.zeros(wheels), np.zeros(rods)))
