"""Runs on many machines with Dask distributed: workers may come and go, records come home and are written here alone."""

from __future__ import annotations

import itertools
import json
import logging
import os
import re
from collections.abc import Generator, Iterator, Sequence
from contextlib import ExitStack
from itertools import islice
from typing import Any

from guideway import __version__
from guideway.errors import BadParameter, GuidewayError
from guideway.io.files import show
from guideway.lab.execute import blank
from guideway.lab.experiment import Run
from guideway.lab.extra import needed
from guideway.lab.journal import Record
from guideway.lab.remote import work

ALLOWED = "local, local:N (N workers on this machine), or dask://HOST:PORT of a Dask scheduler"

PATIENCE = 60
"""How long the first worker may take to come, s."""

CONNECT = 10
"""How long the scheduler may take to answer, s."""

FLIGHTS = 256
"""Tasks that the scheduler knows at a time, for each thread of its first workers at least two."""

PORTION = 1.0
"""Short runs are handed out together, so many that they take about this long, s ..."""

MOST = 50
"""... and no more."""

ATTEMPTS = 5
"""A run during which so many workers died one after the other is given up; each of Dask's own attempts counts several."""

_PLACE = re.compile(r"dask://([^/\s]+:\d{1,5})/?")
_LOCAL = re.compile(r"local(?::(\d{1,4}))?")


class Cluster:
    """A Dask cluster, connected to when it is first used, until it is closed."""

    def __init__(self, cluster: str) -> None:
        """Raises :class:`BadParameter` for what is neither a place nor local."""
        self._told, self._stack = cluster, ExitStack()
        self._local, self._place = _LOCAL.fullmatch(cluster), _PLACE.fullmatch(cluster)
        self._client: Any = None
        if self._local is None and self._place is None:
            raise BadParameter(f"--cluster {show(cluster)} cannot be read: {ALLOWED}")
        self._dask = needed("distributed", "cluster", "runs on a cluster need Dask")

    def records(self, runs: Sequence[Run], digest: str) -> Generator[Record, None, None]:
        """The records of all runs, as they come. Raises :class:`GuidewayError` if the cluster cannot be reached or is lost."""
        if runs:
            yield from _through(self._dask, self._connected(), runs, digest)

    def _connected(self) -> Any:
        if self._client is None:
            address: Any = f"tcp://{self._place[1]}" if self._place is not None else ""
            if self._local is not None:
                address = self._stack.enter_context(_small(self._dask, int(self._local[1] or os.cpu_count() or 1)))
            self._client = self._stack.enter_context(_client(self._dask, address, self._told))
        return self._client

    def close(self) -> None:
        """Leaves it; a small one here ends."""
        self._client = None
        self._stack.close()


def _small(dask: Any, workers: int) -> Any:
    """A cluster on this machine."""
    if not 1 <= workers <= 1024:
        raise BadParameter(f"--cluster local:{workers} is out of range: 1 to 1024 workers")
    more: dict[str, Any] = {"host": "127.0.0.1", "dashboard_address": None, "memory_limit": 0, "silence_logs": logging.CRITICAL}
    return dask.LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, **more)


def _client(dask: Any, address: Any, cluster: str) -> Any:
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what matters is told here
    try:
        client = dask.Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError) as error:
        todo = "check that the scheduler runs (dask scheduler) and that its port can be reached"
        raise GuidewayError(f"the cluster {cluster} cannot be reached ({error}): {todo}") from error
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except Exception as error:
        client.close()
        todo = f"start some with 'dask worker {getattr(address, 'scheduler_address', address)} --nthreads 1' on machines that have guideway[cluster]"
        raise GuidewayError(f"the cluster {cluster} has no workers after {PATIENCE} s: {todo}") from error
    return client


def _through(dask: Any, client: Any, runs: Sequence[Run], digest: str) -> Iterator[Record]:
    """Hands out runs, short ones several at a time, and takes their records; those that died with their worker are handed out again."""
    rest = iter(runs)
    flights: dict[str, tuple[list[Run], int]] = {}
    numbers = itertools.count()

    def flight(some: list[Run], attempt: int = 0) -> Any:
        key = f"guideway-{runs[0].experiment}-{digest[:12]}-{os.getpid()}-{next(numbers)}"
        flights[key] = (some, attempt)
        return client.submit(work, some, digest, __version__, key=key, pure=False)

    first = [flight([run]) for run in islice(rest, max(FLIGHTS, 2 * sum(client.nthreads().values())))]
    flow = dask.as_completed(first, loop=client.loop, with_results=True, raise_errors=False)
    size = 1
    for future, result in flow:
        some, attempt = flights.pop(future.key)
        if future.status == "finished":
            records: list[Record] = [json.loads(line) for line in result]
            mean = sum(record["times"].get("wall", PORTION) for record in records) / len(records)
            size = max(1, min(MOST, int(PORTION / max(mean, 1e-6))))
        else:
            records = [_lost(dask, future, run, digest) for run in some]
            if attempt + 1 < ATTEMPTS:
                for run in some:  # one by one, to find the one that is to blame
                    flow.add(flight([run], attempt + 1))
                continue
        yield from records
        more = list(islice(rest, size))
        if more:
            flow.add(flight(more))


def _lost(dask: Any, future: Any, run: Run, digest: str) -> Record:
    """The record of a run whose workers died. Raises :class:`GuidewayError` for what would befall every run."""
    error = future.exception(timeout=20) if future.status == "error" else None
    if isinstance(error, dask.scheduler.KilledWorker):
        return blank(run, digest, "crashed", {"type": "KilledWorker", "message": "the workers of the cluster died during it again and again"})
    if isinstance(error, GuidewayError):
        raise error
    said = f"{type(error).__name__}: {error}" if error is not None else f"a run was {future.status}"
    raise GuidewayError(f"the cluster does not work ({said}); the records so far are whole. Put it right, then go on with --resume")
