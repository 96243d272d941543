"""Curves along a path or a drive that the result files leave to the reader: curvature, clearance, distance to moving obstacles."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry import Array, arc_length, footprint_radius, listed, placed, points, polygon_distance, shape_distance
from .scenery import Scenery, field_cell

SAMPLES = 1500
"""Most samples of a curve."""


def de_boor(knots: Array, control: Array, degree: int, u: Array) -> Array:
    """A B-spline at parameters ``u`` by de Boor's recursion: ``(len(u), dimension)``."""
    span = np.clip(np.searchsorted(knots, u, side="right") - 1, degree, len(control) - 1)
    local = np.stack([control[span - degree + i] for i in range(degree + 1)])
    for level in range(1, degree + 1):
        for i in range(degree, level - 1, -1):
            low, high = knots[span - degree + i], knots[span + 1 + i - level]
            width = high - low
            part = np.divide(u - low, width, out=np.zeros_like(u), where=width > 0)[:, None]
            local[i] = (1 - part) * local[i - 1] + part * local[i]
    return np.asarray(local[degree])


def derivative(knots: Array, control: Array, degree: int) -> tuple[Array, Array]:
    """Knots and control points of the derivative, one degree lower."""
    width = knots[degree + 1 : degree + len(control)] - knots[1 : len(control)]
    step = np.divide(degree, width, out=np.zeros_like(width), where=width > 0)[:, None]
    return knots[1:-1], step * np.diff(control, axis=0)


def curvature(path: Mapping[str, Any]) -> list[list[float]] | None:
    """Signed curvature over arc length, rows ``[s, kappa]``; ``None`` for polylines and paths that are not given."""
    control, degree = points(path.get("control_points")), path.get("degree")
    knots = points([[knot] for knot in listed(path.get("knots"))], 1).ravel()
    if not isinstance(degree, int) or degree < 2 or len(control) <= degree or len(knots) != len(control) + degree + 1:
        return None
    if not np.isfinite(knots).all() or (np.diff(knots) < 0).any():
        return None
    first, last = knots[degree], knots[len(control)]
    spans = np.unique(knots[(knots >= first) & (knots <= last)])
    each = int(np.clip(4 * SAMPLES // max(1, len(spans) - 1), 4, 24))
    u = np.unique(np.concatenate([np.linspace(a, b, each) for a, b in pairwise(spans)] or [spans]))
    once = derivative(knots, control, degree)
    twice = derivative(*once, degree - 1)
    d1, d2 = de_boor(*once, degree - 1, u), de_boor(*twice, degree - 2, u)
    speed = np.hypot(d1[:, 0], d1[:, 1])
    kappa = np.divide(d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0], speed**3, out=np.zeros_like(speed), where=speed > 1e-9)
    s = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(u))])
    return rows(np.column_stack([s, kappa]))


def rows(table: Array, most: int = 4 * SAMPLES) -> list[list[float]]:
    """A table thinned evenly to at most ``most`` rows (the last is kept), rounded for a compact file."""
    if not len(table):
        return []
    thinned: list[list[float]] = np.round(table[evenly(len(table), most)], 5).tolist()
    return thinned


def evenly(count: int, most: int) -> NDArray[np.int64]:
    """At most ``most`` indices spread over ``count``, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def sample_field(world: Scenery, at: Array) -> Array | None:
    """Clearance field at points, bilinear between cell centres: ``(n,)`` in m."""
    field = world.clearance_field()
    if field is None or not field.size or not len(at):
        return None
    cells = world.occupancy()
    x, y, yaw = (float(v) for v in world.origin) if cells is not None else (float(world.bounds[0]), float(world.bounds[1]), 0.0)
    cell, (height, width) = field_cell(world, cells, field.shape), field.shape
    dx, dy = at[:, 0] - x, at[:, 1] - y
    column = np.clip((math.cos(yaw) * dx + math.sin(yaw) * dy) / cell - 0.5, 0, width - 1)
    row = np.clip(height - (math.cos(yaw) * dy - math.sin(yaw) * dx) / cell - 0.5, 0, height - 1)
    left, top = np.minimum(column.astype(int), max(0, width - 2)), np.minimum(row.astype(int), max(0, height - 2))
    right, under = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    fx, fy = column - left, row - top
    upper = (1 - fx) * field[top, left] + fx * field[top, right]
    lower = (1 - fx) * field[under, left] + fx * field[under, right]
    return np.asarray((1 - fy) * upper + fy * lower, dtype=np.float64)


def clearance(world: Scenery | None, line: Array, along: Array, radius: float) -> list[list[float]] | None:
    """Free distance around the robot's covering disc, rows ``[along, m]``; ``along`` is arc length or time. ``None`` without a map."""
    if world is None or not len(line):
        return None
    dense = np.linspace(along[0], along[-1], min(SAMPLES, max(2, 4 * len(line))))
    at = np.column_stack([np.interp(dense, along, line[:, 0]), np.interp(dense, along, line[:, 1])])
    exact = world.occupancy() is None and len(world.shapes) > 0
    field = None if exact else sample_field(world, at)
    parts = ([] if field is None else [field]) + [shape_distance(shape, at) for shape in world.shapes]
    return rows(np.column_stack([dense, np.minimum.reduce(parts) - radius])) if parts else None


def separation(run: Mapping[str, Any]) -> list[list[float]] | None:
    """Distance between the driven footprint and the nearest visible mover, rows ``[t, m]``; ``None`` without movers."""
    driven = points(run.get("driven"), 4)
    movers = [m for m in listed(run.get("movers")) if isinstance(m, Mapping) and len(points(m.get("states"), 4))]
    if len(driven) < 2 or not movers:
        return None
    driven = driven[evenly(len(driven), SAMPLES)]
    robot = robot_footprint(run)
    nearest = np.full(len(driven), np.inf)
    own, own_radius = placed(robot, driven[:, 1:])
    for mover in movers:
        states = points(mover["states"], 4)
        pose = np.column_stack([np.interp(driven[:, 0], states[:, 0], states[:, i]) for i in (1, 2)] + [np.zeros(len(driven))])
        there = states[np.clip(np.searchsorted(states[:, 0], driven[:, 0], side="right") - 1, 0, len(states) - 1), 3] > 0.5
        other, other_radius = placed(shape if isinstance(shape := mover.get("shape"), Mapping) else {"disc": 0.0}, pose)
        gap = np.minimum(polygon_distance(other, own).min(axis=1), polygon_distance(own, other).min(axis=1)) - own_radius - other_radius
        nearest = np.where(there, np.minimum(nearest, np.maximum(gap, 0.0)), nearest)
    seen = np.isfinite(nearest)
    return rows(np.column_stack([driven[seen, 0], nearest[seen]])) if seen.any() else None


def robot_footprint(result: Mapping[str, Any]) -> Mapping[str, Any]:
    """Footprint of a run or a plan; a point where none is given."""
    for part in (result.get("robot"), result.get("query")):
        footprint: Any = part.get("footprint") if isinstance(part, Mapping) else None
        if isinstance(footprint, Mapping):
            return footprint
    return {"disc": 0.0}


def plan_profile(plan: Mapping[str, Any], world: Scenery | None) -> dict[str, Any]:
    """Curvature and clearance over arc length of a plan."""
    line = points(plan.get("polyline"))
    path: Any = plan.get("path")
    radius = footprint_radius(robot_footprint(plan))
    return {
        "curvature": curvature(path) if isinstance(path, Mapping) else None,
        "clearance": clearance(world, line, arc_length(line), radius),
    }


def run_profile(run: Mapping[str, Any], world: Scenery | None) -> dict[str, Any]:
    """Clearance to the static world and distance to movers over time of a run."""
    driven = points(run.get("driven"), 3)
    radius = footprint_radius(robot_footprint(run))
    return {"clearance": clearance(world, driven[:, 1:], driven[:, 0], radius), "separation": separation(run)}
