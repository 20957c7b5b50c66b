"""A slew, control period by control period, as a Gymnasium environment.

An episode starts at rest (or as `start` says), turned away from the target by a drawn rotation, and
ends with the flight (`truncated`); nothing terminates it. Plant, limits, environment and sensors
are those of `simsat.fly` under the same settings.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces

from simsat.api import prepare_mission
from simsat.control.ground.arrays import Array, Vector3, WheelVector
from simsat.control.ground.attitude import error_angle, error_quaternion, multiply
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.measurement import Measurement
from simsat.flight.loop import Flight
from simsat.flight.mission import Mission, State, mission_sense
from simsat.gym.reward import reward
from simsat.gym.senses import senses_of
from simsat.results.flight_result import FlightResult

SEEDS = 2**31  # of the sensors' noise, drawn anew for every episode
REFUSED = {
    "controller": "whoever calls step decides",
    "axis": "the start is drawn, or given to reset(options={'axis': ..., 'angle_deg': ...})",
    "angle_deg": "give angles_deg, a range to draw from, or both ends the same",
}


class SlewEnv(gymnasium.Env):
    """Turn a spacecraft to its target with wheel torques held over a control period.

    Observation and action are documented in `senses`, the reward in `reward`. `info` holds the
    simulated time `t_s`, the true error `error_deg` and the commanded torque `torque_Nm` (m).
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}

    def __init__(
        self,
        model: Any = "two_wheel",
        angles_deg: tuple[float, float] = (30.0, 180.0),
        render_mode: None = None,
        **settings: Any,
    ):
        """A model and settings as `simsat.fly` takes them (duration_s=30, **{"nmpc.period": 0.25});
        `angles_deg` is the range that the start's rotation is drawn from, evenly, about an axis
        drawn evenly. Raises `SimsatError`."""
        for name in REFUSED & settings.keys():
            raise SettingsError(f"an environment has no {name}: {REFUSED[name]}")
        self._angles_deg = _range(angles_deg)
        self._prepared: Mission = prepare_mission(model, controller=agent, **settings)
        mission = self._prepared
        if mission.reference.moving:
            raise SettingsError("an environment has one attitude to reach: no moving --reference")
        self._senses = senses_of(mission.brief)
        self._normal = mission.model.spacecraft.loop_normal
        low, high = self._senses.bounds
        m = len(self._senses.torque_scale)
        self.observation_space = spaces.Box(low.astype(np.float32), high.astype(np.float32))
        self.action_space = spaces.Box(-1.0, 1.0, (m,), np.float32)
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start an episode; `options` may hold `axis` and `angle_deg` of a rotation to start from
        in place of a drawn one."""
        super().reset(seed=seed)
        axis, angle = self._rotation(dict(options or {}))
        self._mission = self._started(axis, angle)
        plant = self._mission.build_plant()
        self._flight = Flight(plant, self._mission.ticks_per_period)
        self._torque = np.zeros(len(self._senses.torque_scale))
        self._now = self._sensed()
        return self._senses.observe(self._now), self._info()

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold the action for one control period."""
        self._refuse_unusable(action)
        flight, scale, before = self._flight, self._senses.torque_scale, self._torque
        self._torque = self._senses.torque(action)
        flight.commands.append(self._torque)
        flight.plant.advance(self._torque, flight.ticks_per_period)
        self._now = self._sensed()
        paid = self._paid(self._torque / scale, before / scale)
        over = len(flight.commands) >= self._mission.periods
        return self._senses.observe(self._now), paid, False, over, self._info()

    @property
    def result(self) -> FlightResult:
        """The episode so far as a flight: `.plot()`, `.metrics`, `.table`, `.save(folder)`."""
        return FlightResult(self._mission, self._flight)

    def _rotation(self, options: dict[str, Any]) -> tuple[Vector3, float]:
        axis = self.np_random.normal(size=3)
        angle = self.np_random.uniform(*self._angles_deg)
        axis, angle = options.pop("axis", axis), options.pop("angle_deg", angle)
        if options:
            raise SettingsError(f"no option {', '.join(options)}: reset takes axis and angle_deg")
        return axis, angle

    def _started(self, axis: Vector3, angle: float) -> Mission:
        """The mission from this rotation, with noise of its own where sensors have any."""
        mission, sensors = self._prepared, self._prepared.settings.sensors
        if sensors.noisy:
            sensors = replace(sensors, seed=int(self.np_random.integers(SEEDS)))
        settings = replace(mission.settings, axis=tuple(axis), angle_deg=angle, sensors=sensors)
        q_start = multiply(mission.target, settings.turn)
        start = State(q_start, mission.start.omega, mission.start.wheel_speed)
        craft, timing = mission.model.spacecraft, mission.timing
        sense = mission_sense(settings, timing, mission.faults, craft, mission.environment)
        return replace(mission, settings=settings, start=start, sense=sense)

    def _refuse_unusable(self, action: Array) -> None:
        shape = self.action_space.shape
        if np.shape(action) != shape or not np.all(np.isfinite(action)):
            raise SettingsError(
                f"the action is {action}: give {shape[0]} finite shares of the torque limit, "
                "-1 to 1"
            )

    def _sensed(self) -> Measurement:
        flight = self._flight
        samples = min(flight.ticks_per_period, flight.plant.sampled - 1)
        return self._mission.sense(flight.plant, samples, self._torque)

    def _paid(self, share: WheelVector, before: WheelVector) -> float:
        truth, target = self._flight.plant.state(), self._mission.target
        weights, unit = self._mission.settings.nmpc.weights, self._mission.timing.units.rate
        error = error_quaternion(truth.q, target)
        return reward(error, truth.omega / unit, share, before, weights, self._normal)

    def _info(self) -> dict[str, Any]:
        truth = self._flight.plant.state()
        error = float(np.degrees(error_angle(truth.q, self._mission.target)))
        return {"t_s": truth.t, "error_deg": error, "torque_Nm": self._torque.copy()}


def agent(brief: Any) -> Any:
    """Stands where a flight has its controller; whoever calls `step` decides."""
    return lambda now: np.zeros(brief.truth.wheels)


def _range(angles_deg: tuple[float, float]) -> tuple[float, float]:
    low, high = map(float, angles_deg)
    if not 0.0 < low <= high <= 180.0:
        raise SettingsError(
            f"angles_deg is {low:g} to {high:g}: give the lowest and the highest angle of the "
            "start, above 0 and up to 180"
        )
    return low, high
