"""Rational B-splines in space: the path of a tool, and the star of the source of velocity self-learning."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from guideway.errors import BadParameter

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

DOWN = (0.0, 1.0, 0.0, 0.0)
"""The tool points down: its axes are x, -y, -z of the frame the points are given in; a quaternion w, x, y, z."""


@dataclass(frozen=True)
class Nurbs:
    """A rational B-spline with clamped uniform knots over the parameter 0 ... 1, and the tool's orientation along it.

    ``points`` (n, 3) in m, given in the frame of the link ``frame`` (None: the root); ``weights`` (n,), positive; ``closed`` repeats the first point
    at the end, the knots stay clamped. ``tool`` is a unit quaternion (w, x, y, z) of the link ``tip`` (None: ``tool0``) or "down"; ``posture`` (rad)
    is where the inverse kinematics starts, so it picks the branch.
    """

    points: Sequence[Sequence[float]]
    weights: Sequence[float] | None = None
    degree: int = 3
    closed: bool = False
    tool: str | Sequence[float] = "down"
    posture: Sequence[float] | None = None
    frame: str | None = None
    tip: str | None = None

    def __post_init__(self) -> None:
        points = np.asarray(self.points, float)
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2 or not np.isfinite(points).all():
            raise BadParameter(f"points of shape {points.shape} cannot be used: at least two points of three finite numbers, m")
        if isinstance(self.degree, bool) or not 1 <= self.degree <= 9 or self.degree >= len(points) + self.closed:
            raise BadParameter(f"degree {self.degree!r} is out of range: from 1 to 9, and below the number of points ({len(points) + self.closed})")
        weights = np.asarray(self._weights(), float)
        if weights.shape != (len(points),) or not np.isfinite(weights).all() or not (weights > 0).all():
            raise BadParameter(f"weights {self.weights!r} cannot be used: one finite number above 0 for each of the {len(points)} points")
        self.quaternion()

    def _weights(self) -> Sequence[float]:
        return [1.0] * len(self.points) if self.weights is None else self.weights

    def quaternion(self) -> Floats:
        """The tool's orientation (w, x, y, z) of length 1; raises ``BadParameter`` for anything else."""
        given = DOWN if isinstance(self.tool, str) and self.tool == "down" else self.tool
        array = np.asarray(given, float) if not isinstance(given, str) else np.zeros(0)
        if array.shape != (4,) or not np.isfinite(array).all() or not 1e-6 < np.linalg.norm(array) < 1e6:
            raise BadParameter(f"tool {self.tool!r} cannot be used: 'down', or a quaternion [w, x, y, z]")
        return array / np.linalg.norm(array)

    def rotation(self) -> Floats:
        """The tool's orientation as a matrix (3, 3)."""
        w, x, y, z = self.quaternion()
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    def at(self, w: ArrayLike) -> Floats:
        """Positions (m, 3) in m at parameters ``w`` (m,) in 0 ... 1: the rational B-spline itself, evaluated by de Boor's algorithm."""
        weights = np.asarray(self._weights(), float)
        lifted = np.column_stack([np.asarray(self.points, float) * weights[:, None], weights])
        if self.closed:
            lifted = np.vstack([lifted, lifted[:1]])
        found = _de_boor(lifted, self.degree, np.clip(np.atleast_1d(np.asarray(w, float)), 0.0, 1.0))
        return found[:, :3] / found[:, 3:]

    def spread(self, count: int) -> Floats:
        """``count`` parameters from 0 to 1 whose points lie evenly along the path."""
        fine = np.linspace(0.0, 1.0, max(8 * count, 2001))
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.at(fine), axis=0), axis=1))])
        if way[-1] <= 0:
            raise BadParameter("all points of the path are the same: there is no way to go")
        return np.interp(np.linspace(0.0, way[-1], count), way, fine)

    def length(self, count: int = 20001) -> float:
        """Length of the path, m."""
        return float(np.sum(np.linalg.norm(np.diff(self.at(np.linspace(0.0, 1.0, count)), axis=0), axis=1)))


def _de_boor(control: Floats, degree: int, w: Floats) -> Floats:
    """Points of a clamped uniform B-spline over 0 ... 1, for all parameters at once."""
    spans = len(control) - degree
    knots = np.concatenate([np.zeros(degree), np.linspace(0.0, 1.0, spans + 1), np.ones(degree)])
    span = np.clip((w * spans).astype(int), 0, spans - 1) + degree
    span -= w < knots[span]  # rounding at inner knots
    work = [control[span - degree + j] for j in range(degree + 1)]
    for level in range(1, degree + 1):
        for j in range(degree, level - 1, -1):
            low, high = knots[span - degree + j], knots[span + 1 + j - level]
            share = ((w - low) / (high - low))[:, None]
            work[j] = (1 - share) * work[j - 1] + share * work[j]
    return work[degree]


def load_nurbs(path: str | os.PathLike[str]) -> Nurbs:
    """Reads a path of a tool (TOML: ``degree``, ``closed``, ``points``, ``weights``, ``tool``, ``posture``, ``frame``, ``tip``).

    Raises :class:`guideway.errors.BadFile`.
    """
    from guideway.errors import BadFile
    from guideway.io.files import load, name
    from guideway.io.tables import Table, parse_toml

    where = name(path)
    table = Table(where, "", parse_toml(where, load(path).text()))
    points = table.rows("points", 3, "[x, y, z] in m", 2)
    fields: dict[str, Any] = {
        "degree": table.integer("degree", 1, 9, 3),
        "closed": table.flag("closed"),
        "weights": table.numbers("weights", (len(points),), f"a list of {len(points)} weights above 0, one per point"),
        "posture": table.numbers("posture", tuple(range(1, 33)), "a list of joint values, rad"),
        "frame": table.text("frame"),
        "tip": table.text("tip"),
    }
    tool = table.raw("tool")
    fields["tool"] = "down" if tool is None else tool if isinstance(tool, str) else table.numbers("tool", (4,), "a quaternion [w, x, y, z]")
    table.done()
    try:
        return Nurbs(points, **fields)
    except (BadParameter, TypeError, ValueError) as error:
        raise BadFile(where, str(error).rstrip("."), todo="Correct the file") from None


_STAR = (
    (-0.10, 0.25, 0.30, 1.0),
    (-0.004, 0.25, 0.348, 1.0),
    (-0.004, 0.25, 0.428, 1.0),
    (0.092, 0.25, 0.364, 1.0),
    (0.188, 0.25, 0.38, 0.7),
    (0.116, 0.25, 0.30, 1.0),
    (0.188, 0.25, 0.22, 0.7),
    (0.092, 0.25, 0.236, 1.0),
    (-0.004, 0.25, 0.172, 1.0),
    (-0.004, 0.25, 0.252, 1.0),
)
STAR_POSTURE = (141.48, -88.56, -120.04, 118.60, -90.00, -128.52)
"""Start posture of the star in its reference branch, degrees."""

STAR_TORQUE = (28.0, 42.0, 40.0, 11.0, 5.0, 5.0)
"""Torque limits (N m) under which the star asks for something to be learned: the UR5e's own ones are never reached on it."""


def star(posture: Sequence[float] | None = None) -> Nurbs:
    """The star path of the source of velocity self-learning for the UR5e, tool down; ``posture`` (rad) picks another branch."""
    table = np.array(_STAR)
    chosen = cast("Sequence[float]", np.radians(STAR_POSTURE).tolist()) if posture is None else tuple(posture)
    return Nurbs(table[:, :3].tolist(), table[:, 3].tolist(), closed=True, posture=chosen, frame="base", tip="tool0")
