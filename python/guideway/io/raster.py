"""Scenes as grids: every cell that a solid shape touches is blocked."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from guideway.io.types import Disc, GridMap, Polygon, Scene

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from guideway.io.types import BoolGrid

    Floats = NDArray[np.float64]
    Ints = NDArray[np.int64]


def rasterize(scene: Scene) -> GridMap:
    """The grid that a scene stands on with its shapes drawn into it; without a map, cells of the scene's resolution over its bounds.

    Conservative: a cell is blocked if the closed shape and the closed cell meet. The origin is the lower-left corner of the bounds; the last column
    and row may reach over them.
    """
    import numpy as np

    if scene.map is not None:
        blocked = scene.map.blocked.copy()
        unknown, resolution, origin = scene.map.unknown, scene.map.resolution, scene.map.origin
    else:
        x0, y0, x1, y1 = scene.bounds
        resolution, unknown, origin = scene.resolution, None, (x0, y0, 0.0)
        # bounds that are a whole number of cells up to rounding get no extra column
        shape = (max(1, math.ceil((b - a) / resolution - 1e-9)) for a, b in ((y0, y1), (x0, x1)))
        blocked = np.zeros(tuple(shape), bool)
    for shape in scene.shapes:
        _draw(blocked, shape, resolution, origin)
    return GridMap(blocked, unknown, resolution, origin, scene.source, scene.sha256, scene.files, "scene")


def _draw(blocked: BoolGrid, shape: Disc | Polygon, resolution: float, origin: tuple[float, float, float]) -> None:
    """Blocks the cells that ``shape`` meets, in the grid's frame, where cell (column i, row j from below) covers [i, i + 1] x [j, j + 1]."""
    import numpy as np

    c, s = math.cos(origin[2]), math.sin(origin[2])
    points = [shape.center] if isinstance(shape, Disc) else list(shape.points)
    moved = [((x - origin[0]) / resolution, (y - origin[1]) / resolution) for x, y in points]
    corners = np.array([(c * x + s * y, c * y - s * x) for x, y in moved])
    reach = shape.radius / resolution if isinstance(shape, Disc) else 0.0
    height, width = blocked.shape
    low = np.clip(np.floor(corners.min(0) - reach) - 1, 0, [width, height]).astype(int)
    high = np.clip(np.ceil(corners.max(0) + reach) + 1, 0, [width, height]).astype(int)
    if (low >= high).any():
        return
    columns, rows = np.arange(low[0], high[0])[None, :], np.arange(low[1], high[1])[:, None]
    hit = _disc_meets(corners[0], reach, columns, rows) if isinstance(shape, Disc) else _polygon_meets(corners, columns, rows)
    # rows counted from below become rows from the top
    blocked[height - high[1] : height - low[1], low[0] : high[0]] |= hit[::-1]


def _disc_meets(center: Floats, radius: float, columns: Ints, rows: Ints) -> BoolGrid:
    import numpy as np

    dx = center[0] - np.clip(center[0], columns, columns + 1)
    dy = center[1] - np.clip(center[1], rows, rows + 1)
    return dx * dx + dy * dy <= radius * radius


def _polygon_meets(corners: Floats, columns: Ints, rows: Ints) -> BoolGrid:
    """Separating axes: a convex polygon and a cell are apart only if an edge normal of one of them tells them apart."""
    import numpy as np

    low, high = corners.min(0), corners.max(0)
    meets = (columns <= high[0]) & (columns + 1 >= low[0]) & (rows <= high[1]) & (rows + 1 >= low[1])
    for a, b in zip(corners, np.roll(corners, -1, 0), strict=True):
        normal = np.array([b[1] - a[1], a[0] - b[0]])
        along = corners @ normal
        center = (columns + 0.5) * normal[0] + (rows + 0.5) * normal[1]
        half = np.abs(normal).sum() / 2
        meets &= (center + half >= along.min()) & (center - half <= along.max())
    return meets
