"""What is to be learned: a path, the nominal arm, limits; and the exact time optimum of any rows along that path."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.dynamics import Dynamics, Rows
from guideway.arm.learning.kernel import solve
from guideway.arm.learning.motion import Motion, Sampled
from guideway.arm.limits import JointLimits
from guideway.arm.model import Arm
from guideway.errors import BadParameter, Infeasible

Floats = NDArray[np.float64]

INTERVALS = 1000
"""Of the grid that motions are planned on."""
INSIDE = 10
"""Parts of an interval in which accelerations are checked."""
SPARE = 1e-3
"""Share of the acceleration limits that is left for what happens between those points."""
TIGHTENINGS = 4
"""Times that limits are drawn in for what happens between grid points."""


class Task:
    """A joint path (by arc length, rad), the nominal ``arm`` and ``limits`` with speed, acceleration and torque.

    ``s`` (n,) is the grid, ``q, q1, q2`` (n, joints) the path and its derivatives there; ``speed, acceleration, deceleration, torque`` are (joints,).
    """

    def __init__(self, path: Any, arm: Arm, limits: JointLimits, intervals: int = INTERVALS) -> None:
        self.path, self.arm, self.limits, self.dynamics = path, arm, limits, Dynamics(arm)
        self.speed, self.acceleration, self.torque = (_needed(limits, name, arm.joints) for name in ("speed", "acceleration", "torque"))
        slow = limits.per_joint("deceleration", arm.joints)
        self.deceleration = self.acceleration if slow is None else slow
        if not path.length > 0:
            raise BadParameter("the path has no length: there is nothing to learn")
        self.s = np.linspace(0.0, path.length, intervals + 1)
        self.q, self.q1, self.q2 = path.eval(self.s, 2)
        if self.q.shape[1] != arm.joints:
            raise BadParameter(f"the path has {self.q.shape[1]} joints, the arm {arm.joints}: {', '.join(arm.names)}")
        self.nominal = self.dynamics.nominal(self.q, self.q1, self.q2)
        self.ceiling = ((self.speed / np.maximum(np.abs(self.q1), 1e-9)) ** 2).min(1)

    def bounds(self, q1: Floats) -> tuple[Floats, Floats]:
        """Lowest and highest joint accelerations (n, joints) where the path's direction is ``q1``: decelerations are against the motion."""
        forward = q1 >= 0
        return -np.where(forward, self.deceleration, self.acceleration), np.where(forward, self.acceleration, self.deceleration)

    def optimum(self, rows: Rows | None = None, low: Floats | None = None, high: Floats | None = None, near: Motion | None = None) -> Motion:
        """The fastest motion under the kinematic limits and ``low <= rows <= high`` (N m, (n, joints)), rest to rest; ``near`` it, computing is
        quicker.

        Raises :class:`guideway.errors.Infeasible` where even standing still breaks a bound, or no motion exists.
        """
        slowest, fastest = self.bounds(self.q1)
        a, b, d, c = self.q1, self.q2, np.zeros_like(self.q1), np.zeros_like(self.q1)
        if rows is not None and low is not None and high is not None:
            self._holds_still(rows, low, high)
            a, b, d, c = (np.concatenate(pair, 1) for pair in ((a, rows.a), (b, rows.b), (d, rows.d), (c, rows.c)))
            slowest, fastest = np.concatenate([slowest, low], 1), np.concatenate([fastest, high], 1)
        return self.slowed(self._between(slowest, fastest, (a, b, d, c), near))

    def slowed(self, motion: Motion) -> Motion:
        """The motion, slower as a whole where it exceeds a speed or an acceleration, so that it does not."""
        if motion.s is self.s:
            q1 = self._between_points[0]
            share = np.linspace(0.0, 1.0, INSIDE + 1)[:, None]
            x = (motion.x[:-1] * (1 - share) + motion.x[1:] * share)[:, :, None]
            most = float(np.sqrt(max((x * (q1 / self.speed) ** 2).max(), self._worst(motion).max())))
        else:
            most = self.kinematic_ratio(motion.dense())
        return motion if most <= 1.0 else motion.slower(1.0 / (most * (1 + 1e-12)))

    def _between(self, low: Floats, high: Floats, rows: tuple[Floats, Floats, Floats, Floats], near: Motion | None) -> Motion:
        """The optimum on the grid, its acceleration limits drawn in where they were exceeded between grid points, until next to nothing is left."""
        joints = len(self.speed)
        scale = np.ones_like(low)
        scale[:, :joints] -= SPARE
        guess = None if near is None else near.squared(self.s)
        motion = Motion(self.path, self.s, solve(self.s, self.ceiling, rows, low * scale, high * scale, guess))
        for _ in range(TIGHTENINGS):
            worst = self._worst(motion)
            if worst.max() <= 1 - 0.5 * SPARE:
                break
            step = np.minimum((1 - SPARE) / worst, 1.0)
            scale[:, :joints] *= np.minimum(np.append(step, 1.0), np.append(1.0, step))[:, None]
            motion = Motion(self.path, self.s, solve(self.s, self.ceiling, rows, low * scale, high * scale, motion.x))
        return motion

    def _worst(self, motion: Motion) -> Floats:
        """Largest share of its limit that any joint's acceleration takes on each interval of the grid."""
        q1, q2, low, high = self._between_points
        share = np.linspace(0.0, 1.0, INSIDE + 1)[:, None]
        x = (motion.x[:-1] * (1 - share) + motion.x[1:] * share)[:, :, None]
        acceleration = q1 * motion.u[:, None] + q2 * x
        return np.maximum(acceleration / high, acceleration / low).max((0, 2))

    @cached_property
    def _between_points(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Derivatives of the path and bounds of accelerations at the ends of each interval and between, (inside + 1, n - 1, joints)."""
        share = np.linspace(0.0, 1.0, INSIDE + 1)[:, None]
        places = self.s[:-1] * (1 - share) + self.s[1:] * share
        _, q1, q2 = self.path.eval(np.minimum(places.ravel(), self.s[-1]), 2)
        q1, q2 = (part.reshape(*places.shape, -1) for part in (q1, q2))
        return q1, q2, *self.bounds(q1)

    def kinematic_ratio(self, seen: Sampled) -> float:
        """Largest speed over its limit, and root of the largest acceleration over its limit: how much slower a motion would have to be."""
        low, high = self.bounds(seen.q1)
        speed = float((np.abs(seen.qd) / self.speed).max())
        acceleration = float(np.maximum(seen.qdd / high, seen.qdd / low).max())
        return max(speed, float(np.sqrt(max(acceleration, 0.0))))

    def _holds_still(self, rows: Rows, low: Floats, high: Floats) -> None:
        """At rest the torque must be inside: nothing slower helps."""
        over = np.maximum(rows.c - high, low - rows.c)
        if over.max() > 0:
            place, joint = np.unravel_index(int(np.argmax(over)), over.shape)
            raise Infeasible(
                f"static overload: {self.arm.names[joint]} needs {abs(rows.c[place, joint]):.2f} N m to hold and rub at s = {self.s[place]:.4f} rad "
                f"of the path, limit {self.torque[joint]:g} N m less the margin. A slower motion does not help: less payload, or another path"
            )


def _needed(limits: JointLimits, name: str, joints: int) -> Floats:
    found = limits.per_joint(name, joints)
    if found is None:
        raise BadParameter(f"learning needs a limit of {name}: a number above 0, or one for each of the {joints} joints")
    return found
