"""What pyproject.toml, constraints.txt, CITATION.cff and CHANGELOG.md say of versions agrees."""

import importlib.metadata
import re
import tomllib

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.places import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = re.findall(r"call install,\.\[(.*)\]\)", (ROOT / "Makefile").read_text())


def test_every_package_that_make_installs_is_pinned_to_what_is_installed() -> None:
    """Followed from package to package through what is installed, as pip does."""
    lines = (ROOT / "constraints.txt").read_text().split()
    pins = dict(line.split("==") for line in lines)
    pins = {canonicalize_name(name): version for name, version in pins.items()}
    for name in sorted(needed()):
        installed = importlib.metadata.version(name).partition("+")[0]
        assert pins.get(name) == installed, f"constraints.txt lacks {name}=={installed}"


def needed() -> set[str]:
    """Names of all packages that simsat with the extras of `make setup` stands on."""
    (extras,) = EXTRAS
    groups = [PROJECT["optional-dependencies"][extra] for extra in extras.split("$(,)")]
    waiting = [Requirement(line) for line in sum(groups, PROJECT["dependencies"])]
    seen = set[str]()
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        if name in seen:
            continue
        seen.add(name)
        for line in requires(name):
            inner = Requirement(line)
            wanted = [{"extra": extra} for extra in ("", *requirement.extras)]
            if inner.marker is None or any(inner.marker.evaluate(extra) for extra in wanted):
                waiting.append(inner)
    return seen


def requires(name: str) -> list[str]:
    """What an installed package says it needs; nothing of PyTorch, whose builds differ in it."""
    return [] if name == "torch" else importlib.metadata.requires(name) or []


def test_one_version_everywhere() -> None:
    citation = (ROOT / "CITATION.cff").read_text()
    changes = (ROOT / "CHANGELOG.md").read_text()
    released = re.search(r"^## (\d\S+) \((\S+)\)$", changes, re.MULTILINE)
    assert released is not None
    assert PROJECT["version"] == released[1]
    assert f"\nversion: {released[1]}\n" in citation
    assert f'\ndate-released: "{released[2]}"\n' in citation
