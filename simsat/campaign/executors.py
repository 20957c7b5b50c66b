"""Many independent runs in parallel, through the standard `concurrent.futures` interface.

The same code drives processes on this machine and a Dask cluster. Workers never share state, do
their linear algebra on one thread each, and hand results back; the caller keeps them.
"""

import contextlib
import multiprocessing
import os
import signal
import socket
import sys
import threading
import urllib.parse
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, TypeVar

from simsat.control.ground.errors import SettingsError, SimsatError

Item = TypeVar("Item")
Result = TypeVar("Result")

SINGLE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "VECLIB_MAXIMUM_THREADS": "1",
    "NUMEXPR_NUM_THREADS": "1",
}
QUEUED_PER_WORKER = 2  # the one that runs and the next: memory stays flat, workers never wait
PATIENCE_S = 10.0  # for a scheduler to answer
ONE_AT_A_TIME = threading.Lock()  # CasADi is not safe to use from several threads


class WorkerLostError(SimsatError):
    """The process that worked on an item died, twice where that can be told apart from chance."""


class PoolLostError(SimsatError):
    """No worker can be reached any more."""


@dataclass(frozen=True)
class Pool:
    """Somewhere to run things."""

    name: str
    workers: int
    open: Callable[[int], AbstractContextManager[Executor]]
    """Called with the number of workers wanted; a cluster gives what it has."""


def local_pool(workers: int) -> Pool:
    """Processes on this machine, started afresh (no inherited state)."""
    return Pool(f"{workers} process{'es' * (workers > 1)}", workers, _processes)


def cluster_pool(address: str) -> Pool:
    """The workers of a Dask scheduler, `tcp://host:port`.

    Raises `SettingsError` if `distributed` is not installed or nobody answers. Workers need this
    project installed, and the model files at the same paths.
    """
    client = _connect(address)
    workers = max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
    client.close()
    return Pool(f"cluster {address}, {workers} worker(s)", workers, lambda _: _cluster(address))


def run_all(
    pool: Pool, function: Callable[[Item], Result], items: Iterable[Item]
) -> Generator[tuple[Item, Result | WorkerLostError], None, None]:
    """Pairs of an item and its result, in the order in which they finish.

    A worker that dies takes nothing with it: its items run again, each alone in a process of its
    own, and one that kills that process too comes back as a `WorkerLostError`. An exception that
    `function` raises ends everything; leaving the iterator early stops the workers at once.
    """
    waiting = deque(items)
    while waiting:
        suspects = yield from _until_broken(pool, function, waiting)
        for item in suspects:
            yield item, _alone(pool, function, item)


def _until_broken(
    pool: Pool, function: Callable[[Item], Result], waiting: deque[Item]
) -> Generator[tuple[Item, Result | WorkerLostError], None, list[Item]]:
    """Works through `waiting`; returns the items in flight if the executor breaks."""
    in_flight: dict[Future[Result], Item] = {}
    with pool.open(pool.workers) as executor:
        while waiting or in_flight:
            try:
                while waiting and len(in_flight) < QUEUED_PER_WORKER * pool.workers:
                    in_flight[executor.submit(_guarded, function, waiting[0])] = waiting[0]
                    waiting.popleft()
            except BrokenExecutor:
                return list(in_flight.values())
            done, _ = wait(in_flight, return_when=FIRST_COMPLETED)
            for future in done:
                error = _error(future)
                if isinstance(error, BrokenExecutor):
                    return list(in_flight.values())
                yield in_flight.pop(future), _outcome(future, error)
    return []


def _error(future: Future[Any]) -> BaseException | None:
    try:
        return future.exception()
    except CancelledError:  # Dask cancels what it knows when its scheduler is gone
        raise PoolLostError("the connection to the Dask scheduler was lost") from None


def _outcome(future: Future[Any], error: BaseException | None) -> Any:
    if type(error).__name__ == "KilledWorker":  # Dask's word for it, after its own retries
        return WorkerLostError("the worker process died whenever it got this run")
    return future.result()


def _alone(pool: Pool, function: Callable[[Item], Result], item: Item) -> Result | WorkerLostError:
    with pool.open(1) as executor:
        try:
            return executor.submit(_guarded, function, item).result()
        except BrokenExecutor:
            return WorkerLostError("the process flying it died, and died again when it flew alone")


def _guarded(function: Callable[[Item], Result], item: Item) -> Result:
    """What a worker runs: one item at a time, on one thread."""
    with ONE_AT_A_TIME:
        if "torch" in sys.modules:
            sys.modules["torch"].set_num_threads(1)
        return function(item)


@contextlib.contextmanager
def _processes(workers: int) -> Iterator[Executor]:
    before = set(multiprocessing.active_children())
    executor = ProcessPoolExecutor(
        workers, mp_context=multiprocessing.get_context("spawn"), initializer=_start_worker
    )
    with _environment(SINGLE_THREAD):  # processes start on demand and read it on import
        try:
            yield executor
        except BaseException:
            for child in set(multiprocessing.active_children()) - before:
                child.terminate()
            raise
        finally:
            executor.shutdown(cancel_futures=True)


def _start_worker() -> None:
    """Leave Ctrl-C to the parent, and do not outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_die_with_parent, daemon=True).start()


def _die_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "a worker has a parent"
    parent.join()
    os._exit(1)


@contextlib.contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextlib.contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    client = _connect(address)
    try:
        yield client.get_executor(pure=False)
    finally:
        client.close(timeout=PATIENCE_S)


def _connect(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise SettingsError("--cluster needs Dask: pip install 'simsat[cluster]'") from None
    place = urllib.parse.urlsplit(address if "//" in address else f"tcp://{address}")
    try:
        socket.create_connection((place.hostname, place.port), PATIENCE_S).close()
        return Client(address, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise SettingsError(f"no Dask scheduler answers at '{address}': {error}") from error
