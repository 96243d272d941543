"""What a map file holds, in numbers."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from guideway.io.types import GridMap, Scene, Thresholds, Unknown

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from guideway.io.types import BoolGrid


def maps_info(path: str | os.PathLike[str], *, unknown: Unknown | None = None, thresholds: Thresholds | None = None) -> dict[str, object]:
    """What ``guideway maps info`` prints; raises :class:`guideway.errors.BadFile`.

    ``kind``, ``source``, ``sha256``; for a grid ``cells`` [width, height], ``size`` [m, m], ``resolution`` (m), ``origin`` [m, m, rad], ``bounds``
    (m), the shares ``free``, ``blocked``, ``unknown`` (0 to 1, they add up to 1: unknown cells count as unknown alone), ``components`` (4-connected
    parts of the cells where a point robot may be) and ``largest_component`` (its share of those cells). A scene has ``bounds``, ``resolution``,
    counts of shapes and movers and what of robot, lidar, query and plan is there; ``map`` holds its grid.
    """
    from guideway.io import load

    item = load(path, unknown=unknown, thresholds=thresholds)
    return grid_info(item) if isinstance(item, GridMap) else _scene_info(item)


def grid_info(grid: GridMap) -> dict[str, object]:
    """The numbers of :func:`maps_info` for a grid."""
    cells = grid.blocked.size
    unseen = int(grid.unknown.sum()) if grid.unknown is not None else 0
    solid = int((grid.blocked & ~grid.unknown).sum()) if grid.unknown is not None else int(grid.blocked.sum())
    sizes = component_sizes(~grid.blocked)
    return {
        "kind": grid.kind,
        "source": str(grid.source),
        "sha256": grid.sha256,
        "cells": [grid.width, grid.height],
        "size": [grid.width * grid.resolution, grid.height * grid.resolution],
        "resolution": grid.resolution,
        "origin": list(grid.origin),
        "bounds": list(grid.bounds),
        "free": (cells - solid - unseen) / cells,
        "blocked": solid / cells,
        "unknown": unseen / cells,
        "components": len(sizes),
        "largest_component": int(sizes.max()) / int(sizes.sum()) if len(sizes) else 0.0,
    }


def _scene_info(scene: Scene) -> dict[str, object]:
    query = scene.query
    return {
        "kind": scene.kind,
        "source": str(scene.source),
        "sha256": scene.sha256,
        "bounds": list(scene.bounds),
        "resolution": scene.resolution,
        "map": grid_info(scene.map) if scene.map else None,
        "discs": sum("disc" in shape.to_dict() for shape in scene.shapes),
        "polygons": sum("polygon" in shape.to_dict() for shape in scene.shapes),
        "movers": len(scene.movers),
        "robot": scene.has_robot,
        "lidar": scene.lidar is not None,
        "start": list(query.start) if query and query.start else None,
        "goal": list(query.goal) if query and query.goal else None,
        "plan": scene.plan is not None,
    }


def component_sizes(free: BoolGrid) -> NDArray[np.int64]:
    """Sizes, in cells, of the 4-connected parts of ``free`` (height, width); empty where nothing is free.

    Runs of free cells along rows are the nodes, runs that lie over each other the edges; labels sink along the edges and are shortened by pointer
    jumping until nothing changes, so that a maze takes a few rounds, not one per turn.
    """
    import numpy as np

    height, width = free.shape
    padded = np.zeros((height, width + 1), np.int8)
    padded[:, :-1] = free
    steps = np.diff(padded.ravel(), prepend=0)
    starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    label = np.arange(len(starts))
    a, b = _touching(starts, ends, width + 1)
    while len(a):
        low = np.minimum(label[a], label[b])
        before = label.copy()
        np.minimum.at(label, before[a], low)
        np.minimum.at(label, before[b], low)
        while True:
            shorter = label[label]
            if np.array_equal(shorter, label):
                break
            label = shorter
        apart = label[a] != label[b]
        a, b = a[apart], b[apart]
    sizes = np.bincount(label, ends - starts) if len(starts) else np.zeros(0)
    return sizes[sizes > 0].astype(np.int64)


def _touching(starts: NDArray[np.int64], ends: NDArray[np.int64], stride: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of runs that lie over each other in neighbouring rows; positions count cells row by row with one blocked cell after each row."""
    import numpy as np

    # runs of the next row that begin before this one ends and end after it begins
    first = np.searchsorted(ends, starts + stride, "right")
    last = np.searchsorted(starts, ends + stride, "left")
    counts = np.maximum(last - first, 0)
    upper = np.repeat(np.arange(len(starts)), counts)
    offset = np.arange(len(upper)) - np.repeat(np.cumsum(counts) - counts, counts)
    return upper, np.repeat(first, counts) + offset
