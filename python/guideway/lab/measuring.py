"""What is measured of a path, whoever planned it, against the exact optimum of the same model.

Definitions: lengths in m; turns are changes of heading above 1e-6 rad (smooth paths: stretches of curvature above 0.05 1/m); ``energy`` is the length
in cells and half for every turn; ``gap`` is to the exact shortest path of the path's own model, in per cent: lattice paths against the lattice with
the same corner rule, others against the shortest path at any angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from guideway import _core
from guideway.errors import GuidewayError

NEAR = 0.01
"""Gap from which on a run counts as near the optimum."""
SAME = 1e-9
"""Relative difference below which two lengths of one lattice are equal."""
SETTLED = 1e-6
"""Relative difference below which a best cost counts as its final value."""
MOST_POINTS, MOST_IMPROVEMENTS = 400, 200
"""Points of a path and of a curve that a record keeps."""
SQRT2 = math.sqrt(2.0)

Measures = dict[str, Any]


@dataclass(frozen=True)
class Exact:
    """Exact optima of a query; None where there is none or it cannot be had."""

    lattice: float | None
    lattice_turns: int | None
    any_angle: float | None
    """Length at any angle, and a lower bound of every path."""


def exact(query: _core.Query) -> Exact:
    """The optima of a query, by exact searches."""
    lattice, turns, free = None, None, None
    try:
        found = _core.plan(query, "lexicographic")
        told = _core.reference(query, found)
        lattice, turns = told["grid_optimum"], told["grid_turns"]
        free = told["any_angle_optimum"] if told["proved"] else None
    except GuidewayError:
        pass
    if free is None:
        try:
            found = _core.plan(query, "visibility")
            told = _core.reference(query, found)
            free = told["any_angle_optimum"] if told["proved"] else None
        except GuidewayError:
            pass
    return Exact(lattice, turns, free)


def shape(path: _core.Path, query: _core.Query, prefix: str = "") -> Measures:
    """Length, turns, turning, smoothness, curvature, clearance and energy of a path."""
    told = _core.measure(path, query)
    names = {
        "length": "length",
        "turns": "turns",
        "total_turning": "turning",
        "smoothness": "smoothness",
        "max_curvature": "curvature",
        "min_clearance": "clearance",
        "energy": "energy",
    }
    return {prefix + ours: told[theirs] for theirs, ours in names.items()}


def lattice(cells: Any, resolution: float) -> Measures | None:
    """Diagonal and straight steps, turns and exact length of a path of neighbouring cells; None if it is not one."""
    steps = np.diff(np.asarray(cells, float), axis=0)
    if not len(steps) or np.abs(steps - np.round(steps)).max() > 1e-6 or np.abs(steps).max() > 1 + 1e-6 or not np.abs(steps).max(axis=1).all():
        return None
    steps = np.round(steps).astype(int)
    diagonals = int(np.all(steps != 0, axis=1).sum())
    straights = len(steps) - diagonals
    turns = int(np.any(np.diff(steps, axis=0) != 0, axis=1).sum())
    length = (diagonals * SQRT2 + straights) * resolution
    return {"diagonals": diagonals, "straights": straights, "turns": turns, "length": length, "energy": length / resolution + 0.5 * turns}


def cells_of(points: np.ndarray, world: _core.World) -> np.ndarray | None:
    """The cells (column, row) of a polyline along a lattice, one after the other; None where it leaves the centres of cells."""
    if world.occupancy() is None or len(points) < 2:
        return None
    origin, step = world.cell_centers([[0, world.height - 1]])[0], world.resolution
    yaw = world.origin[2] if len(world.origin) > 2 else 0.0
    away = points[:, :2] - origin
    turned = (
        np.column_stack([away[:, 0] * math.cos(yaw) + away[:, 1] * math.sin(yaw), away[:, 1] * math.cos(yaw) - away[:, 0] * math.sin(yaw)]) / step
    )
    corners = np.round(turned)
    if np.abs(turned - corners).max() > 1e-6:
        return None
    found = [corners[:1]]
    for a, b in pairwise(corners):
        away, count = b - a, int(np.abs(b - a).max())
        if count and not set(np.abs(away).tolist()) <= {0.0, float(count)}:
            return None
        found.append(a + np.outer(np.arange(1, count + 1), away / max(count, 1)))
    return np.concatenate(found)


def gaps(measures: Measures, of: Exact, on_lattice: bool) -> Measures:
    """Gap to the optimum of the path's own model, that at any angle, and turns above the fewest of the shortest lattice
    paths (``fewest``: it is shortest and has no more)."""
    best = of.lattice if on_lattice else of.any_angle
    length = measures["length"]
    found: Measures = {"optimum": best, "gap": gap(length, best), "any_angle_gap": gap(length, of.any_angle)}
    found["hit"] = None if found["gap"] is None else found["gap"] == 0
    if on_lattice and of.lattice_turns is not None:
        found["more_turns"] = measures["turns"] - of.lattice_turns
        found["fewest"] = found["hit"] and found["more_turns"] == 0
    return found


def gap(length: float, best: float | None) -> float | None:
    """By how many per cent a length is above the best; None where that is not known."""
    if best is None or best <= 0:
        return None
    share = length / best - 1
    return 0.0 if abs(share) < SAME else 100 * share


def searched(history: np.ndarray, iterations: int, evaluations: int, optimum: float | None) -> tuple[Measures, list[list[float]] | None]:
    """What a search of ours did, and its curve; each iteration is taken to have as many evaluations.

    ``last`` is the first iteration from which on the best is final within 1e-6 of it; for the others see :func:`worked`.
    """
    found: Measures = {"evaluations": evaluations, "iterations": iterations}
    if not len(history):
        return found, None
    first = 1 if history[0][0] == 0 else 0  # swarms count their first population as iteration 0
    each = evaluations / max(iterations + first, 1)
    work = np.clip(np.round((history[:, 0] + first) * each), 0, evaluations)
    found["last"] = int(history[_settled(history)][0])
    more, curve = worked(np.column_stack([work, history[:, 1]]), optimum)
    return found | more, curve


def worked(history: np.ndarray, optimum: float | None) -> tuple[Measures, list[list[float]] | None]:
    """``last_evaluation``, evaluations from which on the best is final, ``near``, evaluations after which it was within 1 % of the optimum (None:
    never), and the curve: evaluations and best so far."""
    if not len(history):
        return {}, None
    found: Measures = {"last_evaluation": int(history[_settled(history)][0])}
    if optimum is not None:
        near = np.flatnonzero(history[:, 1] <= optimum * (1 + NEAR) * (1 + SAME))
        found["near"] = int(history[near[0]][0]) if len(near) else None
    curve = history[np.append(np.diff(history[:, 0]) > 0, True)]  # of several with as many evaluations the last
    return found, [[int(n), float(best)] for n, best in thinned(curve, MOST_IMPROVEMENTS)]


def _settled(history: np.ndarray) -> int:
    final = history[-1][1]
    return int(np.argmax(history[:, 1] <= final + abs(final) * SETTLED))


def thinned(rows: np.ndarray, most: int) -> np.ndarray:
    """At most so many rows, first and last among them, evenly by number."""
    if len(rows) <= most:
        return rows
    return rows[np.unique(np.round(np.linspace(0, len(rows) - 1, most)).astype(int))]


def points_of(path: _core.Path, query: _core.Query) -> list[list[float]]:
    """Points along a path for pictures, m."""
    return np.round(thinned(np.asarray(_core.polyline(path, query), float)[:, :2], MOST_POINTS), 6).tolist()
