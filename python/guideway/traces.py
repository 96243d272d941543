"""What a colony or a swarm leaves for pictures, bounded in size, as the ``trace`` of a plan."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

MOST_CELLS, MOST_PATHS, MOST_POINTS = 5000, 12, 400
"""Cells with pheromone and paths of a population that a leg keeps, and the turning points that a path may have."""


def trace_record(trace: Any) -> dict[str, Any] | None:
    """The ``trace`` of a record: per leg ``pheromone``, ``paths``, ``swarm_iterations``; None for methods that leave none.

    ``pheromone`` has rows column, row (row 0 at the bottom), concentration: the strongest cells, row by row. ``paths`` are the turning points
    (m) of the best distinct paths of a swarm's last population.
    """
    legs = trace.get("legs") if isinstance(trace, Mapping) else None
    kept = [_leg(leg) for leg in legs] if isinstance(legs, list) else []
    return {"legs": kept} if any(kept) else None


def _leg(leg: Mapping[str, Any]) -> dict[str, Any]:
    swarm = leg.get("swarm") or {}
    cells, paths = leg.get("pheromone") or [], leg.get("paths") or swarm.get("paths") or []
    found: dict[str, Any] = {}
    if cells:
        strongest = sorted(cells, key=lambda cell: -cell[2])[:MOST_CELLS]
        rows = sorted(strongest, key=lambda cell: (cell[1], cell[0]))
        found["pheromone"] = [[int(column), int(row), float(f"{value:.4g}")] for column, row, value in rows]
    if paths:
        found["paths"] = [path for path in paths if len(path) <= MOST_POINTS][:MOST_PATHS]
    if swarm:
        found["swarm_iterations"] = int(swarm["iterations"])
    return found
