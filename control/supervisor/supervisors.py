"""The supervisors as the loop calls them: from measurement, plan and correction to a verdict."""

from dataclasses import dataclass, replace

from ..ground.arrays import Quaternion
from ..ground.attitude import error_quaternion
from ..ground.spacecraft import Spacecraft
from ..ground.units import Units
from ..interface.layers import Correction
from ..interface.measurement import Measurement
from ..interface.plan import Plan
from ..interface.verdict import Verdict, idle
from ..nmpc.planner import Nmpc
from .faithful import FaithfulSettings, supervise_faithful
from .health import Health, health_after
from .plan_value import PlanEvaluator, build_plan_evaluator, plan_value
from .sound import PlantBounds, SoundSettings, build_plant_bounds, supervise_sound
from .value import ValueSettings, supervise_value


@dataclass(frozen=True)
class FaithfulSupervisor:
    """The paper's rule on the nominal spacecraft."""

    nominal: Spacecraft
    target: Quaternion
    settings: FaithfulSettings

    def supervise(
        self, measurement: Measurement, plan: Plan, correction: Correction, memory: None
    ) -> tuple[Verdict, None]:
        """See `faithful`."""
        A, J_hub = self.nominal.A, self.nominal.J_hub
        q_BT = error_quaternion(measurement.q, self.target)
        torques = -A @ plan.torque, -A @ correction.torque
        verdict = supervise_faithful(q_BT, measurement.omega, *torques, J_hub, self.settings)
        return verdict if correction.active else idle(verdict), None


@dataclass(frozen=True)
class SoundSupervisor:
    """The sound rule."""

    bounds: PlantBounds
    target: Quaternion
    settings: SoundSettings

    def supervise(
        self, measurement: Measurement, plan: Plan, correction: Correction, memory: None
    ) -> tuple[Verdict, None]:
        """See `sound`."""
        verdict = supervise_sound(
            error_quaternion(measurement.q, self.target),
            measurement.omega,
            measurement.wheel_speed,
            measurement.torque,
            plan.torque,
            correction.torque,
            self.bounds,
            self.settings,
        )
        return verdict if correction.active else idle(verdict), None


@dataclass(frozen=True)
class ValueSupervisor:
    """The value rule, which also watches the planner's model."""

    evaluator: PlanEvaluator
    """Of a planner in own units."""
    settings: ValueSettings
    units: Units

    def supervise(
        self, measurement: Measurement, plan: Plan, correction: Correction, memory: Health | None
    ) -> tuple[Verdict, Health]:
        """See `value` and `health`; a correction that is switched off costs no roll-out."""
        measurement, plan = measurement.in_units(self.units), plan.in_units(self.units)
        torque = correction.torque / self.units.torque
        value = plan_value(self.evaluator, measurement, plan) if correction.active else None
        health = memory or Health()
        if plan.evidence is not None:
            health = health_after(health, plan.evidence.solution.objective)
        period = self.evaluator.planner.settings.stage * self.units.time
        verdict = supervise_value(value, torque, period, self.settings)
        verdict = replace(verdict, signals={"model_health": health.share})
        return verdict if correction.active else idle(verdict), health


def build_sound(
    nominal: Spacecraft, target: Quaternion, settings: SoundSettings, period: float
) -> SoundSupervisor:
    """The sound supervisor of a spacecraft as it is believed to be."""
    return SoundSupervisor(build_plant_bounds(nominal, settings, period), target, settings)


def build_value(
    planner: Nmpc, settings: ValueSettings, units: Units | None = None
) -> ValueSupervisor:
    """The value supervisor of a planner that works in these units, SI unless given."""
    evaluator = build_plan_evaluator(planner, settings.inertia_uncertainty)
    return ValueSupervisor(evaluator, settings, units or Units())
