"""The exceptions users meet. Each message is one sentence: what, where, and what is allowed."""

import math


class SimsatError(Exception):
    """Root of every error raised on purpose."""


class ModelError(SimsatError):
    """A spacecraft file that can't be read, or that MuJoCo would fly wrongly."""


class SettingsError(SimsatError):
    """A setting outside its range, or two settings that contradict each other."""


class OutputError(SimsatError):
    """An output folder or file that exists already or can't be written."""


class NetworkError(SimsatError):
    """A network file that is missing, corrupt, or made for another spacecraft."""


class ForeignNetworkError(NetworkError):
    """A network file made for another spacecraft or another control period."""


class DivergedError(SimsatError):
    """The simulation left the finite numbers; the message says when and in which variable."""


def require(settings: object, group: str, names: str, least: float, *, above: bool = False) -> None:
    """Refuse a settings group in which one of the named numbers isn't finite or is too small.

    `least` itself is allowed unless `above`; `names` are separated by spaces. Raises
    `SettingsError` that names the flag, --GROUP.NAME or without a group --NAME.
    """
    allowed = f"above {least:g}" if above else f"from {least:g} up"
    for name in names.split():
        value = getattr(settings, name)
        if not math.isfinite(value) or value < least or (above and value == least):
            flag = f"{group}.{name}".removeprefix(".").replace("_", "-")
            raise SettingsError(f"--{flag} is {value:g}: give a finite number {allowed}")
