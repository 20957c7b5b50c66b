"""The controllers that can be flown, by name: which planner, corrector and supervisor each has.

A controller of your own needs no change here: see `own_controller`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from simsat.control.correction.corrector import NetworkEstimator, OracleEstimator, ResidualCorrector
from simsat.control.ground.arrays import Quaternion
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.health.planner import build_monitored
from simsat.control.interface.layers import Pilot, Planner, Supervisor
from simsat.control.learned.planner import build_learned_planner
from simsat.control.model.rates import build_rate_model
from simsat.control.nmpc.planner import Nmpc, build_nmpc
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
    target: Quaternion
    truth: Spacecraft
    """The spacecraft as it is: for oracles in studies only."""
    environment: Environment
    """The environment as it is: likewise."""
    own_network: Callable[..., Any] | None = None
    """A function or class of the user's own that makes an estimator of this brief."""

    @property
    def period(self) -> float:
        """Time between control instants, s."""
        return self.settings.nmpc.period


def nmpc(brief: Brief) -> Pilot:
    """The paper's baseline: NMPC on the nominal model."""
    return Pilot(build_nmpc(brief.nominal, brief.settings.nmpc, brief.target))


def nmpc_pinn(brief: Brief) -> Pilot:
    """The baseline and the network's torque on the wheels."""
    return Pilot(nmpc(brief).planner, network_corrector(brief))


def nmpc_pinn_supervisor(brief: Brief) -> Pilot:
    """The same under the supervisor that the settings name."""
    planner = build_nmpc(brief.nominal, brief.settings.nmpc, brief.target)
    return Pilot(planner, network_corrector(brief), choose_supervisor(brief, planner))


def choose_supervisor(brief: Brief, planner: Nmpc) -> Supervisor:
    """The supervisor that `--supervisor` names."""
    settings, nominal = brief.settings, brief.nominal
    if settings.supervisor == "sound":
        return build_sound(nominal, brief.target, settings.sound, settings.nmpc.period)
    if settings.supervisor == "value":
        return build_value(planner, settings.value)
    return FaithfulSupervisor(nominal, brief.target, settings.faithful)


def nmpc_learned(brief: Brief) -> Pilot:
    """Beyond the paper: learns the model in flight and plans the whole manoeuvre with it.

    Where one was trained, a network predicts what bends or swings.
    """
    settings, craft = brief.settings, brief.truth
    learned, nmpc = settings.learned, settings.nmpc
    network = choose_appendage(learned.network, settings.model, craft, nmpc.period)
    return Pilot(build_learned_planner(brief.nominal, learned, brief.target, nmpc, network))


def nmpc_oracle(brief: Brief) -> Pilot:
    """The baseline and the true residual torque on the wheels: what a perfect network could do."""
    friction = brief.settings.nmpc.friction
    oracle = OracleEstimator(
        build_rate_model(brief.truth, friction=True),
        build_rate_model(brief.nominal, friction),
        brief.truth.torque_rate_max,
        brief.environment,
        brief.settings.nmpc.period,
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


def monitored(pilot: Pilot, brief: Brief) -> Pilot:
    """The pilot with a planner that notices failed wheels and goes on with those that are left.

    Raises `SettingsError` for a controller that has none for fewer wheels.
    """
    settings, target = brief.settings, brief.target
    makers: dict[str, Callable[[Spacecraft], Planner]] = {
        "nmpc": lambda craft: build_nmpc(craft, settings.nmpc, target),
        "nmpc-learned": lambda craft: build_learned_planner(
            craft, settings.learned, target, settings.nmpc
        ),
    }
    if settings.controller not in makers:
        raise SettingsError(
            f"--reconfigure needs a controller that can be built for fewer wheels: "
            f"{', '.join(makers)}; '{settings.controller}' can't"
        )
    make = makers[settings.controller]
    planner = build_monitored(brief.nominal, brief.period, pilot.planner, make)
    return replace(pilot, planner=planner)


def build_pilot(brief: Brief) -> Pilot:
    """The pilot that the settings name.

    Raises `SettingsError` that lists the names that exist.
    """
    name = brief.settings.controller
    if name not in CONTROLLERS:
        raise SettingsError(
            f"no controller '{name}'; there are: {', '.join(CONTROLLERS)}, or name one of your own "
            "as package.module:name"
        )
    return CONTROLLERS[name](brief)
