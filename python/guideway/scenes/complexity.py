"""Square grids of any size and blocked share that always have a path, for measuring how work grows.

Blocking cells independently leaves start and goal apart almost surely from about 40 % on, so a corridor is drawn first and kept free.
"""

from __future__ import annotations

import math

import numpy as np

from guideway.errors import BadParameter
from guideway.scenes.draws import Draws
from guideway.scenes.grid import Cell, GridScene, seed_of, whole

SIZES = (2, 1000)
"""Smallest and largest side, cells."""


def complexity(size: int, density: float, seed: int) -> GridScene:
    """A grid of ``size`` x ``size`` cells (2 to 1000) of which the share ``density`` (0 to below 1, rounded to whole cells) is blocked.

    A random walk from start (lower left) to goal (upper right) by steps along rows and columns, with a pull to the goal, stays free; all other cells
    are blocked in random order until the share is reached. Where the walk needs more cells than stay free, its pull grows until it fits. ``record``
    holds ``blocked``, ``share``, ``corridor`` (cells of the walk) and ``pull`` (sixteenths of its steps that lead to the goal for sure).
    Raises :class:`guideway.errors.BadParameter`, also where not even a walk without detours fits: it needs 2 ``size`` - 1 cells.
    """
    size, seed = whole("size", size, *SIZES), seed_of(seed)
    if not (isinstance(density, (int, float)) and math.isfinite(density) and 0 <= density < 1):
        raise BadParameter(f"density {density!r} is out of range: a share from 0 to below 1")
    cells, blocked = size * size, int(density * size * size + 0.5)
    if blocked > cells - (2 * size - 1):
        most = (cells - 2 * size + 1) / cells
        raise BadParameter(f"density {density} leaves no corridor on {size} x {size} cells: at most {most:.4g}")
    draws = Draws(seed, f"complexity {size} {blocked}")
    pull, corridor = 4, None
    while corridor is None:
        corridor = _walk(size, cells - blocked, pull, draws)
        pull += corridor is None
    others = sorted(set(range(cells)) - {y * size + x for x, y in corridor})
    draws.shuffle(others)
    grid = np.zeros(cells, bool)
    grid[others[:blocked]] = True
    record = {"blocked": blocked, "share": blocked / cells, "corridor": len(corridor), "pull": pull}
    return GridScene("complexity", grid.reshape(size, size), (0, size - 1), (size - 1, 0), seed, record)


def _walk(size: int, room: int, pull: int, draws: Draws) -> set[Cell] | None:
    """Cells of a walk from the lower left to the upper right, ``pull`` sixteenths of its steps towards it; None once it needs over ``room`` cells."""
    x, y = 0, size - 1
    seen = {(x, y)}
    while (x, y) != (size - 1, 0):
        if draws.below(16) < pull:
            dx, dy = draws.choice([(1, 0)] * (x < size - 1) + [(0, -1)] * (y > 0))
        else:
            dx, dy = draws.choice(((1, 0), (0, -1), (-1, 0), (0, 1)))
        if 0 <= x + dx < size and 0 <= y + dy < size:
            x, y = x + dx, y + dy
            seen.add((x, y))
            if len(seen) > room:
                return None
    return seen
