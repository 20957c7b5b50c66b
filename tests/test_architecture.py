"""The house rules that keep the code readable: who may import whom, and no import cycles."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("simsat", "control", "learning")
OWNERS = {
    "mujoco": ("simsat.mjcf", "simsat.plant", "simsat.drives"),
    "rerun": ("simsat.recorder", "simsat.recording"),
}


def modules() -> dict[str, Path]:
    names = {}
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            names[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return names


def imports(path: Path, top_level_only: bool) -> set[str]:
    tree = ast.parse(path.read_text())
    nodes = tree.body if top_level_only else ast.walk(tree)
    found = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            members = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= members if members <= modules().keys() else members | {node.module}
    return found


@pytest.mark.parametrize("library", OWNERS)
def test_only_their_owners_import_engine_and_recorder(library: str) -> None:
    for name, path in modules().items():
        used = any(module.split(".")[0] == library for module in imports(path, False))
        assert not used or name.startswith(OWNERS[library]), f"{name} imports {library}"


def test_there_is_no_import_cycle() -> None:
    known = modules()
    graph = {name: imports(path, True) & known.keys() - {name} for name, path in known.items()}
    # A package's __init__ re-exports its modules; its own modules import their siblings, not it.
    try:
        list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        pytest.fail(f"import cycle: {' -> '.join(error.args[1])}")


def test_control_sees_numbers_only() -> None:
    """No engine, loop, file, clock or global random state."""
    allowed = {"arrays", "attitude", "spacecraft", "errors"}
    for name, path in modules().items():
        if not name.startswith("control"):
            continue
        for module in imports(path, False):
            parts = module.split(".")
            assert parts[0] != "simsat" or parts[1] in allowed, f"{name} imports {module}"
            assert parts[0] not in {"time", "random", "mujoco", "rerun", "torch"}, f"{name} {parts}"
