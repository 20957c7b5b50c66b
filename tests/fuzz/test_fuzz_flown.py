"""Settings that are allowed, however far out, are flown: to an end that has a sentence."""

import random
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from simsat.command import parse
from simsat.control.ground.errors import SimsatError
from simsat.flight.controllers import CONTROLLERS
from simsat.flight.mission import prepare
from simsat.results.flight_result import FlightResult
from simsat.run import RunSettings
from tests.fuzz.test_fuzz_flags import FLAGS, values_for

SEEDS = range(3)
EACH = 40
PERIODS, SAMPLES_MAX = 4, 4000

SKIPPED = ("--out", "--recording", "--model", "--controller", "--torque", "--metric")


def words_for(rng: random.Random) -> list[str]:
    """A controller and two or three settings of the right kind and of any size."""
    words = ["--controller", rng.choice(list(CONTROLLERS)), "--nmpc.solver.backend", "interpreted"]
    flags = [flag for flag in FLAGS["run"] if flag not in SKIPPED]
    for flag in rng.sample(flags, rng.randint(2, 3)):
        words += [flag, *values_for(FLAGS["run"][flag], rng)]
    return [word.replace("\x00", "") for word in words]


def ending(words: list[str], monkeypatch: pytest.MonkeyPatch) -> str:
    """How the first periods end, or that the settings are refused."""
    monkeypatch.setattr("sys.argv", ["simsat run", *words])
    try:
        mission = prepare(parse(RunSettings, "").flight)
        timing = replace(mission.timing, periods=min(mission.periods, PERIODS))
        mission = replace(mission, timing=timing)
        if timing.samples > SAMPLES_MAX:
            return "too long for a test"
        result = FlightResult(mission, mission.fly())
    except (SimsatError, SystemExit):
        return "refused"
    assert result.metrics["reason"].isprintable()
    assert len(result.steps) == len(result.flight.steps)
    assert np.isfinite(result.flight.plant.attitudes).all()
    return result.flight.ending.name


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_what_is_allowed_is_flown(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = random.Random(f"flown{seed}")
    endings: Counter[str] = Counter()
    for _ in range(EACH):
        words = words_for(rng)
        try:
            endings[ending(words, monkeypatch)] += 1
        except BaseException as error:
            error.add_note(f"simsat run {words!r}")
            raise
    assert endings["COMPLETE"] > 0
