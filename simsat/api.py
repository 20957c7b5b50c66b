"""What a notebook or a script needs: prepare a mission, fly it, fly many and compare them.

Everything takes the settings of the command line by the same names: `angle_deg=75`, groups as
dictionaries, `nmpc={"horizon": 12}`, or dotted, `**{"nmpc.horizon": 12}`. What the command line
refuses is refused here, as a `SimsatError` in one sentence.
"""

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from simsat.campaign.command import CampaignSettings, fly_campaign
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import changed
from simsat.environment.own import OwnTorque
from simsat.flight.loop import Watch
from simsat.flight.mission import Mission, Plugins, plugins_of, prepare
from simsat.flight.plugins import name_of
from simsat.mjcf import read_compiled
from simsat.results.flight_result import FlightResult
from simsat.settings import FlightSettings

Named = str | Callable[..., Any]
"""Code of the user's own: `package.module:name`, or the function or class itself."""


def prepare_mission(
    model: Any = "two_wheel",
    *,
    controller: Named = "nmpc",
    network: Named = "pinn",
    torques: Iterable[str | OwnTorque] = (),
    metrics: Iterable[Named] = (),
    **settings: Any,
) -> Mission:
    """A flight ready to go, as often as one likes.

    `model` is a name in models/, the path of an MJCF file, or a compiled `mujoco.MjModel` or an
    `mujoco.MjSpec`, so that a parameter can be swept. `controller` and `network` are names, or
    called with the `Brief`; a torque is a function (t, q) -> Nm in body axes; a metric is a
    function of the `FlightResult`. Raises `SimsatError`.
    """
    torques, metrics = list(torques), list(metrics)
    compiled = None if isinstance(model, (str, Path)) else read_compiled(model)
    chosen = changed(
        FlightSettings(),
        {
            "model": model if compiled is None else f"{compiled.spacecraft.name}.mjb",
            "controller": _label(controller),
            "network": _label(network),
            "torque": tuple(map(_label, torques)),
            "metric": tuple(map(_label, metrics)),
            **settings,
        },
    )
    plugins = _plugins(chosen, controller, network, torques, metrics)
    return prepare(chosen, compiled, plugins)


def fly(
    model: Any = "two_wheel", watch: Watch = lambda flight: None, **options: Any
) -> FlightResult:
    """Fly a mission that `prepare_mission` made, or what it would make of these options.

    `watch` is called after every control period with the flight so far.
    """
    if not isinstance(model, Mission):
        model = prepare_mission(model, **options)
    elif options:
        raise SettingsError(
            f"a prepared mission is flown as it is: give {', '.join(options)} to prepare_mission"
        )
    return FlightResult(model, model.fly(watch))


def compare(
    controllers: Sequence[Named] = ("nmpc", "nmpc-learned"),
    attitudes: int | str = "paper",
    *,
    out: Path | str | None = None,
    workers: int | None = None,
    **settings: Any,
) -> Path:
    """Fly a campaign, every controller from every attitude, and return its folder with tables,
    statistics, pictures and report.

    Controllers of your own must be importable by name in the workers: functions or classes of a
    module, or of a script that guards its call with `if __name__ == "__main__"`.
    """
    own = CampaignSettings.__dataclass_fields__.keys() - {"common"}
    mine = {name: settings.pop(name) for name in list(settings) if name in own}
    if any(label.startswith("__main__:") for label in map(_label, controllers)) and not hasattr(
        sys.modules["__main__"], "__file__"
    ):
        raise SettingsError(
            "controllers typed into a prompt can't be sent to the workers of a campaign: put them "
            "into a module"
        )
    folder, _, _ = fly_campaign(
        changed(
            CampaignSettings(),
            {
                "controllers": tuple(map(_label, controllers)),
                "attitudes": str(attitudes),
                "out": None if out is None else Path(out),
                "workers": workers,
                "common": settings,
                **mine,
            },
        )
    )
    return folder


def _label(plugin: Named) -> str:
    return plugin if isinstance(plugin, str) else name_of(plugin)


def _plugins(
    settings: FlightSettings,
    controller: Named,
    network: Named,
    torques: Sequence[Any],
    metrics: Sequence[Any],
) -> Plugins:
    """Code given by name is loaded, code given as it is stays so."""
    by_name = replace(
        settings,
        controller=controller if isinstance(controller, str) else "nmpc",
        network=network if isinstance(network, str) else "pinn",
        torque=tuple(torque for torque in torques if isinstance(torque, str)),
        metric=tuple(metric for metric in metrics if isinstance(metric, str)),
    )
    loaded = plugins_of(by_name)
    return Plugins(
        loaded.controller if isinstance(controller, str) else controller,
        loaded.network if isinstance(network, str) else network,
        _in_order(torques, loaded.torques),
        _in_order(metrics, loaded.metrics),
    )


def _in_order(given: Sequence[Any], loaded: Mapping[str, Any]) -> dict[str, Any]:
    return {_label(one): loaded[one] if isinstance(one, str) else one for one in given}
