"""Plain geometry on arrays: polylines, outlines, distances to discs and convex polygons."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def size_of(value: Any) -> float:
    """A length from a file, m: 0 where it is not a usable number."""
    return float(value) if isinstance(value, int | float) and 0 <= value <= 1e6 else 0.0


def listed(value: Any) -> list[Any]:
    """A list from a file: empty where it is none."""
    return list(value) if isinstance(value, list | tuple | np.ndarray) else []


def points(rows: Any, columns: int = 2) -> Array:
    """Rows of numbers as ``(n, columns)``; empty where there is nothing usable."""
    try:
        array = np.asarray([list(row)[:columns] for row in listed(rows)], dtype=np.float64)
    except (TypeError, ValueError):
        return np.empty((0, columns))
    return np.asarray(array) if array.ndim == 2 and array.shape[1] == columns and np.isfinite(array).all() else np.empty((0, columns))


def arc_length(line: Array) -> Array:
    """Length of a polyline up to each of its points, m: ``(n,)``."""
    return np.asarray(np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])) if len(line) else np.empty(0)


def footprint_radius(footprint: Any) -> float:
    """Radius of the disc around the reference point that covers a footprint, m."""
    if not isinstance(footprint, Mapping):
        return 0.0
    if "disc" in footprint:
        return size_of(footprint["disc"])
    corners = outline(footprint)
    reach = float(np.hypot(corners[:, 0], corners[:, 1]).max()) if len(corners) else 0.0
    return reach + size_of(footprint.get("radius"))


def outline(shape: Mapping[str, Any]) -> Array:
    """Corners of a box, a polygon or an outline (``points`` grown by ``radius``) in its own frame, m; empty for a disc."""
    if "box" in shape:
        length, width = ([size_of(v) / 2 for v in listed(shape["box"])] + [0.0, 0.0])[:2]
        return np.array([[-length, -width], [length, -width], [length, width], [-length, width]])
    return points(shape.get("polygon") or shape.get("points"))


def shape_distance(shape: Mapping[str, Any], at: Array) -> Array:
    """Distance from points to a static disc or polygon, m; 0 inside."""
    if "disc" in shape:
        disc = shape["disc"]
        return np.maximum(np.hypot(*(at - np.asarray(disc["center"], dtype=np.float64)).T) - float(disc["radius"]), 0.0)
    corners = points(shape.get("polygon", {}).get("points"))
    return polygon_distance(np.broadcast_to(corners, (len(at), *corners.shape)), at[:, None, :])[:, 0]


def polygon_distance(corners: Array, at: Array) -> Array:
    """Distance from points ``(t, n, 2)`` to convex polygons ``(t, m, 2)``: ``(t, n)``; 0 inside."""
    start, edge = corners[:, None], np.roll(corners, -1, axis=1)[:, None] - corners[:, None]
    offset = at[:, :, None] - start
    part = np.clip((offset * edge).sum(-1) / np.maximum((edge**2).sum(-1), 1e-18), 0, 1)
    distance = np.linalg.norm(offset - part[..., None] * edge, axis=-1).min(axis=-1)
    if corners.shape[1] < 3:
        return np.asarray(distance)
    side = edge[..., 0] * offset[..., 1] - edge[..., 1] * offset[..., 0]
    return np.where((side >= 0).all(-1) | (side <= 0).all(-1), 0.0, distance)


def placed(shape: Mapping[str, Any], pose: Array) -> tuple[Array, float]:
    """Corners of a shape at poses ``(t, 3)`` and the radius around them: a disc is its centre with a radius. ``(t, m, 2)``, m."""
    if "disc" in shape:
        return pose[:, None, :2], size_of(shape["disc"])
    corners = outline(shape)
    if not len(corners):
        return pose[:, None, :2], size_of(shape.get("radius"))
    cos, sin = np.cos(pose[:, 2])[:, None], np.sin(pose[:, 2])[:, None]
    x, y = corners[:, 0][None], corners[:, 1][None]
    return np.stack([pose[:, :1] + cos * x - sin * y, pose[:, 1:2] + sin * x + cos * y], axis=-1), size_of(shape.get("radius"))
