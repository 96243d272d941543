"""Moving obstacles as a judge sees them: where they are, movers that cross a path, and whether there is a way past them at all."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import guideway as gw

CELL, TICK = 0.1, 0.1
"""Of the search in space and time, m and s."""
SHARES = (0.3, 0.5, 0.7)
"""Where movers cross a path, in shares of its length."""
ASIDE = 2.0
"""How far they go to each side at most, m."""


class Moving:
    """Where a moving obstacle is, and how far a point is from it; ``mover`` as :attr:`guideway.World.movers` has it."""

    def __init__(self, mover: Mapping[str, Any]) -> None:
        track = np.asarray(mover["track"], float)
        self.times, self.places = track[:, 0], track[:, 1:3]
        self.loop, self.phase, self.shape = mover["loop"], mover["phase"], mover["shape"]
        self.appears = bool(mover.get("appears"))

    @property
    def radius(self) -> float:
        """Of a disc, or of the one around a polygon, m."""
        corners = self.shape.get("polygon")
        return float(self.shape.get("disc") or 0.0) if corners is None else max(math.hypot(*corner) for corner in corners)

    def at(self, t: float) -> np.ndarray:
        """Its place (2,) at a time, whether or not it is there yet."""
        last, t = float(self.times[-1]), t + self.phase
        if self.loop == "cycle" and last > 0:
            t %= last
        elif self.loop == "shuttle" and last > 0:
            t = last - abs(t % (2 * last) - last)
        return np.array([np.interp(t, self.times, self.places[:, k]) for k in (0, 1)])

    def distances(self, points: np.ndarray, t: float) -> np.ndarray:
        """From points (..., 2) to its surface, m; negative inside. A box does not turn."""
        d = points - self.at(t)
        if "box" not in self.shape:
            return np.hypot(d[..., 0], d[..., 1]) - self.radius
        reach = np.abs(d) - 0.5 * np.asarray(self.shape["box"])
        outside = np.maximum(reach, 0)
        return np.hypot(outside[..., 0], outside[..., 1]) + np.minimum(reach.max(-1), 0.0)

    def distance(self, p: Sequence[float] | np.ndarray, t: float) -> float:
        """From one point."""
        return float(self.distances(np.asarray(p, float), t))


def way_exists(query: gw.Query, limit: float, arrival: float = 0.2) -> bool:
    """Is there a way in space and time for the robot's disc without its clearance, which goes 0.1 m in 0.1 s or waits?

    The true motions of movers count; what appears is there all along. ``limit`` in s.
    """
    from scipy import ndimage

    world, radius = query.world, query.radius - query.clearance
    x0, y0, x1, y1 = world.bounds
    xs, ys = np.arange(x0, x1 + 1e-9, CELL), np.arange(y0, y1 + 1e-9, CELL)
    px, py = np.meshgrid(xs, ys, indexing="ij")
    places = np.stack([px, py], -1)
    free = world.clearance(places.reshape(-1, 2)).reshape(px.shape) >= radius
    at = tuple(round((query.start[k] - (x0, y0)[k]) / CELL) for k in (0, 1))
    goal = np.hypot(px - query.goal[0], py - query.goal[1]) <= arrival
    movers = [Moving(mover) for mover in world.movers]
    reached = np.zeros(px.shape, bool)
    reached[at] = True
    cross = ndimage.generate_binary_structure(2, 1)
    for k in range(round(limit / TICK) + 1):
        open_now = free.copy()
        for mover in movers:
            open_now &= mover.distances(places, k * TICK) >= radius
        reached &= open_now
        if (reached & goal).any():
            return True
        reached = ndimage.binary_dilation(reached, cross)
    return False


def across(path: gw.Path, world: gw.World, seed: int) -> list[dict[str, Any]]:
    """Three discs of 0.3 to 0.5 m that go to and fro across a path at 0.2 to 0.6 m/s, and one of 0.3 m that appears on it once the robot is within
    3 m, at 80 to 90 % of the path. ``world`` is a grid of 1 m cells; the discs turn round where they would touch what is blocked."""
    rng = np.random.default_rng(seed)
    field, height = world.clearance_field(), world.height
    if field is None:
        raise gw.BadParameter("movers across a path need a world with a grid of its own")

    def room(p: np.ndarray) -> float:
        return float(field[min(max(height - 1 - int(p[1]), 0), height - 1), min(max(int(p[0]), 0), world.width - 1)])

    found = []
    for share in SHARES:
        radius, speed = rng.uniform(0.3, 0.5), rng.uniform(0.2, 0.6)
        x, y, heading, _ = path.planar([share * path.length])[0]
        aside = np.array([-math.sin(heading), math.cos(heading)])
        ends = []
        for side in (1.0, -1.0):
            reach = 0.0
            while reach < ASIDE and room(np.array([x, y]) + side * (reach + 0.1) * aside) >= radius:
                reach += 0.1
            ends.append(np.array([x, y]) + side * max(reach, 0.2) * aside)
        length = float(np.hypot(*(ends[1] - ends[0])))
        track = [[0.0, *ends[0].tolist()], [length / speed, *ends[1].tolist()]]
        found.append({"shape": {"disc": radius}, "track": track, "loop": "shuttle", "phase": float(rng.uniform(0, 10))})
    x, y, _, _ = path.planar([rng.uniform(0.8, 0.9) * path.length])[0]
    found.append({"shape": {"disc": 0.3}, "track": [[0.0, float(x), float(y)]], "loop": "once", "phase": 0.0, "appears": {"within": 3.0}})
    return found
