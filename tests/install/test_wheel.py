"""What is built and installed elsewhere: all of it, nothing else, and it flies there.

Offline and in seconds: the wheel is built with the setuptools that is here and installed into an
environment of its own; the libraries are those of the tests.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

import pytest

from simsat.identity.code import source_hash
from tests.places import MODELS, ROOT

LINKED = ("control", "learning", "models")  # folders whose other place is inside simsat/
BUILT_FROM = ("pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE")
SDIST = "from setuptools import build_meta; build_meta.build_sdist('sdist')"
PACKAGES = "import sysconfig; print(sysconfig.get_path('purelib'))"
WHERE = """
import simsat, simsat.control, simsat.learning, simsat.settings
for place in (simsat.__file__, simsat.control.__file__, simsat.learning.__file__):
    print(place)
print(simsat.settings.MODELS)
"""
WITHOUT_PYTORCH = """
import importlib.util
found = importlib.util.find_spec
importlib.util.find_spec = lambda name: None if name == "torch" else found(name)
import simsat.learning
"""


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clean copy of what is built: a build leaves folders behind, and would pack old ones."""
    copy = tmp_path_factory.mktemp("source")
    copy_source(copy)
    return copy


@pytest.fixture(scope="module")
def wheel(source: Path) -> Path:
    answer = build_wheel(source)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return next((source / "wheel").glob("*.whl"))


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A Python with the wheel and the libraries of these tests, but not their editable install:
    what a line of a .pth file adds to the path is not searched for further .pth files."""
    venv = tmp_path_factory.mktemp("installed")
    call(Path(sys.executable), "-m", "venv", "--without-pip", str(venv), cwd=venv)
    python = venv / "bin" / "python"
    packages = call(python, "-c", PACKAGES, cwd=venv).stdout.strip()
    (Path(packages) / "libraries.pth").write_text(sysconfig.get_path("purelib"))
    pip("--python", str(python), "install", "--no-deps", "--no-index", str(wheel), cwd=venv)
    return python


def copy_source(copy: Path) -> None:
    for name in ("simsat", *LINKED):
        ignore = shutil.ignore_patterns("__pycache__", ".*")
        shutil.copytree(ROOT / name, copy / name, symlinks=True, ignore=ignore)
    for name in BUILT_FROM:
        shutil.copy(ROOT / name, copy)
    (copy / "tests").mkdir()
    (copy / "tests" / "test_any.py").touch()


def build_wheel(source: Path) -> subprocess.CompletedProcess[str]:
    return pip(
        "wheel", "--no-build-isolation", "--no-deps", "--no-index", "-w", "wheel", ".", cwd=source
    )


def pip(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return call(Path(sys.executable), "-m", "pip", *arguments, cwd=cwd)


def call(program: Path, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(
        [str(program), *arguments],
        cwd=cwd, env=environment, capture_output=True, text=True, check=False, timeout=200,
    )  # fmt: skip


def expected(source: Path) -> set[str]:
    """Every file of simsat/ and of the folders that it links to, by its place in the wheel."""
    names = set()
    for top in ("simsat", *LINKED):
        for folder, _, files in os.walk(source / top):  # which does not follow links
            place = Path(folder).relative_to(source)
            inside = place if top == "simsat" else Path("simsat") / place
            names |= {str(inside / file) for file in files}
    return names


def test_the_wheel_holds_every_file_and_nothing_else(wheel: Path, source: Path) -> None:
    """Nothing outside simsat/: `control` at the top is python-control's, and would be overwritten
    by our installation and deleted with it."""
    names = set(zipfile.ZipFile(wheel).namelist())
    info = {name for name in names if name.split("/")[0].endswith(".dist-info")}
    assert names - info == expected(source)
    assert {
        "simsat/py.typed",
        "simsat/control/solver/compiled/sqp.c",
        "simsat/control/solver/compiled/riccati.h",
        "simsat/learning/train.py",
        "simsat/models/parts/space.xml",
        "simsat/models/two_wheel/network/pinn.safetensors",
        "simsat/models/flexible_panels/network/report.json",
    } <= names


def test_the_source_archive_holds_files_instead_of_links(source: Path) -> None:
    answer = call(Path(sys.executable), "-c", SDIST, cwd=source)
    assert answer.returncode == 0, answer.stderr
    with tarfile.open(next((source / "sdist").glob("*.tar.gz"))) as archive:
        members = archive.getmembers()
    assert all(member.isfile() or member.isdir() for member in members)
    names = {member.name.partition("/")[2] for member in members if member.isfile()}
    assert {name for name in names if name.startswith("simsat/")} == expected(source)
    assert not {name.split("/")[0] for name in names} & {"tests", *LINKED}


@pytest.mark.parametrize("lost", LINKED)
def test_a_checkout_that_lost_a_link_is_not_built(lost: str, tmp_path: Path) -> None:
    """Python's zipfile, and pip with it, turn a link into a file that names its target."""
    copy_source(tmp_path)
    link = tmp_path / "simsat" / lost
    link.unlink()
    link.write_text(f"../{lost}")
    answer = build_wheel(tmp_path)
    assert answer.returncode != 0
    assert f"simsat/{lost} must be a link to the folder {lost}/" in answer.stdout + answer.stderr


def test_nothing_of_the_checkout_is_used(python: Path, tmp_path: Path) -> None:
    answer = call(python, "-c", WHERE, cwd=tmp_path)
    places = answer.stdout.split()
    assert len(places) == 4, answer.stderr
    assert all(Path(place).is_relative_to(python.parents[1]) for place in places)


def test_it_counts_as_the_same_code(python: Path, tmp_path: Path) -> None:
    """Results of a checkout can be flown again by what is installed."""
    script = "from simsat.identity.code import source_hash; print(source_hash(training=True))"
    assert call(python, "-c", script, cwd=tmp_path).stdout.strip() == source_hash(training=True)


def test_the_list_of_models_is_that_of_the_checkout(python: Path, tmp_path: Path) -> None:
    answer = call(python, "-m", "simsat.run", "--model", "none", cwd=tmp_path)
    names = sorted(path.stem for path in MODELS.glob("*/*.xml") if path.parent.name != "parts")
    assert len(names) >= 8
    assert f"there are: {', '.join(names)}, or name an MJCF file" in answer.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ("simsat.run", "--duration-s", "10"),
        ("simsat.run", "--duration-s", "2", "--model", "pyramid", "--no-recording"),
        ("simsat.run", "--duration-s", "2", "--controller", "nmpc-pinn", "--no-recording"),
        ("simsat.run", "--duration-s", "2", "--model", "flexible_panels",
         "--controller", "nmpc-learned", "--no-recording"),
        ("simsat.campaign", "--attitudes", "1", "--controllers", "nmpc", "--duration-s", "10",
         "--recordings", "none"),
        ("simsat.learning.train", "--help"),
    ],
    ids=lambda arguments: " ".join(arguments),
)  # fmt: skip
def test_it_flies_elsewhere(arguments: tuple[str, ...], python: Path, tmp_path: Path) -> None:
    answer = call(python, "-m", *arguments, cwd=tmp_path)
    assert answer.returncode == 0, answer.stderr
    assert str(ROOT) not in answer.stdout


def test_python_control_is_left_alone(python: Path, tmp_path: Path) -> None:
    """One process imports another package `control` and ours."""
    (tmp_path / "control").mkdir()
    (tmp_path / "control" / "__init__.py").write_text("theirs = True\n")
    script = "import simsat.control, control; print(control.theirs, simsat.control.__name__)"
    answer = call(python, "-c", script, cwd=tmp_path)
    assert answer.stdout == "True simsat.control\n", answer.stderr


def test_flying_needs_no_pytorch(python: Path, tmp_path: Path) -> None:
    """Three quarters of a gigabyte: it comes with `simsat[learning]` only."""
    script = "import sys, simsat.run; print('torch' in sys.modules)"
    assert call(python, "-c", script, cwd=tmp_path).stdout == "False\n"


def test_training_without_pytorch_is_refused_by_a_sentence(python: Path, tmp_path: Path) -> None:
    answer = call(python, "-c", WITHOUT_PYTORCH, cwd=tmp_path)
    assert "training needs PyTorch, which flying doesn't: pip install" in answer.stderr


def test_the_command_is_installed(python: Path, tmp_path: Path) -> None:
    answer = call(python.with_name("simsat"), "--help", cwd=tmp_path)
    assert answer.returncode == 0, answer.stderr
