"""Site rules: a world without what a mask forbids, and the speeds that a mask allows.

The masks are read as Nav2's costmap filters read them (https://docs.nav2.org, keepout filter and speed filter). A keep-out mask forbids where its
value is 100. A speed mask allows ``base + multiplier * value`` percent of the top speed where its value is above 0; Nav2's own files have base 100
and multiplier -1, so that darker is slower. Values that are unknown say nothing, and a limit that is not above 0 or not below 100 percent is none:
black walls in a mask of speeds do not stop a robot.
"""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any

from guideway._core import SpeedMap, World
from guideway.errors import BadParameter
from guideway.io.masks import read_mask

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MAX_RATIO = 64
"""A mask's cell may be so many times as long as one of the map."""
SLOWEST = 1e-3
"""Smallest limit, m/s."""


def speed_map(path: str | os.PathLike[str], speed: float, *, base: float = 100.0, multiplier: float = -1.0, absolute: bool = False) -> SpeedMap:
    """The speeds that a mask allows a robot whose top speed is ``speed`` (m/s).

    ``base + multiplier * value`` is in percent of ``speed``, or with ``absolute`` (Nav2's filter type 2) in m/s. Raises
    :class:`guideway.errors.BadFile` for a file that is no mask, :class:`BadParameter` for numbers that are not finite.
    """
    import numpy as np

    if not (math.isfinite(speed) and speed > 0):
        raise BadParameter(f"speed {speed!r} is out of range: it must be a finite number above 0, m/s")
    if not (math.isfinite(base) and math.isfinite(multiplier)):
        raise BadParameter(f"base {base!r} and multiplier {multiplier!r} must be finite numbers")
    values, header, _ = read_mask(path)
    allowed = (base + multiplier * values.astype(float)) * (1.0 if absolute else speed / 100.0)
    limited = (values > 0) & (allowed > 0.0) & (allowed < speed)
    return SpeedMap(np.where(limited, np.maximum(allowed, SLOWEST), np.inf), header.resolution, header.origin, source=os.fspath(path))


def with_keep_out(world: World, mask: str | os.PathLike[str] | NDArray[np.bool_]) -> World:
    """``world`` without what a mask forbids; see ``World.with_keep_out``."""
    import numpy as np

    if isinstance(mask, (str, os.PathLike)):
        values, header, _ = read_mask(mask)
        forbidden, resolution, origin = values == 100, header.resolution, header.origin
    else:
        x, y, yaw = world.origin
        forbidden, resolution, origin = np.asarray(mask, bool), world.resolution, (x, y, yaw)
        if forbidden.shape != (world.height, world.width):
            raise BadParameter(f"keep-out mask of shape {forbidden.shape}: an array must have that of the map, ({world.height}, {world.width})")
    corners = _corners(forbidden, resolution, origin)
    known = world.occupancy()
    if known is None:
        return _with_polygons(world, forbidden, resolution, origin)
    blocked = known != 0
    _block(blocked, corners, world)
    return _core_world(world, blocked=blocked, unknown=(known == 2) if (known == 2).any() else None)


def _corners(forbidden: NDArray[np.bool_], resolution: float, origin: tuple[float, float, float]) -> NDArray[np.float64]:
    """The four corners of every forbidden cell, m, shape (n, 4, 2)."""
    import numpy as np

    rows, columns = np.nonzero(forbidden)
    height = forbidden.shape[0]
    low = np.stack([columns, height - 1 - rows], axis=1).astype(float)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    return _to_map(low[:, None, :] + square[None], resolution, origin)


def _to_map(cells: NDArray[np.float64], resolution: float, origin: tuple[float, float, float]) -> NDArray[np.float64]:
    import numpy as np

    x, y, yaw = origin
    c, s = np.cos(yaw), np.sin(yaw)
    scaled = cells * resolution
    return np.stack([x + c * scaled[..., 0] - s * scaled[..., 1], y + s * scaled[..., 0] + c * scaled[..., 1]], axis=-1)


def _block(blocked: NDArray[np.bool_], corners: NDArray[np.float64], world: World) -> None:
    """Blocks every cell of a map that the box around a forbidden cell meets."""
    import numpy as np

    x, y, yaw = world.origin
    c, s = np.cos(yaw), np.sin(yaw)
    d = (corners - np.array([x, y])) / world.resolution
    cells = np.stack([c * d[..., 0] + s * d[..., 1], c * d[..., 1] - s * d[..., 0]], axis=-1)
    # A mask that lies like the map must not spill over by rounding.
    low = np.floor(cells.min(axis=1) + 1e-6).astype(np.int64)
    high = np.ceil(cells.max(axis=1) - 1e-6).astype(np.int64) - 1
    across = int((high - low).max(initial=0)) + 1
    if across > MAX_RATIO:
        raise BadParameter(f"a cell of the keep-out mask covers {across} cells of the map: at most {MAX_RATIO} are accepted")
    height, width = blocked.shape
    for dy in range(across):
        for dx in range(across):
            px, py = low[:, 0] + dx, low[:, 1] + dy
            inside = (px <= high[:, 0]) & (py <= high[:, 1]) & (px >= 0) & (py >= 0) & (px < width) & (py < height)
            blocked[height - 1 - py[inside], px[inside]] = True


def _with_polygons(world: World, forbidden: NDArray[np.bool_], resolution: float, origin: tuple[float, float, float]) -> World:
    """A world of shapes with a rectangle for each run of forbidden cells; equal runs in rows after each other are one."""
    import numpy as np

    height = forbidden.shape[0]
    open_runs: dict[tuple[int, int], int] = {}
    boxes: list[tuple[int, int, int, int]] = []
    for row in range(height + 1):
        line = forbidden[row] if row < height else np.zeros(forbidden.shape[1], bool)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], line, [False]]).astype(np.int8)))
        runs = {(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)}
        for run in [run for run in open_runs if run not in runs]:
            boxes.append((run[0], height - row, run[1], height - open_runs.pop(run)))
        for run in runs:
            open_runs.setdefault(run, row)
    rectangles = [np.array([[a, low], [b, low], [b, high], [a, high]], float) for a, low, b, high in boxes]
    shapes = [{"polygon": {"points": _to_map(box, resolution, origin).tolist()}} for box in rectangles]
    return _core_world(world, bounds=world.bounds, more=shapes)


def _core_world(world: World, more: list[dict[str, Any]] | None = None, **kind: Any) -> World:
    """A world like another in all but its map or its shapes."""
    origin = {} if "bounds" in kind else {"origin": world.origin}
    return World(
        **kind,
        **origin,
        resolution=world.resolution,
        shapes=[*world.shapes, *(more or [])],
        movers=world.movers,
        source=world.source,
        sha256=world.sha256,
        files=world.files,
    )
