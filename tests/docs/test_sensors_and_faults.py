"""The pages on sensors and faults: commands are understood, links lead somewhere, figures are those
of the presets."""

import re
import shlex
import sys
from pathlib import Path

import pytest

from simsat.command import parse
from simsat.flight.mission import prepare
from simsat.run import RunSettings
from simsat.sensors.presets import PRESETS
from tests.places import ROOT

PAGES = {name: (ROOT / "docs" / f"{name}.md").read_text() for name in ("sensors", "faults")}
COMMANDS = [
    line
    for page in PAGES.values()
    for block in re.findall(r"```sh\n(.*?)```", page, re.DOTALL)
    for line in block.splitlines()
    if "simsat.run" in line
]


@pytest.mark.parametrize("line", COMMANDS)
def test_a_command_is_understood_and_can_be_flown(
    line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", shlex.split(line)[2:])
    settings: RunSettings = parse(RunSettings, None)
    assert prepare(settings.flight).pilot is not None


def test_there_are_commands() -> None:
    assert len(COMMANDS) >= 3


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", PAGES[page]):
        assert (ROOT / "docs" / target).exists(), target
    for place in re.findall(r"`((?:control|simsat|tests)/[\w/.]+)`", PAGES[page]):
        assert Path(ROOT / place).exists(), place


def test_the_table_has_the_presets_figures() -> None:
    page = PAGES["sensors"]
    for name in PRESETS:
        sheet = PRESETS[name]
        for figure in (
            f"{sheet.tracker.across_arcsec:g} / {sheet.tracker.about_arcsec:g} arcsec",
            f"{sheet.tracker.sun_exclusion_deg:g} / {sheet.tracker.earth_exclusion_deg:g} deg",
            f"{sheet.gyro.scale_factor_ppm:g} ppm / {sheet.gyro.misalignment_mrad:g} mrad",
            f"{sheet.tachometer.resolution_rpm:g} / {sheet.tachometer.noise_rpm:g}",
            f"| {sheet.gyro.bias_deg_h:g} |",
            f"| {sheet.gyro.angle_random_walk_deg_sqrt_h:g} |",
        ):
            assert figure in page, (name, figure)
