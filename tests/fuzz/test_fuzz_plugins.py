"""Code of the user's own that fails in every way: at import, when called, in what it answers."""

# mypy: disable-error-code="arg-type, dict-item, list-item"

import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simsat.control.ground.errors import PluginError
from simsat.control.interface.layers import Correction, Pilot
from simsat.control.interface.plan import Plan
from simsat.control.interface.verdict import Decision, Reason, Verdict
from simsat.flight.loop import Ending
from simsat.flight.mission import Plugins, prepare
from simsat.results.flight_result import FlightResult
from simsat.settings import FlightSettings
from tests.fuzz.commands import call, nothing_flies  # noqa: F401
from tests.fuzz.garbage import WORDS, word

SEEDS = range(3)
EACH = 60

BODIES = (
    "raise ValueError('no\\nway')", "raise SystemExit(0)", "import sys; sys.exit('bye')",
    "1 / 0", "def name(:", "import not_there_at_all", "raise ImportError", "return 1",
    "raise RecursionError", "raise MemoryError('all of it')", "name = 1", "name = None",
    "def name(): pass", "def name(a, b): pass", "def name(brief): raise SystemExit(0)",
    "def name(brief): yield 1", "class name: pass",
    "class name:\n    def __init__(self, a, b): pass", "def name(brief): return 1",
    "def name(brief): return brief.nothing", "name = lambda *a, **k: None", "x = '\\udcff'",
    "class E(Exception):\n    def __str__(self): raise TypeError\nraise E", "\x00",
    "# -*- coding: x",
    "def __getattr__(name): raise KeyError(name)", "name = type", "del __builtins__",
    "def name(brief):\n    def f(): return f()\n    return f()",
)  # fmt: skip


def words_for(rng: random.Random, folder: Path, number: int) -> list[str]:
    """A flag that names code, in a module written for it or none at all."""
    flag = rng.choice(["--controller", "--network", "--torque", "--metric"])
    controller = ["--controller", "nmpc-pinn"] if flag == "--network" else []
    if rng.random() < 0.3:
        spec = rng.choice([w for w in WORDS if ":" in w] + [f"{word(rng)}:{word(rng)}"])
        return [*controller, f"{flag}={spec}".replace("\x00", "")]
    module = f"fuzzed_{number}"
    body = rng.choice(BODIES).encode("utf-8", "surrogateescape")
    (folder / f"{module}.py").write_bytes(body)
    return [*controller, flag, f"{module}:{rng.choice(['name', 'name', 'other', 'name.x'])}"]


def throw(seed: int, count: int, folder: Path) -> Counter[str]:
    rng = random.Random(f"plugins{seed}")
    kinds: Counter[str] = Counter()
    for k in range(count):
        words = words_for(rng, folder, k)
        try:
            kinds[call("run", words).kind] += 1
        except BaseException as error:
            error.add_note(f"simsat run {words!r}")
            raise
    return kinds


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


@pytest.mark.usefixtures("nothing_flies")
def test_code_that_cannot_be_loaded_gets_a_sentence(here: Path) -> None:
    assert throw(0, 15, here)["sentence"] > 5


@pytest.mark.slow
@pytest.mark.usefixtures("nothing_flies")
@pytest.mark.parametrize("seed", SEEDS)
def test_no_code_brings_a_traceback(seed: int, here: Path) -> None:
    assert throw(1 + seed, EACH, here).total() == EACH


def _leaves(*args: Any) -> Any:
    raise SystemExit(0)


def _generates(*args: Any) -> Any:
    yield 1


def _goes_on_for_ever(*args: Any) -> Any:
    return _goes_on_for_ever(*args)


class _Unprintable:
    def __repr__(self) -> str:
        raise ValueError


def _plan(*args: Any, **more: Any) -> Plan:
    return Plan(*args, **more)


ANSWERS: tuple[Callable[..., Any], ...] = (
    _leaves, _generates, _goes_on_for_ever,
    *(lambda *a, answer=answer: answer for answer in (
        None, 1, "a", b"", [], {}, [1], [1, 2, 3], [[1, 2]], [None, None], ["x", "y"], [1j, 0],
        np.zeros((2, 2)), np.array(["a", "b"]), object(), type, _Unprintable(), float("nan"),
        [np.nan, 0.0], [np.inf, 0.0], [1e308, -1e308], _plan(None), _plan([1, 2], None),
        _plan([0, 0], ["unhashable"]), _plan([0, 0], "ok", None), _plan([0, 0], signals={"a": "b"}),
        _plan([0, 0], signals=None), _plan([0, 0], signals={1: [1]}),
        _plan([0.0, 0.0], signals={"": 1}),
        _plan("ab"), _plan([0.0, 0.0], evidence=_Unprintable()), (_plan([0, 0]), None),
    )),
)  # fmt: skip
"""What a law may answer."""

TOLD = (Ending.PLUGIN_FAILED, Ending.DIVERGED, Ending.COMPLETE)


class _Planner:
    def __init__(self, answer: Callable[..., Any]):
        self.answer = answer

    def plan(self, measurement: Any, memory: Any) -> Any:
        return self.answer(measurement, memory), memory


class _Bare(_Planner):
    def plan(self, measurement: Any, memory: Any) -> Any:
        return self.answer(measurement, memory)


class _Corrector(_Bare):
    def correct(self, *args: Any) -> Any:
        return self.answer(*args), None


class _Supervisor(_Bare):
    def supervise(self, *args: Any) -> Any:
        return self.answer(*args), None


def _still(*args: Any) -> Any:
    return Plan(np.zeros(2))


def _nothing_to_add(*args: Any) -> Any:
    return Correction(np.zeros(2), np.zeros(2), True)


MORE = (
    Correction(None, None, True),
    Correction(np.zeros(3), np.zeros(2), True),
    Correction(np.zeros(2), "x", True),
    Correction(np.full(2, np.nan), np.zeros(2), True),
    Correction(np.zeros(2), np.zeros(2), True, {"a": None}),
    *(
        Verdict(alpha, Decision.ACCEPTED, Reason.SAFE, 0.0, 0.0, 0.0)
        for alpha in (-1.0, 2.0, np.nan)
    ),
)

MAKERS: dict[str, Callable[[Callable[..., Any]], Callable[..., Any]]] = {
    "law": lambda answer: lambda brief: answer,
    "planner": lambda answer: lambda brief: _Planner(answer),
    "bare planner": lambda answer: lambda brief: _Bare(answer),
    "corrector": lambda answer: lambda brief: Pilot(_Planner(_still), _Corrector(answer)),
    "supervisor": lambda answer: (
        lambda brief: Pilot(_Planner(_still), _Corrector(_nothing_to_add), _Supervisor(answer))
    ),
}


@pytest.mark.parametrize("layer", MAKERS)
def test_no_answer_of_ones_own_controller_breaks_a_flight_without_a_sentence(
    layer: str, tmp_path: Path
) -> None:
    """Results are written whatever it was: tables, metrics, and a picture of the last one."""
    settings = FlightSettings(duration_s=1.0, controller="own:law")
    more = [lambda *a, answer=answer: answer for answer in MORE]
    for answer in (*ANSWERS, *more):
        mission = prepare(settings, plugins=Plugins(controller=MAKERS[layer](answer)))
        result = FlightResult(mission, mission.fly())
        assert result.flight.ending in TOLD
        assert result.metrics["reason"].isprintable()
        assert len(result.steps) == len(result.flight.steps)
        assert np.isfinite(result.flight.held_commands()).all() or result.flight.ending in TOLD


@pytest.mark.parametrize("what", ["network", "torque", "metric"])
def test_no_answer_of_ones_own_code_breaks_a_flight_without_a_sentence(what: str) -> None:
    settings = FlightSettings(duration_s=1.0, controller="nmpc-pinn")
    for answer in ANSWERS:
        plugins = {
            "network": Plugins(network=lambda brief, answer=answer: answer),
            "torque": Plugins(torques={"own": answer}),
            "metric": Plugins(metrics={"own": answer}),
        }[what]
        mission = prepare(settings, plugins=plugins)
        try:
            result = FlightResult(mission, mission.fly())
            assert result.flight.ending in TOLD
            assert set(result.metrics) >= {"reason"}
        except PluginError as error:
            told = str(error)
            assert told.isprintable()  # some answers are flown, others refused
