"""Figures for papers (PNG and SVG, by matplotlib) and plain map images (by Pillow alone)."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from guideway.files import write_whole

from .geometry import Array, arc_length, footprint_radius, listed, outline, points
from .products import expand
from .profile import robot_footprint
from .report import is_run, labels
from .scenery import (
    BLOCKED,
    FORBIDDEN,
    OFF_LIMITS,
    SHADE_SIDE,
    UNKNOWN,
    Scenery,
    drawn_cells,
    drawn_shapes,
    field_cell,
    shading,
    shrink_field,
    shrink_walls,
)

COLOURS = ("#0072b2", "#007d59", "#a04a82", "#946200", "#7d4e2d", "#6b5fb5")
"""As in the page: told apart with every common colour vision, dark enough for text on white."""
WALL, UNSEEN, NEAR, FAR = (50, 61, 73), (221, 226, 232), (204, 216, 228), (255, 255, 255)
MOST_SIDE = 4096
"""Longest side of a map image, pixels; larger maps are reduced without losing walls."""
LEAST_SIDE = 512
"""Longest side, pixels, that the image of a small map has at least: its cells are drawn as squares of whole pixels."""


def map_png(world: Scenery, path: str | os.PathLike[str]) -> Path:
    """Writes the map as a PNG: walls, unknown cells, clearance shading; small maps with larger cells. Needs no plotting library.

    Raises ``ValueError`` for a world with neither a grid nor a clearance field.
    """
    target = Path(path)
    buffer = io.BytesIO()
    pixels = map_pixels(world, MOST_SIDE)
    larger = -(-LEAST_SIDE // max(pixels.shape[:2]))
    Image.fromarray(pixels.repeat(larger, 0).repeat(larger, 1), "RGB").save(buffer, "PNG", optimize=True)
    write_whole(target, buffer.getvalue())
    return target


def map_pixels(world: Scenery, most: int, plain: bool = False) -> NDArray[np.uint8]:
    """The map as ``(height, width, 3)`` colours, row 0 on top, at most ``most`` pixels a side; ``plain`` without clearance shading."""
    cells, field = drawn_cells(world), world.clearance_field()
    if cells is None and field is None:
        raise ValueError("this world has no grid to draw: give it a resolution, or draw its shapes with figure()")
    shape = cells.shape if cells is not None else np.asarray(field).shape
    factor = max(1, -(-max(shape) // most))
    tone = np.ones((-(-shape[0] // factor), -(-shape[1] // factor)))
    if field is not None and field.size and not plain:
        small = shrink_field(np.nan_to_num(np.asarray(field), nan=0.0, posinf=0.0, neginf=0.0), factor)
        shaded = shading(np.asarray(field), field_cell(world, cells, field.shape))
        tone = np.sqrt(np.clip(small / (shaded["reach"] if shaded else 1.0), 0, 1))
    pixels = np.asarray(NEAR) + tone[..., None] * (np.asarray(FAR) - np.asarray(NEAR))
    if cells is not None:
        small_cells = shrink_walls(np.asarray(cells), factor)
        for kind, colour in ((BLOCKED, WALL), (UNKNOWN, UNSEEN), (FORBIDDEN, OFF_LIMITS)):
            pixels[small_cells == kind] = colour
    return np.round(pixels).astype(np.uint8)


def figure(results: Sequence[Mapping[str, Any]], world: Scenery | None, path: str | os.PathLike[str]) -> list[Path]:
    """Writes a map figure of plans and runs for a paper as ``path`` with the endings ``.png`` (300 dpi) and ``.svg``.

    Needs matplotlib (``pip install guideway[figures]``), raises ``ImportError`` with that advice without it. Returns the two files.
    """
    results, _ = expand(results, [None] * len(results))
    left, low, right, high = extent(results, world)
    ratio = min(2.0, max(0.4, (high - low) / max(right - left, 1e-9)))
    sheet = figure_sheet((6.3, 6.3 * ratio + 0.5))
    axes = sheet.add_subplot()
    if world is not None:
        draw_world(axes, world)
    for index, (result, label) in enumerate(zip(results, labels(results), strict=True)):
        draw_result(axes, result, label, COLOURS[index % len(COLOURS)], alone=len(results) == 1)
    axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", xlabel="x in m", ylabel="y in m")
    if axes.get_legend_handles_labels()[0]:
        sheet.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    return save(sheet, Path(path))


def figure_sheet(size: tuple[float, float]) -> Any:
    """An empty figure of a size in inches that draws itself without a display."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise ImportError("figures for papers need matplotlib: pip install 'guideway[figures]'") from error
    sheet = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(sheet)
    return sheet


def save(sheet: Any, path: Path) -> list[Path]:
    """Both files, each whole or not at all; without dates, so that the same results give the same bytes."""
    stem = path.with_suffix("") if path.suffix.lower() in {".png", ".svg"} else path
    written = []
    for ending, options in ((".png", {"dpi": 300}), (".svg", {"metadata": {"Date": None}})):
        buffer = io.BytesIO()
        sheet.savefig(buffer, format=ending[1:], **options)
        written.append(stem.with_name(stem.name + ending))
        write_whole(written[-1], buffer.getvalue())
    return written


def extent(results: Sequence[Mapping[str, Any]], world: Scenery | None) -> tuple[float, float, float, float]:
    """What the figure shows: the world's bounds, else the paths with a margin, m."""
    if world is not None:
        left, low, right, high = (float(v) for v in world.bounds)
        return left, low, right, high
    lines = [line for result in results if len(line := final_line(result))]
    if not lines:
        return 0.0, 0.0, 1.0, 1.0
    every = np.concatenate(lines)
    (left, low), (right, high) = every.min(axis=0), every.max(axis=0)
    margin = 0.05 * max(right - left, high - low, 1.0)
    return float(left - margin), float(low - margin), float(right + margin), float(high + margin)


def final_line(result: Mapping[str, Any]) -> Array:
    """The path of a plan, the driven line of a run: ``(n, 2)``."""
    return points(result.get("driven"), 3)[:, 1:] if is_run(result) else points(result.get("polyline"))


def draw_world(axes: Any, world: Scenery, plain: bool = False) -> None:
    """Map image in its frame, and the shapes of a scene; ``plain`` without clearance shading."""
    from matplotlib.patches import Circle, Polygon
    from matplotlib.transforms import Affine2D

    cells, field = world.occupancy(), world.clearance_field()
    grid = cells if cells is not None else field
    if grid is not None:
        cell = field_cell(world, cells, grid.shape)
        x, y, yaw = (float(v) for v in world.origin) if cells is not None else (float(world.bounds[0]), float(world.bounds[1]), 0.0)
        place = Affine2D().rotate(yaw).translate(x, y) + axes.transData
        image = map_pixels(world, 2 * SHADE_SIDE, plain)
        axes.imshow(image, extent=(0, grid.shape[1] * cell, 0, grid.shape[0] * cell), transform=place, interpolation="nearest", zorder=0)
    shapes, wall, off_limits = drawn_shapes(world), *(tuple(channel / 255 for channel in colour) for colour in (WALL, OFF_LIMITS))
    for shape in sorted(shapes, key=lambda shape: not shape.get("forbidden", False)):
        colour = off_limits if shape.get("forbidden") else wall
        if "disc" in shape:
            axes.add_patch(Circle(shape["disc"]["center"], shape["disc"]["radius"], color=colour, linewidth=0))
        else:
            axes.add_patch(Polygon(shape["polygon"]["points"], color=colour, linewidth=0))
    marked = drawn_cells(world)
    if any(shape.get("forbidden") for shape in shapes) or (marked is not None and (marked == FORBIDDEN).any()):
        axes.fill([], [], color=off_limits, label="forbidden")


def draw_result(axes: Any, result: Mapping[str, Any], label: str, colour: str, alone: bool) -> None:
    """The lines of one result, its start and goal, and the robot at a few places."""
    line = final_line(result)
    if alone and not is_run(result):
        reference = result.get("reference")
        extra = [(result.get("raw_path") or result.get("grid_path"), "planner's raw path", "#55626f", (0, (4, 3)))]
        extra.append((reference.get("path") if isinstance(reference, Mapping) else None, "exact optimum", "#17212b", (0, (1, 2))))
        for table, name, tint, dash in extra:
            other = points(table)
            if len(other):
                axes.plot(other[:, 0], other[:, 1], color=tint, linestyle=dash, linewidth=1.0, label=name, zorder=3)
    if len(line):
        axes.plot(line[:, 0], line[:, 1], color=colour, linewidth=1.6, label=label, zorder=4)
        draw_robot(axes, result, line, colour)
    for i, mover in enumerate(m for m in listed(result.get("movers")) if isinstance(m, Mapping)):
        track = points(mover.get("states"), 4)
        there = track[track[:, 3] > 0.5] if len(track) else track
        axes.plot(there[:, 1], there[:, 2], color="#c8500a", linewidth=0.8, alpha=0.8, label=None if i else "moving obstacles", zorder=2)
    query = result.get("query")
    for key, marker in (("start", "o"), ("goal", "*")):
        stop = points([query[key]]) if isinstance(query, Mapping) and query.get(key) else points([])
        if len(stop):
            axes.plot(stop[0, 0], stop[0, 1], marker, color="#17212b", markersize=9 if marker == "*" else 5, markeredgecolor="white", zorder=6)


def draw_robot(axes: Any, result: Mapping[str, Any], line: Array, colour: str) -> None:
    """Outlines of the footprint at nine places, evenly along the line."""
    from matplotlib.patches import Circle, Polygon

    footprint = robot_footprint(result)
    if footprint_radius(footprint) <= 0 or len(line) < 2:
        return
    corners, along = outline(footprint), arc_length(line)
    for s in np.linspace(0, along[-1], 9):
        i = min(int(np.searchsorted(along, s, side="right")) - 1, len(line) - 2)
        x, y = np.interp(s, along, line[:, 0]), np.interp(s, along, line[:, 1])
        dx, dy = line[i + 1] - line[i]
        size = float(np.hypot(dx, dy)) or 1.0
        turned = corners @ np.array([[dx, dy], [-dy, dx]]) / size + [x, y] if len(corners) else corners
        patch = Polygon(turned, fill=False) if len(corners) else Circle((x, y), footprint_radius(footprint), fill=False)
        patch.set(edgecolor=colour, linewidth=0.6, alpha=0.6, zorder=5)
        axes.add_patch(patch)
