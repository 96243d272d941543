"""From files to worlds: what the readers found, as core objects."""

from __future__ import annotations

import os
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from guideway._core import World
from guideway.io.types import Box, Disc, GridMap, Mover, Polygon, Scene

if TYPE_CHECKING:
    from guideway.io.types import Footprint


def load(path: str | os.PathLike[str], **options: Any) -> World:
    """The world of a map or scene file. Options are those of :func:`guideway.io.read` (``unknown``, ``thresholds``)."""
    from guideway.io import read

    return world_of(read(path, **options))


def world_of(found: GridMap | Scene) -> World:
    """A core world from what a reader returned."""
    if isinstance(found, GridMap):
        return World(found.blocked, found.resolution, found.origin, unknown=found.unknown, source=str(found.source), sha256=found.sha256)
    shapes = [shape_record(shape) for shape in found.shapes]
    movers = [mover_record(mover) for mover in found.movers]
    common: dict[str, Any] = {"shapes": shapes, "movers": movers, "source": str(found.source), "sha256": found.sha256}
    if found.map is not None:
        grid = found.map
        return World(grid.blocked, grid.resolution, grid.origin, unknown=grid.unknown, **common)
    return World(bounds=found.bounds, resolution=found.resolution, **common)


def footprint_record(footprint: Footprint) -> dict[str, Any]:
    """A footprint as in files: ``{"disc": r}``, ``{"box": [l, w]}`` or ``{"polygon": [[x, y], ...]}``."""
    if isinstance(footprint, Disc):
        return {"disc": footprint.radius}
    if isinstance(footprint, Box):
        return {"box": [footprint.length, footprint.width]}
    return {"polygon": [list(point) for point in footprint.points]}


def shape_record(shape: Disc | Polygon) -> dict[str, Any]:
    """A static obstacle as in records."""
    if isinstance(shape, Disc):
        return {"disc": {"center": list(shape.center), "radius": shape.radius}}
    return {"polygon": {"points": [list(point) for point in shape.points]}}


def mover_record(mover: Mover) -> dict[str, Any]:
    """A mover as in records."""
    appears = None if mover.appears is None else {key: value for key, value in asdict(mover.appears).items() if value is not None}
    return {
        "shape": footprint_record(mover.shape),
        "track": [list(row) for row in mover.track],
        "loop": mover.loop,
        "phase": mover.phase,
        "appears": appears,
    }
