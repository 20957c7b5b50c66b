"""Campaigns that fly in this very process: nothing to start, and monkeypatching reaches them."""

from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager

from simsat.parallel.pool import Pool


@contextmanager
def here(workers: int) -> Iterator[Executor]:
    """One thread of this process."""
    with ThreadPoolExecutor(1) as executor:
        yield executor


HERE = Pool("here", 1, here)
