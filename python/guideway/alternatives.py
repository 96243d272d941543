"""The set of alternatives of a query: lattice paths of which none is better in every respect."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from guideway import _core
from guideway.errors import BadParameter, NoPath

Observer = Callable[[dict[str, Any]], bool]


def records(query: _core.Query, seconds: float | None = None, observe: Observer | None = None) -> dict[str, Any]:
    """The fields ``alternatives`` and ``pareto`` of a plan record.

    Raises the errors of :mod:`guideway.errors`; on Ctrl-C ``KeyboardInterrupt`` with an attribute ``fields`` that holds what was found (or None).
    """
    try:
        return split(_core.pareto(query, seconds=seconds, observe=observe))
    except NoPath as none:  # there is none on the lattice, or time was too short for one
        proved = bool(getattr(none, "proved", False))
        about = {"complete": proved, "searches": 0, "labels": 0, "seconds": 0.0, "stop": "converged" if proved else "budget"}
        return {"alternatives": [], "pareto": about}
    except KeyboardInterrupt as interrupt:
        found = getattr(interrupt, "found", None)
        interrupt.fields = None if found is None else split(found)  # type: ignore[attr-defined]
        raise


def check(query: _core.Query) -> None:
    """Refuses queries that have no set of alternatives, before any work. Raises :class:`BadParameter`."""
    if query.via:
        raise BadParameter("--pareto joins one start and one goal: leave out the via points, or plan leg by leg")


def split(found: dict[str, Any]) -> dict[str, Any]:
    """What was found, as the two fields of a record."""
    return {"alternatives": found["alternatives"], "pareto": {key: value for key, value in found.items() if key != "alternatives"}}


def table(record: dict[str, Any], most: int = 12) -> list[str]:
    """A few lines for people; of a long set its shortest alternatives, and how many more there are."""
    rows, about = record["alternatives"], record["pareto"]
    whole = "all of them" if about["complete"] else "not complete: time or effort ended first"
    lines = [f"alternatives {len(rows)} ({whole}) in {1e3 * about['seconds']:.1f} ms", "               length m  turns  clear m   energy"]
    for row in rows[:most]:
        clear = "      -" if row["min_clearance"] is None else f"{round(row['min_clearance'], 3) + 0.0:7.3f}"
        lines.append(f"             {row['length']:10.3f} {row['turns']:6d}  {clear} {row['energy']:8.3f}")
    if len(rows) > most:
        lines.append(f"             and {len(rows) - most} more")
    return lines


def gap_line(record: dict[str, Any]) -> list[str]:
    """How far a lattice path is from the best of its kind, and whether the exact path stands in for it."""
    search, reference = record["search"], record["reference"]
    lines = []
    gap, what = (reference["grid_gap"], "length") if reference["grid_energy_gap"] is None else (reference["grid_energy_gap"], "energy")
    if gap is not None:
        turns = "" if reference["grid_turns"] is None else f", fewest turns of the shortest {reference['grid_turns']}"
        lines.append(f"lattice      {100 * gap:.2f} % more {what} than the exact optimum{turns}")
    if search["fallback"]:
        found = search["heuristic"]
        what = "found no path" if found is None else f"found {found['raw_length']:.3f} m"
        lines.append(f"fallback     the exact path; {record['planner']} {what}")
    return lines
