"""Settings that check themselves: a dataclass whose annotations say what each field may be.

    @dataclass(frozen=True)
    class SwitchSettings(Settings, group="correction.switch"):
        off_below_deg: NotNegative = 1.0

A value outside its type or bounds is refused in one sentence that names the flag, whether it came
from a command line, a file or Python. Rules that take more than one field go into `check`.
"""

import contextlib
import dataclasses
import difflib
import math
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from numbers import Integral, Real
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from .errors import SettingsError

S = TypeVar("S", bound="Settings")


@dataclass(frozen=True)
class Bounds:
    """Allowed range of a finite number."""

    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    """Whether `low` itself is refused."""
    open_high: bool = False

    def admits(self, value: float) -> bool:
        """Whether the number is finite and inside."""
        above = value > self.low if self.open_low else value >= self.low
        below = value < self.high if self.open_high else value <= self.high
        return math.isfinite(value) and above and below

    def __str__(self) -> str:
        start = f" {'above' if self.open_low else 'from'} {self.low:g}"
        end = f" to{' below' if self.open_high else ''} {self.high:g}"
        if math.isinf(self.high):
            return "" if math.isinf(self.low) else start + ("" if self.open_low else " up")
        return f" up{end}" if math.isinf(self.low) else start + end


Positive = Annotated[float, Bounds(0.0, open_low=True)]
NotNegative = Annotated[float, Bounds(0.0)]
Share = Annotated[float, Bounds(0.0, 1.0)]
ShareBelowOne = Annotated[float, Bounds(0.0, 1.0, open_high=True)]
NotPositive = Annotated[float, Bounds(high=0.0)]
AtLeastOne = Annotated[float, Bounds(1.0)]
Count = Annotated[int, Bounds(1)]
CountOrNone = Annotated[int, Bounds(0)]


class Settings:
    """Base of every group of settings; subclasses are frozen dataclasses.

    Raises `SettingsError` on construction with a value that an annotation doesn't allow.
    """

    group: ClassVar[str] = ""
    """Where its flags stand: --GROUP.NAME, or --NAME without one."""

    def __init_subclass__(cls, group: str | None = None) -> None:
        if group is not None:
            cls.group = group

    def __post_init__(self) -> None:
        for name, hint in hints(type(self)).items():
            value = getattr(self, name)
            plain = _plain(value, hint)
            if plain is not value:
                object.__setattr__(self, name, plain)
            if not _fits(plain, hint):
                raise SettingsError(f"{self.flag(name)} is {_shown(plain)}: give {wanted(hint)}")
        self.check()

    def check(self) -> None:
        """Rules between fields. Raises `SettingsError`."""

    @classmethod
    def flag(cls, name: str) -> str:
        """A field's name on the command line."""
        return "--" + f"{cls.group}.{name}".removeprefix(".").replace("_", "-")


def hints(settings: type) -> dict[str, Any]:
    """Annotations of a settings class by field, bounds included."""
    return _hints(settings)


@lru_cache(maxsize=64)
def _hints(settings: Any) -> dict[str, Any]:
    every = typing.get_type_hints(settings, include_extras=True)
    return {field.name: every[field.name] for field in dataclasses.fields(settings)}


def changed(settings: S, changes: Mapping[str, Any]) -> S:
    """The settings with some values replaced.

    Names are those of the command line, `nmpc.horizon` or, in groups, {"nmpc": {"horizon": 12}}.
    Raises `SettingsError` on a name that doesn't exist or a value that doesn't fit.
    """
    values: dict[str, Any] = {}
    for name, value in changes.items():
        head, *rest = name.replace("-", "_").split(".")
        inner = values.get(head, _field(settings, head, name))
        values[head] = _changed_to(inner, rest, name, value)
    whole: Any = settings
    return dataclasses.replace(whole, **values)  # at once: they may need each other


def built(kind: type[S], values: Any) -> S:
    """Settings from a mapping of names, nested as the groups are, as a file holds them; what isn't
    named keeps its default.

    Raises `SettingsError` on a name that doesn't exist or a value that doesn't fit.
    """
    if not isinstance(values, Mapping):
        group = kind.flag("").rstrip(".")
        raise SettingsError(f"{group} is {_shown(values)}: give names and values")
    known = hints(kind)
    for name in values:
        if name not in known:
            dotted = kind.flag(str(name)).removeprefix("--")
            raise SettingsError(_unknown(dotted, str(name), list(known)))
    groups = {name: hint for name, hint in known.items() if _is_group(hint) and name in values}
    inner = {name: built(_parts(hint)[0], values[name]) for name, hint in groups.items()}
    try:
        return kind(**{**values, **inner})
    except TypeError as error:  # a field without a default
        raise SettingsError(f"{kind.__name__}: {error}") from error


def _is_group(hint: Any) -> bool:
    plain = _parts(hint)[0]
    return isinstance(plain, type) and issubclass(plain, Settings)


def _replaced(settings: Any, path: list[str], name: str, value: Any) -> Any:
    head, *rest = path
    value = _changed_to(_field(settings, head, name), rest, name, value)
    return dataclasses.replace(settings, **{head: value})


def _changed_to(inner: Any, path: list[str], name: str, value: Any) -> Any:
    """What becomes of a setting or group when something at the end of a path in it is replaced."""
    if path:
        return _replaced(inner, path, name, value)
    if isinstance(inner, Settings) and isinstance(value, Mapping):
        return changed(inner, value)
    return value


def _field(settings: Any, head: str, name: str) -> Any:
    known = list(hints(type(settings))) if isinstance(settings, Settings) else []
    if head in known:
        return getattr(settings, head)
    if not known:
        raise SettingsError(
            f"no setting '{name}': nothing is inside '{name.rpartition('.')[0] or name}'"
        )
    raise SettingsError(_unknown(name, head, known))


def _unknown(name: str, head: str, known: list[str]) -> str:
    near = difflib.get_close_matches(head, known, n=1)
    hint = f"did you mean {near[0]}?" if near else f"there are: {', '.join(known)}"
    return f"no setting '{name}': no '{head}'; {hint}"


def setting(settings: Any, name: str) -> tuple[Any, Any]:
    """Annotation and value of a setting by its dotted name.

    Raises `SettingsError` on a name that doesn't exist.
    """
    *groups, last = name.split(".")
    for head in groups:
        settings = _field(settings, head, name)
    value = _field(settings, last, name)
    return hints(type(settings))[last], value


# What an annotation means.


def _parts(hint: Any) -> tuple[Any, Bounds]:
    """An annotation without its extras, and its bounds."""
    bounds = Bounds()
    while typing.get_origin(hint) is Annotated:
        hint, *extras = typing.get_args(hint)
        bounds = next((extra for extra in extras if isinstance(extra, Bounds)), bounds)
    return hint, bounds


def _plain(value: Any, hint: Any) -> Any:
    """The value in its plain type: a list as a tuple, a whole number as a float, text as a path."""
    hint, _ = _parts(hint)
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return value if value is None else _plain(value, inner[0])
    if hint is float and _is_number(value, Real) and type(value) is not float:
        with contextlib.suppress(OverflowError):  # a whole number of 400 digits stays what it is
            return float(value)
    if hint is int and _is_number(value, Integral) and type(value) is not int:
        return int(value)
    if hint is Path and isinstance(value, str):
        return Path(value)
    if origin is tuple and (isinstance(value, (list, tuple)) or hasattr(value, "tolist")):
        return _plain_tuple(value, inner)
    return value


def _is_number(value: Any, kind: type) -> bool:
    """Whether it is a number of a kind, NumPy's included; true and false are none."""
    return isinstance(value, kind) and not isinstance(value, bool)


def _plain_tuple(value: Any, inner: tuple[Any, ...]) -> tuple[Any, ...]:
    parts = list(value)
    every = [inner[0]] * len(parts) if inner[-1] is Ellipsis else list(inner)
    if len(every) != len(parts):
        return tuple(parts)
    plain = [_plain(part, hint) for part, hint in zip(parts, every, strict=True)]
    same = isinstance(value, tuple) and all(a is b for a, b in zip(plain, parts, strict=True))
    return value if same else tuple(plain)


def _fits(value: Any, hint: Any) -> bool:
    hint, bounds = _parts(hint)
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return any(_fits(value, option) for option in inner)
    if hint in (None, types.NoneType):
        return value is None
    if origin is Literal:
        return any(type(value) is type(option) and value == option for option in inner)
    if origin is tuple:
        return _tuple_fits(value, inner)
    if hint in (float, int):
        return isinstance(value, hint) and not isinstance(value, bool) and bounds.admits(value)
    if hint in (str, Path):
        return isinstance(value, hint) and _is_written(str(value))
    return isinstance(value, hint) if isinstance(hint, type) else True


def _is_written(text: str) -> bool:
    """Whether the text can be kept in a file: half of a character, as command lines can hold one
    that is not UTF-8, can't."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _tuple_fits(value: Any, inner: tuple[Any, ...]) -> bool:
    if not isinstance(value, tuple):
        return False
    if inner[-1] is Ellipsis:
        return all(_fits(part, inner[0]) for part in value)
    return len(value) == len(inner) and all(map(_fits, value, inner))


def wanted(hint: Any) -> str:
    """What an annotation allows, in words."""
    hint, bounds = _parts(hint)
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return " or ".join(wanted(option) for option in inner)
    if hint in (None, types.NoneType):
        return "nothing"
    if origin is Literal:
        return "one of " + ", ".join(map(str, inner))
    if origin is tuple:
        number = "any number of values" if inner[-1] is Ellipsis else f"{len(inner)} values"
        return f"{number}, each {wanted(inner[0])}"
    names = {float: "a finite number", int: "a whole number", bool: "true or false",
             str: "a text", Path: "a path"}  # fmt: skip
    return names.get(hint, f"a {getattr(hint, '__name__', hint)}") + str(bounds)


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_shown, value)) or "empty"
    if _is_number(value, Real):
        return f"{value:g}" if isinstance(value, float) else str(value)
    return "none" if value is None else f"'{value}'"
