"""docs/extending.md is true: its snippets run or are the examples', its tables are complete, and
mistakes get the sentences it shows."""

import dataclasses
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import simsat
from simsat.api import fly
from simsat.campaign.command import CampaignSettings
from simsat.command import parse
from simsat.control.interface.measurement import Measurement
from simsat.control.interface.plan import Plan
from simsat.flight.controllers import Brief
from tests.docs_cases import EXAMPLES, python, shows
from tests.places import ROOT

GUIDE = (ROOT / "docs" / "extending.md").read_text()
SCRIPTS = {path.stem: path.read_text() for path in EXAMPLES.glob("*.py")}
SNIPPETS = re.findall(r"```python\n(.*?)```", GUIDE, re.DOTALL)
INCLUDED = [snippet for snippet in SNIPPETS if any(snippet in text for text in SCRIPTS.values())]
COMMANDS = [line for block in re.findall(r"```sh\n(.*?)```", GUIDE, re.DOTALL)
            for line in block.splitlines()]  # fmt: skip
MISTAKES = """
def divides(brief): return lambda now: 1 / 0
def three(brief): return lambda now: [0.0, 0.0, 0.0]
def five(brief): return 5
def wide(brief): return lambda now, torque, previous: [0.0, 0.0, 0.0]
def nan(t, q): return [0.0, 0.0, float("nan")]
def listed(flight): return [1, 2]
"""


def test_snippets_that_no_script_holds_run(tmp_path: Path) -> None:
    """In one go, as a reader would type them; so those that are an excerpt are exact ones."""
    typed = [snippet for snippet in SNIPPETS if snippet not in INCLUDED]
    assert (len(INCLUDED), len(typed)) == (4, 4)
    (tmp_path / "typed.py").write_text("\n".join(typed))
    python(tmp_path, "typed.py")


def test_commands_are_understood_or_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path in EXAMPLES.glob("*.py"):
        shutil.copy(path, tmp_path)
    assert len(COMMANDS) == 5
    for line in COMMANDS:
        words = shlex.split(line)
        if "simsat.campaign" in words:
            monkeypatch.setattr(sys, "argv", words[2:])
            parse(CampaignSettings, None)
        elif "simsat.run" in words:
            python(tmp_path, *words[1:], "--no-recording", "--duration-s", "25")
        else:
            python(tmp_path, *words[1:])


@pytest.mark.parametrize("kind", [Brief, Measurement, Plan])
def test_the_tables_name_every_field(kind: type) -> None:
    for field in dataclasses.fields(kind):
        assert re.search(rf"^\|.*`{field.name}`.* \|", GUIDE, re.MULTILINE), field.name


def test_every_script_is_in_the_table_and_every_link_leads_somewhere() -> None:
    for name in SCRIPTS:
        assert f"| [{name}.py](examples/{name}.py) |" in GUIDE
    for target in re.findall(r"\]\(([^)#]+)\)", GUIDE):
        assert target.startswith("http") or (ROOT / "docs" / target).exists(), target


def refused(**settings: Any) -> str:
    with pytest.raises(simsat.SimsatError) as error:
        fly(duration_s=5, **settings)
    return str(error.value)


def ended(**settings: Any) -> str:
    flight = fly(duration_s=5, **settings)
    assert flight.metrics["ending"] == "plugin_failed"
    return flight.metrics["reason"]


CAUSES: dict[str, Callable[[], str]] = {
    "a module that isn't there": lambda: refused(controller="nobody:PD"),
    "a name that isn't in it": lambda: refused(controller="mistakes:nope"),
    "an unknown controller": lambda: refused(controller="nmcp"),
    "nothing that can fly": lambda: refused(controller="mistakes:five"),
    "torques for other wheels": lambda: ended(controller="mistakes:three"),
    "an error in flight": lambda: ended(controller="mistakes:divides"),
    "an estimate for other wheels": lambda: ended(controller="nmpc-pinn", network="mistakes:wide"),
    "a torque that isn't three numbers": lambda: ended(torques=["mistakes:nan"]),
    "a torque with the wrong arguments": lambda: ended(torques=["mistakes:five"]),
    "a metric that isn't plain": lambda: fly(
        duration_s=5, metrics=["mistakes:listed"]
    ).metrics["metric_errors"]["mistakes:listed"],
    "a setting that doesn't exist": lambda: refused(angel_deg=75),
    "a setting out of bounds": lambda: refused(nmpc={"horizon": 0}),
}  # fmt: skip
SENTENCES = re.findall(
    r"^\| ([^|`]+) \| `([^`]+)` \|$", GUIDE.partition("| mistake")[2], re.MULTILINE
)


def test_every_mistake_of_the_table_has_a_test() -> None:
    assert {mistake for mistake, _ in SENTENCES} == CAUSES.keys()


@pytest.mark.parametrize(("mistake", "sentence"), SENTENCES)
def test_a_mistake_gets_its_sentence(
    mistake: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mistakes.py").write_text(MISTAKES)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "mistakes", raising=False)
    assert shows(sentence, CAUSES[mistake]())


@pytest.mark.parametrize(
    ("flags", "code", "ending"),
    [(["--controller", "mistakes:five"], 2, "error: controller 'mistakes:five' made a int"),
     (["--controller", "mistakes:divides"], 3, "controller 'mistakes:divides' raised"),
     (["--torque", "mistakes:five"], 3, "torque 'mistakes:five' raised TypeError")],
)  # fmt: skip
def test_exit_codes(flags: list[str], code: int, ending: str, tmp_path: Path) -> None:
    (tmp_path / "mistakes.py").write_text(MISTAKES)
    answer = subprocess.run(
        [sys.executable, "-m", "simsat.run", *flags, "--duration-s", "5", "--out", "kept"],
        cwd=tmp_path, env={"PYTHONPATH": str(ROOT), "PATH": ""}, capture_output=True, text=True,
        check=False, timeout=120,
    )  # fmt: skip
    assert answer.returncode == code
    assert ending in answer.stdout + answer.stderr
    assert "Traceback" not in answer.stderr
    assert (tmp_path / "kept" / "metrics.json").exists() == (code == 3)
