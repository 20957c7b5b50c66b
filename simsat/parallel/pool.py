"""Many independent calls in parallel, through the standard `concurrent.futures` interface.

The same code drives processes on this machine and a Dask cluster. Workers never share state, do
their linear algebra on one thread each, and hand results back; the caller keeps them.
"""

import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, TypeVar

from simsat.control.ground.errors import SimsatError

Item = TypeVar("Item")
Result = TypeVar("Result")

QUEUED_PER_WORKER = 2  # the one that runs and the next: memory stays flat, workers never wait
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
