"""Continuous worlds: a room and a workshop of discs with moving obstacles, and random layouts of the room.

Everything random is drawn in whole millimetres and milliseconds, so the same seed gives the same world on every machine.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

from guideway._core import Query, World
from guideway.errors import BadParameter
from guideway.io.movers import time_path
from guideway.io.types import Disc, Footprint, Mover, Point, Scene
from guideway.records import Limits
from guideway.scenes.draws import Draws
from guideway.scenes.grid import seed_of
from guideway.worlds import footprint_record, world_of

CONDITIONS = ("none", "static", "dynamic")
"""What is in the way: nothing, what stands, or what stands and what moves."""

NOMINAL = Limits(speed=2.0, acceleration=5.0, deceleration=5.0, jerk=10.0, turn_rate=2.0, lateral_acceleration=2.0)
"""The robot of the room and the workshop. It never reaches its acceleration: at this jerk 2 m/s come first."""

ASYMMETRIC = replace(NOMINAL, acceleration=2.0, deceleration=3.0)
"""A second robot, whose limits of acceleration and deceleration differ and do count."""

SHUTTLES = (((3.2, 2.95), (3.2, 4.3), 0.4), ((2.1, 0.5), (3.2, 0.5), 0.4), ((1.5, 5.2), (6.5, 5.2), 0.6), ((5.3, 0.4), (5.3, 2.0), 0.3))
"""The cubes of the room: from, to (m), and speed (m/s)."""

_CUBE, _BALL = Footprint(box=(0.8, 0.8)), Footprint(disc=0.25)
_GAP, _ENDS = 900, 500  # mm between the surfaces of cylinders, and from them to start and goal


@dataclass(frozen=True, eq=False)
class RoomScene:
    """Discs, moving obstacles, a robot and a query.

    ``scene`` is what the file says (:class:`guideway.io.Scene`), ``seed`` what its moving obstacles, or its layout, were drawn from.
    """

    name: str
    scene: Scene
    seed: int

    @property
    def limits(self) -> Limits:
        """The limits of its robot."""
        return Limits(**self.scene.robot.limits())  # type: ignore[arg-type]

    @property
    def discs(self) -> list[tuple[float, float, float]]:
        """Centre and radius of what stands, m."""
        return [(*shape.center, shape.radius) for shape in self.scene.shapes if isinstance(shape, Disc)]

    @cached_property
    def record(self) -> dict[str, Any]:
        """What is known about it, lengths in m: ``discs`` and ``movers`` in number, ``straight`` and the ``shortest`` path among the discs."""
        from guideway._core import plan

        query = self.query("static")
        straight = math.dist(query.start, query.goal)
        return {"discs": len(self.discs), "movers": len(self.scene.movers), "straight": straight, "shortest": plan(query).cost}

    def world(self, condition: str = "dynamic") -> World:
        """Its world under one of the :data:`CONDITIONS`. Raises :class:`guideway.errors.BadParameter`."""
        if condition not in CONDITIONS:
            raise BadParameter(f"condition {condition!r} is not known: one of {', '.join(CONDITIONS)}")
        scene = self.scene
        if condition == "dynamic" and scene is _file(self.name):
            return world_of(scene)
        # what differs from the file does not go by its name
        shapes = [] if condition == "none" else [shape.to_dict() for shape in scene.shapes]
        movers = [mover.to_dict() for mover in scene.movers] if condition == "dynamic" else []
        return World(bounds=scene.bounds, resolution=scene.resolution, shapes=shapes, movers=movers)

    def query(self, condition: str = "dynamic", **options: Any) -> Query:
        """From its start to its goal with its robot; options as those of :class:`guideway.Query`, which win."""
        asked, robot = self.scene.query, self.scene.robot
        assert asked is not None
        assert asked.start is not None
        assert asked.goal is not None
        own: dict[str, Any] = {"footprint": footprint_record(robot.footprint), "clearance": asked.clearance, "limits": self.limits}
        return Query(self.world(condition), asked.start, asked.goal, **(own | options))

    def write(self, path: str | os.PathLike[str]) -> list[Path]:
        """Writes it as a scene file (``.toml``) or, without what moves, as a grid; returns the files written. Raises
        :class:`guideway.errors.BadFile`."""
        from guideway.io import write_map

        return write_map(self.scene, path)


def room(name: str, seed: int = 0) -> RoomScene:
    """The room ``w0`` or the workshop ``w1``; ``seed`` draws where its moving obstacles are, seed 0 is what its file has."""
    scene, seed = _file(name), seed_of(seed)
    if scene is None:
        raise BadParameter(f"room {name!r} is not known: one of {', '.join(MOVERS)}")
    return RoomScene(name, scene if seed == 0 else replace(scene, movers=MOVERS[name](scene, seed)), seed)


@cache
def _file(name: str) -> Scene | None:
    """What the file of a scene that ships with the package says."""
    from guideway.io import load

    scene = load(f"scene:{name}") if name in MOVERS else None
    assert scene is None or isinstance(scene, Scene)
    return scene


def shuttles(_scene: Scene, seed: int) -> tuple[Mover, ...]:
    """Four cubes that go to and fro; where each begins is random."""
    draws, movers = Draws(seed, "w0 movers"), []
    for a, b, speed in SHUTTLES:
        track = time_path((a, b), speed)
        phase = draws.below(round(2000 * track[-1][0])) / 1000
        movers.append(Mover(_CUBE, track, "shuttle", phase, path=(a, b), speed=speed))
    return tuple(movers)


def wanderers(scene: Scene, seed: int) -> tuple[Mover, ...]:
    """Five balls of 0.5 m at 0.3 to 0.8 m/s, each round five random way points; none comes within 1 m of start and goal."""
    draws, movers = Draws(seed, "w1 movers"), []
    ends = ((0.0, 0.0), (12.5, 8.2))
    x0, y0, x1, y1 = (round(1000 * bound) for bound in scene.bounds)
    while len(movers) < 5:
        points = [(draws.between(x0, x1) / 1000, draws.between(y0, y1) / 1000) for _ in range(5)]
        path, speed = (*points, points[0]), draws.between(300, 800) / 1000
        if all(_distance(end, a, b) >= 1.25 for end in ends for a, b in pairwise(path)):
            track = time_path(path, speed)
            movers.append(Mover(_BALL, track, "cycle", draws.below(round(1000 * track[-1][0])) / 1000, path=path, speed=speed))
    return tuple(movers)


MOVERS: dict[str, Callable[[Scene, int], tuple[Mover, ...]]] = {"w0": shuttles, "w1": wanderers}
"""What draws the moving obstacles, by scene."""


def layout(seed: int) -> RoomScene:
    """The room with eight random cylinders of 0.5 to 1.2 m instead of its own, and nothing that moves.

    At least 0.9 m lie between any two surfaces and 0.5 m between them and start and goal; a drawing without a path at 0.3 m is thrown away.
    """
    base, seed = room("w0").scene, seed_of(seed)
    draws = Draws(seed, "layout")
    while True:
        discs = _cylinders(draws)
        shapes = tuple(Disc((x / 1000, y / 1000), r / 1000) for x, y, r in discs)
        found = RoomScene(f"layout-{seed}", replace(base, shapes=shapes, movers=(), source=Path(f"layout-{seed}.toml"), sha256="", files={}), seed)
        if _reaches(found):
            return found


def _cylinders(draws: Draws) -> list[tuple[int, int, int]]:
    """Centres and radii in mm."""
    discs: list[tuple[int, int, int]] = []
    tries = 0
    while len(discs) < 8:
        x, y, r = draws.between(0, 10_000), draws.between(0, 6000), draws.between(250, 600)
        apart = all((x - u) ** 2 + (y - v) ** 2 >= (r + q + _GAP) ** 2 for u, v, q in discs)
        if apart and all((x - u) ** 2 + (y - v) ** 2 >= (r + _ENDS) ** 2 for u, v in ((0, 0), (5000, 3000))):
            discs.append((x, y, r))
        tries += 1
        if tries % 1000 == 0:  # no room for more
            discs.clear()
    return discs


def _reaches(scene: RoomScene) -> bool:
    from guideway._core import plan
    from guideway.errors import NoPath

    try:
        plan(scene.query())
    except NoPath:
        return False
    return True


def _distance(p: Point, a: Sequence[float], b: Sequence[float]) -> float:
    """From ``p`` to the segment ``a b``."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dy * dy
    t = 0.0 if square == 0 else max(0.0, min(1.0, ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square))
    return math.hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy)
