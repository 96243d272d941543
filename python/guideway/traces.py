"""What a search leaves for pictures, bounded in size, as the ``trace`` of a plan."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

MOST_CELLS, MOST_PATHS, MOST_POINTS = 5000, 12, 400
"""Cells with pheromone and paths of a population that a leg keeps, and the turning points that a path may have."""
MOST_GENERATIONS, MOST_CURVES, MOST_CLASSES, MOST_STAGES, MOST_REGIONS, MOST_EDGES = 8, 40, 16, 60, 60, 3000
"""Generations and paths of each that a continuous planner keeps, homotopy classes, stages of the closed loop, regions of one, edges of a tree."""


def trace_record(trace: Any) -> dict[str, Any] | None:
    """The ``trace`` of a record; None for methods that leave none.

    Of colonies and swarms on the lattice ``legs``, each with ``pheromone``, ``paths``, ``swarm_iterations``. ``pheromone`` has rows column, row
    (row 0 at the bottom), concentration: the strongest cells, row by row. ``paths`` are the turning points (m) of the best distinct paths of a
    swarm's last population. Of continuous planners ``objective``, ``population`` over the generations, homotopy ``classes``, the closed ``loop``
    stage by stage, ``speed`` along the path before and after its correction, the lower ``bound``. Of sampling planners the ``tree``.
    """
    if not isinstance(trace, Mapping):
        return None
    found: dict[str, Any] = {}
    legs = [_leg(leg) for leg in _rows(trace.get("legs"))]
    if any(legs):
        found["legs"] = legs
    found |= {key: dict(trace[key]) for key in ("objective", "bound") if isinstance(trace.get(key), Mapping)}
    if population := _rows(trace.get("population")):
        found["population"] = [_generation(each) for each in _spread(population, MOST_GENERATIONS)]
    if classes := _rows(trace.get("classes")):
        found["classes"] = [dict(each) | {"path": _thin(each.get("path"))} for each in classes[:MOST_CLASSES]]
    if stages := _rows(trace.get("loop")):
        lists = ("found", "remaining")
        found["loop"] = [dict(each) | {key: _rows(each.get(key))[:MOST_REGIONS] for key in lists} for each in _spread(stages, MOST_STAGES)]
    if isinstance(speed := trace.get("speed"), Mapping):
        kept: dict[str, Any] = {
            key: _rows(rows)[:MOST_REGIONS] if key.startswith("regions") else _thin(rows) for key, rows in speed.items() if key != "movers"
        }
        if isinstance(around := speed.get("movers"), Mapping):
            kept["movers"] = dict(around)
        found["speed"] = kept
    if tree := _rows(trace.get("tree")):
        found["tree"] = [[_short(value) for value in edge] for edge in _spread(tree, MOST_EDGES)]
    return found or None


def _rows(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


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


def _generation(population: Mapping[str, Any]) -> dict[str, Any]:
    return {"generation": population.get("generation"), "paths": [_thin(path, 80) for path in _rows(population.get("paths"))[:MOST_CURVES]]}


def _spread(rows: list[Any], most: int) -> list[Any]:
    """At most ``most`` of the rows, evenly, the first and the last among them."""
    if len(rows) <= most:
        return rows
    return [rows[round(i * (len(rows) - 1) / (most - 1))] for i in range(most)]


def _thin(rows: Any, most: int = MOST_POINTS) -> list[list[float]]:
    return [[_short(value) for value in row] for row in _spread(_rows(rows), most)]


def _short(value: float) -> float:
    return round(value, 4)
