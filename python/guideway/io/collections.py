"""Worlds out of collections: BARN (``barn_worlds.json.gz#7``) and DynaBARN (``dynabarn_worlds.json#3``), as scenes with query, robot and movers.

BARN [perille2020]: every obstacle is an upright cylinder, start and goal are
those of the navigation challenge. DynaBARN [nair2022]: motions are keyframes (t, x, y) that repeat from the start, read
from ``dynabarn_traj.json`` beside the worlds and joined by straight lines. ``#N`` is the world's own number.
"""

from __future__ import annotations

import json
import os
from itertools import pairwise
from math import dist
from pathlib import Path
from typing import Any

from guideway.errors import BadFile
from guideway.io.files import Blob, guard, load, name, show, word
from guideway.io.movers import check_times
from guideway.io.tables import Table
from guideway.io.types import Disc, Footprint, Lidar, Mover, Point, Polygon, Query, Robot, Scene

_MAX_JSON = 1 << 24
_RESOLUTION = 0.05

# the Jackal robot of the challenge
ROBOT = Robot(Footprint(box=(0.42, 0.33)), speed=2.0, acceleration=2.0, deceleration=2.0, turn_rate=2.0, turn_acceleration=4.0)
LIDAR = Lidar(beams=720, field_of_view=4.71238898038469, range=10.0, noise=0.01, rate=40.0)
ARRIVAL, TIME_LIMIT = 1.0, 100.0


FILES = {"barn": "barn_worlds.json.gz", "dynabarn": "dynabarn_worlds.json"}
"""Name of each collection's file; it lies in a folder of the collection's name in ``GUIDEWAY_DATA``."""


def find_collection(kind: str, file: str | os.PathLike[str] | None = None) -> Path:
    """The file of the collection ``kind`` (a key of :data:`FILES`): ``file``, or where the environment variable ``GUIDEWAY_DATA`` says."""
    if file is not None:
        return Path(file)
    folder = os.environ.get("GUIDEWAY_DATA")
    place = Path(folder or "", kind, FILES[kind])
    if not folder or not place.is_file():
        what = f"it is not in the folder {show(folder)} of GUIDEWAY_DATA" if folder else "GUIDEWAY_DATA, the folder of public data, is not set"
        raise BadFile(str(Path(kind, FILES[kind])), what, "a copy of the collection", "Name its file with --worlds, or set GUIDEWAY_DATA")
    return place


def world_numbers(path: str | os.PathLike[str]) -> list[int]:
    """The numbers of the worlds in a collection, in order."""
    data = _json(load(Path(path), _MAX_JSON))
    if isinstance(data, list):
        found = [world.get("world") for world in data if isinstance(world, dict)]
        return sorted(n for n in found if isinstance(n, int) and not isinstance(n, bool))
    keys = data.get("worlds") if isinstance(data, dict) else None
    return sorted(int(key) for key in keys if key.isascii() and key.isdigit()) if isinstance(keys, dict) else []


def split(path: str | os.PathLike[str]) -> tuple[Path, str | None]:
    """File and world number of ``FILE#N``; the number is None where there is none."""
    text = os.fspath(path)
    base, mark, number = text.rpartition("#")
    if mark and not os.path.lexists(text):
        return Path(base), number
    return Path(text), None


def load_collection(path: str | os.PathLike[str]) -> Scene:
    """Loads world N of ``FILE#N``; raises :class:`BadFile` naming file, world and field."""
    file, number = split(path)
    blob = load(file, _MAX_JSON)
    data = _json(blob)
    where = name(file)
    if isinstance(data, list):
        numbers = [world.get("world") for world in data if isinstance(world, dict)]
        index = _pick(where, number, [n for n in numbers if isinstance(n, int) and not isinstance(n, bool)])
        return _dynabarn(blob, next(w for w in data if isinstance(w, dict) and w.get("world") == index), index)
    top = Table(where, "", data)
    worlds = top.table("worlds")
    if worlds is None:
        raise BadFile(where, "this is not a collection of worlds", "BARN (an object with worlds) or DynaBARN (a list of worlds)", "Name such a file")
    index = _pick(where, number, [int(key) for key in worlds.keys if key.isascii() and key.isdigit() and len(key) < 10])
    return _barn(blob, top, worlds.raw(str(index)), index)


def _json(blob: Blob) -> Any:
    where = name(blob.path)
    text = blob.text(_MAX_JSON)

    def refuse(word: str) -> None:
        raise BadFile(where, f"the value {word} is not a number of JSON", "finite numbers", "Correct it")

    with guard(where):
        try:
            return json.loads(text, parse_constant=refuse)
        except json.JSONDecodeError as e:
            raise BadFile(f"{where}, line {e.lineno}", f"this is not valid JSON: {word(e.msg)}", todo="Copy the file again") from e


def _pick(where: str, number: str | None, known: list[int]) -> int:
    listed = ", ".join(map(str, sorted(known)[:12])) + (" and more" if len(known) > 12 else "")
    if number is None:
        todo = f"Write {Path(where).name}#{min(known, default=0)}"
        raise BadFile(where, "this is a collection: it needs the number of a world", f"#N with N one of {listed}", todo)
    if not (number.isascii() and number.isdigit() and len(number) < 10) or int(number) not in known:
        raise BadFile(where, f"there is no world #{word(number)}", f"one of {listed}", "Name one of these")
    return int(number)


def _scene(blob: Blob, index: int, query: Query, **rest: Any) -> Scene:
    files = {blob.path.name: blob.sha256, **rest.pop("files", {})}
    place: dict[str, Any] = {"source": Path(f"{blob.path}#{index}"), "sha256": blob.sha256, "files": files}
    return Scene(resolution=_RESOLUTION, robot=ROBOT, has_robot=True, lidar=LIDAR, query=query, **place, **rest)


def _barn(blob: Blob, top: Table, centers: object, index: int) -> Scene:
    radius = top.number("radius", 0.0, 1e3, "m", above=True)
    start, goal = _values(top, "start", 3), _values(top, "goal", 2)
    world = Table(top.where, f"world {index}", {"centers": centers})
    discs = tuple(Disc(center, radius) for center in world.points("centers", 1))
    query = Query((start[0], start[1]), (goal[0], goal[1]), start_yaw=start[2], arrival=ARRIVAL, time_limit=TIME_LIMIT, stop=False)
    # the ground of the simulator is open: one metre around everything
    points = [*(d.center for d in discs), (start[0], start[1]), (goal[0], goal[1])]
    return _scene(blob, index, query, bounds=_around(points, 1.0), shapes=discs)


def _dynabarn(blob: Blob, world: Any, index: int) -> Scene:
    table = Table(name(blob.path), f"world {index}", world)
    beside = blob.path.with_name(blob.path.name.replace("worlds", "traj").removesuffix(".gz"))
    motions = load(beside if os.path.lexists(beside) else beside.with_name(beside.name + ".gz"), _MAX_JSON)
    top = Table(name(motions.path), "", _json(motions))
    trajectories = top.table("trajectories")
    if trajectories is None:
        raise top.bad("trajectories", "motions by name")
    start, away = _values(top, "start", 3), _values(top, "goal_relative", 2)
    names = table.raw("moving")
    if not isinstance(names, list) or not all(isinstance(n, str) for n in names):
        raise table.bad("moving", "a list of names of motions")
    shape = Footprint(disc=top.number("obstacle_radius", 0.0, 1e3, "m", above=True))
    movers = tuple(Mover(shape, _keyframes(trajectories, n), "cycle") for n in names)
    fastest = max(map(_top_speed, (_keyframes(trajectories, key) for key in trajectories.keys)), default=None)
    walls = tuple(_wall(wall) for wall in table.tables("static"))
    goal = (start[0] + away[0], start[1] + away[1])
    query = Query((start[0], start[1]), goal, start_yaw=start[2], arrival=ARRIVAL, time_limit=TIME_LIMIT, stop=False)
    points = [*(p for wall in walls for p in wall.points), (start[0], start[1]), goal]
    files = {motions.path.name: motions.sha256}
    return _scene(blob, index, query, bounds=_around(points, 1.0), shapes=walls, movers=movers, mover_speed=fastest, files=files)


def _around(points: list[Point], margin: float) -> tuple[float, float, float, float]:
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    return min(xs) - margin, min(ys) - margin, max(xs) + margin, max(ys) + margin


def _values(table: Table, key: str, count: int) -> tuple[float, ...]:
    values = table.numbers(key, (count,), f"{count} numbers in m and rad")
    if values is None:
        raise table.bad(key, f"{count} numbers in m and rad")
    return values


def _keyframes(trajectories: Table, key: str) -> tuple[tuple[float, float, float], ...]:
    if key not in trajectories:
        raise BadFile(trajectories.where, f"the motion {show(key)} is missing", todo="Copy the file again")
    table = Table(trajectories.where, f"motion {word(key)}", trajectories.raw(key))
    rows = table.rows("keyframes", 3, "[t, x, y] in s and m")
    check_times(f"{trajectories.where}, motion {word(key)}", [row[0] for row in rows])
    return tuple((t, x, y) for t, x, y in rows)


def _top_speed(track: tuple[tuple[float, float, float], ...]) -> float:
    """The largest speed of a motion, m/s; its jump back to the start is none."""
    return max((dist(a[1:], b[1:]) / (b[0] - a[0]) for a, b in pairwise(track)), default=0.0)


def _wall(table: Table) -> Polygon:
    """A box of the simulator seen from above: ``pose`` x, y, z, roll, pitch, yaw of its centre and ``size``."""
    from math import cos, sin

    size, pose = _values(table, "size", 3), _values(table, "pose", 6)
    if size[0] <= 0 or size[1] <= 0:
        raise table.bad("size", "lengths above 0 m")
    c, s = cos(pose[5]), sin(pose[5])
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    halves = [(u * size[0] / 2, v * size[1] / 2) for u, v in corners]
    return Polygon(tuple((pose[0] + c * u - s * v, pose[1] + s * u + c * v) for u, v in halves))
