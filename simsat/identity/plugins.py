"""The source behind code of the user's own, by `package.module:name`.

What counts is the file of the module and every Python file beside it, or in its package, that it
imports, and that these import; of an installed module those that were installed with it. What
doesn't: other installed packages, data that the code reads, compiled extensions, and functions that
no name leads to, such as closures and what is typed into a prompt.
"""

import ast
import contextlib
import hashlib
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from importlib.metadata import packages_distributions
from pathlib import Path

from simsat.control.ground.errors import PluginError
from simsat.flight.plugins import is_plugin, load

OWN = "simsat"  # whose source the identity states anyway
INSTALLED = {Path(sysconfig.get_path(name)) for name in ("stdlib", "purelib", "platlib")}


def plugin_hashes(specs: Iterable[str]) -> dict[str, str]:
    """SHA-256 of the source of each spec that names code of the user's own and can be found.

    Imports the modules; what can't be is left to whoever flies it.
    """
    found = {}
    for spec in filter(is_plugin, specs):
        file = _file(spec)
        if file is not None:
            found[spec] = _hash(file, spec.partition(":")[0])
    return found


def _file(spec: str) -> Path | None:
    """Of the module; a running script is not run again for it."""
    name = spec.partition(":")[0]
    script = getattr(sys.modules["__main__"], "__file__", None)
    if name not in sys.modules and script is not None and Path(script).stem == name:
        return Path(script).resolve()
    with contextlib.suppress(PluginError):
        load(spec, "")
    file = getattr(sys.modules.get(name), "__file__", None)
    return None if file is None or not Path(file).is_file() else Path(file).resolve()


def _hash(file: Path, name: str) -> str:
    root = file.parents[name.count(".") + (file.stem == "__init__")]
    own = _installed_with(name.partition(".")[0]) if root in INSTALLED else None
    files, waiting = {file: name}, [file]
    while waiting:
        at = waiting.pop()
        for imported in _imports(at, files[at]):
            top = imported.partition(".")[0]
            if top == OWN or (own is not None and top not in own):
                continue
            for path, module in _files_of(imported, root):
                if path not in files:
                    files[path] = module
                    waiting.append(path)
    digest = hashlib.sha256()
    for path in sorted(files):
        content = path.read_bytes()
        digest.update(f"{files[path]} {len(content)} ".encode() + content)
    return digest.hexdigest()


def _installed_with(top: str) -> frozenset[str]:
    """Top-level modules of the same distribution, itself among them."""
    tops = packages_distributions()
    mine = set(tops.get(top, ()))
    return frozenset({top, *(other for other, names in tops.items() if mine & set(names))})


def _imports(file: Path, name: str) -> Iterator[str]:
    """Full names of all that a file imports, wherever in it; of `from a import b` both a and a.b,
    since b may be a module."""
    if file.suffix != ".py":
        return
    try:
        tree = ast.parse(file.read_bytes())
    except (SyntaxError, ValueError, RecursionError):
        return
    package = name if file.stem == "__init__" else name.rpartition(".")[0]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*(above if node.level else []), *filter(None, [node.module])])
            yield base
            yield from (f"{base}.{alias.name}".strip(".") for alias in node.names)


def _files_of(name: str, root: Path) -> Iterator[tuple[Path, str]]:
    """Files of a module and of the packages around it, as far as they lie below the root."""
    parts = name.split(".")
    for count in range(1, len(parts) + 1):
        place = root.joinpath(*parts[:count])
        for path in (place.with_name(f"{place.name}.py"), place / "__init__.py"):
            if path.is_file():
                yield path.resolve(), ".".join(parts[:count])
