"""Four kinds of surroundings, from nearly empty to a maze, on square grids of 1 m cells.

Start is the lower left cell, goal the upper right one; a drawing without a path under the corner rule ``clear`` is thrown away and drawn anew.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from guideway.errors import BadParameter
from guideway.scenes.draws import Draws
from guideway.scenes.grid import GridScene, reaches, seed_of, whole

Grid = NDArray[np.bool_]

SIZES = (12, 500)
"""Smallest and largest side, cells."""


def environment(kind: str, seed: int, size: int = 30) -> GridScene:
    """One of the ``ENVIRONMENTS`` on ``size`` x ``size`` cells (12 to 500), the same for the same arguments on every machine.

    ``record`` holds ``blocked`` (cells), ``share`` and ``drawings`` (1: the first had a path). Raises :class:`guideway.errors.BadParameter`.
    """
    draw = ENVIRONMENTS.get(kind)
    if draw is None:
        raise BadParameter(f"environment {kind!r} is not known: one of {', '.join(ENVIRONMENTS)}")
    size, seed = whole("size", size, *SIZES), seed_of(seed)
    draws, start, goal = Draws(seed, f"{kind} {size}"), (0, size - 1), (size - 1, 0)
    drawings = 0
    while True:
        drawings += 1
        grid = draw(size, draws)
        if reaches(grid, start, goal):
            break
    blocked = int(grid.sum())
    return GridScene(kind, grid, start, goal, seed, {"blocked": blocked, "share": blocked / size**2, "drawings": drawings})


def simple(size: int, draws: Draws) -> Grid:
    """Six rectangles of two to five cells a side, a cell or more apart."""
    while True:
        grid, placed = _empty(size), 0
        for _ in range(600):
            width, height = draws.between(2, 5), draws.between(2, 5)
            x, y = draws.below(size - width + 1), draws.below(size - height + 1)
            if not grid[max(0, y - 1) : y + height + 1, max(0, x - 1) : x + width + 1].any():
                grid[y : y + height, x : x + width] = True
                placed += 1
            if placed == 6:
                return grid


def cluttered(size: int, draws: Draws) -> Grid:
    """22 % of the cells: single ones and L-shapes of three, drawn as often as each other, at random places."""
    grid, left = _empty(size), share(size, 22)
    while left:
        x, y = draws.below(size), draws.below(size)
        cells = [(x, y)]
        if left >= 3 and draws.below(2):
            dx, dy = draws.choice((-1, 1)), draws.choice((-1, 1))
            cells += [(x + dx, y), (x, y + dy)]
        if all(0 <= u < size and 0 <= v < size and not grid[v, u] for u, v in cells):
            for u, v in cells:
                grid[v, u] = True
            left -= len(cells)
    return grid


def crowded(size: int, draws: Draws) -> Grid:
    """38 % of the cells (to the nearest block): blocks of 2 x 2 in bands, aisles of one or two cells between them, shifted from band to band."""
    blocks = (share(size, 38) + 2) // 4
    most = (size + 1) // 3
    bands = min(most, max(1, round(blocks**0.5)))
    each = [blocks // bands + (i < blocks % bands) for i in range(bands)]
    draws.shuffle(each)
    grid = _empty(size)
    for y, count in zip(_spread(size, bands, draws), each, strict=True):
        for x in _spread(size, min(most, count), draws):
            grid[y : y + 2, x : x + 2] = True
    return grid


def _spread(size: int, count: int, draws: Draws) -> list[int]:
    """Where ``count`` intervals of two cells begin on ``size`` cells, one or two cells between them and at most two at the ends."""
    gaps = [0] + [1] * (count - 1) + [0]
    for _ in range(size - 2 * count - (count - 1)):
        gaps[draws.choice([i for i, gap in enumerate(gaps) if gap < 2])] += 1
    places, at = [], 0
    for gap in gaps[:-1]:
        places.append(at + gap)
        at += gap + 2
    return places


def maze(size: int, draws: Draws) -> Grid:
    """Recursive division: corridors two cells wide, walls of one cell, one door of two cells in each wall.

    Where ``size`` + 1 is no multiple of three, the lowest and the rightmost corridors are wider.
    """
    grid, rooms = _empty(size), (size + 1) // 3
    stack = [(0, 0, rooms, rooms)]
    while stack:
        x, y, width, height = stack.pop()
        if width < 2 or height < 2:
            continue
        if width > height or (width == height and draws.below(2)):
            cut, door = draws.between(1, width - 1), y + draws.below(height)
            grid[3 * y : _end(y + height, rooms, size), 3 * (x + cut) - 1] = True
            grid[3 * door : 3 * door + 2, 3 * (x + cut) - 1] = False
            stack += [(x, y, cut, height), (x + cut, y, width - cut, height)]
        else:
            cut, door = draws.between(1, height - 1), x + draws.below(width)
            grid[3 * (y + cut) - 1, 3 * x : _end(x + width, rooms, size)] = True
            grid[3 * (y + cut) - 1, 3 * door : 3 * door + 2] = False
            stack += [(x, y, width, cut), (x, y + cut, width, height - cut)]
    return grid


def _end(room: int, rooms: int, size: int) -> int:
    """Where the wall of a chamber that ends before ``room`` ends; the last rooms reach to the border."""
    return size if room == rooms else 3 * room - 1


def _empty(size: int) -> Grid:
    return np.zeros((size, size), bool)


def share(size: int, percent: int) -> int:
    """That many per cent of the cells, rounded half up."""
    return (2 * percent * size * size + 100) // 200


ENVIRONMENTS: dict[str, Callable[[int, Draws], Grid]] = {"simple": simple, "cluttered": cluttered, "crowded": crowded, "maze": maze}
"""The kinds by name."""
