"""Worlds by what an experiment says of them: files, scenes that ship with the package, worlds of collections, and generators.

A world's specification is a mapping with a ``name`` and either ``source`` (a map or scene file relative to the experiment's folder, ``scene:NAME``,
or ``FILE#N`` of a collection) or ``make`` (one of :data:`GENERATORS`) with its arguments. ``seed = "run"`` draws a generated world anew for every
seed of the experiment: methods are still compared on equal worlds. Worlds are a function of their specification; each process keeps those it made.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from guideway import scenes
from guideway._core import Query, World
from guideway.errors import BadFile, BadParameter
from guideway.io import files
from guideway.io.files import show
from guideway.io.packaged import is_packaged
from guideway.records import Limits
from guideway.scenes import GridScene, RoomScene

if TYPE_CHECKING:
    from guideway.lab.experiment import Experiment

KEPT = 64
"""Worlds that a process keeps."""
TRIED = 100
"""Worlds with queries that are made before the first run, to find mistakes."""
RUN = "run"
"""As ``seed``: the seed of the run."""

QUERY_FIELDS = (
    *("start", "goal", "start_cell", "goal_cell", "via", "footprint", "clearance", "half_width", "soft_clearance"),
    *("corners", "material", "limits", "condition"),
)
"""What a query may say beside its ``name``: keywords of :class:`guideway.Query`, cells instead of points, and the condition of a room."""


@dataclass(frozen=True)
class Generator:
    """What makes a world: the function, its arguments with their types, and those that must be there."""

    make: Callable[..., GridScene | RoomScene]
    arguments: Mapping[str, type]
    needed: tuple[str, ...]


def _calibrated(scene_class: str, seed: int = 0) -> GridScene:
    return scenes.calibrated(scene_class, seed)


def _room(room: str, seed: int = 0) -> RoomScene:
    return scenes.room(room, seed)


GENERATORS: dict[str, Generator] = {
    "calibrated": Generator(_calibrated, {"scene_class": str, "seed": int}, ("scene_class",)),
    "environment": Generator(scenes.environment, {"kind": str, "seed": int, "size": int}, ("kind", "seed")),
    "complexity": Generator(scenes.complexity, {"size": int, "density": float, "seed": int}, ("size", "density", "seed")),
    "room": Generator(_room, {"room": str, "seed": int}, ("room",)),
    "layout": Generator(scenes.layout, {"seed": int}, ("seed",)),
    "crossings": Generator(scenes.crossings, {"seed": int, "robot": str}, ("seed",)),
}
"""The generators by the word in ``make``."""


_COMMON = ("name", "source", "make", "resolution", "unknown", "query", "condition", "crossed")
WORLD_FIELDS = (
    *_COMMON,
    *dict.fromkeys(name for generator in GENERATORS.values() for name in generator.arguments),
)
"""Fields of a specification: those of every world, and the arguments of the generators. ``condition`` is that of a room; ``crossed`` is a matter of
drives, which add movers that cross the path (:mod:`guideway.lab.kinds.drive`): the world here is without them."""


@dataclass(frozen=True, eq=False)
class Place:
    """A world, and what its file or generator says of the query: keywords of :class:`guideway.Query`."""

    name: str
    scene: Any
    """What it was made from: :class:`guideway.scenes.GridScene`, :class:`guideway.scenes.RoomScene`, or what the reader of its file returned."""
    world: World
    asked: Mapping[str, Any]
    resolution: float | None = None

    def query(self, spec: Mapping[str, Any] | None = None) -> Query:
        """Its query with what ``spec`` (see :data:`QUERY_FIELDS`) says instead. Raises :class:`guideway.errors.BadParameter` naming the field."""
        given = {key: value for key, value in (spec or {}).items() if key != "name"}
        where = f"query {(spec or {}).get('name', '')!r} in world {self.name!r}"
        for key in given:
            if key not in QUERY_FIELDS:
                raise BadParameter(f"{where}: {key!r} is not known: one of {', '.join(QUERY_FIELDS)}")
        _check_values(given, where)
        world = _conditioned(self, given.pop("condition", None), where)
        options = _merged(self.asked, _points(world, given, where), where)
        missing = [end for end in ("start", "goal") if end not in options]
        if missing:
            what = "give it in [[queries]], or in query = { start = [x, y], goal = [x, y] } of the world"
            raise BadParameter(f"{where}: no {missing[0]} is given, and the world has none of its own: {what}")
        start, goal = options.pop("start"), options.pop("goal")
        try:
            return Query(world, start, goal, **options)
        except BadParameter as error:
            raise BadParameter(f"{where}: {error}") from None
        except TypeError as error:
            raise BadParameter(f"{where}: {_wrong(world, start, goal, options)}: {error}") from None


def make(spec: Mapping[str, Any], folder: str | os.PathLike[str] = ".", seed: int = 0) -> World:
    """The world of a specification; ``folder`` is that of the experiment, ``seed`` that of the run (only ``seed = "run"`` looks at it)."""
    return place(spec, folder, seed).world


def query(spec: Mapping[str, Any], asked: Mapping[str, Any] | None = None, folder: str | os.PathLike[str] = ".", seed: int = 0) -> Query:
    """The query ``asked`` (see :data:`QUERY_FIELDS`) in the world of a specification."""
    return place(spec, folder, seed).query(asked)


def place(spec: Mapping[str, Any], folder: str | os.PathLike[str] = ".", seed: int = 0) -> Place:
    """World and query of a specification. Raises :class:`guideway.errors.BadParameter` or :class:`guideway.errors.BadFile` naming the field."""
    check(spec)
    plain = {key: (seed if key == "seed" and value == RUN else value) for key, value in spec.items()}
    return _made(json.dumps(plain, sort_keys=True, default=str), os.fspath(folder))


def check(spec: Mapping[str, Any]) -> None:
    """Raises :class:`guideway.errors.BadParameter` naming the field that is wrong; makes nothing."""
    where = f"world {spec.get('name', '')!r}"
    if ("source" in spec) == ("make" in spec):
        raise BadParameter(f"{where}: source or make must say what it is, one of them")
    if "source" in spec:
        _check_fields(spec, (), where)
        if not isinstance(spec["source"], str) or not spec["source"]:
            raise BadParameter(f"{where}: source {show(spec['source'])} is not the name of a file, scene:NAME or FILE#N")
        return
    generator = GENERATORS.get(spec["make"]) if isinstance(spec["make"], str) else None
    if generator is None:
        raise BadParameter(f"{where}: make {spec['make']!r} is not known: one of {', '.join(GENERATORS)}")
    _check_fields(spec, tuple(generator.arguments), where)
    for name in generator.needed:
        if name not in spec:
            raise BadParameter(f"{where}: {name} is missing: make = {spec['make']!r} needs it")
    for name, kind in generator.arguments.items():
        value = spec.get(name)
        fits = isinstance(value, (int, float) if kind is float else kind) and not isinstance(value, bool)
        if name in spec and not fits and not (name == "seed" and value == RUN):
            words = {int: "a whole number", float: "a number", str: "a word"}[kind]
            raise BadParameter(f"{where}: {name} {value!r} is not {words}" + (f' or "{RUN}"' if name == "seed" else ""))


def check_all(experiment: Experiment) -> None:
    """Checks all worlds of an experiment, and makes the first of each kind with every query, as far as :data:`TRIED` goes.

    Raises :class:`guideway.errors.GuidewayError` naming what would fail in every run there: a file that is missing, an argument out of range, a query
    without a start.
    """
    for spec in experiment.worlds:
        check(spec)
        _check_file(spec, experiment.folder)
    words = [{**query, **method.get("query", {})} for method in experiment.methods for query in experiment.queries]
    asked = list({json.dumps(query, sort_keys=True, default=str): query for query in words}.values())
    firsts: dict[str, Mapping[str, Any]] = {}
    for spec in experiment.worlds:
        kind = {key: value for key, value in spec.items() if key not in ("name", "seed")}
        kind |= {"source": str(spec["source"]).partition("#")[0]} if "source" in spec else {}
        firsts.setdefault(json.dumps(kind, sort_keys=True, default=str), spec)
    tried = ((spec, given) for spec in firsts.values() for given in asked)
    for spec, given in islice(tried, TRIED):
        query(spec, {key: value for key, value in given.items() if key != "order"}, experiment.folder, experiment.seeds[0])


def _check_file(spec: Mapping[str, Any], folder: str) -> None:
    source = spec.get("source")
    if source is None or is_packaged(source):
        return
    place = Path(folder, source)
    whole = place.parent / place.name.partition("#")[0]
    if not place.exists() and not whole.exists():
        raise BadParameter(f"world {spec.get('name', '')!r}: source {show(source)}: there is no file {files.name(whole)}")


def _check_fields(spec: Mapping[str, Any], arguments: tuple[str, ...], where: str) -> None:
    known = (*_COMMON, *arguments)
    for key in spec:
        if key not in known:
            raise BadParameter(f"{where}: {key!r} is not known: one of {', '.join(known)}")
    resolution = spec.get("resolution")
    if resolution is not None and (isinstance(resolution, bool) or not isinstance(resolution, (int, float)) or not resolution > 0):
        raise BadParameter(f"{where}: resolution {resolution!r} is not a length above 0 (m)")
    if spec.get("condition", scenes.CONDITIONS[0]) not in scenes.CONDITIONS:
        raise BadParameter(f"{where}: condition {spec['condition']!r} is not known: one of {', '.join(scenes.CONDITIONS)}")
    if not isinstance(spec.get("crossed", False), bool):
        raise BadParameter(f"{where}: crossed {spec['crossed']!r} is not true or false")
    if not isinstance(spec.get("query", {}), Mapping):
        raise BadParameter(f"{where}: query {spec['query']!r} is not a table")


@lru_cache(maxsize=KEPT)
def _made(words: str, folder: str) -> Place:
    spec = json.loads(words)
    where = f"world {spec.get('name', '')!r}"
    if "source" in spec:
        found, asked = _opened(spec, folder)
    else:
        generator = GENERATORS[spec["make"]]
        try:
            found = generator.make(**{name: spec[name] for name in generator.arguments if name in spec})
        except BadParameter as error:
            raise BadParameter(f"{where}: {error}") from None
        asked = _asked(found)
    resolution = spec.get("resolution")
    kept = Place(spec.get("name", ""), found, _world(found), asked, resolution)
    own = dict(spec.get("query", {}))
    for key in own:
        if key not in QUERY_FIELDS:
            raise BadParameter(f"{where}: query.{key} is not known: one of {', '.join(QUERY_FIELDS)}")
    world = _conditioned(kept, own.pop("condition", spec.get("condition")), where)
    return Place(kept.name, found, world, _merged(asked, _points(world, own, where), where), resolution)


def _check_values(given: Mapping[str, Any], where: str) -> None:
    """Numbers that every planner would refuse, and limits that are no table."""
    for name in ("clearance", "half_width", "soft_clearance"):
        value = given.get(name, 0.0)
        if isinstance(value, (bool, int, float)) and (isinstance(value, bool) or not 0 <= value < math.inf):
            raise BadParameter(f"{where}: {name} {value!r} is not a length from 0 (m)")
    for name in ("start", "goal"):
        point = given.get(name)
        if isinstance(point, (list, tuple)) and any(isinstance(v, bool) or (isinstance(v, float) and not math.isfinite(v)) for v in point):
            raise BadParameter(f"{where}: {name} {show(point)} is not a point: [x, y] or [x, y, yaw] in m and rad")
    if not isinstance(given.get("limits", {}), (Mapping, Limits)):
        raise BadParameter(f"{where}: limits {show(given['limits'])} is not a table such as {{ speed = 1.0 }}")


def _merged(asked: Mapping[str, Any], given: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Keywords of a query with those that are given instead; limits one by one."""
    options = dict(asked) | dict(given)
    if isinstance(options.get("limits"), Mapping):
        own = asked.get("limits")
        options["limits"] = _limits((own.to_dict() if isinstance(own, Limits) else {}) | dict(options["limits"]), where)
    return options


def _opened(spec: Mapping[str, Any], folder: str) -> tuple[Any, dict[str, Any]]:
    """What a file, scene or world of a collection is, and its query."""
    source = spec["source"]
    name = source.removeprefix("scene:")
    if is_packaged(source) and name in scenes.names():
        found = scenes.load(name)
        return found, _asked(found)
    from guideway.io import load

    options = {"unknown": spec["unknown"]} if "unknown" in spec else {}
    try:
        found = load(source if is_packaged(source) else Path(folder, source), **options)
    except BadFile as error:
        raise BadParameter(f"world {spec.get('name', '')!r}: source {source!r}: {error}") from None
    return found, _asked_of_file(found)


def _asked(scene: GridScene | RoomScene) -> dict[str, Any]:
    """What a scene asks, as keywords of a query."""
    if isinstance(scene, GridScene):
        start, goal = scene.world.cell_centers([scene.start, scene.goal]).tolist()
        return {"start": tuple(start), "goal": tuple(goal)}
    return _asked_of_file(scene.scene)


def _asked_of_file(found: Any) -> dict[str, Any]:
    """What a scene file asks; nothing for a map alone."""
    from guideway.io.types import Scene
    from guideway.worlds import footprint_record

    if not isinstance(found, Scene):
        return {}
    asked: dict[str, Any] = {}
    robot, said = found.robot, found.query
    if found.has_robot or said is not None:
        asked |= {"footprint": footprint_record(robot.footprint), "limits": Limits(**robot.limits())}  # type: ignore[arg-type]
    if said is not None:
        for end, yaw in (("start", said.start_yaw), ("goal", said.goal_yaw)):
            point = getattr(said, end)
            if point is not None:
                asked[end] = (*point, *([] if yaw is None else [yaw]))
        asked |= {"via": list(said.via), "clearance": said.clearance, "half_width": said.half_width, "material": said.material}
        asked |= {} if said.soft_clearance is None else {"soft_clearance": said.soft_clearance}
    return asked


def _world(found: Any) -> World:
    from guideway.worlds import world_of

    if isinstance(found, GridScene):
        return found.world
    return found.world() if isinstance(found, RoomScene) else world_of(found)


def _conditioned(held: Place, condition: str | None, where: str) -> World:
    """The world under a condition of rooms, with the cells that the specification asks for."""
    world = held.world
    if condition is not None:
        if not isinstance(held.scene, RoomScene):
            raise BadParameter(f"{where}: condition {condition!r} is for rooms (make = room, layout or crossings, or scene:w0 and scene:w1)")
        try:
            world = held.scene.world(condition)
        except BadParameter as error:
            raise BadParameter(f"{where}: {error}") from None
    if held.resolution is None or world.resolution == held.resolution:
        return world
    if world.occupancy() is not None:
        raise BadParameter(f"{where}: resolution {held.resolution!r} is for worlds without a grid of their own; this one has {world.resolution} m")
    return World(bounds=world.bounds, resolution=held.resolution, shapes=world.shapes, movers=world.movers)


def _points(world: World, given: dict[str, Any], where: str) -> dict[str, Any]:
    """A query's keywords: cells as points."""
    for end in ("start", "goal"):
        cell = given.pop(f"{end}_cell", None)
        if cell is None:
            continue
        fits = isinstance(cell, (list, tuple)) and len(cell) == 2 and all(isinstance(i, int) and not isinstance(i, bool) for i in cell)
        if not fits or not (0 <= cell[0] < world.width and 0 <= cell[1] < world.height):
            raise BadParameter(f"{where}: {end}_cell {show(cell)} is no cell: [column, row] up to [{world.width - 1}, {world.height - 1}]")
        given[end] = tuple(world.cell_centers([cell]).tolist()[0])
    return given


def _wrong(world: World, start: Any, goal: Any, options: Mapping[str, Any]) -> str:
    """The name of the keyword that a query refuses."""
    for name, value in options.items():
        try:
            Query(world, start, goal, **{name: value})
        except TypeError:
            return name
        except BadParameter:
            continue
    return "start or goal"


def _limits(values: Mapping[str, Any], where: str) -> Limits:
    try:
        return Limits(**values)
    except TypeError:
        known = Limits().to_dict()
        wrong = next(name for name in values if name not in known)
        raise BadParameter(f"{where}: limits.{wrong} is not known: one of {', '.join(known)}") from None
