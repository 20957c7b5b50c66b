"""The controllers that can be flown, by name: which planner, corrector and supervisor each has.

A controller of your own needs no change here: see `own_controller`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from simsat.control.correction.corrector import NetworkEstimator, OracleEstimator, ResidualCorrector
from simsat.control.ground.arrays import Quaternion
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.own import in_units
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.ground.units import Units
from simsat.control.health.planner import build_monitored
from simsat.control.interface.layers import Pilot, Planner, Supervisor
from simsat.control.interface.own_units import InOwnUnits
from simsat.control.learned.planner import build_learned_planner
from simsat.control.magnetic.dipoles import DipoleLaw
from simsat.control.magnetic.planner import RodPlanner
from simsat.control.model.rates import build_rate_model
from simsat.control.nmpc.following import FollowingNmpc
from simsat.control.nmpc.planner import Nmpc, build_nmpc
from simsat.control.reference.own_units import ReferenceInUnits
from simsat.control.reference.reference import Reference
from simsat.control.supervisor.supervisors import FaithfulSupervisor, build_sound, build_value
from simsat.environment import Environment
from simsat.flight.own_estimator import own_estimator
from simsat.networks.appendage import choose_appendage
from simsat.networks.correction import find_network, read_network
from simsat.settings import FlightSettings


@dataclass(frozen=True)
class Brief:
    """What a controller is built from."""

    nominal: Spacecraft
    """What it may believe."""
    settings: FlightSettings
    """With a number in SI for all that is in the craft's own units unless given."""
    target: Quaternion
    truth: Spacecraft
    """The spacecraft as it is: for oracles in studies only."""
    environment: Environment
    """The environment as it is: likewise."""
    reference: Reference
    """What is to be followed over time; `target` is its attitude at t = 0."""
    own_network: Callable[..., Any] | None = None
    """A function or class of the user's own that makes an estimator of this brief."""

    @property
    def period(self) -> float:
        """Time between control instants, s."""
        return self.settings.nmpc.stage

    @property
    def units(self) -> Units:
        """The craft's own: our planners work in them."""
        return self.truth.own_units


def nmpc(brief: Brief) -> Pilot:
    """The paper's baseline: NMPC on the nominal model."""
    planner, reference = baseline(brief), ReferenceInUnits(brief.reference, brief.units)
    following = FollowingNmpc(planner, reference) if reference.moving else planner
    return Pilot(InOwnUnits(following, brief.units))


def baseline(brief: Brief) -> Nmpc:
    """Its planner, in the craft's own units."""
    units = brief.units
    settings = in_units(brief.settings.nmpc, units)
    return build_nmpc(brief.nominal.in_units(units), settings, brief.target)


def nmpc_pinn(brief: Brief) -> Pilot:
    """The baseline and the network's torque on the wheels."""
    return Pilot(nmpc(brief).planner, network_corrector(brief))


def nmpc_pinn_supervisor(brief: Brief) -> Pilot:
    """The same under the supervisor that the settings name."""
    planner = baseline(brief)
    supervisor = choose_supervisor(brief, planner)
    return Pilot(InOwnUnits(planner, brief.units), network_corrector(brief), supervisor)


def choose_supervisor(brief: Brief, planner: Nmpc) -> Supervisor:
    """The supervisor that `--supervisor` names, of a planner in own units."""
    settings, nominal = brief.settings, brief.nominal
    if settings.supervisor == "sound":
        return build_sound(nominal, brief.target, settings.sound, brief.period)
    if settings.supervisor == "value":
        return build_value(planner, settings.value, brief.units)
    return FaithfulSupervisor(nominal, brief.target, settings.faithful)


def nmpc_learned(brief: Brief) -> Pilot:
    """Beyond the paper: learns the model in flight and plans the whole manoeuvre with it.

    Where one was trained, a network predicts what bends or swings.
    """
    settings, craft, units = brief.settings, brief.truth, brief.units
    learned, nmpc = in_units(settings.learned, units), in_units(settings.nmpc, units)
    network = choose_appendage(learned.network, settings.model, craft, brief.period)
    if network is not None:
        network = network.in_units(units)
    planner = build_learned_planner(
        brief.nominal.in_units(units),
        learned,
        brief.target,
        nmpc,
        network,
        expected_outside(brief),
        ReferenceInUnits(brief.reference, units),
    )
    return Pilot(InOwnUnits(planner, units))


def expected_outside(brief: Brief) -> float:
    """Size of the torque from outside that the learned controller is to expect in the craft's own
    units: in orbit accelerations don't go with the craft's natural time."""
    slowness = max(1.0, brief.units.time)
    return slowness**2 if brief.environment.models else 1.0


def nmpc_oracle(brief: Brief) -> Pilot:
    """The baseline and the true residual torque on the wheels: what a perfect network could do."""
    friction = brief.settings.nmpc.friction
    oracle = OracleEstimator(
        build_rate_model(brief.truth, friction=True),
        build_rate_model(brief.nominal, friction),
        brief.truth.torque_rate_max,
        brief.environment,
        brief.period,
    )
    corrector = ResidualCorrector(oracle, brief.settings.correction, brief.target)
    return Pilot(nmpc(brief).planner, corrector)


def network_corrector(brief: Brief) -> ResidualCorrector:
    """The corrector that asks the network which the settings name, or one of the user's own.

    Raises `NetworkError` if there is none, or none for this spacecraft.
    """
    settings, craft = brief.settings, brief.truth
    if brief.own_network is not None:
        own = own_estimator(brief.own_network, settings.network, brief, craft.wheels)
        return ResidualCorrector(own, settings.correction, brief.target)
    path = find_network(settings.network, settings.model)
    friction, foreign = settings.nmpc.friction, settings.correction.foreign_network
    network = read_network(path, craft, brief.nominal, friction, foreign)
    estimator = NetworkEstimator(network, brief.nominal.J)
    return ResidualCorrector(estimator, settings.correction, brief.target)


CONTROLLERS: dict[str, Callable[[Brief], Pilot]] = {
    "nmpc": nmpc,
    "nmpc-pinn": nmpc_pinn,
    "nmpc-pinn-supervisor": nmpc_pinn_supervisor,
    "nmpc-learned": nmpc_learned,
    "nmpc-oracle": nmpc_oracle,
}

FOLLOWING = ("nmpc", "nmpc-learned")
"""Those that can follow a reference that moves."""

RECONFIGURED = ("nmpc", "nmpc-learned")
"""Those that can be built for fewer wheels."""


def monitored(pilot: Pilot, brief: Brief) -> Pilot:
    """The pilot with a planner that notices failed wheels and goes on with those that are left.

    Raises `SettingsError` for a controller that has none for fewer wheels.
    """
    name, settings = brief.settings.controller, brief.settings
    if name not in RECONFIGURED:
        raise SettingsError(
            f"--reconfigure needs a controller that can be built for fewer wheels: "
            f"{', '.join(RECONFIGURED)}; '{name}' can't"
        )
    alone = replace(settings, learned=replace(settings.learned, network="none"))

    def make(craft: Spacecraft) -> Planner:
        return CONTROLLERS[name](replace(brief, nominal=craft, settings=alone)).planner

    planner = build_monitored(brief.nominal, brief.period, pilot.planner, make)
    return replace(pilot, planner=planner)


def build_pilot(brief: Brief) -> Pilot:
    """The pilot that the settings name.

    Raises `SettingsError` that lists the names that exist.
    """
    name = brief.settings.controller
    if brief.reference.moving and name in CONTROLLERS and name not in FOLLOWING:
        raise SettingsError(
            f"controller '{name}' makes for one attitude, --reference "
            f"{' '.join(brief.settings.reference.to)} is followed by: {', '.join(FOLLOWING)}"
        )
    if name not in CONTROLLERS:
        raise SettingsError(
            f"no controller '{name}'; there are: {', '.join(CONTROLLERS)}, or name one of your own "
            "as package.module:name"
        )
    pilot = CONTROLLERS[name](brief)
    if brief.settings.reconfigure:
        pilot = monitored(pilot, brief)
    if not with_rods(brief):
        return pilot
    law = DipoleLaw(brief.nominal, brief.settings.rods, brief.period, brief.reference)
    return replace(pilot, planner=RodPlanner(pilot.planner, law))


def with_rods(brief: Brief) -> bool:
    """Whether magnetic rods are there and used."""
    return brief.settings.rods.enabled and brief.nominal.rods.count > 0
