"""Grids and rooms to plan in: those that ship with the package, and generators of more, the same for the same seed on every machine.

>>> import guideway as gw
>>> scene = gw.scenes.load("pso-aco-1")
>>> gw.plan(scene.query(), planner="jump-point").cost
28.627416997969522
>>> gw.scenes.complexity(70, 0.7, seed=1).record["blocked"]
3430
>>> round(gw.plan(gw.scenes.load("w0").query("static")).cost, 3)
6.197
"""

from __future__ import annotations

from typing import Literal, overload

from guideway.errors import BadParameter
from guideway.scenes.calibrated import CLASSES, Targets, calibrated, describe
from guideway.scenes.complexity import complexity
from guideway.scenes.crossings import ROBOTS, crossings
from guideway.scenes.environments import ENVIRONMENTS, environment
from guideway.scenes.grid import GridScene
from guideway.scenes.rooms import ASYMMETRIC, CONDITIONS, MOVERS, NOMINAL, RoomScene, layout, room

__all__ = [
    "ASYMMETRIC",
    "CLASSES",
    "CONDITIONS",
    "ENVIRONMENTS",
    "KINDS",
    "MOVERS",
    "NOMINAL",
    "ROBOTS",
    "GridScene",
    "RoomScene",
    "Targets",
    "calibrated",
    "complexity",
    "crossings",
    "describe",
    "environment",
    "layout",
    "load",
    "make",
    "names",
    "room",
]

KINDS = {
    "calibrated": "shares blocked cells, optima and turns with a packaged scene (--class pso-aco-1, pso-aco-2, m20 or m30; 1 and 2 for short)",
    "simple": "six rectangles",
    "cluttered": "22 % single cells and L-shapes",
    "crowded": "38 % blocks of 2 x 2 cells, aisles of one or two cells",
    "maze": "recursive division, corridors of two cells",
    "complexity": "any size and any blocked share (--density), a corridor stays free",
    "layout": "a room of 10 m x 6 m with eight random discs; its robot, start and goal are those of scene:w0",
}
"""What :func:`make` makes, with a line each."""


def names() -> list[str]:
    """Names of the scenes that ship with the package, for :func:`load` and, with ``scene:`` before them, wherever a map may stand."""
    return [*CLASSES, *MOVERS]


@overload
def load(name: Literal["w0", "w1"], seed: int | None = None) -> RoomScene: ...
@overload
def load(name: Literal["pso-aco-1", "pso-aco-2", "m20", "m30"], seed: None = None) -> GridScene: ...
@overload
def load(name: str, seed: int | None = None) -> GridScene | RoomScene: ...
def load(name: str, seed: int | None = None) -> GridScene | RoomScene:
    """A scene that ships with the package: a grid, or the rooms ``w0`` and ``w1``, whose moving obstacles are drawn from ``seed`` (default 0).

    ``record`` holds its facts, those of a grid as in :func:`calibrated`. Raises :class:`guideway.errors.BadParameter`.
    """
    from guideway.io import load as read
    from guideway.io.types import Scene

    if name in MOVERS:
        return room(name, 0 if seed is None else seed)
    if name not in CLASSES:
        raise BadParameter(f"scene {name!r} is not known: one of {', '.join(names())}")
    if seed is not None:
        raise BadParameter(f"seed {seed!r} is not an option of {name}: nothing in it is random")
    scene = read(f"scene:{name}")
    assert isinstance(scene, Scene)
    assert scene.map is not None
    blocked = scene.map.blocked
    last = len(blocked) - 1
    return GridScene(name, blocked, (0, last), (last, 0), None, describe(blocked, CLASSES[name]))


def make(kind: str, seed: int = 0, *, size: int | None = None, density: float | None = None, scene_class: str | None = None) -> GridScene | RoomScene:
    """A new grid, or room, of one of the ``KINDS``.

    ``size`` is the side in cells (default 30; calibrated grids have that of their class), ``density`` the blocked share of a complexity map (default
    0.3), ``scene_class`` that of a calibrated grid (default "pso-aco-1"). Raises :class:`guideway.errors.BadParameter` for values out of range,
    options that the kind does not have, and kinds that are not known.
    """
    if kind not in KINDS:
        raise BadParameter(f"kind {kind!r} is not known: one of {', '.join(KINDS)}")
    has = {"calibrated": ("class",), "complexity": ("size", "density"), "layout": ()}.get(kind, ("size",))
    for name, value in (("size", size), ("density", density), ("class", scene_class)):
        if value is not None and name not in has:
            raise BadParameter(f"{name} {value!r} is not an option of {kind} maps: they have {' and '.join(has) or 'none'}")
    if kind == "calibrated":
        short = {"1": "pso-aco-1", "2": "pso-aco-2"}
        chosen = scene_class or "pso-aco-1"
        return calibrated(short.get(chosen, chosen), seed)
    if kind == "layout":
        return layout(seed)
    if kind == "complexity":
        return complexity(30 if size is None else size, 0.3 if density is None else density, seed)
    return environment(kind, seed, 30 if size is None else size)
