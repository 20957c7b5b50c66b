"""Code of the user's own, by name: `package.module:name`, as entry points are written.

The same name works on the command line, in a settings file, in Python and in every worker of a
campaign, which only needs to be able to import the module.
"""

import contextlib
import importlib
import os
import re
import sys
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from simsat.control.ground.errors import PluginError, SimsatError

FOREIGN = (Exception, SystemExit)
"""What code of the user's own may raise: to leave Python is not its business either."""

MISSING = object()
NAME = re.compile(r"[^\W\d][\w.]*:[^\W\d][\w.]*")


def is_plugin(spec: str) -> bool:
    """Whether a setting names code of the user's own rather than ours or a file."""
    return NAME.fullmatch(spec) is not None


def load(spec: str, flag: str) -> Any:
    """The object that `package.module:name` stands for; `flag` names the setting in messages.

    The working directory is searched as well, as `python -m` does. Raises `PluginError` if there
    is no such module or name, or if importing it fails.
    """
    module_name, _, path = spec.partition(":")
    if not is_plugin(spec):
        raise PluginError(f"{flag} '{spec}': name it as package.module:name")
    here = os.getcwd()
    if here not in sys.path and "" not in sys.path:
        sys.path.insert(0, here)
    try:
        found: Any = sys.modules.get(module_name) or importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        raise PluginError(f"{flag} '{spec}': {error}; is its folder where you started?") from error
    except FOREIGN as error:
        raise PluginError(f"{flag} '{spec}' can't be imported: {told(error)}") from error
    for part in path.split("."):
        with named(f"{flag} '{spec}'"):
            inner = getattr(found, part, MISSING)
            names = [name for name in dir(found) if not name.startswith("_")]
        if inner is MISSING:
            raise PluginError(f"{flag} '{spec}': no '{part}' there, only {', '.join(names)}")
        found = inner
    return found


def name_of(plugin: Callable[..., Any]) -> str:
    """`package.module:name` of a function or class, for tables and workers."""
    name = getattr(plugin, "__qualname__", type(plugin).__qualname__)
    module = getattr(plugin, "__module__", None) or "__main__"
    script = getattr(sys.modules["__main__"], "__file__", None)
    if module == "__main__" and script is not None:  # as a worker can import it
        module = Path(script).stem
    return f"{module}:{name}"


def told(error: BaseException) -> str:
    """An exception in one line: what it is, and the line of code that raised it."""
    frames = traceback.extract_tb(error.__traceback__)
    last = frames[-1] if frames else None
    where = f" ({Path(last.filename).name}, line {last.lineno})" if last else ""
    try:
        text = " ".join(str(error).split())
    except FOREIGN:  # an exception of the user's own that can't say what it is
        text = ""
    return f"{type(error).__name__}{': ' if text else ''}{text}{where}"


def shown(value: Any) -> str:
    """A value of the user's own as Python writes it, or its type if it can't be written."""
    try:
        return repr(value)
    except FOREIGN:
        return f"a {type(value).__name__}"


@contextlib.contextmanager
def named(what: str) -> Iterator[None]:
    """Errors of the user's code inside the block become a `PluginError` that says whose."""
    try:
        yield
    except SimsatError:
        raise
    except FOREIGN as error:
        raise PluginError(f"{what} raised {told(error)}") from error
