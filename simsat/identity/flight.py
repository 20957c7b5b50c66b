"""What a flight depends on besides its settings, as plain JSON that can be kept and compared."""

import contextlib
import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from simsat.control.ground.errors import NetworkError
from simsat.flight.mission import Mission
from simsat.identity.code import (
    ATMOSPHERE_PACKAGE,
    FIELD_PACKAGE,
    FLYING_PACKAGES,
    ORBIT_PACKAGE,
    computing,
)
from simsat.identity.plugins import plugin_hashes
from simsat.mjcf import read_model
from simsat.mjcf.shipped import find_model
from simsat.networks.appendage import find_appendage
from simsat.networks.correction import find_network
from simsat.settings import CommonSettings, FlightSettings

Identity = dict[str, Any]
"""`model`, `networks`, `plugins`, `files`, `code`, `packages`, `python`, `platform`."""


def flight_identity(settings: CommonSettings, model: str) -> Identity:
    """The identity of a flight; `model` is the compiled model's (`Model.identity`)."""
    networks = network_hashes(settings.network, settings.learned.network, settings.model)
    plugins = plugin_hashes(plugin_names(settings))
    files = {n: file_hash(path) for n, path in settings.files.items() if path.is_file()}
    found = {"model": model, "networks": networks, "plugins": plugins, "files": files}
    return found | computing((*FLYING_PACKAGES, *_packages(settings)))


def plugin_names(settings: CommonSettings) -> tuple[str, ...]:
    """Settings that may name code of the user's own; a controller's only where there is one."""
    controller = (settings.controller,) if isinstance(settings, FlightSettings) else ()
    return (*controller, settings.network, *settings.torque, *settings.metric)


def under(controller: str, identity: Identity) -> Identity:
    """The identity of flights under a controller from what they all share."""
    return identity | {"plugins": identity["plugins"] | plugin_hashes([controller])}


def _packages(settings: CommonSettings) -> Iterator[str]:
    """Packages that some settings alone compute with."""
    if settings.environment.density_model == "nrlmsis":
        yield ATMOSPHERE_PACKAGE
    if "igrf" in (settings.environment.field, settings.onboard.field):
        yield FIELD_PACKAGE
    if settings.orbit.tle is not None:
        yield ORBIT_PACKAGE


def mission_identity(mission: Mission, asked: Any) -> Identity:
    """The identity of a mission prepared from the settings `asked`, of a run or of a replay, whose
    profile counts too."""
    identity = flight_identity(mission.settings, mission.model.identity)
    profile = getattr(asked, "profile", None)
    return identity if profile is None else identity | {"profile": file_hash(profile)}


def expected_identity(settings: CommonSettings) -> Identity:
    """The same before the flight, from the files as they are now.

    Raises `ModelError`.
    """
    return flight_identity(settings, read_model(find_model(settings.model)).identity)


def network_hashes(network: str, appendage: str, model: Path) -> dict[str, str]:
    """SHA-256 of each network file that the settings name, by flag; none where there is no file.

    A controller without networks leaves them unread: they are stated all the same.
    """
    found = dict[str, str]()
    with contextlib.suppress(NetworkError):  # a controller that needs it says so
        found["network"] = file_hash(find_network(network, model))
    with contextlib.suppress(NetworkError):
        path = find_appendage(appendage, model)
        if path is not None:
            found["learned.network"] = file_hash(path)
    return found


def file_hash(path: Path) -> str:
    """SHA-256 of a file's content, in hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
