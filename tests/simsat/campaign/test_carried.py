"""A campaign's folder is flown again where nothing of the original files is left."""

import shutil
from pathlib import Path

import pytest

from simsat.campaign.attitudes import spiral_attitudes
from simsat.campaign.carried import CARRIED, PLACES, carry_points, places_in
from simsat.campaign.command import fly_missing
from simsat.campaign.run import CampaignRun, plan_runs
from simsat.campaign.study import grid, parse_variation
from simsat.control.ground.errors import OutputError
from simsat.results.files import write_json
from simsat.settings import CommonSettings
from simsat.verify import verify
from tests import campaign_cases
from tests.places import MODELS

NAMES = ("two_wheel", "three_wheel")


@pytest.fixture
def originals(tmp_path: Path) -> Path:
    """The spacecraft in a place that will be gone."""
    for name in (*NAMES, "parts"):
        shutil.copytree(MODELS / name, tmp_path / "originals" / name)
    return tmp_path / "originals"


def planned(originals: Path) -> tuple[CampaignRun, ...]:
    """Two spacecraft, one of them with two networks, at two points each."""
    models = [originals / name / f"{name}.xml" for name in NAMES]
    network = MODELS / "two_wheel" / "network" / "linear.safetensors"
    shutil.copy(network, originals / "mine.safetensors")
    points = (
        *grid((parse_variation(f"model={','.join(map(str, models))}"),)),
        *grid(
            (
                parse_variation(f"model={models[0]}"),
                parse_variation(f"network=pinn,{originals / 'mine.safetensors'}"),
            )
        ),
    )
    return plan_runs(CommonSettings(duration_s=1.0), ("nmpc",), spiral_attitudes(1), points)


def test_rows_are_flown_again_without_the_originals(
    originals: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simsat.verify.local_pool", lambda workers: campaign_cases.HERE)
    out = tmp_path / "out"
    out.mkdir()
    write_json(out / "campaign.json", {})
    runs = planned(originals)
    carry_points(out, runs)
    fly_missing(out, runs, campaign_cases.HERE)
    shutil.rmtree(originals)
    moved = Path(shutil.move(out, tmp_path / "elsewhere"))
    verification = verify(moved)
    assert verification.same
    assert verification.changed == ()
    assert verification.flown == 4
    assert len(list((moved / CARRIED).glob("[0-9]"))) == 3  # the same files once
    spacecraft = next((moved / CARRIED / "0" / "model").rglob("two_wheel.xml"))
    spacecraft.write_text(spacecraft.read_text().replace("0.050895867768595046", "0.05"))
    assert verify(moved).changed == (
        "the compiled model (its file, an included file or an asset was edited)",
    )


def test_copies_that_a_kill_left_half_made_are_made_anew(originals: Path, tmp_path: Path) -> None:
    runs = planned(originals)
    half = tmp_path / "out" / (CARRIED + ".part") / "0" / "model"
    half.mkdir(parents=True)
    (half / "leftover.xml").write_text("<muj")
    carry_points(tmp_path / "out", runs)
    assert len(places_in(tmp_path / "out")) == 4
    bus = next((tmp_path / "out").rglob("bus.xml"))
    sound = bus.read_text()
    bus.write_text("<muj")
    assert not (tmp_path / "out" / (CARRIED + ".part")).exists()
    assert not list((tmp_path / "out").rglob("leftover.xml"))
    index = tmp_path / "out" / CARRIED / PLACES
    index.write_text("{bad")
    with pytest.raises(OutputError, match=r"can't read .*places.json"):
        places_in(tmp_path / "out")
    carry_points(tmp_path / "out", runs)
    assert len(places_in(tmp_path / "out")) == 4
    assert bus.read_text() == sound
