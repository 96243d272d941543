"""How far one planning call makes the memory of a process grow: measured in a process of its own, where nothing was freed before."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from guideway.errors import GuidewayError

CLEAR, STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")
PATIENCE = 600.0
"""Seconds that the process may take."""


def growth(run: Any) -> float | None:
    """MiB that the peak resident memory grew by during the planning call of a run; None where the system does not tell."""
    job = {key: value for key, value in asdict(run).items() if key not in ("limits",)}
    command = [sys.executable, "-c", "from guideway.lab.kinds.heap import main; main()"]
    done = subprocess.run(command, input=json.dumps(job, default=str), capture_output=True, text=True, timeout=PATIENCE, check=False)
    told = done.stdout.strip()
    return float(told) if done.returncode == 0 and told not in ("", "None") else None


def main() -> None:
    """Reads a run from stdin, prints the growth."""
    print(measured(json.loads(sys.stdin.read())))


def measured(job: dict[str, Any]) -> float | None:
    """The growth during one call in this process, after a short one that loads what is loaded once."""
    from guideway.lab import planning, worlds
    from guideway.records import Budget

    query = worlds.query(job["world"], {**job["query"], **job["method"].get("query", {})}, job["folder"], job["seed"])
    call = planning.planner(job["method"], job["folder"])
    with contextlib.suppress(GuidewayError):
        call(query, job["seed"] + 1, Budget(evaluations=200))
    try:
        CLEAR.write_text("5")
        before = _status("VmRSS")
        with contextlib.suppress(GuidewayError):  # a search in vain takes memory too
            call(query, job["seed"], Budget(**job["budget"]))
        return max(0.0, _status("VmHWM") - before)
    except (OSError, StopIteration):
        return None


def _status(name: str) -> float:
    line = next(line for line in STATUS.read_text().splitlines() if line.startswith(name))
    return int(line.split()[1]) / 1024
