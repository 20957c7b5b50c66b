"""What make installs and when, tried with a Python that only pretends."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.places import ROOT

PRETENDER = """#!/bin/bash
# Notes its arguments; makes a .venv that holds a copy of itself; installs nothing.
echo "$*" >> "$NOTES"
for last; do :; done
case "$*" in
    "-m venv --clear "*) rm -rf "$last"; ;&
    "-m venv "*) mkdir -p "$last/bin"; touch "$last/pyvenv.cfg"; cp "$0" "$last/bin/python" ;;
    "-m pip install "*) echo "  Downloading a.whl (1 MB)"; echo Looking; [ ! -e offline ] ;;
esac
"""
FLYING = "-e ."
EVERYTHING = "-e .[learning,gym,cluster,dev]"


class Checkout:
    """A folder with the Makefile, and what was asked of Python in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.notes = folder / "notes"
        for name in ("Makefile", "pyproject.toml", "constraints.txt"):
            shutil.copy(ROOT / name, folder)
            os.utime(folder / name, (0, 0))
        python = folder / "pretender"
        python.write_text(PRETENDER)
        python.chmod(0o755)

    def make(self, target: str) -> subprocess.CompletedProcess[str]:
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}
        self.notes.write_text("")
        return subprocess.run(
            ["make", f"PYTHON={self.folder / 'pretender'}", target],
            cwd=self.folder, env=environment | {"NOTES": str(self.notes)},
            capture_output=True, text=True, check=False, timeout=60,
        )  # fmt: skip

    def change(self, name: str) -> None:
        """Make a file newer than what was set up, however coarse the clock is."""
        for stamp in ("flying", "testing"):
            if (self.folder / ".venv" / stamp).exists():
                os.utime(self.folder / ".venv" / stamp, (1, 1))
        os.utime(self.folder / name, (2, 2))

    def installed(self) -> list[str]:
        """What the last make installed."""
        lines = self.notes.read_text().splitlines()
        return [line.partition("constraints.txt ")[2] for line in lines if "pip install" in line]

    def asked(self, words: str) -> bool:
        """Whether the last make called Python with these words."""
        return words in self.notes.read_text()


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    return Checkout(tmp_path)


def test_run_installs_what_flying_needs_says_so_and_flies(checkout: Checkout) -> None:
    answer = checkout.make("run")
    assert answer.returncode == 0, answer.stderr
    assert checkout.installed() == [FLYING]
    assert checkout.asked("-m simsat.run")
    assert answer.stdout.startswith("Setting up .venv for flying")
    assert "Downloading a.whl (1 MB)" in answer.stdout
    assert "Looking" not in answer.stdout


def test_a_second_run_installs_nothing(checkout: Checkout) -> None:
    checkout.make("run")
    answer = checkout.make("run")
    assert checkout.installed() == []
    assert answer.stdout == ".venv/bin/python -m simsat.run\n"


def test_test_adds_the_rest_and_run_is_content_with_it(checkout: Checkout) -> None:
    checkout.make("run")
    checkout.make("test")
    assert checkout.installed() == [EVERYTHING]
    assert checkout.asked("-m pytest")
    for target in ("run", "test"):
        checkout.make(target)
        assert checkout.installed() == []


@pytest.mark.parametrize("changed", ["pyproject.toml", "constraints.txt"])
def test_new_requirements_are_installed(checkout: Checkout, changed: str) -> None:
    checkout.make("test")
    checkout.change(changed)
    checkout.make("run")
    assert checkout.installed() == [FLYING]
    checkout.make("test")
    assert checkout.installed() == [EVERYTHING]


@pytest.mark.parametrize(("first", "wanted"), [("run", FLYING), ("test", EVERYTHING)])
def test_an_install_that_broke_off_is_started_anew(
    checkout: Checkout, first: str, wanted: str
) -> None:
    checkout.make("run")
    checkout.change("pyproject.toml")
    (checkout.folder / "offline").touch()
    answer = checkout.make(first)
    assert answer.returncode != 0
    assert not checkout.asked("simsat.run")
    (checkout.folder / "offline").unlink()
    checkout.make(first)
    assert checkout.asked("-m venv --clear")
    assert checkout.installed() == [wanted]


def test_a_venv_whose_python_is_gone_is_made_anew(checkout: Checkout) -> None:
    checkout.make("run")
    python = checkout.folder / ".venv" / "bin" / "python"
    python.unlink()
    python.symlink_to("/nowhere/python3.11")
    checkout.make("run")
    assert checkout.asked("-m venv --clear")
    assert checkout.installed() == [FLYING]
    assert checkout.asked("-m simsat.run")


def test_help_names_every_target(checkout: Checkout) -> None:
    shown = checkout.make("help").stdout
    for target in ("run", "test", "check", "bench", "setup"):
        assert f"make {target} " in shown
