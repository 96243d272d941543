"""Collisions of a moving arm with itself and its surroundings: proved along the whole path, not only at samples.

Between two places of the path a point of a link moves no farther than ``sum_j r_j |dq_j|``, with ``r_j`` the largest distance it can have from
the axis of joint j; by Cauchy and Schwarz that is at most ``|r| ds``, since the path is measured in joint arc length. So from the distances at both
ends of an interval follows a lower bound in between; where it is not enough, the interval is halved (conservative advancement).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway.arm.extra import coal, pinocchio
from guideway.arm.model import Arm
from guideway.arm.shapes import Scene, Shape, links_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from guideway._core import Path

    Floats = NDArray[np.float64]

FINEST = 1e-4
"""Intervals of the path are not halved below this, rad: what is still open then counts as touching."""

EXACT = 0.05
"""Below this distance of the hulls (m) the meshes themselves are measured."""

POSTURES = 200
"""Random postures in which a pair must overlap every time to be left out as always touching."""


@dataclass(frozen=True)
class Pair:
    """Two solids that may meet; ``reach`` (m/rad) bounds how fast they approach each other per path."""

    one: Shape
    other: Shape
    reach: float

    @property
    def name(self) -> str:
        """Both names."""
        return f"{self.one.name} and {self.other.name}"


class Surroundings:
    """An arm's own shapes and those around it, ready to be checked; ``dropped`` lists the pairs that are not, and why."""

    def __init__(self, arm: Arm, scene: Scene | None = None) -> None:
        self.arm, self.scene = arm, scene or Scene()
        self.shapes = links_of(arm) + self.scene.solids(arm)
        self.dropped: list[dict[str, str]] = []
        self._pin, self._data = pinocchio(), arm.model.createData()
        library = coal()
        self._distance, self._request, self._result = library.distance, library.DistanceRequest(), library.DistanceResult()
        self._transform = library.Transform3s
        self.pairs = self._pairs()

    def _pairs(self) -> list[Pair]:
        found: list[Pair] = []
        carriers = {shape.joint for shape in self.shapes if shape.part != "scene"}
        for i, one in enumerate(self.shapes):
            for other in self.shapes[i + 1 :]:
                reach = self._reach(one, other)
                if reach == 0:
                    continue  # they never move against each other
                why = None if "scene" in (one.part, other.part) else self._joined(one.joint, other.joint, carriers)
                if why is not None:
                    self.dropped.append({"pair": f"{one.name} and {other.name}", "why": why})
                else:
                    found.append(Pair(one, other, reach))
        return found

    def _above(self, joint: int) -> list[int]:
        chain: list[int] = []
        while joint:
            chain.append(joint)
            joint = self.arm.model.parents[joint]
        return chain

    def _joined(self, one: int, other: int, carriers: set[int]) -> str | None:
        """Why two parts of the arm may touch by construction: a joint between them, or a linkage that both belong to."""
        for low, high in ((one, other), (other, one)):
            above = next((joint for joint in [*self._above(low)[1:], 0] if joint in carriers), None)
            if above == high and low != high:
                return "one joint lies between them"
            if low and high and self.arm.model.names[low] in self.arm.followers.get(self.arm.model.names[high], ()):
                return f"joint {self.arm.model.names[low]} follows joint {self.arm.model.names[high]}: they are one linkage"
        return None

    def _reach(self, one: Shape, other: Shape) -> float:
        """Length of the vector of the largest lever arms of all driven joints that move one shape against the other, m/rad."""
        chains = self._above(one.joint), self._above(other.joint)
        levers = np.zeros(self.arm.joints)
        for shape, chain, opposite in ((one, *chains), (other, *chains[::-1])):
            lever = float(np.linalg.norm(shape.pose[:3, 3])) + shape.radius
            for joint in chain:
                if joint not in opposite:
                    model = self.arm.model.joints[joint]
                    slides = "P" in model.shortname().removeprefix("JointModel")[:1]
                    row = np.abs(self.arm.coupling[model.idx_v])
                    levers += row * (1.0 if slides else lever)
                    lever += self._travel(row) if slides else 0.0
                lever += float(np.linalg.norm(self.arm.model.jointPlacements[joint].translation))
        return float(np.linalg.norm(levers))

    def _travel(self, row: Floats) -> float:
        """How far a sliding joint can be out, m."""
        ranges = np.maximum(np.abs(self.arm.lower), np.abs(self.arm.upper))
        return float(np.sum(row[row > 0] * ranges[row > 0]))

    def place(self, q: Floats) -> list[Any]:
        """Where all shapes are in a posture."""
        self._pin.forwardKinematics(self.arm.model, self._data, self.arm.coupling @ q + self.arm.offset)
        placed: list[Any] = []
        for shape in self.shapes:
            pose = self._data.oMi[shape.joint].homogeneous @ shape.pose
            placed.append(self._transform(np.ascontiguousarray(pose[:3, :3]), np.ascontiguousarray(pose[:3, 3])))
        return placed

    def distance(self, pair: Pair, placed: list[Any]) -> float:
        """A distance that is not too large (m): that of the hulls, near each other that of the meshes; 0 or less where they overlap."""
        a, b = self.shapes.index(pair.one), self.shapes.index(pair.other)
        found = self._measure(pair.one.hull, placed[a], pair.other.hull, placed[b])
        if found < EXACT and not (pair.one.convex and pair.other.convex):
            return max(found, self._measure(pair.one.solid, placed[a], pair.other.solid, placed[b]))
        return found

    def _measure(self, one: Any, at: Any, other: Any, there: Any) -> float:
        self._result.clear()
        return float(self._distance(one, at, other, there, self._request, self._result))

    def always_touching(self, pair: Pair) -> bool:
        """Do the two overlap in every one of many random postures? Then their shapes say nothing about the posture."""
        low, high = (np.where(np.isfinite(bound), bound, side * math.pi) for bound, side in ((self.arm.lower, -1), (self.arm.upper, 1)))
        postures = np.random.default_rng(0).uniform(low, high, (POSTURES, self.arm.joints))
        return all(self.distance(pair, self.place(q)) <= 0 for q in postures)


def check(surroundings: Surroundings, path: Path, clearance: float | None = None, end: float | None = None) -> dict[str, Any]:
    """Whether the arm keeps ``clearance`` (m; default that of the scene) from itself and its surroundings all along a path.

    Returns ``ok``, ``pairs`` (how many were checked), ``dropped``, ``closest`` (``pair``, sampled ``distance`` in m, ``s``), ``proved`` (a lower
    bound of all distances between and at the samples, m), where it is not kept, ``hit`` (``pair``, ``s``, ``distance``), and the ``scene`` with
    its ``shapes`` and the ``tool``. ``end``: only up to there, rad.
    """
    need = surroundings.scene.clearance if clearance is None else clearance
    length = path.length if end is None else end
    poses: dict[float, list[Any]] = {}

    def placed(s: float) -> list[Any]:
        if s not in poses:
            poses[s] = surroundings.place(path.eval([s])[0, 0])
        return poses[s]

    closest: dict[str, Any] | None = None
    proved, hit, checked = math.inf, None, 0
    for pair in list(surroundings.pairs):
        bound, least, where, open_at = _advance(surroundings, pair, placed, length, need)
        if open_at is not None and surroundings.distance(pair, placed(open_at)) <= 0 and surroundings.always_touching(pair):
            surroundings.dropped.append({"pair": pair.name, "why": f"they overlap in each of {POSTURES} random postures"})
            surroundings.pairs.remove(pair)
            continue
        checked += 1
        proved = min(proved, bound)
        if closest is None or least < closest["distance"]:
            closest = {"pair": pair.name, "distance": least, "s": where}
        if open_at is not None and (hit is None or open_at < hit["s"]):
            hit = {"pair": pair.name, "s": open_at, "distance": surroundings.distance(pair, placed(open_at))}
    return {
        "ok": hit is None,
        "clearance": need,
        "pairs": checked,
        "dropped": list(surroundings.dropped),
        "closest": closest,
        "proved": None if math.isinf(proved) else proved,
        "hit": hit,
        "scene": {"shapes": [dict(shape) for shape in surroundings.scene.shapes], "tool": [dict(shape) for shape in surroundings.scene.tool]},
    }


def _advance(around: Surroundings, pair: Pair, placed: Any, length: float, need: float) -> tuple[float, float, float, float | None]:
    """Lower bound of the distance of a pair along a path, the least sampled one and where, and the first place where it is not enough."""
    known: dict[float, float] = {}

    def distance(s: float) -> float:
        if s not in known:
            known[s] = around.distance(pair, placed(s))
        return known[s]

    bound, stack = math.inf, [(0.0, length)]
    open_at: float | None = None
    while stack:
        low, high = stack.pop()
        if distance(low) <= need:
            open_at = low
            break
        least = (distance(low) + distance(high) - pair.reach * (high - low)) / 2
        if least > need:
            bound = min(bound, least, distance(low), distance(high))
        elif high - low < FINEST:
            open_at = high
            break
        else:
            middle = 0.5 * (low + high)
            stack += [(middle, high), (low, middle)]  # the near half first: the first contact is found first
    where = min(known, key=lambda s: known[s])
    if open_at is not None:
        bound = min(bound, known[where])
    return bound, known[where], where, open_at
