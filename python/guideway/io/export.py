"""Maps, scenes and trajectories to files; what is written here is read back the same by :mod:`guideway.io`."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from guideway.errors import BadFile
from guideway.io.files import name
from guideway.io.types import GridMap, Mover, Scene
from guideway.io.write import write_atomic

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

COLUMNS = ("t", "x", "y", "yaw", "speed", "acceleration", "jerk", "curvature")
"""Columns of a trajectory CSV: s, m, m, rad, m/s, m/s2, m/s3, 1/m."""

_BLOCKED, _UNKNOWN, _FREE = 0, 205, 254  # the grey values that map_saver writes
_EPSILON = 1e-12


def write_map(item: GridMap | Scene, path: str | os.PathLike[str]) -> list[Path]:
    """Writes a map or scene in the format its name asks for and returns the files written.

    ``.yaml``: map_server with a binary PGM beside it; ``.map``: Moving AI; ``.txt``: text; ``.toml``: scene. Moving AI and text know neither
    resolution, origin nor unknown cells: what blocks the robot is blocked there. A scene becomes a grid by blocking every cell that an obstacle
    touches; its movers, robot and query are not part of a grid. Raises :class:`BadFile`.
    """
    target = Path(path)
    extension = target.suffix.lower()
    if extension == ".toml":
        write_atomic(target, scene_toml(item, target))
        return [target]
    if extension not in (".yaml", ".yml", ".map", ".txt"):
        todo = "Give the output one of these names"
        raise BadFile(name(path), f"{extension or 'a name without an extension'} is not a kind of map", ".yaml, .map, .txt or .toml", todo)
    grid = item if isinstance(item, GridMap) else _rasterized(item)
    if extension in (".yaml", ".yml"):
        return _write_map_server(grid, target)
    free, blocked = (".", "@") if extension == ".map" else (".", "#")
    head = f"type octile\nheight {grid.height}\nwidth {grid.width}\nmap\n" if extension == ".map" else ""
    write_atomic(target, head.encode() + _rows(grid, free, blocked))
    return [target]


def _rasterized(scene: Scene) -> GridMap:
    from guideway.io.raster import rasterize

    return rasterize(scene)


def _rows(grid: GridMap, free: str, blocked: str) -> bytes:
    import numpy as np

    cells = np.full((grid.height, grid.width + 1), ord("\n"), np.uint8)
    cells[:, :-1] = np.where(grid.blocked, np.uint8(ord(blocked)), np.uint8(ord(free)))
    return cells.tobytes()


def _write_map_server(grid: GridMap, target: Path) -> list[Path]:
    image = target.with_suffix(".pgm")
    x, y, yaw = grid.origin
    lines = [
        f"image: {json.dumps(image.name, ensure_ascii=False)}",
        "mode: trinary",
        f"resolution: {grid.resolution!r}",
        f"origin: [{x!r}, {y!r}, {yaw!r}]",
        "negate: 0",
        "occupied_thresh: 0.65",
        "free_thresh: 0.196",
    ]
    # the image first: the YAML file never names an image that is not there
    write_atomic(image, f"P5\n{grid.width} {grid.height}\n255\n".encode() + _grey(grid).tobytes())
    write_atomic(target, "\n".join(lines) + "\n")
    return [target, image]


def _grey(grid: GridMap) -> NDArray[np.uint8]:
    import numpy as np

    grey = np.where(grid.blocked, np.uint8(_BLOCKED), np.uint8(_FREE))
    if grid.unknown is not None:
        grey[grid.unknown] = _UNKNOWN
    return grey


def scene_toml(item: GridMap | Scene, target: Path) -> str:
    """The text of a scene file; a map in it is named relative to the folder of ``target``."""
    scene = item if isinstance(item, Scene) else None
    grid = item if isinstance(item, GridMap) else item.map
    world: dict[str, Any]
    if grid is not None:
        world = {"map": os.path.relpath(grid.source, target.parent or ".")}
        if grid.unknown is not None and not bool((grid.blocked & grid.unknown).any()):
            world["unknown"] = "free"
        if grid.thresholds != "inclusive":
            world["thresholds"] = grid.thresholds
    else:
        world = {"bounds": item.bounds, "resolution": item.resolution}
    if scene is not None and scene.keep_out:
        world["keep_out"] = [os.path.relpath(mask, target.parent or ".") for mask in scene.keep_out]
    if scene is not None and scene.speed_mask is not None:
        world["speed_mask"] = os.path.relpath(scene.speed_mask, target.parent or ".")
    if scene is not None and scene.mover_speed is not None:
        world["mover_speed"] = scene.mover_speed
    parts = [toml_table("[world]", world)]
    if scene is not None:
        parts += [toml_table(f"[[{kind}]]", fields) for shape in scene.shapes for kind, fields in shape.to_dict().items() if isinstance(fields, dict)]
        parts += [toml_table("[[mover]]", _mover(mover)) for mover in scene.movers]
        parts += _settings(scene)
    return "\n".join(parts)


def _settings(scene: Scene) -> list[str]:
    parts: list[str] = []
    if scene.has_robot:
        parts.append(toml_table("[robot]", {"footprint": scene.robot.footprint.to_dict(), **scene.robot.limits()}))
    if scene.lidar is not None:
        parts.append(toml_table("[lidar]", vars(scene.lidar)))
    if (query := scene.query) is not None:
        fields = {key: value for key, value in vars(query).items() if not key.endswith("_yaw")}
        for key, point, yaw in (("start", query.start, query.start_yaw), ("goal", query.goal, query.goal_yaw)):
            fields[key] = None if point is None else [*point, *([] if yaw is None else [yaw])]
        fields["via"] = query.via or None
        parts.append(toml_table("[query]", fields))
    if scene.plan is not None:
        parts.append(toml_table("[plan]", {**vars(scene.plan), "set": scene.plan.set or None}))
    return parts


def _mover(mover: Mover) -> dict[str, Any]:
    fields: dict[str, Any] = {"shape": mover.shape.to_dict()}
    if mover.path is not None and mover.speed is not None:
        fields.update(path=mover.path, speed=mover.speed if len(mover.track) > 1 else None)
    else:
        fields["trajectory"] = mover.track
    appears = mover.appears.to_dict() if mover.appears else None
    return {**fields, "loop": mover.loop, "phase": mover.phase, "appears": appears}


def toml_table(head: str, fields: dict[str, Any]) -> str:
    """A table of a TOML file; fields that are None are left out."""
    return "\n".join([head, *(f"{_key(key)} = {_value(value)}" for key, value in fields.items() if value is not None), ""])


def _key(key: str) -> str:
    return key if key.isascii() and key.replace("_", "").replace("-", "").isalnum() else _value(key)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        # numbers out of NumPy print their type in repr
        return repr(float(value))
    if isinstance(value, int):
        return str(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(str(k))} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, Iterable) and not isinstance(value, str):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    # JSON strings are TOML strings, but for DEL
    return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")


def write_trajectory(path: str | os.PathLike[str], rows: ArrayLike) -> None:
    """Writes a trajectory CSV with the header ``t,x,y,yaw,speed,acceleration,jerk,curvature``; ``rows`` has shape (n, 8), finite, SI units.

    Raises :class:`BadFile` for another shape, values that are not finite and times that do not increase.
    """
    import numpy as np

    table = np.asarray(rows, float)
    if table.ndim != 2 or table.shape[1] != len(COLUMNS) or not np.isfinite(table).all():
        raise BadFile(
            name(path), f"rows of shape {table.shape} that may not be finite", f"finite numbers of shape (n, {len(COLUMNS)})", "Correct the rows"
        )
    if (np.diff(table[:, 0]) <= -_EPSILON).any():
        raise BadFile(name(path), "the times go back", "times that increase from row to row", "Sort the rows")
    lines: Sequence[str] = [",".join(COLUMNS), *(",".join(f"{v:.10g}" for v in row) for row in table.tolist())]
    write_atomic(path, "\n".join(lines) + "\n")
