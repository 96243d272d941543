"""A worker process as its owner sees it."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import time
from collections import deque
from multiprocessing.connection import Pipe
from typing import Any

from guideway.errors import GuidewayError
from guideway.lab.execute import blank
from guideway.lab.experiment import Run
from guideway.lab.journal import Record, key_of
from guideway.lab.own import is_own

START = 120.0
"""A worker that is not there after so long is given up, s."""

LEAVES = ("memory", "crashed")
"""After such a record what is left of a worker is not to be trusted: it ends itself."""

SINGLE = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "NUMBA", "RAYON", "VECLIB_MAXIMUM", "BLIS")
"""Libraries that are told to use one thread."""

Item = tuple[Run, str]
"""A run and the digest of its experiment."""


def owner(run: Run) -> str:
    """A user's own planner by file and name, "" for those that are ours: what it does to its process no other planner is to see."""
    planner = run.method.get("planner")
    return f"{run.folder}/{planner}" if isinstance(planner, str) and is_own(planner) else ""


class Child:
    """A worker process. Runs are put in, records come out in the same order; it is killed when a run takes too long."""

    def __init__(self, kind: str) -> None:
        """``kind`` is loaded before the first run, whose time does not count it."""
        if sys.platform == "win32":
            raise GuidewayError("guideway lab runs on Linux and macOS; on Windows use WSL")
        self.kind = kind
        self.connection, theirs = Pipe()
        self.waiting: deque[Item] = deque()
        self.since = time.monotonic()
        self.last = 0.0
        """What the last run took, s."""
        self.ready = False
        self.owner = ""
        """Whose planner it has run last: see :func:`owner`."""
        self.big = False
        """Was the last run put in so large that another could fill the socket?"""
        self._leaving = False
        self._said = tempfile.TemporaryFile()  # noqa: SIM115, it lives as long as the process
        single = {f"{name}_NUM_THREADS": "1" for name in SINGLE}
        command = [sys.executable, "-m", "guideway.lab.worker", str(theirs.fileno()), str(os.getpid())]
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=self._said,
            stderr=self._said,
            pass_fds=[theirs.fileno()],
            env=os.environ
            | single
            | {"PYTHONHASHSEED": "0", "PYTHONSAFEPATH": "1", "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
            start_new_session=True,  # Ctrl-C is for its owner, and its own children end with it
        )
        theirs.close()
        with contextlib.suppress(OSError):  # it has died at once: failed() tells
            self.connection.send((sys.path, kind))

    def put(self, item: Item) -> None:
        """One more run to do."""
        if not self.waiting:
            self.since = time.monotonic()
        self.waiting.append(item)
        self.owner = owner(item[0])
        data = pickle.dumps(item)
        self.big = len(data) > 1 << 13
        with contextlib.suppress(OSError):  # it has died: the next take() tells
            self.connection.send_bytes(data)

    @property
    def deadline(self) -> float:
        """When the run at work has had its time, in the time of ``time.monotonic``."""
        if not self.ready:
            return self.since + START
        return self.since + self.waiting[0][0].limits["seconds"] if self.waiting else float("inf")

    def take(self) -> list[Record]:
        """Records that are there by now. Raises ``EOFError`` if the process has ended and all of its records were taken."""
        found: list[Record] = []
        try:
            while self.connection.poll():
                data = self.connection.recv_bytes()
                now = time.monotonic()
                if not self.ready:
                    self.ready = True
                else:
                    found += self._accepted(data)
                    self.last = now - self.since
                self.since = now
        except (OSError, EOFError):
            if not found:
                raise EOFError from None
        return found

    def _accepted(self, data: bytes) -> list[Record]:
        """The record of the run at work. Raises ``EOFError`` for anything else, after which the process is not to be trusted."""
        try:
            record: Record = json.loads(data)
            key = key_of(record)
        except (ValueError, TypeError, KeyError):  # the method wrote to what is not its own
            self.kill()
            raise EOFError from None
        if not self.waiting or self.waiting[0][0].key != key:  # it has become two processes
            self._leaving = True
            self.kill()
            raise EOFError
        self._leaving = record["status"] in LEAVES
        self.waiting.popleft()
        return [record]

    def overdue(self) -> bool:
        """Has the run at work had its time?"""
        return time.monotonic() > self.deadline

    def failed(self) -> Record | None:
        """The process has ended, or is ended now because its run had its time: the record of the run at work, None if there was none.

        Raises ``GuidewayError`` if it never began to work.
        """
        late = self.overdue()
        if late:
            self.kill()
        code = self._ended()
        if not self.ready:
            self._said.seek(0)
            tail = " ".join(self._said.read().decode(errors="replace").split())[-300:]
            raise GuidewayError(f"the workers of the lab do not start (exit status {code}): {tail or 'no message'}")
        if not self.waiting or self._leaving:
            return None
        run, digest = self.waiting.popleft()
        if late:
            return blank(run, digest, "timeout", {"type": "Timeout", "message": f"it takes longer than {run.limits['seconds']:g} s"})
        return blank(run, digest, "crashed", {"type": "Crashed", "message": _end(code)})

    def _ended(self) -> int:
        try:
            return self.process.wait(5)
        except subprocess.TimeoutExpired:  # it closed its socket and goes on
            self.kill()
            return self.process.wait()

    def kill(self) -> None:
        """Ends the process and those that it started."""
        with contextlib.suppress(OSError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()

    def close(self) -> None:
        """Ends it, whatever it does."""
        self.kill()
        self.process.wait()
        self.connection.close()
        self._said.close()


def _end(code: int) -> str:
    if code >= 0:
        return f"its process ended with exit status {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    return f"its process was ended by {name}" + (", as the system does when memory runs out" if name == "SIGKILL" else "")


def run_one(child: Child, run: Run, digest: str) -> Record:
    """Waits for the record of one run. The child may be dead after it: see ``child.process.poll()``."""
    child.put((run, digest))
    while True:
        child.connection.poll(max(0.0, min(1.0, child.deadline - time.monotonic())))
        try:
            found: list[Any] = child.take()
        except EOFError:
            found = [child.failed()]
        else:
            if not found and child.overdue():
                found = [child.failed()]
        if found and found[0] is not None:
            return found[0]
