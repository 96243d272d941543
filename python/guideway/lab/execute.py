"""One run, here and now: its record, whatever the method does."""

from __future__ import annotations

import contextlib
import functools
import math
import os
import platform
import random
import re
import sys
import time
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from guideway import __version__
from guideway.errors import GuidewayError
from guideway.lab import kinds
from guideway.lab.experiment import Run
from guideway.lab.journal import SCHEMA, Record

_ADDRESS = re.compile(r"0x[0-9a-fA-F]{4,}")
_MIB = 1 << 20


def execute(run: Run, digest: str) -> Record:
    """Runs it under its memory limit; refusals, errors, lack of memory and invalid results become the record's ``status`` and ``error``.

    The global generators of ``random`` and NumPy begin with the run's seed, so that methods that draw from them can be repeated.
    """
    random.seed(run.seed)
    np.random.seed(run.seed % (1 << 32))
    _forget_peak()
    wall, cpu = time.perf_counter(), time.process_time()
    found = _outcome(run)
    times = {"wall": time.perf_counter() - wall, "cpu": time.process_time() - cpu}
    record = blank(run, digest)
    own = found.pop("times")
    record.update(found)
    record["times"] = times | {name: float(value) for name, value in own.items() if math.isfinite(value)}
    record["peak_mib"] = _peak()
    return record


def blank(run: Run, digest: str, status: str = "ok", error: Mapping[str, str] | None = None) -> Record:
    """The record of a run that says nothing yet."""
    world, query, method, seed = run.key
    return {
        "schema": SCHEMA,
        "experiment": run.experiment,
        "digest": digest,
        "world": world,
        "query": query,
        "method": method,
        "seed": seed,
        "status": status,
        "error": None if error is None else dict(error),
        "measures": {},
        "curve": None,
        "path": None,
        "certified": None,
        "times": {},
        "peak_mib": None,
        "version": __version__,
        "machine": machine(),
    }


def _outcome(run: Run) -> Record:
    """``status``, ``error`` and what was measured."""
    try:
        with _memory(run.limits["memory_mib"]):
            found = kinds.load(run.kind).run(run)
    except MemoryError:
        return _bad("memory", "MemoryError", f"it needs more than {run.limits['memory_mib']:g} MiB of memory")
    except kinds.NotAResult as error:
        return _bad("invalid", "NotAPath", _said(error))
    except Exception as error:
        return _bad("failed", type(error).__name__, _said(error))
    except BaseException as error:  # a panic of a compiled planner, SystemExit
        return _bad("crashed", type(error).__name__, _said(error))
    return _checked(found)


def _checked(found: kinds.Outcome) -> Record:
    """The outcome as plain, finite data; a result that is none is invalid."""
    holes: list[str] = []
    try:
        measures = {str(name): _plain(value, name, holes) for name, value in found.measures.items()}
        curve, path = (_rows(rows, name, holes) for rows, name in ((found.curve, "curve"), (found.path, "path")))
    except Exception as error:
        return _bad("invalid", "NotAnOutcome", _said(error))
    status, error = "ok", None
    if holes:
        status, error = "invalid", {"type": "NotFinite", "message": f"not finite: {', '.join(dict.fromkeys(holes))}"}
    elif found.certified is False:
        status, error = "invalid", {"type": "CertificateFailed", "message": "the independent checker refused the result"}
    certified = None if found.certified is None else bool(found.certified)
    kept = {"measures": measures, "curve": curve, "path": path, "certified": certified, "times": found.times}
    return {"status": status, "error": error} | kept


def _plain(value: Any, name: str, holes: list[str]) -> float | int | bool | None:
    """A value as JSON has it; None where it is not finite."""
    if value is None or isinstance(value, (bool, int)):
        return value
    item = value.item() if hasattr(value, "item") else value  # of NumPy
    if isinstance(item, (bool, int)):
        return item
    number = float(item)
    if not math.isfinite(number):
        holes.append(name)
        return None
    return number


def _rows(rows: Any, name: str, holes: list[str]) -> list[list[Any]] | None:
    return None if rows is None else [[_plain(value, name, holes) for value in row] for row in rows]


def _bad(status: str, kind: str, message: str) -> Record:
    return {"status": status, "error": {"type": kind, "message": message}, "times": {}}


def _said(error: BaseException) -> str:
    """The message of an error without what differs from run to run."""
    with contextlib.suppress(Exception):
        text = " ".join(_ADDRESS.sub("0x...", str(error)).encode("utf-8", "replace").decode().split())
        return text if isinstance(error, GuidewayError) else text[:500]
    return ""


@contextlib.contextmanager
def _memory(limit: float) -> Iterator[None]:
    """At most so many MiB of memory for data, where the system can limit it."""
    if sys.platform == "win32":
        yield
        return
    import resource

    which = resource.RLIMIT_DATA if sys.platform == "linux" else resource.RLIMIT_AS
    before = resource.getrlimit(which)
    wanted = int(limit * _MIB)
    soft = wanted if before[1] == resource.RLIM_INFINITY else min(wanted, before[1])
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(which, (soft, before[1]))
    try:
        yield
    finally:
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(which, before)


def _forget_peak() -> None:
    with contextlib.suppress(OSError), open("/proc/self/clear_refs", "w") as file:
        file.write("5")


def _peak() -> float | None:
    """Most memory that was in use since :func:`_forget_peak`, MiB."""
    with contextlib.suppress(OSError, ValueError), open("/proc/self/status", "rb") as file:
        for line in file:
            if line.startswith(b"VmHWM:"):
                return round(int(line.split()[1]) / 1024, 1)
    return None


@functools.cache
def machine() -> str:
    """Processor, number of cores, system and Python of this machine."""
    name = platform.processor() or platform.machine()
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
        name = next((line.partition(":")[2].strip() for line in file if line.startswith("model name")), name)
    return f"{name}, {os.cpu_count()} cores, {platform.system()} {platform.release()}, Python {platform.python_version()}"
