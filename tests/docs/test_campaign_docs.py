"""What docs/campaign.md tells people to type is understood."""

import shlex
import sys
from pathlib import Path

import pytest

from simsat.campaign.attitudes import choose_attitudes
from simsat.campaign.command import CampaignSettings
from simsat.campaign.study import at_point, grid, parse_variation, read_study
from simsat.command import parse
from simsat.mjcf.shipped import find_model
from simsat.settings import FlightSettings
from simsat.verify import VerifySettings
from tests.places import ROOT

GUIDE = (ROOT / "docs" / "campaign.md").read_text()
COMMANDS = [line for line in GUIDE.splitlines() if line.startswith("python -m simsat.campaign")]


@pytest.mark.parametrize("line", COMMANDS)
def test_every_command_of_the_guide_is_understood(
    line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["campaign", *shlex.split(line)[3:]])
    settings = parse(CampaignSettings, None)
    assert find_model(settings.common.model).exists()
    variations = tuple(map(parse_variation, settings.vary))
    if settings.study is not None:
        variations += read_study(ROOT / settings.study)
    for point in grid(variations):
        at_point(settings.common, point)


def test_verify_s_commands_are_understood(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [line for line in GUIDE.splitlines() if line.startswith("python -m simsat.verify")]
    assert len(lines) == 3
    for line in lines:
        words = shlex.split(line, comments=True)[3:]
        monkeypatch.setattr(sys, "argv", ["verify", *words])
        settings = parse(VerifySettings, None)
        assert str(settings.folder) == words[0]
        assert settings.rows == (10 if "--rows" in words else None)


def test_the_guide_has_commands() -> None:
    assert len(COMMANDS) >= 5


@pytest.mark.parametrize("path", sorted((ROOT / "docs" / "studies").glob("*.toml")))
def test_every_study_varies_settings_that_exist(path: Path) -> None:
    points = grid(read_study(path))
    assert len(points) > 1
    assert len({at_point(FlightSettings(), point) for point in points}) == len(points)


def test_the_attitudes_file_of_the_guide_is_read(tmp_path: Path) -> None:
    path = tmp_path / "my_attitudes.csv"
    path.write_text(GUIDE.split("```\naxis_x")[1].split("```")[0].join(["axis_x", ""]))
    assert [start.angle_deg for start in choose_attitudes(str(path))] == [180.0, 30.0]
