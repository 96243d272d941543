"""Planners on grids of other people: cells that the robot does not fit in are blocked for them, the rest is theirs."""

from __future__ import annotations

import importlib
import random
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

import guideway as gw
from guideway.lab.peers import Answer

Cell = tuple[int, int]


def lattice(query: gw.Query) -> tuple[np.ndarray, Cell, Cell]:
    """Blocked cells (height, width), row 0 on top, and the cells (row, column) of start and goal, which are never blocked."""
    if query.via:
        raise gw.BadParameter("via points are not possible for this peer")
    query.validate()
    world = query.world
    rows, columns = np.mgrid[0 : world.height, 0 : world.width]
    centers = world.cell_centers(np.stack([columns.ravel(), rows.ravel()], 1))
    occupied = world.occupancy()
    blocked = (world.clearance(centers) < query.radius - 1e-9).reshape(world.height, world.width)
    if occupied is not None:
        blocked |= occupied.astype(bool)
    ends = []
    for place in (query.start, query.goal):
        nearest = int(np.argmin(((centers - np.asarray(place[:2])) ** 2).sum(1)))
        ends.append((nearest // world.width, nearest % world.width))
        blocked[ends[-1]] = False
    return blocked, ends[0], ends[1]


def through(query: gw.Query, cells: Any) -> list[list[float]]:
    """Way points (m) from start to goal through cells (row, column), which may be fractions."""
    at = np.asarray(cells, float)
    corner = query.world.cell_centers([(0, 0), (1, 0), (0, 1)])
    inner = corner[0] + at[:, 1:] * (corner[1] - corner[0]) + at[:, :1] * (corner[2] - corner[0])
    points = [list(map(float, query.start[:2])), *inner.tolist(), list(map(float, query.goal[:2]))]
    return [point for k, point in enumerate(points) if k == 0 or np.hypot(*(np.subtract(point, points[k - 1]))) > 1e-9]


def nano_astar(query: gw.Query, *, seed: int, budget: Mapping[str, Any]) -> Answer:
    """nano-astar: A* over eight neighbours that never cuts a corner. It ends on its own: budgets do not count."""
    del seed, budget
    package: Any = importlib.import_module("nano_astar")
    blocked, start, goal = lattice(query)
    grid = np.ascontiguousarray(blocked, np.uint8)
    begun = time.perf_counter()
    found = package.astar(grid, start, goal, heuristic="octile", diagonal=True)
    seconds = time.perf_counter() - begun
    if found is None:
        raise gw.NoPath("nano-astar found no path")
    return Answer(through(query, found[0]), seconds=seconds)


def motion_planning(query: gw.Query, *, seed: int, budget: Mapping[str, Any], planner: str, samples: int | None = None) -> Answer:
    """A planner of python-motion-planning; ``samples`` is the most that a sampling one draws. It ends on its own: budgets do not count.

    Its sampling planners draw from Python's own generator, which is seeded here and put back afterwards.
    """
    del budget
    package: Any = importlib.import_module("python_motion_planning")
    common: Any = importlib.import_module("python_motion_planning.common")
    blocked, start, goal = lattice(query)
    kinds = np.where(blocked, common.TYPES.OBSTACLE, common.TYPES.FREE).astype(np.int8)
    grid = common.Grid(bounds=[[0, blocked.shape[0]], [0, blocked.shape[1]]], resolution=1.0, type_map=kinds)
    words = {} if samples is None else {"max_sample_step": int(samples)}
    made = getattr(package, planner)(map_=grid, start=start, goal=goal, **words)
    before, begun = random.getstate(), time.perf_counter()
    random.seed(seed)
    try:
        path, report = made.plan()
    finally:
        random.setstate(before)
    seconds = time.perf_counter() - begun
    if not report["success"] or not len(path):
        raise gw.NoPath(f"python-motion-planning {planner} found no path")
    return Answer(through(query, path), seconds=seconds)
