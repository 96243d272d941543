"""Random grids that share what is known about a given one: simulated annealing over swaps of a blocked and a free cell.

The cost is the weighted deviation from the targets of a scene class: the exact optima under the corner rules ``touch`` and ``clear`` as (diagonals,
straights) and their least turns. The counts of blocked cells are met by every grid on the way: cells are swapped within the part that has a count.
Everything that decides is a whole number, so the same seed gives the same grid on every machine.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from guideway._core import World, lattice_optimum
from guideway.errors import BadParameter
from guideway.scenes.draws import Draws
from guideway.scenes.grid import Cell, GridScene, seed_of

EDITS, STARTS = 6000, 20
"""Edits of one annealing, and how many are begun at most."""


@dataclass(frozen=True)
class Targets:
    """What the grids of a class have in common. Start is the lower left cell, goal the upper right one.

    ``size`` is the side in cells, ``blocked`` the number of blocked cells, ``inner`` that without the last row (top) and column (right) or None;
    ``touch`` and ``clear`` are (diagonals, straights, turns), turns None where any number will do.
    """

    size: int
    blocked: int
    inner: int | None
    touch: tuple[int, int, int | None]
    clear: tuple[int, int, int | None]


CLASSES = {
    "pso-aco-1": Targets(20, 133, 120, (16, 6, 3), (15, 8, 7)),
    "pso-aco-2": Targets(20, 207, 187, (14, 10, 6), (10, 18, 13)),
    "m20": Targets(20, 100, None, (18, 2, 2), (17, 4, None)),
    "m30": Targets(30, 225, None, (28, 2, 3), (25, 8, None)),
}
"""The scene classes by the name of the scene whose numbers they share."""


def calibrated(kind: str, seed: int) -> GridScene:
    """A random grid of the scene class ``kind`` (one of ``CLASSES``), the same for the same seed on every machine.

    ``record`` holds ``blocked``, ``inner``, ``touch`` and ``clear`` (``diagonals``, ``straights``, ``turns`` each), ``deviation`` (by how much the
    targets are missed, per target, empty where they are met exactly), ``exact`` (is it empty?), ``starts`` and ``edits``.
    Raises :class:`guideway.errors.BadParameter`.
    """
    targets = CLASSES.get(kind)
    if targets is None:
        raise BadParameter(f"scene class {kind!r} is not known: one of {', '.join(CLASSES)}")
    seed = seed_of(seed)
    best, edits, starts = None, 0, 0
    for starts in range(1, STARTS + 1):
        found = _Annealing(targets, Draws(seed, f"calibrated {kind} {starts}"))
        edits += found.run()
        if best is None or found.cost < best.cost:
            best = found
        if best.cost == 0:
            break
    assert best is not None
    record = describe(best.grid(), targets) | {"starts": starts, "edits": edits}
    return GridScene(kind, best.grid(), (0, targets.size - 1), (targets.size - 1, 0), seed, record)


def describe(blocked: np.ndarray[Any, np.dtype[np.bool_]], targets: Targets) -> dict[str, Any]:
    """What a grid (bool, (size, size), row 0 on top) has of the ``targets``: the ``record`` of :func:`calibrated` but for the work."""
    size, world = targets.size, World(blocked)
    ends = (0, size - 1), (size - 1, 0)
    record: dict[str, Any] = {"blocked": int(blocked.sum()), "inner": int(blocked[1:, :-1].sum())}
    missed = {"blocked": record["blocked"] - targets.blocked, "inner": 0 if targets.inner is None else record["inner"] - targets.inner}
    for rule in ("touch", "clear"):
        found, wanted = lattice_optimum(world, *ends, rule), getattr(targets, rule)
        names = ("diagonals", "straights", "turns")
        record[rule] = None if found is None else {name: found[name] for name in names}
        for name, want in zip(names, wanted, strict=True):
            if want is not None:
                missed[f"{rule} {name}"] = None if found is None else found[name] - want
    deviation = {name: by for name, by in missed.items() if by != 0}
    return record | {"deviation": deviation, "exact": not deviation}


class _Annealing:
    """One annealing: a grid, its cost, and edits that are kept or taken back."""

    def __init__(self, targets: Targets, draws: Draws) -> None:
        self.targets, self.draws = targets, draws
        self.side = targets.size
        self.cells = np.zeros(self.side * self.side, bool)
        self.parts = self._fill(self._way())
        self.cost = self._cost(1 << 30)

    def grid(self) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """The grid, bool, (size, size), row 0 on top."""
        return self.cells.reshape(self.side, self.side).copy()

    def run(self) -> int:
        """Anneals until the cost is 0 or the edits are used up; returns how many were tried."""
        for edit in range(EDITS):
            if self.cost == 0:
                return edit
            blocked, free = self.draws.choice(self.parts)
            i, j = self.draws.below(len(blocked)), self._clumped(free)
            self._swap(blocked, free, i, j)
            # what may be lost: with probability 2^-k at least k times the temperature, which falls from 8 to 1
            word = self.draws.bits() | 1 << 40
            heads = (word & -word).bit_length() - 1
            most = self.cost + heads * (8 - 8 * edit // EDITS)
            cost = self._cost(most)
            if cost <= most:
                self.cost = cost
            else:
                self._swap(blocked, free, i, j)
        return EDITS

    def _clumped(self, free: list[int]) -> int:
        """Which free cell to block: one beside a blocked cell three times out of four at least, so that obstacles hold together."""
        while True:
            j = self.draws.below(len(free))
            x, y = free[j] % self.side, free[j] // self.side
            beside = ((x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1))
            near = any(0 <= u < self.side and 0 <= v < self.side and self.cells[v * self.side + u] for u, v in beside)
            if near or not self.draws.below(4):
                return j

    def _swap(self, blocked: list[int], free: list[int], i: int, j: int) -> None:
        blocked[i], free[j] = free[j], blocked[i]
        self.cells[blocked[i]], self.cells[free[j]] = True, False

    def _cost(self, most: int) -> int:
        """The weighted deviation; anything over ``most`` as soon as that is certain."""
        world = World(self.cells.reshape(self.side, self.side))
        ends, cost = ((0, self.side - 1), (self.side - 1, 0)), 0
        right = []
        for rule in ("touch", "clear"):
            diagonals, straights, turns = getattr(self.targets, rule)
            found = world.shortest(*ends, rule)
            if found is None:
                return cost + 1000
            steps = _steps(found[1])
            off = 2 * abs(steps[0] - diagonals) + abs(steps[1] - straights)
            if off:
                cost += 6 * off + 20  # more than any number of turns costs
            elif turns is not None:
                right.append((rule, turns))
        for rule, turns in right:
            if cost <= most:
                found = lattice_optimum(world, *ends, rule)
                cost += 1000 if found is None else 2 * min(10, abs(found["turns"] - turns))
        return cost

    def _way(self) -> set[int]:
        """Cells of a random path under ``clear`` with the right diagonals and straights, and the cells that its diagonals need."""
        diagonals, straights, _ = self.targets.clear
        moves = [(1, 1)] * diagonals + [(1, 0), (0, 1)] * (straights // 2)
        self.draws.shuffle(moves)
        x, y, kept = 0, 0, {self._index(0, 0)}
        for dx, dy in moves:
            kept |= {self._index(x + dx, y), self._index(x, y + dy), self._index(x + dx, y + dy)}
            x, y = x + dx, y + dy
        return kept

    def _index(self, x: int, y: int) -> int:
        return (self.side - 1 - y) * self.side + x

    def _fill(self, way: set[int]) -> list[tuple[list[int], list[int]]]:
        """Blocks cells off the ``way`` in clumps; returns the blocked and the free cells that may be swapped, for each part with a count."""
        side, targets = self.side, self.targets
        rim = {i for i in range(side * side) if i < side or i % side == side - 1}
        every = set(range(side * side))
        parts = [(every, targets.blocked)]
        if targets.inner is not None:
            parts = [(every - rim, targets.inner), (rim, targets.blocked - targets.inner)]
        ends = {self._index(0, 0), self._index(side - 1, side - 1)}
        done = []
        for part, count in parts:
            room, blocked = sorted(part - way), set[int]()
            while len(blocked) < count:
                at = self.draws.choice(room)
                near = any(at + step in blocked for step in (-1, 1, -side, side))
                if at not in blocked and (near or not self.draws.below(4)):
                    blocked.add(at)
            self.cells[sorted(blocked)] = True
            done.append((sorted(blocked), sorted(part - blocked - ends)))
        return done


def _steps(corners: list[Cell]) -> tuple[int, int]:
    """Diagonals and straights of a path given by its corners."""
    diagonals = straights = 0
    for (ax, ay), (bx, by) in itertools.pairwise(corners):
        dx, dy = abs(ax - bx), abs(ay - by)
        diagonals, straights = diagonals + min(dx, dy), straights + max(dx, dy) - min(dx, dy)
    return diagonals, straights
