"""Files and messages to plain, checked data and back: maps, scenarios, scenes, trajectories.

Nothing here plans. Every complaint is a :class:`guideway.errors.BadFile`: one paragraph that names the file and the field, the value, what is
allowed and what to do. Names are loaded when they are first used, so that importing this package costs nothing.
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from guideway.io.collections import load_collection
    from guideway.io.export import write_map, write_trajectory
    from guideway.io.info import maps_info
    from guideway.io.lines import ScenarioRow, load_moving_ai, load_scenario, load_text
    from guideway.io.map_server import load_map_server
    from guideway.io.packaged import load_packaged
    from guideway.io.scene import load_movers, load_scene
    from guideway.io.types import Appears, Disc, Footprint, GridMap, Lidar, Mover, Plan, Polygon, Query, Robot, Scene, Thresholds, Unknown
    from guideway.io.write import write_atomic

_HOME = {
    **dict.fromkeys(("Appears", "Disc", "Footprint", "GridMap", "Lidar", "Mover", "Plan", "Polygon", "Query", "Robot", "Scene"), "types"),
    **dict.fromkeys(("ScenarioRow", "load_moving_ai", "load_scenario", "load_text"), "lines"),
    **dict.fromkeys(("load_movers", "load_scene"), "scene"),
    **dict.fromkeys(("write_map", "write_trajectory"), "export"),
    "load_collection": "collections",
    "load_map_server": "map_server",
    "load_packaged": "packaged",
    "maps_info": "info",
    "write_atomic": "write",
}

__all__ = [
    "Appears",
    "Disc",
    "Footprint",
    "GridMap",
    "Lidar",
    "Mover",
    "Plan",
    "Polygon",
    "Query",
    "Robot",
    "ScenarioRow",
    "Scene",
    "load",
    "load_collection",
    "load_map",
    "load_map_server",
    "load_movers",
    "load_moving_ai",
    "load_packaged",
    "load_scenario",
    "load_scene",
    "load_text",
    "maps_info",
    "write_atomic",
    "write_map",
    "write_trajectory",
]

_KINDS = "*.yaml (map_server), *.map (Moving AI), *.txt (rows of . and #), *.toml (scene), a collection such as barn_worlds.json.gz#7, or scene:NAME"


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def _extension(path: str | os.PathLike[str]) -> str:
    base = os.path.basename(os.fspath(path)).lower()
    return os.path.splitext(base.removesuffix(".gz"))[1]


def load(path: str | os.PathLike[str], *, unknown: Unknown | None = None, thresholds: Thresholds | None = None) -> GridMap | Scene:
    """Loads whatever ``MAP`` of the command line may be, told by its name; ``scene:NAME`` is a scene that ships with the package.

    ``unknown`` ("blocked", "free") says what unknown cells of map_server maps do to the robot, ``thresholds`` ("inclusive", "strict") picks the
    reading of their pixels (see :mod:`guideway.io.map_server`). Raises :class:`guideway.errors.BadFile`.
    """
    if os.fspath(path).startswith("scene:"):
        from guideway.io.packaged import load_packaged

        return load_packaged(path, unknown=unknown, thresholds=thresholds)
    if _extension(os.fspath(path).rpartition("#")[0] or path) == ".json" or _extension(path) == ".json":
        from guideway.io.collections import load_collection

        return load_collection(path)
    if _extension(path) == ".toml":
        from guideway.io.scene import load_scene

        return load_scene(path, unknown=unknown, thresholds=thresholds)
    return load_map(path, unknown=unknown or "blocked", thresholds=thresholds or "inclusive")


def load_map(path: str | os.PathLike[str], *, unknown: Unknown = "blocked", thresholds: Thresholds = "inclusive") -> GridMap:
    """Loads an occupancy grid: map_server YAML, Moving AI or text, told by its name; options as in :func:`load`."""
    from guideway.errors import BadFile
    from guideway.io.files import name

    extension = _extension(path)
    if extension in (".yaml", ".yml"):
        from guideway.io.map_server import load_map_server

        return load_map_server(path, unknown=unknown, thresholds=thresholds)
    from guideway.io.lines import load_moving_ai, load_text

    if extension == ".map":
        return load_moving_ai(path)
    if extension == ".txt":
        return load_text(path)
    images = (".pgm", ".ppm", ".png", ".bmp", ".jpg", ".jpeg")
    todo = "Name the YAML file that describes this image" if extension in images else "Name one of these"
    raise BadFile(name(path), f"{extension or 'a name without an extension'} is not a kind of map", _KINDS, todo)
