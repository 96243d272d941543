"""From files to worlds: what the readers found, as core objects."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from guideway._core import World
from guideway.io.types import GridMap, Scene

if TYPE_CHECKING:
    from guideway.io.types import Footprint


def load(path: str | os.PathLike[str], **options: Any) -> World:
    """The world of a map or scene file. Options are those of :func:`guideway.io.load` (``unknown``, ``thresholds``)."""
    from guideway.io import load as read

    return world_of(read(path, **options))


def world_of(found: GridMap | Scene) -> World:
    """A core world from what a reader returned."""
    if isinstance(found, GridMap):
        return World(
            found.blocked, found.resolution, found.origin, unknown=found.unknown, source=str(found.source), sha256=found.sha256, files=found.files
        )
    shapes = [shape.to_dict() for shape in found.shapes]
    movers = [mover.to_dict() for mover in found.movers]
    common: dict[str, Any] = {"shapes": shapes, "movers": movers, "source": str(found.source), "sha256": found.sha256, "files": found.files}
    if found.map is not None:
        grid = found.map
        world = World(grid.blocked, grid.resolution, grid.origin, unknown=grid.unknown, **common)
    else:
        world = World(bounds=found.bounds, resolution=found.resolution, **common)
    for mask in found.keep_out:
        world = world.with_keep_out(mask)
    return world


def footprint_record(footprint: Footprint) -> dict[str, Any]:
    """A footprint as in files: ``{"disc": r}``, ``{"box": [l, w]}`` or ``{"polygon": [[x, y], ...]}``."""
    return footprint.to_dict()
