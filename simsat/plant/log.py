"""The log of the truth: every sample, or every so many of them on flights of days."""

from dataclasses import dataclass

import numpy as np

from simsat.control.ground.arrays import Array, Rods, Vectors3, WheelVectors

WINDOW = 4096  # samples that are at hand at the full rate: 200 s at 20 Hz


@dataclass(frozen=True)
class Layout:
    """Where attitude, body rate and wheel speeds stand in MuJoCo's state."""

    attitude: slice
    rate: slice
    wheels: Array
    """Indices into qvel, shape (m,)."""


@dataclass(frozen=True)
class Samples:
    """The truth at k instants that follow each other, oldest first."""

    t: Array
    q: Array
    """Body -> inertial, shape (k, 4)."""
    omega: Vectors3
    """Body axes, rad/s, shape (k, 3)."""
    wheel_speed: WheelVectors
    """Relative to the hub, rad/s, shape (k, m)."""
    torque: WheelVectors
    """Motor torque acting on the rotors, Nm, shape (k, m)."""
    dipole: Rods
    """Dipole of each rod over the tick that ended, A m^2, shape (k, rods)."""


@dataclass
class StateLog:
    """Rows of the truth as MuJoCo holds it, `tick` (s) apart."""

    tick: float
    layout: Layout
    qpos: Array
    qvel: Array
    torque: Array
    """Motor torque acting on the rotors, Nm, shape (rows, m)."""
    dipole: Array
    """Dipole of each magnetic rod over the plant's tick that ended, A m^2, shape (rows, k)."""
    rod_torque_N: Array
    """Torque of all rods over that tick, inertial axes, Nm, shape (rows, 3)."""
    rows: int = 0
    before: int = 0
    """Rows that have been dropped from the front."""
    rolling: bool = False
    """Whether it drops its older half when it is full."""

    @property
    def t(self) -> Array:
        """Sample times, s."""
        return self.tick * np.arange(self.before, self.before + self.rows, dtype=np.float64)

    def samples(self, first: int = 0) -> Samples:
        """The rows from `first` on, counted from those that are held."""
        rows, layout = slice(first, self.rows), self.layout
        return Samples(
            t=self.tick * np.arange(self.before + first, self.before + self.rows, dtype=float),
            q=self.qpos[rows, layout.attitude],
            omega=self.qvel[rows, layout.rate],
            wheel_speed=self.qvel[rows, layout.wheels],
            torque=self.torque[rows],
            dipole=self.dipole[rows],
        )

    @property
    def columns(self) -> tuple[Array, ...]:
        """All that a row holds."""
        return self.qpos, self.qvel, self.torque, self.dipole, self.rod_torque_N

    def append(self, row: tuple[Array | tuple[float, float, float], ...]) -> None:
        """Write a row as `columns` has it."""
        if self.rolling and self.rows == len(self.qpos):
            half = self.rows // 2
            for column in self.columns:
                column[: self.rows - half] = column[half:]
            self.before, self.rows = self.before + half, self.rows - half
        for column, values in zip(self.columns, row, strict=True):
            column[self.rows] = values
        self.rows += 1

    def clear(self) -> None:
        """Begin anew."""
        self.rows = self.before = 0


def empty_log(
    tick: float,
    rows: int,
    layout: Layout,
    sizes: tuple[int, int, int, int],
    rolling: bool = False,
) -> StateLog:
    """A log with room for so many rows; sizes are those of qpos, qvel, wheels and rods."""
    qpos, qvel, torque, dipole, rod_torque_N = (np.zeros((rows, size)) for size in (*sizes, 3))
    return StateLog(tick, layout, qpos, qvel, torque, dipole, rod_torque_N, rolling=rolling)
