"""What is said of the code: its source's hash, its revision, its packages."""

import importlib.metadata
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

from simsat.identity.code import TRAINING_PACKAGES, computing
from simsat.identity.difference import differences
from tests.places import ROOT

ASK = "import json; from simsat.identity.code import computing; print(json.dumps(computing()))"


def asked(folder: Path) -> str:
    """What the package in a folder says of itself."""
    return subprocess.run(
        [sys.executable, "-c", ASK], cwd=folder, capture_output=True, text=True, check=True
    ).stdout


def installed(folder: Path) -> Path:
    """The package as an installation lays it down: whole folders, no links, no repository."""
    shutil.copytree(ROOT / "simsat", folder / "simsat", ignore=shutil.ignore_patterns("models"))
    return folder


def test_a_checkout_and_an_installed_copy_are_the_same_code_until_one_is_edited(
    tmp_path: Path,
) -> None:
    here, there = computing(), json.loads(asked(installed(tmp_path)))
    assert there["code"]["revision"] is None
    assert differences(here, there) == []
    edited = tmp_path / "simsat" / "control" / "nmpc" / "planner.py"
    edited.write_text(edited.read_text().replace("e", "E", 1))
    (phrase,) = differences(here, json.loads(asked(tmp_path)))
    assert phrase.startswith("simsat's own code was ")


def test_a_repository_around_an_installed_copy_is_not_its_revision(tmp_path: Path) -> None:
    for command in (["init", "-q"], ["-c", "user.name=a", "-c", "user.email=b", "commit", "-q",
                                     "--allow-empty", "-m", "theirs"]):  # fmt: skip
        subprocess.run(["git", *command], cwd=tmp_path, check=True)
    assert json.loads(asked(installed(tmp_path)))["code"]["revision"] is None


def test_training_adds_its_own_code_and_torch(tmp_path: Path) -> None:
    flying, training = computing(), computing(TRAINING_PACKAGES, training=True)
    assert flying["code"]["sha256"] != training["code"]["sha256"]
    assert training["packages"].keys() - flying["packages"].keys() == {"torch"}
    assert flying["packages"]["numpy"] == importlib.metadata.version("numpy") == np.__version__


def test_differences_name_each_part_once() -> None:
    then = {"model": "a", "networks": {"network": "b"}, **computing()}
    now = {
        **then,
        "model": "c",
        "networks": {"learned.network": "d"},
        "packages": then["packages"] | {"scipy": "9.9"},
        "python": "3.99",
    }
    assert differences(then, then) == []
    phrases = differences(then, now)
    assert phrases[0].startswith("the compiled model")
    assert phrases[1:3] == ["the content of --network", "the content of --learned.network"]
    assert phrases[3].endswith("now 9.9")
    assert phrases[4].endswith("now 3.99")
    assert len(phrases) == 5
