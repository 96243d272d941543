"""Site rules: a world with what a mask forbids, and the speeds that a mask allows.

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
    """``world`` with what a mask forbids; see ``World.with_keep_out``."""
    import numpy as np

    if isinstance(mask, (str, os.PathLike)):
        values, header, _ = read_mask(mask)
        forbidden, resolution, origin = values == 100, header.resolution, header.origin
    else:
        x, y, yaw = world.origin
        forbidden, resolution, origin = np.asarray(mask, bool), world.resolution, (x, y, yaw)
        if forbidden.shape != (world.height, world.width):
            raise BadParameter(f"keep-out mask of shape {forbidden.shape}: an array must have that of the map, ({world.height}, {world.width})")
    if world.occupancy() is None:
        return world.forbidding(shapes=_polygons(_clipped(forbidden, resolution, origin, world), resolution, origin))
    cells = np.zeros((world.height, world.width), bool)
    _block(cells, _corners(forbidden, resolution, origin), world)
    return world.forbidding(cells)


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


def _clipped(forbidden: NDArray[np.bool_], resolution: float, origin: tuple[float, float, float], world: World) -> NDArray[np.bool_]:
    """The forbidden cells that reach into the bounds of a world; as with a map, what is beyond does not count."""
    import numpy as np

    x0, y0, x1, y1 = world.bounds
    rows, columns = np.nonzero(forbidden)
    corners = _corners(forbidden, resolution, origin)
    near = (corners.min(axis=1) < (x1, y1)).all(axis=1) & (corners.max(axis=1) > (x0, y0)).all(axis=1)
    kept = np.zeros_like(forbidden)
    kept[rows[near], columns[near]] = True
    return kept


def _polygons(forbidden: NDArray[np.bool_], resolution: float, origin: tuple[float, float, float]) -> list[dict[str, Any]]:
    """Rectangles that cover the forbidden cells and nothing else."""
    import numpy as np

    height = forbidden.shape[0]
    across, down = _rectangles(forbidden), _rectangles(forbidden.T)
    boxes = across if len(across) <= len(down) else [(left, top, right, bottom) for top, left, bottom, right in down]
    corners = [np.array([[a, height - d], [b, height - d], [b, height - c], [a, height - c]], float) for a, c, b, d in boxes]
    return [{"polygon": {"points": _to_map(box, resolution, origin).tolist()}} for box in corners]


def _rectangles(cells: NDArray[np.bool_]) -> list[tuple[int, int, int, int]]:
    """Rectangles (left, top, right, bottom; they may overlap): from each cell not covered yet as far right, and then as far down, as it goes."""
    import numpy as np

    left_over, found = cells.copy(), []
    for top in range(cells.shape[0]):
        while (free := np.flatnonzero(left_over[top])).size:
            left = int(free[0])
            right = left + int(np.append(np.flatnonzero(~cells[top, left:]), cells.shape[1] - left)[0])
            full = cells[top:, left:right].all(axis=1)
            bottom = top + int(np.append(np.flatnonzero(~full), full.size)[0])
            left_over[top:bottom, left:right] = False
            found.append((left, top, right, bottom))
    return found
