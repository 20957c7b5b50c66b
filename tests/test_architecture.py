"""The house rules that keep the code readable: who may import whom, no cycles, no crowded rooms."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.places import ROOT

BELOW = {"control": (), "simsat": ("control",), "learning": ("control", "simsat")}
"""Each package, and those whose modules it may import besides its own."""

OWNERS = {
    "mujoco": ("simsat.mjcf", "simsat.plant"),
    "rerun": ("simsat.recording",),
    "gymnasium": ("simsat.gym",),
}
CROWDED = 15  # files in one folder


def modules() -> dict[str, Path]:
    """Every module by the place of its file: control.x, simsat.y, learning.z."""
    names = {}
    for package in BELOW:
        for path in (ROOT / package).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            if parts[:2] in (("simsat", "control"), ("simsat", "learning")):
                continue  # the same files by their other names
            names[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return names


MODULES = modules()


def imports(name: str) -> set[str]:
    """What a module imports anywhere in it, nested imports and type checking included."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(MODULES[name].read_text())):
        if isinstance(node, ast.Import):
            found |= {_placed(alias.name) for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            source = _placed(_absolute(node, name))
            members = {f"{source}.{alias.name}" for alias in node.names}
            found |= (members & MODULES.keys()) | (set() if members <= MODULES.keys() else {source})
    return found


def _absolute(node: ast.ImportFrom, name: str) -> str:
    if node.level == 0:
        return node.module or ""
    package = MODULES[name].name == "__init__.py"
    parts = name.split(".")[: len(name.split(".")) - node.level + package]
    return ".".join([*parts, *([node.module] if node.module else [])])


def _placed(module: str) -> str:
    """simsat.control.x is the file control/x.py."""
    parts = module.split(".")
    inner = parts[0] == "simsat" and parts[1:2] in (["control"], ["learning"])
    return ".".join(parts[1:] if inner else parts)


@pytest.mark.parametrize("library", OWNERS)
def test_only_their_owners_import_engine_recorder_and_gymnasium(library: str) -> None:
    for name in MODULES:
        used = any(module.split(".")[0] == library for module in imports(name))
        assert not used or name.startswith(OWNERS[library]), f"{name} imports {library}"


def test_there_is_no_import_cycle_not_even_by_a_nested_import() -> None:
    graph = {name: imports(name) & MODULES.keys() - {name} for name in MODULES}
    try:
        list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        pytest.fail(f"import cycle: {' -> '.join(error.args[1])}")


@pytest.mark.parametrize("package", BELOW)
def test_the_arrow_between_packages_runs_one_way(package: str) -> None:
    """models -> control -> simsat -> learning."""
    for name in MODULES:
        if name.split(".")[0] != package:
            continue
        for module in imports(name):
            top = module.split(".")[0]
            assert top not in BELOW or top in (package, *BELOW[package]), f"{name} imports {module}"


def test_control_sees_numbers_only() -> None:
    """No engine, clock or random state of its own, and no name that ties it to where it lies."""
    for name, path in MODULES.items():
        if name.split(".")[0] != "control":
            continue
        for module in imports(name):
            assert module.split(".")[0] not in {"time", "random", "mujoco", "rerun", "torch"}, name
        absolute = [
            node.module
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module
        ]
        assert not any(module.split(".")[0] in BELOW for module in absolute), name


def test_no_room_is_crowded() -> None:
    folders = {path.parent for path in MODULES.values()} | {
        path.parent for path in (ROOT / "tests").rglob("*.py")
    }
    for folder in folders:
        files = [path for path in folder.iterdir() if path.is_file()]
        assert len(files) <= CROWDED, f"{folder.relative_to(ROOT)} holds {len(files)} files"


def test_every_room_says_what_it_is_for() -> None:
    for name, path in MODULES.items():
        if path.name == "__init__.py":
            assert ast.get_docstring(ast.parse(path.read_text())), name
