"""What the page draws beside the summary, thinned so that large experiments stay small: values of runs, paths, pictures of worlds."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from guideway.errors import GuidewayError
from guideway.lab import worlds
from guideway.lab.cells import Cell, Grid, Record, is_sound, seed_of, value_of
from guideway.lab.experiment import Run
from guideway.lab.movers import Moving
from guideway.view.geometry import Array, points
from guideway.view.scenery import field_cell, picture, shading, shrink_field

MOST_PATHS = 2_000_000
"""Characters of paths in a report; each experiment has its share, and the best, middle and worst of each cell come first."""
MOST_PICTURES = 2_500_000
"""Characters of pictures of worlds in a report, shared in the same way."""
MOST_TRACKS = 20
"""Places of a moving obstacle's track that are drawn."""
LEAST_PATH = 200
"""Characters below which no further path is tried."""
MOST_POINTS = 400
"""Points of a path that is drawn."""
SHADE = 160
"""Longest side of the shading of a world, pixels."""
STATUSES = ("ok", "failed", "invalid", "timeout", "memory", "crashed")


@dataclass
class Budget:
    """What is left of the characters of a report. Experiments come one after the other, those with few runs first: each may take an equal part of
    what is left, and leaves to the others what it does not need.
    """

    paths: int = MOST_PATHS
    pictures: int = MOST_PICTURES
    known: dict[str, int] = field(default_factory=dict[str, int])
    worlds: list[dict[str, Any] | None] = field(default_factory=list["dict[str, Any] | None"])
    _keep: tuple[int, int] = (0, 0)
    _lacking: set[str] = field(default_factory=set[str])

    def share(self, experiments: int) -> None:
        """Begins the next experiment of so many that are left."""
        self._keep = (self.paths - self.paths // experiments, self.pictures - self.pictures // experiments)
        self._lacking.clear()

    def room(self) -> int:
        """Characters of paths that the experiment may still take."""
        return self.paths - self._keep[0]

    def took(self, path: int) -> bool:
        """Takes the characters of a path; False, and nothing more for this experiment, where they do not fit."""
        if path > self.room():
            self._keep = (self.paths, self._keep[1])
            return False
        self.paths -= path
        return True

    def world(self, run: Run) -> int | None:
        """The number of the picture of a run's world; None where it cannot be made or does not fit any more."""
        drawn = run.seed if run.world.get("seed") == worlds.RUN or run.world.get("crossed") else 0
        place = {name: value for name, value in run.world.items() if name != "name"}
        key = json.dumps([place, run.query.get("condition"), run.folder, drawn], sort_keys=True, default=str)
        if key not in self.known and key not in self._lacking:
            self._draw(key, run)
        number = self.known.get(key, -1)
        return None if number < 0 else number

    def _draw(self, key: str, run: Run) -> None:
        self.known[key] = -1
        with contextlib.suppress(GuidewayError, ImportError, OSError, ValueError, TypeError, KeyError):
            found = pictured(run)
            size = len(json.dumps(found))
            if size > self.pictures - self._keep[1]:
                del self.known[key]  # the next experiment may have room
                self._lacking.add(key)
                return
            self.pictures -= size
            self.known[key] = len(self.worlds)
            self.worlds.append(found)


def pictured(run: Run) -> dict[str, Any]:
    """The world of a run under the condition of its query, with the tracks of what moves in it."""
    if run.world.get("crossed"):
        from guideway.lab.kinds.drive import site_of

        world = site_of(run).query.world
    else:
        condition = {"condition": run.query["condition"]} if "condition" in run.query else {}
        world = worlds.make({**run.world, **condition}, run.folder, run.seed)
    return small_picture(world) | ({"movers": [moving(mover) for mover in world.movers]} if world.movers else {})


def moving(mover: Mapping[str, Any]) -> dict[str, Any]:
    """The track of a moving obstacle as x, y, x, y ..., where it is at first, half its width (m), and whether its track is closed."""
    found = Moving(mover)
    half = found.radius or 0.5 * min(mover["shape"].get("box", (0.0,)))
    track = found.places[np.unique(np.linspace(0, len(found.places) - 1, MOST_TRACKS).astype(int))]
    at = [round(float(v), 3) for v in found.at(0.0)]
    return {"track": [round(float(v), 3) for v in track.ravel()], "at": at, "half": round(half, 3), "cycle": found.loop == "cycle"}


class Plain:
    """A world with the walls alone, so that no large shading is made."""

    def __init__(self, world: Any) -> None:
        self.resolution, self.origin, self.bounds, self.shapes = world.resolution, world.origin, world.bounds, list(world.shapes)
        self.cells = world.occupancy()

    def occupancy(self) -> Any:
        """As the world's."""
        return self.cells

    def clearance_field(self) -> None:
        """None: it is not asked for."""


def small_picture(world: Any) -> dict[str, Any]:
    """Walls and shapes of a world, with shading of few pixels."""
    found = picture(Plain(world))
    distances = world.clearance_field()
    if found["walls"] and distances is not None and distances.size:
        factor = max(1, -(-max(distances.shape) // SHADE))
        found["shade"] = shading(shrink_field(np.asarray(distances), factor), factor * field_cell(world, world.occupancy(), distances.shape))
    found["bounds"] = [float(v) for v in found["bounds"]]
    return json.loads(json.dumps(found, default=float))


def drawings(tables: Sequence[Grid], budget: Budget) -> list[dict[str, Any]]:
    """What is drawn of each experiment, from one budget: those with few runs take their share first."""
    order = sorted(range(len(tables)), key=lambda k: sum(len(cell.records) for cell in tables[k].cells.values()))
    found: dict[int, dict[str, Any]] = {}
    for left, place in zip(range(len(tables), 0, -1), order, strict=True):
        budget.share(left)
        found[place] = drawing(tables[place], budget)
    return [found[place] for place in range(len(tables))]


def drawing(table: Grid, budget: Budget) -> dict[str, Any]:
    """Values, paths and worlds of an experiment's cells, in the order of the summary's cells."""
    runs = {(run.key[0], run.key[1], run.key[2]): run for run in table.experiment.runs()}
    chosen = [marked(table, cell) for cell in table.cells.values()]
    drawn: list[list[dict[str, Any]]] = [[] for _ in chosen]
    for rank in range(4):
        for cell, marks, kept in zip(table.cells.values(), chosen, drawn, strict=True):
            for record, role in marks:
                if (role_rank(role) == rank) and (path := path_of(record, budget)):
                    run = runs.get((cell.world, cell.query, cell.method))
                    world = None if run is None else budget.world(replace(run, seed=seed_of(record)))
                    kept.append({"seed": seed_of(record), "role": role, "world": world, "path": path})
    names = shown(table)
    return {"names": names, "cells": [runs_of(cell, names) | {"paths": kept} for cell, kept in zip(table.cells.values(), drawn, strict=True)]}


def role_rank(role: str | None) -> int:
    """Best before median before worst before all others."""
    return {"best": 0, "median": 1, "worst": 2}.get(str(role), 3)


def shown(table: Grid) -> list[str]:
    """Measures whose single values are in the page: those of the experiment, the gap and a time."""
    first = [metric.name for metric in table.experiment.metrics if metric.name in table.measured]
    return list(dict.fromkeys([*first, *(name for name in ("gap", "evaluations") if name in table.measured), "cpu", "wall"]))


def runs_of(cell: Cell, names: Sequence[str]) -> dict[str, Any]:
    """Seeds, states and values of a cell's runs as columns; no values of runs that failed."""
    values = {name: [short(value_of(r, name)) if is_sound(r) else None for r in cell.records] for name in names}
    return {
        "seeds": [seed_of(record) for record in cell.records],
        "states": [state(record) for record in cell.records],
        "values": {name: column for name, column in values.items() if any(value is not None for value in column)},
    }


def state(record: Record) -> int:
    """A status as a number; a result that the checker refused is invalid whatever the record says."""
    status = record.get("status")
    if status == "ok" and not is_sound(record):
        return STATUSES.index("invalid")
    return STATUSES.index(status) if status in STATUSES else STATUSES.index("crashed")


def short(value: float | None) -> float | None:
    """A value with seven digits."""
    return None if value is None else float(f"{value:.7g}")


def marked(table: Grid, cell: Cell) -> list[tuple[Record, str | None]]:
    """The runs of a cell with a path: best, median and worst by the reference measure (else the first that says what is better), then the others."""
    metric = next((m for m in table.compared if m.name == table.experiment.reference), next(iter(table.compared), None))
    paths = [record for record in cell.records if record.get("path")]
    known = cell.by_seed(metric.name) if metric else {}
    sign = -1 if metric and metric.better == "higher" else 1
    order = sorted((r for r in paths if is_sound(r) and seed_of(r) in known), key=lambda r: (sign * known[seed_of(r)], seed_of(r)))
    roles: dict[int, str] = {}
    for role, place in (("worst", len(order) - 1), ("median", (len(order) - 1) // 2), ("best", 0)):
        if order:
            roles[id(order[place])] = role
    return [(record, roles.get(id(record))) for record in paths]


def path_of(record: Record, budget: Budget) -> list[float] | None:
    """A path as x, y, x, y ... with as many digits as can be seen, thinned; None once the report is full."""
    line = points(record.get("path")) if budget.room() > LEAST_PATH else points([])
    if len(line) < 2:
        return None
    span = float(np.ptp(line, axis=0).max()) or 1.0
    digits = max(0, 4 - math.floor(math.log10(span)))
    kept = [round(float(v), digits) for v in thin(line, span / 2500).ravel()]
    size = sum(len(repr(v)) + 1 for v in kept)
    return kept if budget.took(size) else None


def thin(line: Array, tolerance: float) -> Array:
    """Ramer, Douglas and Peucker: the points without which a line would leave its place by more than the tolerance; at most ``MOST_POINTS``."""
    if len(line) > 20 * MOST_POINTS:
        line = line[np.unique(np.linspace(0, len(line) - 1, 20 * MOST_POINTS).astype(int))]
    keep = np.zeros(len(line), dtype=bool)
    keep[[0, -1]] = True
    stack = [(0, len(line) - 1)]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        far, place = farthest(line, first, last)
        if far > tolerance:
            keep[place] = True
            stack += [(first, place), (place, last)]
    kept = line[keep]
    return kept if len(kept) <= MOST_POINTS else kept[np.unique(np.linspace(0, len(kept) - 1, MOST_POINTS).astype(int))]


def farthest(line: Array, first: int, last: int) -> tuple[float, int]:
    """Largest distance of the points between two others from the segment that joins these, and whose it is."""
    between, start, along = line[first + 1 : last], line[first], line[last] - line[first]
    part = np.clip((between - start) @ along / max(float(along @ along), 1e-300), 0, 1)
    distance = np.hypot(*(between - start - part[:, None] * along).T)
    place = int(distance.argmax())
    return float(distance[place]), first + 1 + place
