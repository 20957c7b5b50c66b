"""Work spread over processes: complete, thread-pinned, and unharmed by workers that die."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from simsat.parallel.pool import WorkerLostError, run_all
from simsat.parallel.processes import SINGLE_THREAD, local_pool
from tests.places import ROOT


def thread_settings(item: int) -> tuple[int, dict[str, str | None]]:
    return item, {name: os.environ.get(name) for name in SINGLE_THREAD}


def die_sometimes(item: tuple[str, Path]) -> str:
    """Kill the own process: never, the first time only, or always."""
    habit, marker = item
    if habit == "always" or (habit == "once" and not marker.exists()):
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return f"{habit} done"


def sleep_unless_first(item: int) -> int:
    if item:
        time.sleep(60.0)
    return os.getpid()


def refuse(item: int) -> int:
    raise ValueError(f"item {item} is not to my taste")


def test_every_item_comes_back_from_single_threaded_workers() -> None:
    before = dict(os.environ)
    results = dict(run_all(local_pool(2), thread_settings, range(9)))
    assert results == {i: (i, SINGLE_THREAD) for i in range(9)}
    assert dict(os.environ) == before


def test_a_worker_that_dies_takes_only_its_own_item_with_it(tmp_path: Path) -> None:
    habits = ["never", "never", "once", "never", "always", "never", "never"]
    items = [(habit, tmp_path / str(i)) for i, habit in enumerate(habits)]
    results = dict(run_all(local_pool(2), die_sometimes, items))
    assert len(results) == len(items)
    for (habit, path), result in results.items():
        if habit == "always":
            assert isinstance(result, WorkerLostError), path
            assert "died again when it flew alone" in str(result)
        else:
            assert result == f"{habit} done"


def test_an_exception_of_the_function_reaches_the_caller() -> None:
    with pytest.raises(ValueError, match="item 0 is not to my taste"):
        list(run_all(local_pool(1), refuse, [0]))


def alive(pid: int) -> bool:
    """Whether the process runs (one that nobody has waited for yet does not)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_until_gone(pid: int, patience: float = 10.0) -> bool:
    end = time.monotonic() + patience
    while alive(pid) and time.monotonic() < end:
        time.sleep(0.05)
    return not alive(pid)


@pytest.mark.skipif(not Path("/proc").exists(), reason="looks at processes through /proc")
def test_leaving_early_stops_the_workers_at_once() -> None:
    started = time.monotonic()
    with contextlib.closing(run_all(local_pool(1), sleep_unless_first, range(4))) as results:
        _, pid = next(results)
    assert isinstance(pid, int)
    assert wait_until_gone(pid)
    assert time.monotonic() - started < 30.0  # s; the next item alone sleeps for 60


@pytest.mark.skipif(not Path("/proc").exists(), reason="looks at processes through /proc")
def test_workers_do_not_outlive_a_killed_parent(tmp_path: Path) -> None:
    script = (
        "from simsat.parallel.pool import run_all\n"
        "from simsat.parallel.processes import local_pool\n"
        "from tests.simsat.parallel.test_pool import sleep_unless_first\n"
        "if __name__ == '__main__':\n"
        "    for _, pid in run_all(local_pool(1), sleep_unless_first, range(3)):\n"
        "        print(pid, flush=True)\n"
    )
    (tmp_path / "parent.py").write_text(script)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [sys.executable, str(tmp_path / "parent.py")],
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
    ) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        assert alive(worker)
        parent.kill()
        assert wait_until_gone(worker)
