"""Scene and job files (TOML): a continuous or mapped world, what moves in it, the robot, the query and how to plan."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Literal, cast

from guideway.errors import BadFile
from guideway.io.files import MAX_TEXT, load, name
from guideway.io.movers import read_footprint, read_movers
from guideway.io.tables import HUGE, Table, parse_toml
from guideway.io.types import MAX_CELLS, SOFT_WEIGHT, Corners, Disc, GridMap, Lidar, Material, Mover, Plan, Point, Polygon, Query, Robot, Scene

from guideway.io.types import Thresholds, Unknown  # isort: skip

CORNERS = ("touch", "clear", "squeeze")
MATERIALS = ("standard", "long", "heavy")
REFINEMENTS = ("none", "simplify", "smooth", "bspline")
_RESOLUTION = 0.05


def load_scene(path: str | os.PathLike[str], *, unknown: Unknown | None = None, thresholds: Thresholds | None = None) -> Scene:
    """Loads a scene or job TOML with the files it names (``map``, ``trajectory``), which are relative to it.

    ``unknown`` and ``thresholds`` win over those of the file's ``[world]``. Raises :class:`BadFile` naming file, table and field; fields that are not
    known are refused with the list of those that are.
    """
    blob = load(path, MAX_TEXT)
    where, folder = name(blob.path), blob.path.parent
    top = Table(where, "", parse_toml(where, blob.text()))
    files = {blob.path.name: blob.sha256}
    world = top.table("world")
    if world is None:
        raise BadFile(f"{where}, [world]", "the table is missing", "[world] with bounds = [x0, y0, x1, y1], or map", "Add it")
    grid = _map(world, folder, files, (unknown, thresholds))
    shapes = (*[_disc(t) for t in top.tables("disc")], *[_polygon(t) for t in top.tables("polygon")])
    movers = read_movers(top, folder, files)
    keep_out, speed_mask = _masks(world, folder, files)
    mover_speed = world.optional("mover_speed", 1e-6, 100.0, "m/s")
    bounds, resolution = _extent(world, grid)
    robot, lidar, query, plan = top.table("robot"), top.table("lidar"), top.table("query"), top.table("plan")
    top.done()
    return Scene(
        bounds=bounds,
        resolution=resolution,
        source=blob.path,
        sha256=blob.sha256,
        map=grid,
        shapes=shapes,
        movers=movers,
        robot=read_robot(robot) if robot else Robot(),
        has_robot=robot is not None,
        lidar=_lidar(lidar) if lidar else None,
        query=_query(query) if query else None,
        plan=_plan(plan) if plan else None,
        files=files,
        keep_out=keep_out,
        speed_mask=speed_mask,
        mover_speed=mover_speed,
    )


def _masks(world: Table, folder: Path, files: dict[str, str]) -> tuple[tuple[Path, ...], Path | None]:
    """Site rules: files named relative to the scene, which are read later."""
    from guideway.io.masks import read_mask

    named = world.raw("keep_out") or []
    if not isinstance(named, list) or not all(isinstance(item, str) for item in named):
        raise world.bad("keep_out", 'a list of map_server files, e.g. ["keepout.yaml"]')
    slow = world.text("speed_mask")
    paths = [folder / item for item in [*named, *([] if slow is None else [slow])]]
    for path in paths:
        if not os.path.lexists(path):
            raise BadFile(world.at("keep_out" if path != paths[-1] or slow is None else "speed_mask"), f"the mask {name(path)} does not exist")
        files.update({str(path.parent.relative_to(folder) / key): value for key, value in read_mask(path)[2].items()})
    return tuple(paths[: len(named)]), None if slow is None else paths[-1]


def load_movers(path: str | os.PathLike[str], radius: float = 0.25) -> tuple[Mover, ...]:
    """Loads moving obstacles: a TOML file with ``[[mover]]`` tables, or a CSV with discs of ``radius`` (m): ``t,x,y`` is one that goes once,
    ``t,id,x,y`` one per id (see :func:`guideway.io.movers.load_people`).
    """
    from guideway.io.movers import load_people

    if os.fspath(path).lower().endswith(".csv"):
        return load_people(Path(path), radius)
    blob = load(path, MAX_TEXT)
    where = name(blob.path)
    data = parse_toml(where, blob.text())
    top = Table(where, "", data)
    movers = read_movers(top, blob.path.parent, {})
    for other in ("world", "disc", "polygon", "robot", "lidar", "query", "plan"):  # a whole scene may be named: only its movers count
        top.raw(other)
    top.done()
    if not movers:
        raise BadFile(where, "there is no moving obstacle", "[[mover]] tables", "Add one or leave the option out")
    return movers


def _map(world: Table, folder: Path, files: dict[str, str], options: tuple[Unknown | None, Thresholds | None]) -> GridMap | None:
    from guideway.io import load_map

    unknown = world.choice("unknown", ("blocked", "free"), "blocked")
    thresholds = world.choice("thresholds", ("inclusive", "strict"), "inclusive")
    target = world.text("map")
    if target is None:
        return None
    if target.lower().endswith(".toml"):
        raise world.bad("map", "a map: .yaml (map_server), .map (Moving AI) or .txt")
    path = folder / target
    if not os.path.lexists(path):
        raise BadFile(world.at("map"), f"the map {name(path)} does not exist", todo="Correct the field or copy the map there")
    grid = load_map(path, unknown=options[0] or cast(Unknown, unknown), thresholds=options[1] or cast(Thresholds, thresholds))
    files.update({str(Path(target).parent / key): value for key, value in grid.files.items()})
    return grid


def _extent(world: Table, grid: GridMap | None) -> tuple[tuple[float, float, float, float], float]:
    """Bounds and resolution; a map brings its own."""
    bounds = world.numbers("bounds", (4,), "[x0, y0, x1, y1] in m")
    finest = 1e-6
    given = world.optional("resolution", finest, 1e6, "m")
    world.done()
    if grid is not None:
        if bounds is not None:
            raise BadFile(world.at("bounds"), "bounds and map are both given", "one of the two: a map brings its own bounds", "Remove one")
        if given is not None and not math.isclose(given, grid.resolution, rel_tol=1e-9):
            raise world.bad("resolution", f"{grid.resolution:g} m, the resolution of the map; or leave it out")
        return grid.bounds, grid.resolution
    if bounds is None:
        raise BadFile(world.at("bounds"), "neither bounds nor map is given", "bounds = [x0, y0, x1, y1] in m, or map", "Add one of the two")
    x0, y0, x1, y1 = bounds
    if not (x0 < x1 and y0 < y1):
        raise world.bad("bounds", "[x0, y0, x1, y1] in m with x0 < x1 and y0 < y1")
    resolution = _RESOLUTION if given is None else given
    if math.ceil((x1 - x0) / resolution) * math.ceil((y1 - y0) / resolution) > MAX_CELLS:
        raise world.bad("resolution", f"a cell side in m that gives at most {MAX_CELLS} cells over the bounds", resolution)
    return (x0, y0, x1, y1), resolution


def _disc(table: Table) -> Disc:
    center = table.numbers("center", (2,), "[x, y] in m")
    if center is None:
        raise table.bad("center", "[x, y] in m")
    disc = Disc((center[0], center[1]), table.number("radius", 0.0, 1e6, "m"))
    table.done()
    return disc


def _polygon(table: Table) -> Polygon:
    from guideway.io.movers import check_convex

    points = table.points("points", 3)
    check_convex(table, "points", points)
    table.done()
    return Polygon(points)


def read_robot(table: Table) -> Robot:
    """The ``[robot]`` table: footprint in m, limits in SI units; a deceleration left out equals the acceleration."""
    default = Robot()
    acceleration = table.number("acceleration", 1e-6, 1e6, "m/s2", default.acceleration)
    robot = Robot(
        footprint=read_footprint(table, "footprint") or default.footprint,
        speed=table.number("speed", 1e-6, 1e6, "m/s", default.speed),
        acceleration=acceleration,
        deceleration=table.number("deceleration", 1e-6, 1e6, "m/s2", acceleration),
        jerk=table.number("jerk", 1e-6, 1e6, "m/s3", default.jerk),
        turn_rate=table.optional("turn_rate", 1e-6, 1e6, "rad/s"),
        turn_acceleration=table.optional("turn_acceleration", 1e-6, 1e6, "rad/s2"),
        lateral_acceleration=table.optional("lateral_acceleration", 1e-6, 1e6, "m/s2"),
    )
    table.done()
    return robot


def _lidar(table: Table) -> Lidar:
    default = Lidar()
    lidar = Lidar(
        beams=table.integer("beams", 1, 100_000, default.beams) or default.beams,
        # a full turn may be written with a few digits
        field_of_view=table.number("field_of_view", 0.0, 6.284, "rad", default.field_of_view, above=True),
        range=table.number("range", 0.0, 1e6, "m", default.range, above=True),
        noise=table.number("noise", 0.0, 1e3, "m", default.noise),
        rate=table.number("rate", 0.0, 1e6, "Hz", default.rate, above=True),
    )
    table.done()
    return lidar


def _pose(table: Table, key: str) -> tuple[Point | None, float | None]:
    values = table.numbers(key, (2, 3), "[x, y] in m or [x, y, yaw] in m and rad")
    if values is None:
        return None, None
    return (values[0], values[1]), (values[2] if len(values) == 3 else None)


def _query(table: Table) -> Query:
    start, start_yaw = _pose(table, "start")
    goal, goal_yaw = _pose(table, "goal")
    soft = table.numbers("soft_clearance", (1, 2), "[m] or [m, weight]")
    query = Query(
        start=start,
        goal=goal,
        start_yaw=start_yaw,
        goal_yaw=goal_yaw,
        via=table.points("via", 0) if "via" in table else table.raw("via") or (),
        clearance=table.number("clearance", 0.0, 1e6, "m", 0.0),
        half_width=table.number("half_width", 0.0, 1e6, "m", 0.0),
        soft_clearance=None if soft is None else (soft[0], soft[1] if len(soft) == 2 else SOFT_WEIGHT),
        arrival=table.number("arrival", 0.0, HUGE, "m", 0.1, above=True),
        material=cast(Material, table.choice("material", MATERIALS, "standard")),
        time_limit=table.optional("time_limit", 0.0, 1e6, "s", above=True),
        stop=table.flag("stop", True),
        order=cast('Literal["given", "best"]', table.choice("order", ("given", "best"), "given")),
    )
    table.done()
    return query


def _plan(table: Table) -> Plan:
    settings = table.table("set")
    plan = Plan(
        planner=table.text("planner"),
        set=_settings(settings) if settings else {},
        seed=table.integer("seed", 0, 2**64 - 1),
        iterations=table.integer("iterations", 1, 10**12),
        evaluations=table.integer("evaluations", 1, 10**15),
        seconds=table.optional("seconds", 0.0, 1e6, "s", above=True),
        refine=table.choice("refine", REFINEMENTS, "") or None,
        corners=cast("Corners | None", table.choice("corners", CORNERS, "") or None),
        exact_fallback=table.flag("exact_fallback"),
        pareto=table.flag("pareto"),
        out=table.text("out"),
        report=table.text("report"),
    )
    table.done()
    return plan


def _settings(table: Table) -> dict[str, object]:
    """Parameters of a planner by name; their own ranges are checked by the planner."""
    values: dict[str, object] = {}
    for key in table.keys:
        value = table.raw(key)
        if not isinstance(value, bool | int | float | str) or (isinstance(value, float) and not math.isfinite(value)):
            raise table.bad(key, "a finite number, a text, true or false")
        values[key] = value
    return values
