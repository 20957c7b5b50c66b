"""Files that are broken, of another kind, too large or meant to harm: each gets one sentence."""

import io
import json
import os
import pickle
import random
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simsat.control.ground.settings import hints
from simsat.settings import FlightSettings
from tests.fuzz.commands import call, nothing_flies  # noqa: F401
from tests.fuzz.garbage import kept, mangled, number, value, word
from tests.places import MODELS

SEEDS = range(4)
EACH = 150
QUICK_EACH = 12

Lines = tuple[str, list[str]]


def csv(rng: random.Random, folder: Path) -> Lines:
    """Attitudes."""
    mark = rng.choice(["", "", "\ufeff"])
    delimiter = rng.choice([",", ",", ",", ";", "\t", "|", "\x00", " "])
    names = ["axis_x", "axis_y", "axis_z", "angle_deg"]
    if rng.random() < 0.2:
        names[rng.randrange(4)] = word(rng)
    rows = [[number(rng) if rng.random() < 0.3 else "0.5" for _ in names]
            for _ in range(rng.randint(0, 4))]  # fmt: skip
    text = mark + "\n".join(delimiter.join(row) for row in [names, *rows])
    encoding = rng.choice(["utf-8", "utf-8", "utf-8", "utf-16", "latin-1"])
    content = text.encode(encoding, "replace")
    if rng.random() < 0.4:
        content = mangled(content, rng)
    path = kept(folder / "attitudes.csv", content)
    return "campaign", ["--controllers", "nmpc", "--attitudes", path]


def toml_value(rng: random.Random) -> str:
    text = value(rng)
    return text if rng.random() < 0.4 else json.dumps(text.encode("utf-8", "replace").decode())


def toml(rng: random.Random, folder: Path) -> Lines:
    """Studies."""
    names = [*hints(FlightSettings), "nmpc.horizon", "nominal.mismatch", "start.omega-deg-s", "x"]
    lines = []
    for _ in range(rng.randint(0, 3)):
        name = rng.choice(names) if rng.random() < 0.9 else word(rng)
        listed = ", ".join(toml_value(rng) for _ in range(rng.randint(0, 3)))
        lines.append(f"{name} = [{listed}]" if rng.random() < 0.9 else f"{name} = {listed}")
    if rng.random() < 0.1:
        lines.append("a." * rng.choice([10, 5000]) + "b = [1]")
    if rng.random() < 0.1:
        lines.append("a = " + "[" * rng.choice([10, 20_000]))
    content = "\n".join(lines).encode("utf-8", "replace")
    if rng.random() < 0.3:
        content = mangled(content, rng)
    path = kept(folder / "study.toml", content)
    return "campaign", ["--controllers", "nmpc", "--attitudes", "2", "--study", path]


FIGURES = """mass = 10
inertia = [0.2, 0.3, 0.25]
[box]
size = [0.2, 0.3, 0.4]
[[wheel]]
axis = [1, 0, 0]
mass = 0.1
spin_inertia = 1e-4
speed_rpm = 6000
torque = 0.01
"""


def figures(rng: random.Random, folder: Path) -> Lines:
    """What a spacecraft file is written from."""
    lines = FIGURES.splitlines()
    for _ in range(rng.randint(0, 3)):
        at = rng.randrange(len(lines))
        name = lines[at].split(" = ")[0] if rng.random() < 0.8 else word(rng)
        listed = ", ".join(number(rng) for _ in range(rng.choice([1, 3, 3, 6])))
        lines[at] = f"{name} = {rng.choice([number(rng), toml_value(rng), f'[{listed}]'])}"
    content = "\n".join(lines).encode("utf-8", "replace")
    if rng.random() < 0.2:
        content = mangled(content, rng)
    path = kept(folder / "craft.toml", content)
    return "new", [path, "--out", str(folder / f"{rng.random()}.xml")]


def vary(rng: random.Random, folder: Path) -> Lines:
    """Studies on the command line."""
    name = rng.choice([*hints(FlightSettings), "nmpc.horizon", "nmpc.solver.backend", word(rng)])
    values = ",".join(value(rng) for _ in range(rng.randint(0, 3)))
    spec = f"{name}={values}".replace("\x00", "")
    return "campaign", ["--controllers", "nmpc", "--attitudes", "2", "--vary", spec]


ARRAYS: list[Callable[[random.Random], Any]] = [
    lambda rng: np.zeros((4, 2)),
    lambda rng: np.zeros((4, 3)),
    lambda rng: np.zeros((0, 2)),
    lambda rng: np.zeros(2),
    lambda rng: np.full((4, 2), rng.choice([np.nan, np.inf, 1e308, 1e-320])),
    lambda rng: np.zeros((4, 2), rng.choice(["i1", "u8", "c16", "?", "f2", "S3", "U3", "M8[s]"])),
    lambda rng: np.zeros((2, 2), [("a", "f8"), ("b", "i4")]),
    lambda rng: np.array([{"a": 1}], dtype=object),
    lambda rng: np.array(rng.choice([0.5, 0.05, 0.0, -1.0, np.nan, 1e300, 1e-300, 0.3])),
    lambda rng: np.array([0.5, 0.5]),
]
SOUND = {"u": np.zeros((4, 2)), "dt_u": 0.5, "q0": np.array([1.0, 0, 0, 0]), "w0": np.zeros(3)}


def npz(rng: random.Random, folder: Path) -> Lines:
    """Torque profiles."""
    entries: dict[str, Any] = dict(SOUND)
    for _ in range(rng.randint(0, 2)):
        entries[rng.choice(["u", "dt_u", "q0", "w0", "Om0", "other"])] = rng.choice(ARRAYS)(rng)
    out = io.BytesIO()
    rng.choice([np.savez, np.savez_compressed])(out, **entries)
    content = out.getvalue()
    kind = rng.random()
    if kind < 0.4:
        content = mangled(content, rng)
    elif kind < 0.5:
        content = repacked(content, rng)
    elif kind < 0.55:
        content = rng.choice([b"", b"\x93NUMPY", pickle.dumps([1]), b"PK\x05\x06" + bytes(18)])
    path = kept(folder / "profile.npz", content)
    return "replay", [path]


def repacked(content: bytes, rng: random.Random) -> bytes:
    """The archive with an array whose header promises something else than follows it."""
    shape = rng.choice(["(10000000000, 2)", "(4, -2)", "(4, 2, 1)", "(9" * 30, "4", "'a'"])
    kind = rng.choice(["<f8", "|O", "<f9", "<U1000000000", "x"])
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    body = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head.encode() + bytes(64)
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(out, "w") as new:
        for name in old.namelist():
            new.writestr(name, body if name == "u.npy" else old.read(name))
    return out.getvalue()


def network(rng: random.Random, folder: Path) -> Lines:
    """Network files: the header rewritten, or bytes changed anywhere."""
    content = (MODELS / "two_wheel" / "network" / "pinn.safetensors").read_bytes()
    end = 8 + int.from_bytes(content[:8], "little")
    if rng.random() < 0.6:
        header = json.loads(content[8:end])
        alter(header, rng)
        text = json.dumps(header).encode()
        size = len(text) if rng.random() < 0.9 else rng.choice([0, 1, 2**40, 2**64 - 1])
        content = size.to_bytes(8, "little") + text + content[end:]
    else:
        content = mangled(content[: end if rng.random() < 0.5 else len(content)], rng)
    path = kept(folder / "net.safetensors", content)
    return "run", ["--controller", "nmpc-pinn", "--network", path]


def alter(header: dict[str, Any], rng: random.Random) -> None:
    """Change metadata or a tensor's description."""
    about = header["__metadata__"]
    for _ in range(rng.randint(1, 2)):
        kind = rng.randrange(6)
        name = rng.choice([n for n in header if n != "__metadata__"])
        if kind == 0:
            about["bound_Nm"] = value(rng)
        elif kind == 1:
            about.pop(rng.choice(list(about)), None)
        elif kind == 2:
            about[rng.choice(list(about))] = rng.choice([word(rng), 1, None, [], {}])
        elif kind == 3:
            kinds = ["F64", "F32", "F16", "BF16", "I64", "U8", "BOOL", "F8_E4M3", "C64", "X", 1]
            header[name]["dtype"] = rng.choice(kinds)
        elif kind == 4:
            header[name]["shape"] = rng.choice([[], [0], [2, 2], [-1], [2**62, 4], ["a"], None])
        else:
            header[name]["data_offsets"] = rng.choice([[0, 0], [8, 0], [0, 2**63], [0], None])


def place(rng: random.Random, folder: Path) -> Lines:
    """Folders for files, files for folders, devices, names that no file has."""
    file, inner = folder / "file", folder / rng.choice(["a b", "ä", "-x", "x\ny", "x" * 200])
    file.write_bytes(b"text")
    inner.mkdir(exist_ok=True)
    spot = rng.choice(
        [folder, inner, file, file / "below", inner / ("n" * 300), inner / ("m/" * 2100),
         Path("/dev/null"), Path("/"), Path("."), Path(""), inner / "none.xml", Path("/dev/full")]
    )  # fmt: skip
    flag = rng.choice(
        ["--model", "--network", "--learned.network", "--study", "--attitudes", "profile",
         "folder", "--out", "--torque", "--metric", "--controller"]
    )  # fmt: skip
    if flag == "profile":
        return "replay", [f"{spot}"]
    if flag == "folder":
        return "verify", [f"{spot}"]
    if flag in ("--study", "--attitudes"):
        return "campaign", ["--controllers", "nmpc", flag, f"{spot}"]
    controller = ["--controller", "nmpc-pinn"] if flag == "--network" else []
    return "run", [*controller, flag, f"{spot}"]


def saved(rng: random.Random, folder: Path) -> Lines:
    """Folders of results, edited."""
    run = folder / "run"
    run.mkdir(exist_ok=True)
    for name in ("settings.json", "metrics.json", "identity.json"):
        (run / name).unlink(missing_ok=True)
        if rng.random() < 0.6:
            record: dict[str, Any] = {
                "settings": {rng.choice(["axis", "nmpc", "x"]): rng.choice([1, [], {}, "a", None])}
            }
            content = json.dumps(rng.choice([record, [], 1, None, "x", {}])).encode()
            kept(run / name, mangled(content, rng) if rng.random() < 0.4 else content)
    return "verify", [str(run)]


KINDS = {f.__name__: f for f in (csv, toml, figures, vary, npz, network, place, saved)}


def throw(kind: str, seed: int, count: int, folder: Path) -> Counter[str]:
    rng = random.Random(f"{kind}{seed}")
    kinds: Counter[str] = Counter()
    for _ in range(count):
        name, words = KINDS[kind](rng, folder)
        try:
            kinds[call(name, words).kind] += 1
        except BaseException as error:
            error.add_note(f"simsat {name} {words!r}")
            raise
    return kinds


@pytest.mark.usefixtures("nothing_flies")
@pytest.mark.parametrize("kind", KINDS)
def test_a_bad_file_gets_a_sentence(kind: str, tmp_path: Path) -> None:
    assert throw(kind, 0, QUICK_EACH, tmp_path)["sentence"] > 0


@pytest.mark.slow
@pytest.mark.usefixtures("nothing_flies")
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", KINDS)
def test_no_file_brings_a_traceback(kind: str, seed: int, tmp_path: Path) -> None:
    assert throw(kind, 1 + seed, EACH, tmp_path).total() == EACH


class Thief:
    """What a pickle can do when it is read."""

    def __init__(self, path: Path):
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(self.path),)


@pytest.mark.usefixtures("nothing_flies")
def test_code_in_a_profile_is_not_run(tmp_path: Path) -> None:
    np.savez(tmp_path / "evil.npz", u=np.array([Thief(tmp_path / "stolen")]), dt_u=0.5)
    outcome = call("replay", [str(tmp_path / "evil.npz")])
    assert outcome.kind == "sentence"
    assert not (tmp_path / "stolen").exists()


@pytest.mark.usefixtures("nothing_flies")
def test_an_archive_that_unpacks_to_more_than_memory_is_refused_before(tmp_path: Path) -> None:
    """40 MB of zeros in 40 kB stand for 40 GB: the bound is by what the directory says."""
    path = tmp_path / "bomb.npz"
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (2000000000, 2), }"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("dt_u.npy", _npy(np.array(0.5)))
        with archive.open("u.npy", "w", force_zip64=True) as entry:
            entry.write(b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head)
            for _ in range(400):
                entry.write(bytes(1_000_000))
    outcome = call("replay", [str(path)])
    assert outcome.kind == "sentence"
    assert "unpacks to 400 MB" in outcome.err


def _npy(array: Any) -> bytes:
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()
