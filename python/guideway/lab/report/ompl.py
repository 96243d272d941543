"""Benchmark logs in the format of OMPL, which its ``ompl_benchmark_statistics.py`` and Planner Arena read: one per world and query."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from guideway.files import write_whole
from guideway.lab.cells import Cell, Grid, Instance, Record, is_sound, numbers, seed_of, spent
from guideway.lab.curves import usable

from .loading import Loaded

STATUS = ("Unknown status", "Invalid start", "Invalid goal", "Unrecognized goal type", "Timeout", "Approximate solution", "Exact solution", "Crash")
ENDS = {"ok": 6, "timeout": 4, "crashed": 7, "memory": 7}
GOAL, START = ("GoalBlocked",), ("StartBlocked", "OutsideMap")
FIRST = (
    ("time", "REAL"),
    ("memory", "REAL"),
    ("solved", "BOOLEAN"),
    ("correct_solution", "BOOLEAN"),
    ("status", "ENUM"),
    ("solution_length", "REAL"),
)
MOST_STEPS = 60
"""Points of a convergence curve in a log."""


def write_logs(found: Sequence[Loaded], folder: Path) -> list[Path]:
    """``EXPERIMENT-WORLD-QUERY.log`` for every world and query."""
    folder.mkdir(parents=True, exist_ok=True)
    written: dict[str, Path] = {}
    for loaded in found:
        for instance in loaded.grid.instances:
            name = stem = "-".join(filter(None, (token(part) for part in (loaded.experiment.name, *instance))))
            while name.lower() in written:
                name = f"{stem}-{len(written)}"
            written[name.lower()] = folder / f"{name}.log"
            write_whole(written[name.lower()], log(loaded.grid, instance))
    return list(written.values())


def log(table: Grid, instance: Instance) -> str:
    """The log of one world and query."""
    cells = [cell for method in table.methods if (cell := table.cell(instance, method))]
    records = [record for cell in cells for record in cell.records]
    limits, title = table.experiment.limits, "-".join(filter(None, (table.experiment.name, *instance)))
    version = next((str(record.get("version")) for record in records if record.get("version")), "0.0.0")
    head = [
        f"Guideway version {token(version) or '0.0.0'}",
        f"Experiment {token(title) or 'experiment'}",
        f"Running on {host(records)}",
        "Starting at 1970-01-01 00:00:00",
        "<<<|", line(table.experiment.title), *(line(f"{key} = {value}") for key, value in sorted(table.experiment.budget.items())), "|>>>",
        "<<<|", *machine(records), "|>>>",
        f"{min(map(seed_of, records), default=0)} is the random seed",
        f"{real(limits.get('seconds', 0))} seconds per run",
        f"{real(limits.get('memory_mib', 0))} MB per run",
        f"{max((len(cell.records) for cell in cells), default=0)} runs per planner",
        f"{real(math.fsum(numbers(record.get('times')).get('wall', 0.0) for record in records))} seconds spent to collect the data",
        "1 enum type",
        "|".join(("status", *STATUS)),
        f"{len(cells)} planners",
    ]  # fmt: skip
    return "\n".join([*head, *(row for cell in cells for row in planner(table, cell))]) + "\n"


def planner(table: Grid, cell: Cell) -> list[str]:
    """The runs of a method, and the course of its searches."""
    method: Mapping[str, Any] = next((item for item in table.experiment.methods if item["name"] == cell.method), {})
    settings = [line(f"{key} = {value}") for key, value in sorted(settings_of(method).items())]
    columns = measured(cell)
    rows = [run(cell_record, columns, table.experiment.reference) for cell_record in cell.records]
    names = [*(f"{name} {kind}" for name, kind in FIRST), *(f"{column} REAL" for column in columns.values())]
    out = [line(cell.method) or "method", f"{len(settings)} common properties", *settings, f"{len(names)} properties for each run", *names]
    out += [f"{len(rows)} runs", *rows]
    curves = [course(record, table.experiment.budget) for record in cell.records]
    if any(curves):
        out += ["3 progress properties for each run", "time REAL", "evaluations INTEGER", "best_cost REAL", f"{len(curves)} runs", *curves]
    return [*out, "."]


def settings_of(method: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters of a method, flat."""
    flat = {key: value for key, value in method.items() if key != "name" and not isinstance(value, Mapping)}
    return flat | {key: value for key, inner in method.items() if isinstance(inner, Mapping) for key, value in inner.items()}


def measured(cell: Cell) -> dict[str, str]:
    """Measures of a cell and their columns: names that SQL takes, each once."""
    taken = {name.lower() for name, _ in FIRST} | {"id", "experimentid", "plannerid", "evaluations_spent"}
    out: dict[str, str] = {}
    for name in sorted({name for record in cell.records for name in numbers(record.get("measures"))}):
        column = stem = re.sub(r"\W", "_", name, flags=re.ASCII).strip("_") or "measure"
        if column[0].isdigit():
            column = stem = f"m{column}"
        while column.lower() in taken:
            column = f"{stem}_{len(taken)}"
        taken.add(column.lower())
        out[name] = column
    return out


def run(record: Record, columns: Mapping[str, str], reference: str | None) -> str:
    """One run: values separated by ``; ``; what is not known is empty."""
    sound, values, times = is_sound(record), numbers(record.get("measures")), numbers(record.get("times"))
    length = values.get("length", values.get(reference or "")) if sound else None
    clock = next((times[name] for name in ("plan", "wall", "cpu") if name in times), None)
    memory = record.get("peak_mib")
    first = [clock, memory if isinstance(memory, int | float) else None, int(record.get("status") == "ok"), int(sound), status_of(record), length]
    return "".join(f"{real(value)}; " for value in [*first, *(values.get(name) if sound else None for name in columns)])


def status_of(record: Record) -> int:
    """The number of OMPL's status."""
    error = record.get("error")
    kind = error.get("type") if isinstance(error, Mapping) else None
    if kind in START:
        return 1
    return 2 if kind in GOAL else ENDS.get(str(record.get("status")), 0) if is_sound(record) or record.get("status") != "ok" else 0


def course(record: Record, budget: Mapping[str, Any]) -> str:
    """Convergence as ``time,evaluations,best,;``: times are shares of the run's time in proportion to its evaluations, for the log has no others."""
    points = usable(record.get("curve")) if is_sound(record) else []
    if not points:
        return ""
    step = max(1, -(-len(points) // MOST_STEPS))
    kept = points[::step] if (len(points) - 1) % step == 0 else [*points[::step], points[-1]]
    whole = max(spent(record, budget) or 0.0, points[-1][0], 1.0)
    times = numbers(record.get("times"))
    clock = next((times[name] for name in ("plan", "wall", "cpu") if name in times), 0.0)
    return "".join(f"{real(clock * at / whole)},{int(at)},{real(best)},;" for at, best in kept)


def real(value: Any) -> str:
    """A number as text, empty where there is none."""
    if isinstance(value, bool):
        return str(int(value))
    return repr(value) if isinstance(value, int) else f"{value:.10g}" if isinstance(value, float) and math.isfinite(value) else ""


def line(text: Any) -> str:
    """Text on one line that does not look like a mark of the format."""
    words = " ".join(str(text).split())
    return words.replace("<<<|", "< <<|").replace("|>>>", "|> >>") if words != "." else ". "


def token(text: str) -> str:
    """A word without spaces, of letters that a file name takes everywhere."""
    return re.sub(r"[^A-Za-z0-9._+]+", "-", text).strip("-.")[:120]


def host(records: Sequence[Record]) -> str:
    """Name of the first machine, as a word."""
    known = next((record["machine"] for record in records if record.get("machine")), "unknown")
    name = (
        next((str(known[key]) for key in ("name", "host", "hostname", "cpu") if known.get(key)), "unknown")
        if isinstance(known, Mapping)
        else str(known)
    )
    return token(name) or "unknown"


def machine(records: Sequence[Record]) -> list[str]:
    """What is known of the machines."""
    known = {line(machine) for record in records if (machine := record.get("machine"))}
    return sorted(known)
