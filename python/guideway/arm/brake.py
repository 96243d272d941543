"""Slowing down and stopping on the path: the smallest path acceleration that every limit allows, place by place.

The motion that is braked keeps all limits, so at every place the set of allowed (u, x) - path acceleration, squared path speed - holds its own point
(u, x) and, where the arm can stand still there, (0, 0); it is convex but for viscous friction. Hence every slower point (k u, k x) is allowed too,
and a brake that always takes the smallest allowed acceleration never runs into a place without one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway.arm.limits import JointLimits
from guideway.arm.motion import ArmMotion
from guideway.arm.timing import demands
from guideway.errors import BadParameter

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

STEPS = 200
"""Steps of a brake: of the way that the first, rough pass finds."""

_SLACK = 1e-7


def kinematic_rows(motion: ArmMotion, limits: JointLimits) -> Callable[[Floats], dict[str, Floats]]:
    """Rows of joint acceleration and deceleration: the latter against the direction of the joint's motion."""
    joints = len(motion.names)
    faster = limits.per_joint("acceleration", joints)
    slower = limits.per_joint("deceleration", joints)

    def rows(s: Floats) -> dict[str, Floats]:
        _, first, second = motion.path.path.eval(s, 2)
        up = np.full(joints, np.inf) if faster is None else faster
        down = up if slower is None else slower
        forward = first >= 0
        still = np.zeros_like(first)
        return {
            "a": first,
            "b": second,
            "d": still,
            "c": still,
            "low": -np.where(forward, down, up),
            "high": np.where(forward, up, down),
        }

    return rows


class _Course:
    """All rows of a motion at given places."""

    def __init__(self, motion: ArmMotion, s: Floats) -> None:
        self.s = s
        parts = [kinematic_rows(motion, motion.limits)(s)]
        rows, _, _ = demands(motion.arm, motion.path.path, motion.limits)
        if rows is not None:
            found = rows(s)
            parts.append({key: np.broadcast_to(value, (len(s), found["a"].shape[1])) for key, value in found.items()})
        self.a, self.b, self.c, self.d, self.low, self.high = (
            np.concatenate([part[key] for part in parts], axis=1) for key in ("a", "b", "c", "d", "low", "high")
        )
        self.scale = np.where(np.isfinite(self.high - self.low), np.maximum(self.high - self.low, 1e-300), 1.0)

    def excess(self, k: int, u: float, x: float) -> float:
        """How far (u, x) is beyond the limits at place k, relative to them."""
        value = self.a[k] * u + self.b[k] * x + self.d[k] * np.sqrt(max(x, 0.0)) + self.c[k]
        return float(np.max(np.maximum(value - self.high[k], self.low[k] - value) / self.scale[k]))


def slowed(motion: ArmMotion, t: float, factor: float) -> ArmMotion:
    """The motion that from time ``t`` (s) on brakes on the path down to ``factor`` of the speed that the motion has there, then follows it.

    With ``factor`` 0 it stops. Limits of speed, acceleration and torque are kept; a brake steps in acceleration, so limits of jerk and torque rate
    are not: ``report["brake"]`` says what is kept (``worst``: largest excess over a limit, relative to it), where the brake ``ends`` (s) and its way.
    """
    if not 0 <= t <= motion.duration:
        raise BadParameter(f"time {t!r} is out of range: from 0 to the duration, {motion.duration:.4g} s")
    s0, v0 = motion.along(t)[0, :2]
    if v0 <= 0 or t >= motion.duration:
        return motion if t > 0 else replace(motion, pieces=motion.pieces[:0])
    s, x = _way(motion, float(s0), float(v0), factor)
    head, brake = motion.cut(t), _pieces(s, x, t)
    end = float(brake[-1, 0] + brake[-1, 5])
    pieces = np.concatenate([head, brake])
    if factor > 0:
        at = motion.time_at(float(s[-1]))
        tail = motion.rest(at)
        tail = tail * np.array([1 / factor, 1, factor, factor**2, factor**3, 1 / factor])
        tail[:, 0] += end - at / factor
        pieces = np.concatenate([pieces, tail])
    report = {"from": t, "ends": end, "way": float(s[-1] - s0), "factor": factor, "worst": _worst(motion, brake)}
    return replace(motion, pieces=pieces, report=motion.report | {"brake": report})


def _way(motion: ArmMotion, s0: float, v0: float, factor: float) -> tuple[Floats, Floats]:
    """Places and squared path speeds of the brake: first roughly, until its way is known, then in fine steps over it."""
    left = motion.path.path.length - s0
    way, count = max(v0 * v0 / 2, 1e-6), 32
    while True:
        way = min(way, left)
        s, x, met = _descend(motion, np.linspace(s0, s0 + way, count + 1), v0 * v0, factor)
        if (met and count == STEPS) or (not met and way >= left):
            return s, x
        way, count = (1.1 * (float(s[-1]) - s0), STEPS) if met else (2 * way, count)


def _descend(motion: ArmMotion, s: Floats, x0: float, factor: float) -> tuple[Floats, Floats, bool]:
    """Squared path speeds along evenly spaced places ``s`` with the hardest brake: places and values until the target is met, and whether it is."""
    step = s[1] - s[0]
    course = _Course(motion, s)
    own = motion.along(motion.times_at(s))[:, 1] ** 2
    own[-1] = 0.0 if s[-1] >= motion.path.path.length else own[-1]
    aim = factor**2 * own
    x = [x0]
    for k in range(len(s) - 1):
        scaled = (own[k + 1] * min(1.0, x[k] / max(own[k], 1e-300)) - x[k]) / (2 * step)
        u = _hardest(course, k, x[k], step, scaled)
        after = x[k] + 2 * u * step
        if after <= aim[k + 1] + 1e-12 * x0:
            if factor > 0:
                return s[: k + 2], np.append(x, aim[k + 1]), True
            stop = s[k] + min(step, -x[k] / (2 * min(u, -1e-300)))
            return np.append(s[: k + 1], stop), np.append(x, 0.0), True
        x.append(after)
    return s, np.array(x), False


def _hardest(course: _Course, k: int, x: float, step: float, known: float) -> float:
    """The smallest path acceleration on a step that the limits allow at both of its ends; ``known`` is one that they allow."""

    def fits(u: float) -> bool:
        after = x + 2 * u * step
        return course.excess(k, u, x) <= _SLACK and course.excess(k + 1, u, max(after, 0.0)) <= _SLACK

    low = -x / (2 * step)  # to rest within the step
    if fits(low):
        return low
    high = known
    for _ in range(44):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high


def _pieces(s: Floats, x: Floats, t: float) -> Floats:
    """Pieces of constant acceleration between squared speeds at places."""
    v = np.sqrt(np.maximum(x, 0.0))
    length = np.diff(s)
    duration = 2 * length / np.maximum(v[:-1] + v[1:], 1e-300)
    kept = length > 0
    start = t + np.concatenate([[0.0], np.cumsum(duration)[:-1]])
    table = np.column_stack([start, s[:-1], v[:-1], (v[1:] - v[:-1]) / np.maximum(duration, 1e-300), np.zeros(len(length)), duration])
    return table[kept]


def _worst(motion: ArmMotion, brake: Floats, within: int = 8) -> float:
    """The largest excess over a limit on the pieces of a brake, between its steps too, relative to it."""
    shares = (np.arange(within) + 0.5) / within
    t = (shares[None, :] * brake[:, 5:6]).ravel()
    v = np.repeat(brake[:, 2], within) + t * np.repeat(brake[:, 3], within)
    s = np.repeat(brake[:, 1], within) + t * np.repeat(brake[:, 2], within) + t**2 / 2 * np.repeat(brake[:, 3], within)
    course = _Course(motion, s)
    u = np.repeat(brake[:, 3], within)
    values: list[Any] = [course.excess(k, u[k], v[k] ** 2) for k in range(len(s))]
    return float(max(0.0, *values))
