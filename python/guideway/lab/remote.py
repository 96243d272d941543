"""What a Dask worker does: one run, in a process of its own that can be stopped."""

from __future__ import annotations

import threading

from guideway import __version__
from guideway.errors import BadParameter
from guideway.lab.child import Child, owner, run_one
from guideway.lab.experiment import Run
from guideway.lab.journal import line_of

_OWN = threading.local()
"""Each thread of the Dask worker has its own processes, by the owner of the planner."""

MOST = 4
"""Processes of a thread."""


def work(runs: list[Run], digest: str, version: str) -> list[bytes]:
    """The lines of the journal of some runs. Raises :class:`BadParameter` if this machine has another version of Guideway."""
    if version != __version__:
        raise BadParameter(f"a worker of the cluster has guideway {__version__}, this program {version}: install the same everywhere")
    return [_one(run, digest) for run in runs]


def _one(run: Run, digest: str) -> bytes:
    children: dict[str, Child] = _OWN.__dict__.setdefault("children", {})
    whose = owner(run)
    child = children.pop(whose, None)
    if child is None or child.process.poll() is not None or child.kind != run.kind:
        if child is not None:
            child.close()
        child = Child(run.kind)
    children[whose] = child  # the last is that which was used last
    while len(children) > MOST:
        children.pop(next(iter(children))).close()
    record = run_one(child, run, digest)
    if record["status"] in ("memory", "crashed", "timeout"):
        children.pop(whose).close()
    return line_of(record)
