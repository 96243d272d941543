"""Footprints and moving obstacles of scene files."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

from guideway.errors import BadFile
from guideway.io.files import MAX_TEXT, load, name
from guideway.io.tables import Table, parse_csv
from guideway.io.types import Appears, Footprint, Loop, Mover, Point

LOOPS = ("once", "cycle", "shuttle")
_SHAPES = "{ disc = radius }, { box = [length, width] } or { polygon = [[x, y], ...] } in m"
_LONGEST = 1e9  # s


def read_footprint(table: Table, key: str) -> Footprint | None:
    """The footprint in field ``key``, None where it is missing; a polygon must be convex and hold its reference point (0, 0)."""
    if key not in table:
        return table.raw(key)
    inner = table.table(key)
    if inner is None or sum(kind in inner for kind in ("disc", "box", "polygon")) != 1:
        raise table.bad(key, _SHAPES)
    shape = _shape(inner)
    for kind in ("disc", "box", "polygon"):
        inner.raw(kind)
    inner.done()
    return shape


def _shape(inner: Table) -> Footprint:
    if "disc" in inner:
        return Footprint(disc=inner.number("disc", 0.0, 1e6, "m"))
    if "box" in inner:
        box = inner.numbers("box", (2,), "[length, width] in m")
        if box is None or not (0 < box[0] <= 1e6 and 0 < box[1] <= 1e6):
            raise inner.bad("box", "[length, width], each above 0 and at most 1e6 m")
        return Footprint(box=(box[0], box[1]))
    points = inner.points("polygon", 3)
    sign = check_convex(inner, "polygon", points)
    n = len(points)
    if any(sign * _cross(points[i], points[(i + 1) % n], (0.0, 0.0)) < 0 for i in range(n)):
        raise inner.bad("polygon", "a polygon that holds its reference point (0, 0)")
    return Footprint(polygon=points)


def check_convex(table: Table, key: str, points: Sequence[Point]) -> int:
    """Refuses corners that span no area or no convex polygon; 1 if they go counter-clockwise, else -1."""
    n = len(points)
    # relative to the first corner, so that small polygons far from the origin keep their area
    area = sum(_cross(points[0], points[i], points[i + 1]) for i in range(1, n - 1)) / 2
    if abs(area) < 1e-12:
        raise table.bad(key, "corners that span an area")
    sign = 1 if area > 0 else -1
    turning = 0.0
    for i in range(n):
        a, b, c = points[i], points[(i + 1) % n], points[(i + 2) % n]
        u, v = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
        cross = sign * (u[0] * v[1] - u[1] * v[0])
        if cross < -1e-12 * max(math.hypot(*u) * math.hypot(*v), 1e-300):
            what = f"the polygon is not convex at ({b[0]:g}, {b[1]:g})"
            raise BadFile(table.at(key), what, "corners of a convex polygon, in order", "Split it into convex parts")
        turning += math.atan2(cross, u[0] * v[0] + u[1] * v[1])
    if turning > 2 * math.pi + 1e-6:
        raise BadFile(table.at(key), "the polygon crosses itself", "corners of a convex polygon, in order", "Correct the order")
    return sign


def _cross(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def read_movers(top: Table, folder: Path, files: dict[str, str]) -> tuple[Mover, ...]:
    """The ``[[mover]]`` tables; trajectories are read from files relative to ``folder``, whose sha256 are added to ``files``."""
    return tuple(_mover(table, folder, files) for table in top.tables("mover"))


def _mover(table: Table, folder: Path, files: dict[str, str]) -> Mover:
    shape = read_footprint(table, "shape")
    if shape is None:
        raise table.bad("shape", _SHAPES)
    if ("path" in table) == ("trajectory" in table):
        what = "path and trajectory are both given" if "path" in table else "neither path nor trajectory is given"
        raise BadFile(table.at("path"), what, "path = [[x, y], ...] in m with speed, or trajectory = a CSV file with t,x,y", "Give one of the two")
    motion = _on_path(table) if "path" in table else _on_file(table, folder, files)
    mover = Mover(
        shape=shape,
        loop=cast(Loop, table.choice("loop", LOOPS, "once")),
        phase=table.number("phase", -_LONGEST, _LONGEST, "s", 0.0),
        appears=_appears(table),
        **motion,
    )
    table.done()
    return mover


def _on_path(table: Table) -> dict[str, Any]:
    path = table.points("path", 1)
    table.raw("trajectory")
    legs = sum(math.dist(a, b) for a, b in pairwise(path))
    speed = table.number("speed", 0.0, 1e6, "m/s", None if legs > 0 else 0.0, above=legs > 0)
    track = time_path(path, speed)
    if track[-1][0] > _LONGEST:
        raise table.bad("speed", f"a speed in m/s at which the path takes at most {_LONGEST:g} s")
    return {"track": track, "path": path, "speed": speed}


def _on_file(table: Table, folder: Path, files: dict[str, str]) -> dict[str, Any]:
    table.raw("path")
    if "speed" in table:
        raise BadFile(table.at("speed"), "a trajectory brings its own times", "speed only together with path", "Remove it")
    table.raw("speed")
    if isinstance(table.raw("trajectory"), list):
        return _inline(table)
    file = table.text("trajectory") or ""
    path = folder / file
    if not os.path.lexists(path):
        raise BadFile(table.at("trajectory"), f"the file {name(path)} does not exist", todo="Correct the field or copy the file there")
    return {"track": load_track(path, files, file)}


def _inline(table: Table) -> dict[str, Any]:
    """``trajectory = [[t, x, y], ...]``: the rows themselves."""
    rows = table.rows("trajectory", 3, "[t, x, y] in s and m")
    check_times(table.at("trajectory"), [row[0] for row in rows])
    return {"track": tuple((row[0], row[1], row[2]) for row in rows)}


def time_path(path: Sequence[Point], speed: float) -> tuple[tuple[float, float, float], ...]:
    """Rows (t, x, y) of a path driven at ``speed`` (m/s); points that repeat the one before are dropped."""
    rows = [(0.0, *path[0])]
    for a, b in pairwise(path):
        time = rows[-1][0] + (math.dist(a, b) / speed if speed > 0 else 0.0)
        if time > rows[-1][0]:
            rows.append((time, *b))
    return tuple(rows)


def load_track(path: Path, files: dict[str, str], shown: str = "") -> tuple[tuple[float, float, float], ...]:
    """Rows (t in s, x, y in m) of a CSV file with the header ``t,x,y``; times strictly increasing from 0."""
    blob = load(path, MAX_TEXT)
    where = name(blob.path)
    rows = parse_csv(where, blob.text(), ("t", "x", "y"))
    check_times(where, [row[0] for row in rows])
    files[shown or path.name] = blob.sha256
    return tuple((t, x, y) for t, x, y in rows)


def load_people(path: Path, radius: float) -> tuple[Mover, ...]:
    """Discs from a CSV file: rows ``t,id,x,y`` (or ``t,x,y``: one disc) in any order of ids, times in s that increase for each id.

    The smallest time of the file is the start of the run. A person is there from its first row on, walks straight between rows and stays where its
    rows end.
    """
    blob = load(path, MAX_TEXT)
    where, text = name(blob.path), blob.text()
    first = next((line for line in text.split("\n") if line.strip()), "")
    if [word.strip() for word in first.split(",")] == ["t", "x", "y"]:
        return (Mover(Footprint(disc=radius), load_track(path, {})),)
    rows = parse_csv(where, text, ("t", "id", "x", "y"))
    begin = min(row[0] for row in rows)
    people: dict[float, list[tuple[float, float, float]]] = {}
    for t, who, x, y in rows:
        people.setdefault(who, []).append((t - begin, x, y))
    return tuple(_person(where, who, people[who], radius) for who in sorted(people))


def _person(where: str, who: float, rows: list[tuple[float, float, float]], radius: float) -> Mover:
    start = rows[0][0]
    track = tuple((t - start, x, y) for t, x, y in rows)
    check_times(f"{where}, id {who:g}", [row[0] for row in track])
    return Mover(Footprint(disc=radius), track, phase=-start, appears=Appears(at=start) if start > 0 else None)


def check_times(where: str, times: Sequence[float]) -> None:
    """Refuses times that do not start at 0 or do not increase."""
    if times[0] != 0:
        raise BadFile(f"{where}, field t", f"the first time is {times[0]:g} s", "0 s", "Shift the times")
    for i, (a, b) in enumerate(pairwise(times)):
        if not a < b:
            raise BadFile(f"{where}, field t", f"row {i + 2} has {b:g} s after {a:g} s", "times that increase from row to row", "Sort the rows")


def _appears(table: Table) -> Appears | None:
    inner = table.table("appears")
    if inner is None:
        return None
    appears = Appears(within=inner.optional("within", 0.0, 1e9, "m"), at=inner.optional("at", 0.0, _LONGEST, "s"))
    inner.done()
    if (appears.within is None) == (appears.at is None):
        raise table.bad("appears", "{ within = distance in m } or { at = time in s }")
    return appears
