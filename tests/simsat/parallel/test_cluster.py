"""A campaign on a real Dask scheduler with two worker processes over loopback, one of them killed.

Workers run without a nanny: a killed one stays away, as a lost machine would.
"""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from simsat.campaign.attitudes import spiral_attitudes
from simsat.campaign.command import fly_missing
from simsat.campaign.rows import read_records
from simsat.campaign.run import CampaignRun, RunResult, fly_run, plan_runs
from simsat.campaign.table import as_table, flat_rows
from simsat.control.ground.errors import SettingsError
from simsat.parallel import cluster as cluster_module
from simsat.parallel.cluster import cluster_pool
from simsat.parallel.pool import Pool, PoolLostError, WorkerLostError, run_all
from simsat.parallel.processes import SINGLE_THREAD
from simsat.settings import FlightSettings
from tests.campaign_cases import HERE
from tests.places import ROOT

pytest.importorskip("distributed")

PATIENCE_S = 60.0  # for a process to start on a busy machine


@dataclass(frozen=True)
class Cluster:
    address: str
    scheduler: subprocess.Popen[bytes]
    workers: tuple[subprocess.Popen[bytes], ...]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with running(tmp_path_factory.mktemp("cluster"), workers=2) as started:
        yield started


@contextlib.contextmanager
def running(
    folder: Path, workers: int, protocol: str = "tcp", **variables: str
) -> Iterator[Cluster]:
    contact = folder / "scheduler.json"
    told = {"PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "ignore"}
    environment = os.environ | SINGLE_THREAD | told | variables
    started: list[subprocess.Popen[bytes]] = []

    def start(tool: str, *flags: str) -> subprocess.Popen[bytes]:
        module = ["-m", f"distributed.cli.dask_{tool}", "--no-dashboard", *flags]
        log = (folder / f"{tool}-{len(started)}.log").open("wb")
        with log:
            process = subprocess.Popen(
                [sys.executable, *module], stderr=log, stdout=log, env=environment
            )
        started.append(process)
        return process

    try:
        place = ("--host", "127.0.0.1", "--port", "0", "--protocol", protocol)
        scheduler = start("scheduler", *place, "--scheduler-file", str(contact))
        address = wait_for(lambda: json.loads(contact.read_text())["address"])
        flags = ("--nthreads", "1", "--no-nanny")
        yield Cluster(
            address, scheduler, tuple(start("worker", address, *flags) for _ in range(workers))
        )
    finally:
        for process in started:
            process.kill()
            process.wait()


def wait_for(question: Any) -> Any:
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        with contextlib.suppress(OSError, ValueError, LookupError):
            answer = question()
            if answer:
                return answer
        time.sleep(0.05)
    raise TimeoutError("the cluster did not come up")


def with_workers(cluster: Cluster, count: int) -> Pool:
    def question() -> Pool | None:
        pool = cluster_pool(cluster.address)
        return pool if pool.workers >= count else None

    pool: Pool = wait_for(question)
    return pool


def fly_slowly(run: CampaignRun) -> RunResult:
    time.sleep(0.3)  # long enough for the kill to fall into a run
    return fly_run(run)


def test_a_worker_killed_half_way_changes_nothing(cluster: Cluster, tmp_path: Path) -> None:
    base = FlightSettings(duration_s=2.0)
    runs = plan_runs(base, ("nmpc",), spiral_attitudes(12), ({},))
    pool = with_workers(cluster, 2)
    assert "2 worker(s)" in pool.name
    flown = dict[int, dict[str, Any]]()
    for run, result in run_all(pool, fly_slowly, runs):
        assert isinstance(result, RunResult)
        flown[run.index] = result.record
        if len(flown) == 4:
            cluster.workers[0].kill()
    workers = {record["timing"]["worker"] for record in flown.values()}
    assert len(workers) == 2  # both took part
    alone = tmp_path / "alone"
    alone.mkdir()
    fly_missing(alone, runs, HERE)
    records = [flown[i] for i in range(len(runs))]
    assert as_table(flat_rows(records)).equals(as_table(flat_rows(read_records(alone))))


def test_losing_the_scheduler_is_said(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = plan_runs(FlightSettings(duration_s=1.0), ("nmpc",), spiral_attitudes(40), ({},))
    pool = with_workers(cluster, 1)
    monkeypatch.setattr(cluster_module, "PATIENCE_S", 1.0)
    results = run_all(pool, fly_slowly, runs)
    next(results)
    cluster.scheduler.kill()
    with pytest.raises(PoolLostError, match="the connection to the Dask scheduler was lost"):
        list(results)


def test_a_run_that_kills_every_worker_is_given_up() -> None:
    from distributed.scheduler import KilledWorker

    class Deadly(ThreadPoolExecutor):
        def submit(self, *arguments: Any, **keywords: Any) -> Future[Any]:
            future: Future[Any] = Future()
            future.set_exception(KilledWorker("run-1", None, 3))
            return future

    ((item, result),) = run_all(Pool("cluster", 1, Deadly), str, ["run-1"])
    assert item == "run-1"
    assert isinstance(result, WorkerLostError)
    assert "the worker process died whenever it got this run" in str(result)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "127.0.0.1:9", "nowhere"])
def test_a_scheduler_that_does_not_answer_is_named(address: str) -> None:
    with pytest.raises(SettingsError, match=f"no Dask scheduler answers at '{address}'"):
        cluster_pool(address)


@pytest.mark.skipif(shutil.which("openssl") is None, reason="makes a certificate with openssl")
def test_an_encrypted_cluster_takes_only_those_with_a_certificate(tmp_path: Path) -> None:
    import dask

    with pytest.raises(SettingsError, match=r"needs certificates: set DASK_DISTRIBUTED__COMM__TLS"):
        cluster_pool("tls://127.0.0.1:9")
    certificate, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2",
         "-subj", "/CN=simsat", "-keyout", str(key), "-out", str(certificate)],
        check=True, capture_output=True,
    )  # fmt: skip
    tls: dict[str, Any] = {"distributed.comm.tls.ca-file": str(certificate)}
    for role in ("scheduler", "worker", "client"):
        tls[f"distributed.comm.tls.{role}.cert"] = str(certificate)
        tls[f"distributed.comm.tls.{role}.key"] = str(key)
    variables = {
        f"DASK_{name.upper().replace('-', '_').replace('.', '__')}": value
        for name, value in tls.items()
    }
    variables["DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION"] = "True"
    with running(tmp_path, 1, "tls", **variables) as cluster:
        assert cluster.address.startswith("tls://127.0.0.1:")
        with dask.config.set(tls):
            results = dict(run_all(with_workers(cluster, 1), after, [0, 1]))
        plain = cluster.address.replace("tls", "tcp")
        with pytest.raises(SettingsError, match="no Dask scheduler answers at 'tcp://"):
            cluster_pool(plain)
    assert results == {0: 1, 1: 2}


def after(index: int) -> int:
    return index + 1
