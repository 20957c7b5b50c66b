"""The workers of a Dask cluster."""

import contextlib
import socket
import urllib.parse
from collections.abc import Iterator
from concurrent.futures import Executor
from typing import Any

from simsat.control.ground.errors import SettingsError
from simsat.parallel.pool import Pool

PATIENCE_S = 10.0  # for a scheduler to answer


def cluster_pool(address: str) -> Pool:
    """The workers of a Dask scheduler, `tcp://host:port`, or `tls://host:port` with certificates
    from Dask's configuration.

    Raises `SettingsError` if `distributed` is not installed, nobody answers, or there are no
    certificates. Workers need this project installed, and the model files at the same paths.
    """
    client = _connect(address)
    workers = max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
    client.close()
    return Pool(f"cluster {address}, {workers} worker(s)", workers, lambda _: _cluster(address))


@contextlib.contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    client = _connect(address)
    try:
        yield client.get_executor(pure=False)
    finally:
        client.close(timeout=PATIENCE_S)


def _connect(address: str) -> Any:
    try:
        from distributed import Client, Security
    except ImportError:
        raise SettingsError("--cluster needs Dask: pip install 'simsat[cluster]'") from None
    place = urllib.parse.urlsplit(address if "//" in address else f"tcp://{address}")
    try:
        certified = Security().get_connection_args("client").get("ssl_context") is not None
        if place.scheme == "tls" and not certified:
            raise SettingsError(
                f"--cluster {address} needs certificates: set DASK_DISTRIBUTED__COMM__TLS__CA_FILE"
                ", ..._TLS__CLIENT__CERT and ..._TLS__CLIENT__KEY (see docs/campaign.md)"
            )
        socket.create_connection((place.hostname, place.port), PATIENCE_S).close()
        return Client(address, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise SettingsError(f"no Dask scheduler answers at '{address}': {error}") from error
