"""Slowing down and stopping on the path: the smallest path acceleration that every limit allows, place by place.

The motion that is braked keeps all limits, so at every place the set of allowed (u, x) - path acceleration, squared path speed - holds its own point
(u, x) and, where the arm can stand still there, (0, 0); it is convex but for viscous friction. Hence every slower point (k u, k x) is allowed too,
and a brake that always takes the smallest allowed acceleration never runs into a place without one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from guideway.arm.certificate import worst_rate
from guideway.arm.limits import JointLimits
from guideway.arm.model import STILL
from guideway.arm.motion import ArmMotion
from guideway.arm.timing import demands
from guideway.errors import BadParameter

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from guideway._core import Path

    Floats = NDArray[np.float64]

STEPS = 100
"""Steps of a brake, besides those of its motion: of the way that the first, rough pass finds."""

ROUNDS = 4
"""Times that a brake is found; limits that it exceeds between its steps are tightened there."""

_SLACK = 1e-7
_ASIDE = 1e-7
_SAMPLES = 400


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


def turns(path: Path, start: float, end: float) -> Floats:
    """Places (rad) between two where a joint turns round: Coulomb friction and limits of deceleration jump there."""
    s = np.linspace(start, end, _SAMPLES + 1)
    first = path.eval(s, 1)[1]
    k, joint = np.nonzero((first[:-1] * first[1:] < 0) & (np.abs(first).max(axis=0) > STILL))
    low, high = s[k], s[k + 1]
    for _ in range(50 if len(k) else 0):
        middle = 0.5 * (low + high)
        before = path.eval(middle, 1)[1][np.arange(len(k)), joint] * first[k, joint] > 0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.unique(high)


class _Course:
    """All rows of a motion at given places."""

    def __init__(self, motion: ArmMotion, s: Floats) -> None:
        parts = [kinematic_rows(motion, motion.limits)(s)]
        rows, _, _ = demands(motion.arm, motion.path.path, motion.limits)
        if rows is not None:
            found = rows(s)
            parts.append({key: np.broadcast_to(value, (len(s), found["a"].shape[1])) for key, value in found.items()})
        self.a, self.b, self.c, self.d, self.low, self.high = (
            np.concatenate([part[key] for part in parts], axis=1) for key in ("a", "b", "c", "d", "low", "high")
        )
        self.scale = np.where(np.isfinite(self.high - self.low), np.maximum(0.5 * (self.high - self.low), 1e-300), 1.0)

    def excess(self, k: int, u: float, x: float) -> float:
        """How far (u, x) is beyond the limits at place k, relative to them."""
        value = self.a[k] * u + self.b[k] * x + self.d[k] * np.sqrt(max(x, 0.0)) + self.c[k]
        return float(np.max(np.maximum(value - self.high[k], self.low[k] - value) / self.scale[k]))

    def excesses(self, u: Floats, x: Floats) -> Floats:
        """The same at all places."""
        root, u, x = np.sqrt(np.maximum(x, 0.0))[:, None], u[:, None], x[:, None]
        value = self.a * u + self.b * x + self.d * root + self.c
        return np.max(np.maximum(value - self.high, self.low - value) / self.scale, axis=1)


class _Steps:
    """The rows at both ends of the steps between places, each from within the step, and by how much they are tightened.

    ``own`` are the squared path speeds of the motion that is braked, ``bend`` is how fast its path acceleration changes on each step (1/s2): where
    the brake can only follow it, that must be followed too.
    """

    def __init__(self, motion: ArmMotion, s: Floats) -> None:
        self.s, self.length = s, np.diff(s)
        inside = [s[:-1] + share * self.length for share in (_ASIDE, 1 - _ASIDE)]
        self.start, self.end = (_Course(motion, places) for places in inside)
        self.tight = np.full(len(self.length), -_SLACK)
        self.own = motion.along(motion.times_at(s))[:, 1] ** 2
        self.own[-1] = 0.0 if s[-1] >= motion.path.path.length else self.own[-1]
        before, after = (motion.along(motion.times_at(places))[:, 2] for places in inside)
        self.bend = (after - before) / self.length

    def slope(self, k: int, x: float) -> float:
        """The change of the path acceleration on a step that begins with a squared speed."""
        return float(self.bend[k] * min(1.0, x / max(self.own[k], 1e-300)))

    def fits(self, k: int, u: float, x: float, bend: float) -> bool:
        """Whether a mean path acceleration keeps the limits at both ends of a step."""
        half, after = 0.5 * bend * self.length[k], max(x + 2 * u * self.length[k], 0.0)
        return self.start.excess(k, u - half, x) <= -self.tight[k] and self.end.excess(k, u + half, after) <= -self.tight[k]


def slowed(motion: ArmMotion, t: float, factor: float) -> ArmMotion:
    """The motion that from time ``t`` (s) on brakes on the path down to ``factor`` of the speed that the motion has there, then follows it.

    With ``factor`` 0 it stops. Limits of speed, acceleration and torque are kept; a brake steps in acceleration, so limits of jerk and torque rate
    are not: ``report["brake"]`` says what is kept (``worst``: largest excess over a limit, relative to it), where the brake ``ends`` (s), its way,
    and with a limit of torque rate the largest share of it that is used from time ``t`` on (``torque_rate``; steps between pieces do not count).
    """
    if not 0 <= t <= motion.duration:
        raise BadParameter(f"time {t!r} is out of range: from 0 to the duration, {motion.duration:.4g} s")
    s0, v0 = motion.along(t)[0, :2]
    if v0 <= 0 or t >= motion.duration:
        return motion if t > 0 else replace(motion, pieces=motion.pieces[:0])
    s, x, bend = _way(motion, float(s0), float(v0), factor)
    head, brake = motion.cut(t), _pieces(s, x, bend, t)
    end = float(brake[-1, 0] + brake[-1, 5])
    pieces = np.concatenate([head, brake])
    if factor > 0:
        at = motion.time_at(float(s[-1]))
        tail = motion.rest(at)
        tail = tail * np.array([1 / factor, 1, factor, factor**2, factor**3, 1 / factor])
        tail[:, 0] += end - at / factor
        pieces = np.concatenate([pieces, tail])
    later = replace(motion, pieces=pieces[len(head) :])
    rate = {"torque_rate": worst_rate(later)} if motion.arm is not None and motion.limits.torque_rate is not None else {}
    report = {
        "from": t,
        "ends": end,
        "way": float(s[-1] - s0),
        "factor": factor,
        "worst": max(0.0, float(_excesses(motion, brake).max(initial=0.0))),
    } | rate
    return replace(motion, pieces=pieces, report=motion.report | {"brake": report})


def _way(motion: ArmMotion, s0: float, v0: float, factor: float) -> tuple[Floats, Floats, Floats]:
    """Places, squared path speeds and, step by step, the change of the path acceleration (1/s2) of the brake: first roughly, until its way is known,
    then in fine steps over it."""
    left = motion.path.path.length - s0
    way, count = max(v0 * v0 / 2, 1e-6), 32
    while True:
        way = min(way, left)
        places = np.union1d(np.linspace(s0, s0 + way, count + 1), _nodes(motion, s0, s0 + way))
        steps = _Steps(motion, places[np.append(True, np.diff(places) > 1e-9)])
        s, x, bend, met = _descend(steps, v0 * v0, factor)
        if (met and count == STEPS) or (not met and way >= left):
            return _tightened(motion, steps, (s, x, bend), factor)
        way, count = (1.1 * (float(s[-1]) - s0), STEPS) if met else (2 * way, count)


def _nodes(motion: ArmMotion, start: float, end: float) -> Floats:
    """Places between two at which steps end: where a joint turns round, and where the motion's own path acceleration may jump."""
    own = motion.pieces[:, 1]
    return np.concatenate([turns(motion.path.path, start, end), own[(own > start) & (own < end)]])


def _tightened(motion: ArmMotion, steps: _Steps, found: tuple[Floats, Floats, Floats], factor: float) -> tuple[Floats, Floats, Floats]:
    """The brake, found again with limits tightened on the steps on which it exceeds them."""
    best, least = found, np.inf
    for _ in range(ROUNDS):
        excess = _excesses(motion, _pieces(*found, 0.0)).max(axis=1)
        if excess.max(initial=0.0) < least:
            best, least = found, float(excess.max(initial=0.0))
        if least <= 2 * _SLACK:
            break
        steps.tight[: len(excess)] += 1.1 * np.maximum(excess, 0.0)
        found = _descend(steps, float(found[1][0]), factor)[:3]
    return best


def _descend(steps: _Steps, x0: float, factor: float) -> tuple[Floats, Floats, Floats, bool]:
    """The hardest brake along the steps: places, squared path speeds, changes of the path acceleration until the target is met, whether it is."""
    s, own, aim = steps.s, steps.own, factor**2 * steps.own
    x, bends = [x0], list[float]()
    for k, step in enumerate(steps.length):
        scaled = (own[k + 1] * min(1.0, x[k] / max(own[k], 1e-300)) - x[k]) / (2 * step)
        bend = steps.slope(k, x[k])
        u = _hardest(steps, k, x[k], scaled, bend)
        after = x[k] + 2 * u * step
        if after <= aim[k + 1] + 1e-12 * x0:
            if factor > 0:
                return s[: k + 2], np.append(x, aim[k + 1]), np.array([*bends, bend]), True
            stop = s[k] + min(step, -x[k] / (2 * min(u, -1e-300)))
            return np.append(s[: k + 1], stop), np.append(x, 0.0), np.array([*bends, 0.0]), True
        x.append(after)
        bends.append(bend)
    return s, np.array(x), np.array(bends), False


def _hardest(steps: _Steps, k: int, x: float, known: float, bend: float) -> float:
    """The smallest mean path acceleration on a step that the limits allow at both of its ends; ``known`` is one that they allow."""
    low = -x / (2 * steps.length[k])  # to rest within the step
    if steps.fits(k, low, x, 0.0):
        return low
    high = known
    for _ in range(36):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if steps.fits(k, middle, x, bend) else (middle, high)
    return high


def _pieces(s: Floats, x: Floats, bend: Floats, t: float) -> Floats:
    """Pieces of constant jerk between squared speeds at places."""
    v = np.sqrt(np.maximum(x, 0.0))
    length, mean = np.diff(s), 0.5 * (v[:-1] + v[1:])
    duration = length / np.maximum(mean, 1e-300)
    jerk = bend * mean
    jerk = np.where(np.abs(jerk) * duration**2 <= 0.3 * mean, jerk, 0.0)
    for _ in range(6):  # length = duration (mean - jerk duration^2 / 12)
        miss = duration * (mean - jerk * duration**2 / 12) - length
        duration = duration - miss / np.maximum(mean - jerk * duration**2 / 4, 1e-300)
    kept = length > 0
    start = t + np.concatenate([[0.0], np.cumsum(duration)[:-1]])
    u = (v[1:] - v[:-1]) / np.maximum(duration, 1e-300) - 0.5 * jerk * duration
    return np.column_stack([start, s[:-1], v[:-1], u, jerk, duration])[kept]


def _excesses(motion: ArmMotion, brake: Floats, within: int = 9) -> Floats:
    """Excess over the limits within the pieces of a brake, up to their ends, relative to the limits, (pieces, within)."""
    shares = np.clip(np.linspace(0.0, 1.0, within), _ASIDE, 1 - _ASIDE)
    t = (shares[None, :] * brake[:, 5:6]).ravel()
    _, s0, v0, u0, j, _ = (np.repeat(column, within) for column in brake.T)
    s, v, u = s0 + t * (v0 + t * (u0 / 2 + t * j / 6)), v0 + t * (u0 + t * j / 2), u0 + t * j
    return _Course(motion, s).excesses(u, v**2).reshape(-1, within)
