"""The program of a worker process: takes runs from its end of a pair of sockets and sends back a line of the journal for each.

Started as ``python -m guideway.lab.worker FD PARENT``. It is a program of its own, not a fork: threads, locks and imports of the program that started
it cannot get in its way, ``__main__`` is not imported again, and a Dask worker, which may not use ``multiprocessing``, can have one.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import pickle
import signal
import sys
from multiprocessing.connection import Connection

GRACE = 30.0
"""A worker that nobody stopped ends itself so long after the time limit of its run, s."""


def main() -> None:
    """Works until the other end is closed."""
    connection = Connection(int(sys.argv[1]))
    _die_with(int(sys.argv[2]))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        sys.path[:], kind = connection.recv()
        from guideway.lab import kinds
        from guideway.lab.child import LEAVES
        from guideway.lab.execute import execute
        from guideway.lab.journal import line_of

        with contextlib.suppress(Exception):  # each run will tell
            kinds.load(kind)
        connection.send_bytes(b"ready")
        _hush()
        while True:
            run, digest = pickle.loads(connection.recv_bytes())
            signal.setitimer(signal.ITIMER_REAL, run.limits["seconds"] + GRACE)
            record = execute(run, digest)
            signal.setitimer(signal.ITIMER_REAL, 0)
            connection.send_bytes(line_of(record))
            if record["status"] in LEAVES:
                break
    except (EOFError, ConnectionError):
        pass
    os._exit(0)  # threads that a method left behind do not hold it up


def _die_with(parent: int) -> None:
    """Ends this process with its parent, however that ends, where the system can do it."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(1, signal.SIGKILL, 0, 0, 0)  # PR_SET_PDEATHSIG
    if os.getppid() != parent:
        os._exit(0)


def _hush() -> None:
    """What methods print goes nowhere."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(nowhere, descriptor)


if __name__ == "__main__":
    main()
