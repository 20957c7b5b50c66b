"""Flags of every command with values that they don't take, unknown, doubled and without values."""

import random
import typing
from collections import Counter
from typing import Any

import pytest

from simsat.bad_network_study import StudySettings
from simsat.campaign.command import CampaignSettings
from simsat.control.ground.settings import Settings, hints
from simsat.replay import ReplaySettings
from simsat.run import OutputSettings
from simsat.settings import FlightSettings
from simsat.verify import VerifySettings
from tests.fuzz.commands import call, nothing_flies  # noqa: F401
from tests.fuzz.garbage import argument, number, value, word

SEEDS = range(4)
EACH = 150
QUICK_EACH = 12
FLOATS = (
    "0", "-0.0", "1", "-1", "0.5", "0.05", "100", "1e-9", "1e-300", "5e-324", "1e9", "1e150",
    "1.7e308", "-1.7e308", "1e400", "nan", "inf", "-inf", "3600", "1e6", "1e-3", "0.3",
)  # fmt: skip
INTS = ("0", "1", "-1", "2", "3", "24", "500", "501", "100000000", "9" * 30, "-" + "9" * 30)


def flags(settings: type, prefix: str = "") -> dict[str, Any]:
    """All flags of a group of settings, with what each takes."""
    found: dict[str, Any] = {}
    for name, hint in hints(settings).items():
        kinds = [hint, *typing.get_args(hint)]
        inner = next((k for k in kinds if isinstance(k, type) and issubclass(k, Settings)), None)
        if name in ("common", "output") and inner is not None:
            found |= flags(inner)
        elif inner is not None:
            found |= flags(inner, f"{prefix}{name}.")
        elif name not in ("profile", "folder"):
            found[f"--{prefix}{name}".replace("_", "-")] = hint
    return found


FLAGS = {
    "run": flags(FlightSettings) | flags(OutputSettings),
    "campaign": flags(CampaignSettings),
    "replay": flags(ReplaySettings),
    "verify": flags(VerifySettings),
    "bad_network_study": flags(StudySettings),
}


def values_for(hint: Any, rng: random.Random) -> list[str]:
    """Values of the right kind and of any size."""
    if typing.get_origin(hint) is typing.Annotated:
        return values_for(typing.get_args(hint)[0], rng)
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Literal:
        return [str(rng.choice(inner))]
    if origin is tuple:
        count = rng.randint(0, 4) if inner[-1] is Ellipsis else len(inner)
        return [v for _ in range(count) for v in values_for(inner[0], rng)]
    if inner:  # a union: one of its kinds
        return values_for(rng.choice(inner), rng)
    if hint is float:
        return [rng.choice(FLOATS)]
    if hint is int:
        return [rng.choice(INTS)]
    if hint is bool:
        return [] if rng.random() < 0.8 else ["True"]
    return [word(rng)]


def words_for(name: str, rng: random.Random) -> list[str]:
    """A command line: a few flags, mostly known, with values that mostly don't fit."""
    words = []
    if name == "campaign":
        words = ["--controllers", "nmpc", "--attitudes", "2"]
    if name in ("replay", "verify") and rng.random() < 0.9:
        words.append(word(rng))
    for _ in range(rng.randint(1, 4)):
        flag = rng.choice(list(FLAGS[name]))
        values = values_for(FLAGS[name][flag], rng)
        if rng.random() < 0.15:
            values = [rng.choice([number, value])(rng) for _ in range(rng.randint(0, 4))]
        if rng.random() < 0.03:
            flag = rng.choice(["--", "-x", "--" + word(rng), flag + "x", flag.upper(), flag + "="])
        joined = rng.random() < 0.2 and len(values) == 1
        words += [f"{flag}={values[0]}"] if joined else [flag, *values]
    return [argument(w) for w in words]


def throw(name: str, seed: int, count: int) -> Counter[str]:
    rng = random.Random(f"{name}{seed}")
    kinds: Counter[str] = Counter()
    for _ in range(count):
        words = words_for(name, rng)
        try:
            kinds[call(name, words).kind] += 1
        except BaseException as error:
            error.add_note(f"simsat {name} {[w[:100] for w in words]!r}")
            raise
    return kinds


@pytest.mark.usefixtures("nothing_flies")
@pytest.mark.parametrize("name", FLAGS)
def test_bad_flags_get_a_sentence_or_the_usage_box(name: str) -> None:
    kinds = throw(name, 0, QUICK_EACH)
    assert kinds["sentence"] + kinds["box"] > 0


@pytest.mark.slow
@pytest.mark.usefixtures("nothing_flies")
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", FLAGS)
def test_no_flag_brings_a_traceback(name: str, seed: int) -> None:
    assert throw(name, 1 + seed, EACH).total() == EACH
