"""Joint paths: from tool paths by inverse kinematics, from files of way points; one C2 cubic spline over joint arc length each."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway import _core
from guideway.arm.inverse import Branch, branches, follow
from guideway.arm.model import Arm
from guideway.arm.nurbs import Nurbs
from guideway.errors import BadFile, BadParameter, NoPath

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

POINTS = 301
"""Points that the spline of a tool path goes through at first; their number is doubled until the spline between them is near enough."""

BETWEEN = 4
"""Points of the inverse kinematics for each point of the spline: the spline is checked at those it does not go through."""

MOST = 9601
"""Points of the spline at most."""

DEVIATION = 5e-6
"""How far the tip may be from its path between the points of the spline, m (and rad), by default."""

ROUNDING = 1e-8
"""A joint that moves by less than this along a tool path stands still, rad."""


class JointPath:
    """A path of joints: ``path`` (:class:`guideway.Path` over joint arc length, rad), ``names`` of the joints, and what is known of how it came
    about in ``report``: for a tool path the branch, and ``deviation`` of the tip from it (m)."""

    def __init__(self, path: _core.Path, names: tuple[str, ...], report: dict[str, Any] | None = None, source: str | None = None) -> None:
        self.path, self.names, self.report, self.source = path, names, report or {}, source

    def __repr__(self) -> str:
        return f"JointPath({len(self.names)} joints, {self.path.length:.4f} rad)"


def pose_at(nurbs: Nurbs, w: Floats) -> Floats:
    """Poses (n, 4, 4) of the tool at parameters ``w`` (n,)."""
    poses = np.tile(np.eye(4), (len(w), 1, 1))
    poses[:, :3, :3] = nurbs.rotation()
    poses[:, :3, 3] = nurbs.at(w)
    return poses


def arm_for(arm: Arm, nurbs: Nurbs) -> Arm:
    """The arm with the base and the tip that a tool path names."""
    from guideway.arm.build import retipped

    return retipped(arm, nurbs.tip or arm.tip, nurbs.frame or arm.base)


def path_of_nurbs(arm: Arm, nurbs: Nurbs, *, points: int = POINTS, deviation: float = DEVIATION) -> JointPath:
    """The joint path of a tool path: inverse kinematics in one branch, a cubic spline through it, checked between its points.

    The spline goes through every fourth point of the inverse kinematics and is checked at the others; where the tip is farther than ``deviation``
    (m, rad) from where it shall be, points are added. Raises ``NoPath`` for points out of reach, singular postures, joint limits and corners that
    no smooth spline meets.
    """
    arm = arm_for(arm, nurbs)
    posture, before = nurbs.posture, math.inf
    while True:
        w = nurbs.spread(BETWEEN * (points - 1) + 1)
        branch = follow(arm, lambda at: pose_at(nurbs, at), w, posture)
        path = through(branch.q[::BETWEEN])
        off, worst = _deviation(arm, path, branch)
        if off <= deviation:
            report = branch.report | {"deviation": off, "tip": arm.tip, "frame": arm.base}
            return JointPath(path, arm.names, report)
        if 2 * points - 1 > MOST or off > 0.35 * before:  # a smooth path comes nearer by a factor of 4 at least
            x, y, z = nurbs.at([w[worst]])[0]
            raise NoPath(
                f"the spline through {points} points of the inverse kinematics stays {off:.2g} m or rad away from the tool path near "
                f"({x:.4f}, {y:.4f}, {z:.4f}) m, {100 * w[worst]:.4g} % of the way, allowed: {deviation:.2g}: there is a corner or a cusp. "
                "Take a path of degree 3, move equal neighbouring points apart, or allow a larger deviation"
            )
        points, posture, before = 2 * points - 1, branch.q[0].tolist(), off


def through(q: Floats) -> _core.Path:
    """The spline through postures (n, joints); joints that move by no more than rounding are held still exactly."""
    path = _core.Path.through(np.ascontiguousarray(q))
    still = np.ptp(q, axis=0) < ROUNDING
    if not still.any():
        return path
    control = path.control_points.copy()
    control[:, still] = q[0, still]
    return _core.Path(path.degree, path.knots.tolist(), control.tolist())


def _deviation(arm: Arm, path: _core.Path, branch: Branch) -> tuple[float, int]:
    """How far the tip is from its pose at all points of the inverse kinematics: the worst, and where."""
    there = path.eval(places(path, branch.q))[0]
    # first order is enough here: the spline is within microns of the posture
    twist = np.einsum("kij,kj->ki", arm.jacobian(branch.q), there - branch.q)
    off = np.maximum(np.linalg.norm(twist[:, :3], axis=1), np.linalg.norm(twist[:, 3:], axis=1))
    worst = int(np.argmax(off))
    return float(off[worst]), worst


def places(path: _core.Path, q: Floats) -> Floats:
    """Where along the path the postures ``q`` (n, joints) are that follow each other on it: arc lengths (n,), by projection."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])
    s = way * (path.length / max(way[-1], 1e-300))
    for _ in range(4):
        there, first = path.eval(s, 1)
        s = np.clip(s + np.sum((q - there) * first, axis=1), 0.0, path.length)
    return s


def all_branches(arm: Arm, nurbs: Nurbs) -> list[JointPath]:
    """The joint paths of a tool path in every branch of its start pose that reaches its end; raises ``NoPath`` where there is none."""
    own = arm_for(arm, nurbs)
    found: list[JointPath] = []
    why: NoPath | None = None
    for posture in branches(own, pose_at(nurbs, np.zeros(1))[0]):
        try:
            found.append(path_of_nurbs(arm, replace(nurbs, posture=posture.tolist())))
        except NoPath as error:
            why = error
    if not found and why is not None:
        raise why
    return found


def path_through(points: ArrayLike, names: tuple[str, ...], source: str | None = None) -> JointPath:
    """The joint path through way points (n, joints), rad: a C2 cubic spline over the distance between them; two points give a straight line."""
    array = np.asarray(points, float)
    if array.ndim != 2 or array.shape[1] != len(names) or len(array) < 2 or not np.isfinite(array).all():
        raise BadParameter(f"way points of shape {array.shape} cannot be used: at least two rows of {len(names)} finite numbers, rad")
    return JointPath(through(array), names, source=source)


def load_way_points(path: str | os.PathLike[str], names: tuple[str, ...] | None = None) -> tuple[Floats, tuple[str, ...]]:
    """Reads joint way points (CSV: a header with the joints' names, a row per point, rad) in the order of ``names``.

    Raises :class:`guideway.errors.BadFile` where the joints are not those of ``names``, and for anything that is not a finite number.
    """
    from guideway.io.files import load, name, show
    from guideway.io.tables import parse_csv

    where, text = name(path), load(path).text()
    first = next((line for line in text.split("\n") if line.strip()), "")
    header = tuple(word.strip() for word in first.split(","))
    if _number(header[0]) is not None:
        allowed = ",".join(names) if names else "the names of the joints, separated by commas"
        raise BadFile(where, f"the first line {show(first)} is no header", allowed, "Add a first line with the names of the joints")
    if len(set(header)) != len(header) or not all(header):
        raise BadFile(where, f"the header is {show(first)}", "different names of joints, separated by commas", "Correct the first line")
    names = names or header
    for title in header:
        if title not in names:
            raise BadFile(where, f"joint {show(title)} is not of this robot", ", ".join(names), "Name the joints of the robot of --urdf")
    for title in names:
        if title not in header:
            raise BadFile(where, f"joint {show(title)} has no column", ", ".join(names), "Add it, or name another link that is moved (--tip)")
    table = np.array(parse_csv(where, text, header))
    if len(table) < 2:
        raise BadFile(where, "there is one way point", "at least two", "Add the others")
    return np.ascontiguousarray(table[:, [header.index(title) for title in names]]), names


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return None if math.isnan(value) else value


def joint_path(arm: Arm, given: Nurbs | str | os.PathLike[str] | ArrayLike) -> JointPath:
    """The joint path of an arm: from a tool path, a file of way points (CSV), or way points (n, joints), within its joint limits."""
    if isinstance(given, Nurbs):
        return path_of_nurbs(arm, given)
    if isinstance(given, str | os.PathLike):
        points, names = load_way_points(given, arm.names)
        found = path_through(points, names, os.fspath(given))
    else:
        found = path_through(given, arm.names)
    found.report["joint_limit_margin"] = check_range(arm, found.path)
    return found


def check_range(arm: Arm, path: _core.Path, count: int = 2001) -> float:
    """The distance to the nearest joint limit along a path, rad; raises ``NoPath`` where it is left."""
    s = np.linspace(0.0, path.length, count)
    q = path.eval(s)[0]
    margin = np.minimum(q - arm.lower, arm.upper - q)
    worst = np.unravel_index(np.argmin(margin), margin.shape)
    if margin[worst] < 0:
        low, high = arm.lower[worst[1]], arm.upper[worst[1]]
        raise NoPath(
            f"the path leaves the range of {arm.names[worst[1]]} at s = {s[worst[0]]:.4g} rad of {path.length:.4g} rad: {q[worst]:.4f} rad, "
            f"allowed: {low:.4f} to {high:.4f} rad. Correct the way points near it"
        )
    return float(margin[worst])
