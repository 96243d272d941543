"""What a Dask worker does: one run, in a process of its own that can be stopped."""

from __future__ import annotations

import threading

from guideway import __version__
from guideway.errors import BadParameter
from guideway.lab.child import Child, run_one
from guideway.lab.experiment import Run
from guideway.lab.journal import line_of

_OWN = threading.local()
"""Each thread of the Dask worker has its own process."""


def work(runs: list[Run], digest: str, version: str) -> list[bytes]:
    """The lines of the journal of some runs. Raises :class:`BadParameter` if this machine has another version of Guideway."""
    if version != __version__:
        raise BadParameter(f"a worker of the cluster has guideway {__version__}, this program {version}: install the same everywhere")
    return [_one(run, digest) for run in runs]


def _one(run: Run, digest: str) -> bytes:
    child: Child | None = getattr(_OWN, "child", None)
    if child is None or child.process.poll() is not None:
        child = _OWN.child = Child(run.kind)
    record = run_one(child, run, digest)
    if record["status"] in ("memory", "crashed", "timeout"):
        child.close()
        _OWN.child = None
    return line_of(record)
