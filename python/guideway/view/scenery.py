"""What a picture needs to know of a world, and how a map becomes two small palette images."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from .geometry import shape_distance

FREE, BLOCKED, UNKNOWN, FORBIDDEN = 0, 1, 2, 3
OFF_LIMITS = (232, 190, 178)

WALL_PIXELS = 4096 * 4096
"""Most pixels of an embedded wall image; larger maps are reduced (browsers on phones refuse larger canvases)."""
WALL_BYTES = 5_000_000
"""Most bytes of an embedded wall image before it is reduced."""
SHADE_SIDE = 896
"""Longest side of the embedded clearance image, pixels; it is smooth, so it is drawn interpolated."""
SCENE_SIDE = 240
"""Longest side of the clearance image that is made for a world of shapes alone, pixels."""
SHADES = 64
"""Tones of the clearance image."""


class Scenery(Protocol):
    """The part of a world that can be drawn; ``guideway.World`` has it. Images have row 0 on top."""

    @property
    def resolution(self) -> float:
        """Side of a cell, m."""
        ...

    @property
    def origin(self) -> Sequence[float]:
        """Pose of the lower-left corner of the lower-left cell: x, y in m, yaw in rad."""
        ...

    @property
    def bounds(self) -> Sequence[float]:
        """Left, lower, right, upper edge, m."""
        ...

    @property
    def shapes(self) -> Sequence[Mapping[str, Any]]:
        """``{"disc": {"center": [x, y], "radius": r}}`` and ``{"polygon": {"points": [[x, y], ...]}}``, m."""
        ...

    def occupancy(self) -> NDArray[np.uint8] | None:
        """``(height, width)``: 0 free, 1 blocked, 2 unknown; ``None`` in a world without a grid."""
        ...

    def clearance_field(self) -> NDArray[np.floating[Any]] | None:
        """``(height, width)``: distance from each cell to the nearest obstacle, m; ``None`` if not at hand."""
        ...


@dataclass(frozen=True)
class Snapshot:
    """A world looked at once: its grids are copied out of it a single time, however often they are drawn."""

    resolution: float
    origin: Sequence[float]
    bounds: Sequence[float]
    shapes: Sequence[Mapping[str, Any]]
    cells: NDArray[np.uint8] | None
    field: NDArray[np.floating[Any]] | None

    @classmethod
    def of(cls, world: Scenery) -> Snapshot:
        """The present state of a world."""
        return cls(world.resolution, world.origin, world.bounds, drawn_shapes(world), drawn_cells(world), world.clearance_field())

    def occupancy(self) -> NDArray[np.uint8] | None:
        """As :class:`Scenery`."""
        return self.cells

    def clearance_field(self) -> NDArray[np.floating[Any]] | None:
        """As :class:`Scenery`."""
        return self.field


def drawn_cells(world: Scenery) -> NDArray[np.uint8] | None:
    """The cells of a world, those that are only forbidden apart: as :meth:`Scenery.occupancy`, and 3 for what no wall but a keep-out mask blocks."""
    cells, solid = world.occupancy(), getattr(world, "solid", None)
    if cells is None or solid is None:
        return cells
    return np.where((cells == BLOCKED) & (solid.occupancy() != BLOCKED), FORBIDDEN, cells).astype(np.uint8)


def drawn_shapes(world: Scenery) -> list[Mapping[str, Any]]:
    """The shapes of a world, with ``forbidden`` true where nothing stands."""
    solid = getattr(world, "solid", None)
    if solid is None:
        return list(world.shapes)
    standing = list(solid.shapes)
    return [shape if shape in standing else {**shape, "forbidden": True} for shape in world.shapes]


def shrink_walls(cells: NDArray[np.uint8], factor: int) -> NDArray[np.uint8]:
    """Reduces a map by an integer factor so that no wall is lost: a block is blocked if any cell is, else forbidden, else unknown if any is."""
    height, width = cells.shape
    padded = np.pad(cells, ((0, -height % factor), (0, -width % factor)), constant_values=FREE)
    blocks = padded.reshape(padded.shape[0] // factor, factor, padded.shape[1] // factor, factor)
    blocked, unknown, forbidden = ((blocks == kind).any(axis=(1, 3)) for kind in (BLOCKED, UNKNOWN, FORBIDDEN))
    return np.where(blocked, BLOCKED, np.where(forbidden, FORBIDDEN, np.where(unknown, UNKNOWN, FREE))).astype(np.uint8)


def shrink_field(field: NDArray[np.floating[Any]], factor: int) -> NDArray[np.float32]:
    """Reduces a field by an integer factor; the mean of each block."""
    height, width = field.shape
    padded = np.pad(field.astype(np.float32), ((0, -height % factor), (0, -width % factor)), mode="edge")
    blocks = padded.reshape(padded.shape[0] // factor, factor, padded.shape[1] // factor, factor)
    return np.asarray(blocks.mean(axis=(1, 3), dtype=np.float32), dtype=np.float32)


def palette_png(values: NDArray[np.uint8], colours: Sequence[tuple[int, int, int]], clear: int | None = None) -> bytes:
    """A palette PNG of the fewest bits per pixel; ``clear`` is the index drawn transparent."""
    image = Image.fromarray(values, "L").copy()
    image.putpalette([channel for colour in colours for channel in colour])
    bits = 1 if len(colours) <= 2 else 2 if len(colours) <= 4 else 8
    buffer = io.BytesIO()
    extra: dict[str, Any] = {} if clear is None else {"transparency": clear}
    image.save(buffer, "PNG", bits=bits, compress_level=6, **extra)
    return buffer.getvalue()


def walls(cells: NDArray[np.uint8], resolution: float) -> dict[str, Any]:
    """The blocked and unknown cells as an image, at full resolution where that is small enough."""
    factor = 1
    while cells.shape[0] * cells.shape[1] / factor**2 > WALL_PIXELS:
        factor += 1
    while True:
        small = cells if factor == 1 else shrink_walls(cells, factor)
        colours = [(255, 255, 255), (46, 56, 68), (214, 219, 225), OFF_LIMITS][: 4 if (small == FORBIDDEN).any() else 3]
        data = palette_png(np.minimum(small, len(colours) - 1), colours, clear=FREE)
        if len(data) <= WALL_BYTES:
            return image_entry(data, small.shape, resolution * factor, cells.shape, resolution) | {"factor": factor}
        factor += 1


def shading(field: NDArray[np.floating[Any]], cell: float) -> dict[str, Any] | None:
    """The clearance as an image of few tones; ``reach`` is the distance of the last tone, m."""
    factor = max(1, -(-max(field.shape) // SHADE_SIDE))
    small = shrink_field(np.nan_to_num(field, nan=0.0, posinf=0.0, neginf=0.0), factor)
    positive = small[small > 0]
    if positive.size == 0:
        return None
    reach = float(np.percentile(positive, 97))
    tones = np.round((SHADES - 1) * np.sqrt(np.clip(small / reach, 0, 1))).astype(np.uint8)
    levels = [round(205 + 50 * i / (SHADES - 1)) for i in range(SHADES)]
    greys = [(level, level, level) for level in levels]
    return image_entry(palette_png(tones, greys), small.shape, cell * factor, field.shape, cell) | {"reach": reach}


def image_entry(data: bytes, shape: tuple[int, ...], pixel: float, cells: tuple[int, ...], cell: float) -> dict[str, Any]:
    """Image and its place in the map frame: ``cell`` m per pixel, ``span`` and ``top`` the extent of the map from its origin, m."""
    place = {"cell": pixel, "span": cells[1] * cell, "top": cells[0] * cell}
    return {"png": base64.b64encode(data).decode("ascii"), "width": shape[1], "height": shape[0]} | place


def picture(world: Scenery) -> dict[str, Any]:
    """Everything the page draws of a world, ready for JSON."""
    cells, field = drawn_cells(world), world.clearance_field()
    bounds = [float(v) for v in world.bounds]
    origin = [float(v) for v in world.origin] if cells is not None else [bounds[0], bounds[1], 0.0]
    entry: dict[str, Any] = {"bounds": bounds, "origin": origin, "shapes": drawn_shapes(world), "walls": None, "shade": None}
    if cells is not None and cells.size:
        entry["walls"] = walls(np.asarray(cells, dtype=np.uint8), float(world.resolution))
    if field is not None and field.size:
        entry["shade"] = shading(np.asarray(field), field_cell(world, cells, field.shape))
    elif cells is None and entry["shapes"]:
        entry["shade"] = shading(*scene_field(bounds, entry["shapes"]))
    return entry


def scene_field(bounds: Sequence[float], shapes: Sequence[Mapping[str, Any]]) -> tuple[NDArray[np.float64], float]:
    """Clearance of a world of shapes on a coarse grid for shading, row 0 on top, and the side of its cells, m."""
    left, low, right, high = bounds
    cell = max(right - left, high - low, 1e-9) / SCENE_SIDE
    x = left + cell * (np.arange(max(1, round((right - left) / cell))) + 0.5)
    y = low + cell * (np.arange(max(1, round((high - low) / cell)))[::-1] + 0.5)
    at = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2).astype(np.float64)
    nearest = np.full(len(at), np.inf)
    for shape in shapes:
        np.minimum(nearest, shape_distance(shape, at), out=nearest)
    return nearest.reshape(len(y), len(x)), cell


def field_cell(world: Scenery, cells: NDArray[np.uint8] | None, shape: tuple[int, ...]) -> float:
    """Side of a cell of the clearance field, m: the grid's, or what fills the bounds of a world without one."""
    if cells is not None:
        return float(world.resolution)
    return (float(world.bounds[2]) - float(world.bounds[0])) / shape[1]
