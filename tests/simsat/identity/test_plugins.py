"""The source of code of one's own: which files count, and that campaigns ask."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from simsat.campaign.attitudes import spiral_attitudes
from simsat.campaign.command import CampaignSettings, fly_campaign
from simsat.campaign.run import plan_runs
from simsat.control.ground.errors import OutputError
from simsat.flight.mission import prepare
from simsat.identity.difference import differences
from simsat.identity.flight import mission_identity
from simsat.identity.plugins import plugin_hashes
from simsat.settings import CommonSettings, FlightSettings

FILES = {
    "silent_law.py": "import json\nimport silent_gains\nfrom silent_lab import rules\n"
    "def law(brief):\n    from silent_lab.deep import late\n"
    "    return lambda measurement: [silent_gains.K * rules.ONE, 0.0]\n",
    "silent_gains.py": "K = 0.001\n",
    "silent_lab/__init__.py": "",
    "silent_lab/rules.py": "from . import base\nONE = base.ONE\n",
    "silent_lab/base.py": "ONE = 1.0\n",
    "silent_lab/deep/__init__.py": "",
    "silent_lab/deep/late.py": "from ..base import ONE\n",
    "silent_alone.py": "def metric(flight):\n    return 1.0\n",
    "notes.txt": "",
}
LAW, METRIC = "silent_law:law", "silent_alone:metric"


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    for name, content in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    forget()


def forget() -> None:
    """What a new process begins without."""
    for name in [name for name in sys.modules if name.startswith("silent_")]:
        del sys.modules[name]


@pytest.mark.parametrize("name", FILES)
def test_every_file_that_the_code_imports_counts_and_no_other(lab: Path, name: str) -> None:
    before = plugin_hashes([LAW])
    (lab / name).write_text(FILES[name] + "\n# edited\n")
    counts = name not in ("silent_alone.py", "notes.txt")
    assert (plugin_hashes([LAW]) != before) is counts
    assert differences({"plugins": before}, {"plugins": plugin_hashes([LAW])}) == (
        ["the code of 'silent_law:law'"] if counts else []
    )


def test_names_of_ours_and_of_nothing_have_no_source(lab: Path) -> None:
    assert plugin_hashes(["nmpc", "pinn", "silent_none:law", "silent_law:nothing", "sys:exit"]) == (
        plugin_hashes(["silent_law:nothing"])
    )
    assert set(plugin_hashes([LAW, METRIC, "nmpc"])) == {LAW, METRIC}


def test_code_of_an_installed_package_is_that_package_s_alone() -> None:
    (content,) = plugin_hashes(["tqdm:tqdm"]).values()  # imports half of what is installed
    assert len(content) == 64


def test_the_same_code_elsewhere_is_the_same(
    lab: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = plugin_hashes([LAW])
    there = tmp_path_factory.mktemp("elsewhere")
    for name, content in FILES.items():
        (there / name).parent.mkdir(parents=True, exist_ok=True)
        (there / name).write_text(content)
    forget()
    monkeypatch.syspath_prepend(there)
    assert plugin_hashes([LAW]) == here


def test_a_flight_states_the_code_of_all_its_plug_ins(lab: Path) -> None:
    settings = FlightSettings(duration_s=1.0, controller=LAW, metric=(METRIC,))
    identity = mission_identity(prepare(settings), settings)
    assert set(identity["plugins"]) == {LAW, METRIC}
    common = CommonSettings(duration_s=1.0, metric=(METRIC,))
    run, other = plan_runs(common, (LAW, "nmpc"), spiral_attitudes(1), ({},))
    assert run.flown_with == identity
    assert set(other.flown_with["plugins"]) == {METRIC}


EDITS: dict[str, Callable[[Path], object]] = {
    "the controller": lambda lab: (lab / "silent_law.py").write_text(
        FILES["silent_law.py"] + "#\n"
    ),
    "what it imports": lambda lab: (lab / "silent_gains.py").write_text("K = 0.002\n"),
}


@pytest.mark.parametrize("edit", EDITS)
def test_a_campaign_is_not_resumed_with_edited_code(lab: Path, edit: str) -> None:
    settings = CampaignSettings(
        controllers=("nmpc", LAW), attitudes="1", workers=1, recordings="none", out=lab / "out",
        resume=True, common=CommonSettings(duration_s=1.0),
    )  # fmt: skip
    fly_campaign(settings)
    rows = {path: path.read_bytes() for path in (lab / "out" / "rows").iterdir()}
    next(path for path in rows if path.name == "00001.json").unlink()
    EDITS[edit](lab)
    forget()
    with pytest.raises(
        OutputError, match=r"flown with something else \(the code of 'silent_law:law'"
    ):
        fly_campaign(settings)
    assert {path.name for path in (lab / "out" / "rows").iterdir()} == {
        path.name for path in rows if path.name != "00001.json"
    }
