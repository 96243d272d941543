"""A world as a room of the simulator: an MJCF document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import NDArray

from guideway._core import World
from guideway.errors import BadParameter

WALL = 0.5
"""Height of what stands and moves, m."""
MOST_BOXES = 20_000
"""Largest number of boxes that the cells of a map may become."""
HIDDEN = -10.0
"""Where a mover is that has not appeared, m above the floor."""
STILL, MOVING, FLOOR = "0.36 0.42 0.50 1", "0.83 0.42 0.20 1", "0.86 0.88 0.90 1"


def texts(*values: float) -> str:
    """Numbers as an attribute."""
    return " ".join(f"{value:.9g}" for value in values)


def add(parent: Element, tag: str, **attributes: str) -> Element:
    """A new last child."""
    return SubElement(parent, tag, attributes)


def furnish(root: Element, world: World) -> list[str]:
    """Adds floor, walls and movers of a world to a document; returns the names of the movers' bodies, in their order."""
    assets = add(root, "asset")
    world = world.solid  # what is only forbidden is no body
    stage = add(root, "worldbody")
    left, low, right, high = world.bounds
    middle = ((left + right) / 2, (low + high) / 2)
    reach = max(right - left, high - low)
    stands = {"contype": "2", "conaffinity": "1"}
    _floor(assets, stage, (*middle, right - left, high - low))
    add(
        stage,
        "light",
        pos=texts(middle[0] - 0.3 * reach, middle[1] - 0.5 * reach, 0.9 * reach + 2),
        dir="0.25 0.45 -1",
        diffuse="0.42 0.42 0.42",
        specular="0 0 0",
        directional="true",
    )
    for number, shape in enumerate(world.shapes):
        _solid(assets, stage, f"static {number}", shape, {"rgba": STILL, **stands})
    for number, (x, y, yaw, length, width) in enumerate(boxes(world)):
        place = {"pos": texts(x, y, WALL / 2), "euler": texts(0, 0, yaw), "size": texts(length / 2, width / 2, WALL / 2)}
        add(stage, "geom", name=f"cells {number}", type="box", rgba=STILL, **place, **stands)
    _border(stage, world.bounds)
    names = [f"mover {number}" for number in range(len(world.movers))]
    for name, mover in zip(names, world.movers, strict=True):
        body = add(stage, "body", name=name, mocap="true", pos=texts(0, 0, HIDDEN))
        _solid(assets, body, name, mover["shape"], {"rgba": MOVING, **stands})
    return names


def _floor(assets: Element, stage: Element, place: Sequence[float]) -> None:
    """A plane with squares of one metre."""
    x, y, width, height = place
    add(assets, "texture", name="sky", type="skybox", builtin="flat", rgb1="0.97 0.98 0.99", rgb2="0.97 0.98 0.99", width="64", height="64")
    add(assets, "texture", name="squares", type="2d", builtin="checker", rgb1="0.90 0.91 0.93", rgb2="0.84 0.86 0.89", width="256", height="256")
    add(assets, "material", name="floor", texture="squares", texrepeat="0.5 0.5", texuniform="true", reflectance="0.02")
    size = texts(width / 2 + 8.0, height / 2 + 8.0, 0.1)
    add(stage, "geom", name="floor", type="plane", pos=texts(x, y, 0), size=size, material="floor", contype="2", conaffinity="5")


def _border(stage: Element, bounds: Sequence[float]) -> None:
    """The border of the world as a line on the floor: it blocks the reference point of a robot, not its body, so nothing can touch it."""
    left, low, right, high = bounds
    for (x, y), (a, b) in (((left, low), (right, low)), ((right, low), (right, high)), ((right, high), (left, high)), ((left, high), (left, low))):
        line(stage, [(x, y), (a, b)], "0.55 0.60 0.66 1", 0.02)


def line(stage: Element, points: Sequence[Sequence[float]], colour: str, radius: float) -> None:
    """A line on the floor that nothing touches."""
    for (x, y), (a, b) in pairwise(points):
        if np.hypot(a - x, b - y) > 1e-6:
            add(
                stage,
                "geom",
                type="capsule",
                fromto=texts(x, y, 0, a, b, 0),
                size=texts(radius),
                rgba=colour,
                contype="0",
                conaffinity="0",
                group="1",
            )


def _solid(assets: Element, parent: Element, name: str, shape: Mapping[str, Any], more: Mapping[str, str]) -> None:
    """A disc, box or convex polygon, standing on the floor; in the frame of ``parent``."""
    if "disc" in shape:
        disc = shape["disc"]
        center, radius = (disc["center"], disc["radius"]) if isinstance(disc, Mapping) else ((0.0, 0.0), disc)
        if radius > 0:
            add(parent, "geom", name=name, type="cylinder", pos=texts(*center, WALL / 2), size=texts(radius, WALL / 2), **more)
    elif "box" in shape:
        length, width = shape["box"]
        add(parent, "geom", name=name, type="box", pos=texts(0, 0, WALL / 2), size=texts(length / 2, width / 2, WALL / 2), **more)
    else:
        polygon = shape["polygon"]
        prism(assets, parent, name, polygon["points"] if isinstance(polygon, Mapping) else polygon, (0.0, WALL), more)


def prism(
    assets: Element, parent: Element, name: str, points: Sequence[Sequence[float]], heights: tuple[float, float], more: Mapping[str, str]
) -> None:
    """A convex polygon as a solid between two heights."""
    corners = [value for z in heights for x, y in points for value in (x, y, z)]
    add(assets, "mesh", name=name, vertex=texts(*corners), inertia="convex")
    add(parent, "geom", name=name, type="mesh", mesh=name, **more)


def boxes(world: World) -> list[tuple[float, float, float, float, float]]:
    """The blocked cells of a map as rectangles: centre (m), heading (rad), length and width (m)."""
    cells = world.occupancy()
    if cells is None:
        return []
    merged = rectangles(np.flipud(np.asarray(cells) > 0))
    if len(merged) > MOST_BOXES:
        raise BadParameter(
            f"the map becomes {len(merged)} boxes for the simulator, at most {MOST_BOXES} are possible: reduce its resolution or its size"
        )
    side, (x0, y0, yaw) = world.resolution, world.origin
    cos, sin = np.cos(yaw), np.sin(yaw)
    found = []
    for column, row, width, height in merged:
        u, v = (column + width / 2) * side, (row + height / 2) * side
        found.append((x0 + cos * u - sin * v, y0 + sin * u + cos * v, yaw, width * side, height * side))
    return found


def rectangles(blocked: NDArray[np.bool_]) -> list[tuple[int, int, int, int]]:
    """Rectangles (column, row, width, height) that cover the true cells and no other: equal runs of neighbouring rows become one."""
    found: list[tuple[int, int, int, int]] = []
    open_: dict[tuple[int, int], int] = {}
    edges = np.diff(np.pad(blocked.astype(np.int8), ((0, 1), (1, 1))), axis=1)
    for row, edge in enumerate(edges):
        runs = list(zip(np.flatnonzero(edge == 1).tolist(), np.flatnonzero(edge == -1).tolist(), strict=True))
        for run in [run for run in open_ if run not in runs]:
            found.append((run[0], open_[run], run[1] - run[0], row - open_.pop(run)))
        for run in runs:
            open_.setdefault(run, row)
    return found
