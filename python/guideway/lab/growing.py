"""How measures and times grow with the size of the world: fits for each method, and for each kind of world by itself."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from .cells import Cell, Grid
from .statistics import Growth, describe, growth

Points = list[tuple[float, float]]


def growths(table: Grid, clocks: Sequence[str]) -> list[dict[str, Any]]:
    """Fits of c n^p (``points``: size and median of each world) over worlds that have a ``size``: per method, measure of the experiment or time
    (the first of ``clocks`` that was taken), and values of the worlds' other fields.
    """
    first = [metric.name for metric in table.experiment.metrics if metric.name in table.measured]
    rows = []
    for method in table.methods:
        cells = [cell for cell in table.cells.values() if cell.method == method]
        taken = {name for cell in cells for record in cell.records for name in record.get("times") or {}}
        for name in dict.fromkeys([*first, *[clock for clock in clocks if clock in taken][:1]]):
            for label, (fit, points) in fits(table, cells, name).items():
                row = {"method": method, "metric": name, "group": label}
                rows.append(row | fit.to_dict() | {"points": [list(point) for point in sorted(points)]})
    return rows


def fits(table: Grid, cells: Collection[Cell], metric: str) -> dict[str, tuple[Growth, Points]]:
    """The fits of one method's cells by the other fields of their worlds, with the points; nothing where there are no two sizes."""
    worlds = {str(world["name"]): world for world in table.experiment.worlds if isinstance(world.get("size"), int | float)}
    sets: dict[str, Points] = {}
    for cell in cells:
        world, median = worlds.get(cell.world), describe(cell.values(metric)).median
        if world is not None and median is not None:
            sets.setdefault(group(world, cell.query), []).append((float(world["size"]), median))
    found = {label: (growth([size for size, _ in points], [value for _, value in points]), points) for label, points in sets.items()}
    return {label: (fit, points) for label, (fit, points) in found.items() if fit}


def group(world: Mapping[str, Any], query: str) -> str:
    """The other numbers that tell worlds apart, and the query, as words."""
    words = [
        f"{key} {value}"
        for key, value in world.items()
        if key not in ("name", "make", "source", "size", "seed") and isinstance(value, str | int | float)
    ]
    return ", ".join([*words, *([query] if query else [])])
