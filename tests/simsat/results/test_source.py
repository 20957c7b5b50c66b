"""A run is flown again from its folder alone, elsewhere, and from settings files."""

import json
import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest

import simsat
from simsat.control.ground.errors import OutputError, SettingsError
from simsat.flight.mission import prepare
from simsat.mjcf import read_model
from simsat.mjcf.travel import copy_model, model_files
from simsat.results.source import read_flight
from simsat.run import named_source
from tests.places import MODELS

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def fly_again(settings: simsat.FlightSettings) -> simsat.FlightResult:
    return simsat.fly(prepare(settings))


def model_with_a_mesh(folder: Path) -> Path:
    """two_wheel with an antenna from a mesh folder, its includes copied along."""
    for name in ("two_wheel", "parts"):
        shutil.copytree(MODELS / name, folder / name)
    (folder / "shapes").mkdir()
    (folder / "shapes" / "antenna.obj").write_text(TETRAHEDRON)
    path: Path = folder / "two_wheel" / "two_wheel.xml"
    text = path.read_text().replace(
        "<worldbody>",
        '<compiler meshdir="../shapes"/><asset><mesh name="antenna" file="antenna.obj"/></asset>'
        "<worldbody>",
    )
    geom = '<geom type="mesh" mesh="antenna" mass="0" group="2"/><body name="rotor_x"'
    path.write_text(text.replace('<body name="rotor_x"', geom, 1))
    return path


def test_a_model_travels_with_includes_and_assets(tmp_path: Path) -> None:
    path = model_with_a_mesh(tmp_path / "there")
    names = {file.name for file in model_files(path)}
    assert names == {"two_wheel.xml", "space.xml", "wheels.xml", "antenna.obj"}
    model = read_model(path)
    copied = copy_model(model, path, tmp_path / "copy")
    shutil.rmtree(tmp_path / "there")
    assert read_model(copied).identity == model.identity
    assert copied.suffix == ".xml"


@pytest.mark.parametrize("controller", ["nmpc-pinn", "nmpc-learned"])
def test_a_run_is_flown_again_from_its_folder_alone(tmp_path: Path, controller: str) -> None:
    path = tmp_path / "craft" / "two_wheel" / "two_wheel.xml"
    for name in ("two_wheel", "parts"):
        shutil.copytree(MODELS / name, tmp_path / "craft" / name)
    flown = simsat.fly(path, controller=controller, angle_deg=40, duration_s=3.0)
    flown.save(tmp_path / "run")
    shutil.rmtree(tmp_path / "craft")
    shutil.move(tmp_path / "run", tmp_path / "elsewhere")
    settings = read_flight(tmp_path / "elsewhere")
    again = fly_again(settings)
    assert again.table.equals(flown.table)


def test_a_network_of_one_s_own_travels_too(tmp_path: Path) -> None:
    mine = tmp_path / "mine.safetensors"
    shutil.copyfile(MODELS / "two_wheel" / "network" / "linear.safetensors", mine)
    flown = simsat.fly(controller="nmpc-pinn", network=str(mine), duration_s=1.0)
    flown.save(tmp_path / "run")
    mine.unlink()
    settings = read_flight(tmp_path / "run")
    assert Path(settings.network).read_bytes()
    assert fly_again(settings).table.equals(flown.table)


def test_a_model_built_in_python_is_kept_compiled(tmp_path: Path) -> None:
    spec = mujoco.MjSpec.from_file(str(MODELS / "two_wheel" / "two_wheel.xml"))
    spec.body("bus").fullinertia = 1.1 * np.array(spec.body("bus").fullinertia)
    flown = simsat.fly(spec, duration_s=1.0)
    flown.save(tmp_path / "run")
    settings = read_flight(tmp_path / "run")
    assert settings.model.suffix == ".mjb"
    again = fly_again(settings)
    np.testing.assert_array_equal(again.table["q_x"], flown.table["q_x"])


def test_what_is_not_as_it_was_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    simsat.fly(duration_s=1.0).save(tmp_path / "run")
    wheels = tmp_path / "run" / "model" / "parts" / "wheels.xml"
    wheels.write_text(wheels.read_text().replace("-0.05 0.05", "-0.04 0.04"))
    read_flight(tmp_path / "run")
    assert capsys.readouterr().err.startswith("not as it was: the compiled model")


@pytest.mark.parametrize("kind", ["toml", "json"])
def test_a_settings_file_changes_what_it_names(tmp_path: Path, kind: str) -> None:
    text = {
        "toml": 'model = "pyramid"\naxis = [1, 0, 0]\n[nmpc]\nhorizon = 12\n',
        "json": '{"model": "pyramid", "axis": [1, 0, 0], "nmpc": {"horizon": 12}}',
    }[kind]
    path = tmp_path / f"mine.{kind}"
    path.write_text(text)
    settings = read_flight(path)
    assert settings == simsat.FlightSettings(
        model=Path("pyramid"), axis=(1.0, 0.0, 0.0), nmpc=type(settings.nmpc)(horizon=12)
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[nmpc]\nhorizin = 3", "no setting 'nmpc.horizin': no 'horizin'; did you mean horizon"),
        ("nmpc = 3", "--nmpc is 3: give names and values"),
        ("angle_deg = 'wide'", "--angle-deg is 'wide': give a finite number"),
        ("angle_deg: 3", "it is no TOML"),
    ],
)
def test_a_bad_settings_file_is_one_sentence(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(SettingsError, match=f"--from '.*mine.toml': {message}"):
        read_flight(path)


def test_a_folder_without_settings_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"can't read '.*settings.json'"):
        read_flight(tmp_path)
    (tmp_path / "settings.json").write_text(json.dumps({"settings": {"axis": 3}}))
    with pytest.raises(OutputError, match="--axis is 3: give 3 values"):
        read_flight(tmp_path)


def test_from_is_found_among_the_flags() -> None:
    assert named_source(["--model", "x", "--from", "a"]) == Path("a")
    assert named_source(["--from=a", "--angle-deg", "3"]) == Path("a")
    assert named_source(["--model", "x"]) is None
    assert named_source(["--from"]) is None


def test_orbit_elements_travel_too_and_an_edited_copy_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    elements = tmp_path / "vanguard.tle"
    elements.write_text(
        "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753\n"
        "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667\n"
    )
    orbit = {"tle": elements, "epoch_utc": "2000-06-28T00:00:00"}
    flown = simsat.fly(duration_s=1.0, angle_deg=10, orbit=orbit, environment={"field": "igrf"})
    flown.save(tmp_path / "run")
    elements.unlink()
    settings = read_flight(tmp_path / "run")
    assert settings.orbit.tle == tmp_path / "run" / "files" / "orbit.tle" / "vanguard.tle"
    assert capsys.readouterr().err == ""
    assert fly_again(settings).table.equals(flown.table)
    settings.orbit.tle.write_text(settings.orbit.tle.read_text() + "\n")
    read_flight(tmp_path / "run")
    assert "not as it was: the content of --orbit.tle" in capsys.readouterr().err
    packages = json.loads((tmp_path / "run" / "settings.json").read_text())["flown_with"][
        "packages"
    ]
    assert {"sgp4", "ppigrf"} <= packages.keys()
