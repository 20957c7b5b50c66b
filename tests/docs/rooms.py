"""The drawing of the rooms in CONTRIBUTING.md, from their own words: python -m tests.docs.rooms.

A room is a package; its line is the first of its docstring. Run it after a room was added, renamed
or told anew; it rewrites the drawing and nothing else.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

from tests.places import ROOT

GUIDE = ROOT / "CONTRIBUTING.md"
FENCE = "```text\n"
BUILDINGS = ("control", "simsat", "learning")  # in the order in which they may import
ARROW = "   │\n   ▼\n"
MODELS = "Spacecraft as MJCF files, each with its provenance and, where trained, a network."
WIDTH = 20  # of the names: the deepest room has 17 characters


def drawing() -> str:
    """models -> control -> simsat -> learning, with a line for each room inside."""
    return (
        FENCE + ARROW.join([f"{_line('models', MODELS)}\n", *map(_building, BUILDINGS)]) + "```\n"
    )


def _building(name: str) -> str:
    lines = [_line(name, purpose(ROOT / name)), *_rooms(ROOT / name, "")]
    return "".join(f"{line}\n" for line in lines)


def _rooms(folder: Path, indent: str) -> Iterator[str]:
    rooms = rooms_in(folder)
    for room in rooms:
        last = room is rooms[-1]
        yield _line(f"{indent}{'└' if last else '├'}── {room.name}", purpose(room))
        yield from _rooms(room, indent + ("    " if last else "│   "))


def _line(name: str, words: str) -> str:
    return f"{name}/".ljust(WIDTH) + f"  {words}"


def rooms_in(folder: Path) -> list[Path]:
    """Packages directly inside, links left out: they are the other name of a building."""
    inside = [path.parent for path in folder.glob("*/__init__.py")]
    return sorted(path for path in inside if not path.is_symlink())


def purpose(room: Path) -> str:
    """First line of a room's docstring."""
    text = ast.get_docstring(ast.parse((room / "__init__.py").read_text())) or ""
    return text.partition("\n")[0]


def drawn(guide: str) -> str:
    """The drawing as the guide has it."""
    start = guide.index(FENCE + "models/")
    return guide[start : guide.index("```\n", start + len(FENCE)) + len("```\n")]


if __name__ == "__main__":
    text = GUIDE.read_text()
    GUIDE.write_text(text.replace(drawn(text), drawing()))
