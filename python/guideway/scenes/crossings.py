"""Random rooms whose obstacles cross the robot's path: the dynamic scenes that controllers are compared on."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from guideway.io.types import Appears, Disc, Footprint, Mover, Point, Query, Robot
from guideway.records import Limits
from guideway.scenes.draws import Draws
from guideway.scenes.grid import seed_of
from guideway.scenes.rooms import RoomScene, _reaches, room

ROBOTS = {
    "default": Limits(speed=1.0, acceleration=1.0, deceleration=1.0, jerk=10.0, turn_rate=2.0, turn_acceleration=4.0),
    "paper": Limits(speed=1.0, acceleration=0.25, deceleration=0.25, jerk=10.0, turn_rate=0.56, turn_acceleration=0.85),
}
"""The robots of these scenes: one that brakes within a second, and that of the source."""

SHARES = (0.3, 0.5, 0.7)
"""Where movers cross, in shares of the path's length."""

_WIDE, _HIGH, _RADIUS = 12_000, 8000, 0.2
_CLEARANCE = {"default": 0.1, "paper": 0.35}


def crossings(seed: int, robot: str = "default") -> RoomScene:
    """A hall of 12 m x 8 m with six random discs, three discs that go to and fro across the shortest path and one obstacle that appears ahead.

    Movers have a radius of 0.3 to 0.5 m and 0.2 to 0.6 m/s and cross at 30, 50 and 70 % of the path, 1.5 to 3 m to each side, at 60 to 120
    degrees; the obstacle that appears has a radius of 0.3 m, stands on the path or up to 0.4 m beside it at 40 to 80 % of it and is there once
    the robot is within 3 m. ``robot`` is one of :data:`ROBOTS`, a disc of 0.2 m; it plans with 0.1 m of clearance, that of the source with its
    safety distance of 0.35 m, so the two have other rooms.
    """
    base, seed = room("w0").scene, seed_of(seed)
    draws = Draws(seed, "crossings")
    limits = ROBOTS[robot]
    machine = Robot(
        footprint=Footprint(disc=_RADIUS),
        speed=limits.speed,
        acceleration=limits.acceleration,
        deceleration=limits.deceleration or limits.acceleration,
        jerk=limits.jerk,
        turn_rate=limits.turn_rate,
        turn_acceleration=limits.turn_acceleration,
    )
    while True:
        start = (1.0, draws.between(1000, _HIGH - 1000) / 1000)
        goal = (_WIDE / 1000 - 1.0, draws.between(1000, _HIGH - 1000) / 1000)
        asked = Query(start=start, goal=goal, clearance=_CLEARANCE[robot], arrival=0.2)
        name = f"crossings-{seed}"
        scene = replace(
            base,
            bounds=(0.0, 0.0, _WIDE / 1000, _HIGH / 1000),
            resolution=0.1,
            shapes=_discs(draws, (start, goal)),
            movers=(),
            robot=machine,
            query=asked,
            source=Path(f"{name}.toml"),
            sha256="",
            files={},
        )
        still = RoomScene(name, scene, seed)
        if _reaches(still):
            return RoomScene(name, replace(scene, movers=_movers(draws, _path(still))), seed)


def _discs(draws: Draws, ends: tuple[Point, Point]) -> tuple[Disc, ...]:
    discs: list[Disc] = []
    while len(discs) < 6:
        x, y, r = draws.between(2000, _WIDE - 2000) / 1000, draws.between(500, _HIGH - 500) / 1000, draws.between(200, 500) / 1000
        if all(math.dist(end, (x, y)) > r + 0.8 for end in ends):
            discs.append(Disc((x, y), r))
    return tuple(discs)


def _path(scene: RoomScene) -> list[Point]:
    from guideway._core import plan

    return [(float(x), float(y)) for x, y in plan(scene.query("static")).path.control_points]


def _movers(draws: Draws, path: list[Point]) -> tuple[Mover, ...]:
    movers = []
    for share in SHARES:
        (x, y), heading = _along(path, share)
        angle = heading + math.pi / 2 + math.radians(draws.between(-30, 30))
        radius, speed = draws.between(300, 500) / 1000, draws.between(200, 600) / 1000
        back, forth = draws.between(1500, 3000) / 1000, draws.between(1500, 3000) / 1000
        c, s = math.cos(angle), math.sin(angle)
        ends = ((round(x - back * c, 3), round(y - back * s, 3)), (round(x + forth * c, 3), round(y + forth * s, 3)))
        duration = math.dist(*ends) / speed
        phase = draws.below(round(2000 * duration)) / 1000
        track = ((0.0, *ends[0]), (duration, *ends[1]))
        movers.append(Mover(Footprint(disc=radius), track, "shuttle", phase, path=ends, speed=speed))
    (x, y), heading = _along(path, draws.between(400, 800) / 1000)
    aside = draws.between(-400, 400) / 1000
    place = (0.0, round(x - aside * math.sin(heading), 3), round(y + aside * math.cos(heading), 3))
    return (*movers, Mover(Footprint(disc=0.3), (place,), "once", appears=Appears(within=3.0)))


def _along(path: list[Point], share: float) -> tuple[Point, float]:
    """Point and heading at a share of a polyline's length."""
    lengths = [math.dist(a, b) for a, b in pairwise(path)]
    left = share * sum(lengths)
    for ((ax, ay), (bx, by)), length in zip(pairwise(path), lengths, strict=True):
        if left <= length and length > 0:
            r = left / length
            return (ax + r * (bx - ax), ay + r * (by - ay)), math.atan2(by - ay, bx - ax)
        left -= length
    return path[-1], math.atan2(path[-1][1] - path[-2][1], path[-1][0] - path[-2][0])
