"""Functions to minimise inside a box: the usual test functions, shifted, and way points among discs.

A problem's specification is a mapping with a ``name`` and ``function`` (one of :data:`FUNCTIONS`, or ``ways``) with ``dimensions`` and ``shift``, or
``seed`` of the room for ``ways``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from guideway.errors import BadParameter

Floats = NDArray[np.float64]

FIELDS = ("name", "function", "dimensions", "shift", "seed")
"""Fields of a specification."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A function and its box. ``many`` takes shape (n, d) and returns shape (n,); ``optimum`` is its least value, None where it is not known."""

    name: str
    many: Callable[[Floats], Floats]
    bounds: Floats
    optimum: float | None
    feasible: Callable[[Floats], bool] | None = None

    def one(self, x: Any) -> float:
        """The value at one place, shape (d,)."""
        return float(self.many(np.asarray(x, np.float64)[None])[0])


def _sphere(x: Floats) -> Floats:
    return (x * x).sum(axis=1)


def _rosenbrock(x: Floats) -> Floats:
    return (100 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1 - x[:, :-1]) ** 2).sum(axis=1)


def _rastrigin(x: Floats) -> Floats:
    return (x * x - 10 * np.cos(2 * math.pi * x) + 10).sum(axis=1)


def _ackley(x: Floats) -> Floats:
    root = np.sqrt((x * x).mean(axis=1))
    return 20 + math.e - 20 * np.exp(-0.2 * root) - np.exp(np.cos(2 * math.pi * x).mean(axis=1))


def _griewank(x: Floats) -> Floats:
    return 1 + (x * x).sum(axis=1) / 4000 - np.cos(x / np.sqrt(np.arange(1, x.shape[1] + 1))).prod(axis=1)


FUNCTIONS: dict[str, tuple[Callable[[Floats], Floats], float]] = {
    "sphere": (_sphere, 100.0),
    "rosenbrock": (_rosenbrock, 30.0),
    "rastrigin": (_rastrigin, 5.12),
    "ackley": (_ackley, 32.0),
    "griewank": (_griewank, 600.0),
}
"""Function and half the side of its box; the least value of each is 0."""

SHIFT = 0.1
"""By how much of its half side the box is moved if nothing is said, so that its middle is no minimum."""


def check(spec: Mapping[str, Any]) -> None:
    """Raises :class:`guideway.errors.BadParameter` naming the field that is wrong."""
    where = f"world {spec.get('name', '')!r}"
    function = spec.get("function")
    if function not in (*FUNCTIONS, "ways"):
        raise BadParameter(f"{where}: function {function!r} is not known: one of {', '.join(FUNCTIONS)}, ways")
    known = ("name", "function", *(("seed",) if function == "ways" else ("dimensions", "shift")))
    for key in spec:
        if key not in known:
            raise BadParameter(f"{where}: {key!r} is no field of {function}: {', '.join(known)}")
    _whole(where, spec, "dimensions", 2, 1000)
    _whole(where, spec, "seed", 0, 1 << 32)
    shift = spec.get("shift", SHIFT)
    if isinstance(shift, bool) or not isinstance(shift, (int, float)) or not -0.9 <= shift <= 0.9:
        raise BadParameter(f"{where}: shift {shift!r} is not a share of half a side from -0.9 to 0.9")


def _whole(where: str, spec: Mapping[str, Any], name: str, low: int, high: int) -> None:
    value = spec.get(name, low)
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise BadParameter(f"{where}: {name} {value!r} is not a whole number from {low} to {high}")


def problem(spec: Mapping[str, Any]) -> Problem:
    """The problem of a specification. Raises :class:`guideway.errors.BadParameter`."""
    check(spec)
    if spec["function"] == "ways":
        return _ways(spec.get("seed", 12))
    many, half = FUNCTIONS[spec["function"]]
    shift = float(spec.get("shift", SHIFT))
    sides = [[-(1 + shift) * half, (1 - shift) * half]] * spec.get("dimensions", 10)
    return Problem(spec.get("name", ""), many, np.array(sides), 0.0)


START, GOAL, SAFE, COUNT, DISCS = np.array([0.4, 0.4]), np.array([9.5, 5.5]), 0.3, 10, 12
"""Of ``ways``: from and to (m), distance to keep (m), free way points, discs."""


@lru_cache(maxsize=16)
def _ways(seed: int) -> Problem:
    """Ten free way points from start to goal among twelve discs in 10 m x 6 m: length, and 20 times how far segments enter the grown discs."""
    rng = np.random.default_rng(seed)
    discs: list[Floats] = []
    while len(discs) < DISCS:
        center, radius = rng.uniform([0.8, 0.4], [9.2, 5.6]), rng.uniform(0.25, 0.6)
        room = min(np.linalg.norm(center - START), np.linalg.norm(center - GOAL))
        apart = all(np.linalg.norm(center - other[:2]) >= radius + other[2] + 0.15 for other in discs)
        if room >= radius + SAFE + 0.1 and apart:
            discs.append(np.array([*center, radius]))
    centers, reach = np.array(discs)[:, :2], np.array(discs)[:, 2] + SAFE

    def parts(x: Floats) -> tuple[Floats, Floats]:
        ends = [np.broadcast_to(p, (len(x), 1, 2)) for p in (START, GOAL)]
        points = np.concatenate([ends[0], x.reshape(len(x), COUNT, 2), ends[1]], axis=1)
        first, along = points[:, :-1], np.diff(points, axis=1)
        square = (along * along).sum(axis=2)
        to = centers[:, None, None] - first
        share = np.clip((to * along).sum(axis=3) / np.maximum(square, 1e-12), 0.0, 1.0)
        away = to - share[..., None] * along
        depth = np.maximum(reach[:, None, None] - np.sqrt((away * away).sum(axis=3)), 0.0)
        return np.sqrt(square).sum(axis=1), depth.sum(axis=(0, 2))

    def many(x: Floats) -> Floats:
        length, depth = parts(x)
        return length + 20.0 * depth

    def feasible(x: Floats) -> bool:
        return bool(parts(np.asarray(x)[None])[1][0] < 1e-3)

    bounds = np.column_stack([np.zeros(2 * COUNT), np.tile([10.0, 6.0], COUNT)])
    return Problem(f"ways {seed}", many, bounds, None, feasible)
