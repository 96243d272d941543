"""A square grid with a start and a goal: what every generator returns."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from guideway._core import Query, World
from guideway.errors import BadParameter

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Cell = tuple[int, int]


@dataclass(frozen=True, eq=False)
class GridScene:
    """A grid of 1 m cells with a start and a goal.

    ``blocked`` is bool of shape (height, width), row 0 on top; ``start`` and ``goal`` are cells (column, row), row 0 on top. ``seed`` made it (None:
    it is not random); ``record`` says what is known about it.
    """

    name: str
    blocked: NDArray[np.bool_]
    start: Cell
    goal: Cell
    seed: int | None = None
    record: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def world(self) -> World:
        """The world of this grid: resolution 1 m, origin (0, 0)."""
        return World(self.blocked)

    def query(self, **options: Any) -> Query:
        """From the centre of the start cell to that of the goal cell, m; options as those of :class:`guideway.Query`."""
        start, goal = self.world.cell_centers([self.start, self.goal]).tolist()
        return Query(self.world, start, goal, **options)

    def text(self) -> str:
        """Rows of ``.`` (free) and ``#`` (blocked), top row first, each with a line end."""
        return "".join("".join(".#"[cell] for cell in row) + "\n" for row in self.blocked.astype(int).tolist())

    def write(self, path: str | os.PathLike[str]) -> list[Path]:
        """Writes it in the format its name asks for and returns the files written.

        ``.yaml`` (map_server), ``.map`` (Moving AI) and ``.txt`` hold the grid alone; ``.toml`` is a scene with start and goal, its grid beside it
        as ``.txt``. Raises :class:`guideway.errors.BadFile`.
        """
        from guideway.io import GridMap, Scene, write_map
        from guideway.io import Query as Asked

        target = Path(path)
        grid = GridMap(self.blocked, None, 1.0, (0.0, 0.0, 0.0), target.with_suffix(".txt"), "", {}, "text")
        if target.suffix.lower() != ".toml":
            return write_map(grid, target)
        (sx, sy), (gx, gy) = self.world.cell_centers([self.start, self.goal]).tolist()
        scene = Scene(grid.bounds, 1.0, target, "", map=grid, query=Asked(start=(sx, sy), goal=(gx, gy)))
        beside = write_map(grid, grid.source)  # the grid first: the scene never names a map that is not there
        return [*write_map(scene, target), *beside]


def whole(name: str, value: object, low: int, high: int) -> int:
    """``value`` if it is a whole number from ``low`` to ``high``; else :class:`guideway.errors.BadParameter`."""
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise BadParameter(f"{name} {value!r} is out of range: a whole number from {low} to {high}")
    return value


def seed_of(value: object) -> int:
    """``value`` if it can be a seed."""
    return whole("seed", value, 0, (1 << 63) - 1)


def reaches(blocked: NDArray[np.bool_], start: Cell, goal: Cell) -> bool:
    """Do steps along rows and columns lead from ``start`` to ``goal``? That is the same as a path under the corner rules touch and clear."""
    free = (~blocked).tolist()
    height, width = blocked.shape
    seen, stack = {start}, [start]
    while stack:
        x, y = stack.pop()
        if (x, y) == goal:
            return free[start[1]][start[0]] and free[y][x]
        for to in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if 0 <= to[0] < width and 0 <= to[1] < height and free[to[1]][to[0]] and to not in seen:
                seen.add(to)
                stack.append(to)
    return False
