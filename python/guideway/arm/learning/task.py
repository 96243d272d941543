"""What is to be learned: a path, the nominal arm, limits; and the exact time optimum of any rows along that path.

Every limit that a limits file can state is either kept by all motions of a task (speed, acceleration, deceleration, torque, those of the tip) or
refused when the task is made (jerk, torque rate: motions of learning are pieces of constant path acceleration).
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.between import Grid
from guideway.arm.learning.dynamics import Dynamics, Rows
from guideway.arm.learning.kernel import solve
from guideway.arm.learning.motion import Motion, Sampled
from guideway.arm.limits import JointLimits
from guideway.arm.model import Arm
from guideway.arm.rows import tip_ceiling, tip_derivatives, tip_rows
from guideway.errors import BadParameter, Infeasible

Floats = NDArray[np.float64]

INTERVALS = 1000
"""Of the grid that motions are planned on."""
SPARE = 1e-3
"""Share of the acceleration limits that is left for what happens between those points."""
TIGHTENINGS = 4
"""Times that limits are drawn in for what happens between grid points."""
REFUSED = ("jerk", "torque_rate")
"""Limits that motions of learning cannot keep."""


class Task:
    """A joint path (by arc length, rad), the nominal ``arm`` and ``limits`` with speed, acceleration and torque, perhaps those of the tip.

    ``s`` (n,) is the grid, ``q, q1, q2`` (n, joints) the path and its derivatives there; ``speed, acceleration, deceleration, torque`` are (joints,).
    """

    def __init__(self, path: Any, arm: Arm, limits: JointLimits, intervals: int = INTERVALS) -> None:
        _refuse(limits)
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
        if limits.tip_speed is not None:
            self.ceiling = np.minimum(self.ceiling, tip_ceiling(arm, path, limits.tip_speed)(self.s))
        self.grid = self._last = Grid(self, self.s)
        self._tip = None if limits.tip_acceleration is None else tip_rows(arm, path, limits.tip_acceleration)(self.s)

    def bounds(self, q1: Floats) -> tuple[Floats, Floats]:
        """Lowest and highest joint accelerations (n, joints) where the path's direction is ``q1``: decelerations are against the motion."""
        forward = q1 >= 0
        return -np.where(forward, self.deceleration, self.acceleration), np.where(forward, self.acceleration, self.deceleration)

    def optimum(self, rows: Rows | None = None, low: Floats | None = None, high: Floats | None = None, near: Motion | None = None) -> Motion:
        """The fastest motion under the kinematic limits and ``low <= rows <= high`` (N m, (n, joints)), rest to rest; ``near`` it, computing is
        quicker.

        Raises :class:`guideway.errors.Infeasible` where even standing still breaks a bound, or no motion exists.
        """
        slowest, fastest, (a, b, d, c) = self._kinematic
        if rows is not None and low is not None and high is not None:
            self._holds_still(rows, low, high)
            a, b, d, c = (np.concatenate(pair, 1) for pair in ((a, rows.a), (b, rows.b), (d, rows.d), (c, rows.c)))
            slowest, fastest = np.concatenate([slowest, low], 1), np.concatenate([fastest, high], 1)
        return self.slowed(self._between(slowest, fastest, (a, b, d, c), near))

    @cached_property
    def _kinematic(self) -> tuple[Floats, Floats, tuple[Floats, Floats, Floats, Floats]]:
        """Lowest and highest values and rows of what needs no torques: accelerations of the joints, then that of the tip in many directions."""
        (slowest, fastest), a, b = self.grid.bounds, self.q1, self.q2
        if self._tip is not None:
            a, b = np.concatenate([a, self._tip["a"]], 1), np.concatenate([b, self._tip["b"]], 1)
            low, high = (np.broadcast_to(self._tip[name], self._tip["a"].shape) for name in ("low", "high"))
            slowest, fastest = np.concatenate([slowest, low], 1), np.concatenate([fastest, high], 1)
        return slowest, fastest, (a, b, np.zeros_like(a), np.zeros_like(a))

    def slowed(self, motion: Motion) -> Motion:
        """The motion, slower as a whole where it exceeds a speed or an acceleration, so that it does not."""
        grid, spare = self.grid, 0.0
        if motion.s is not self.s:
            # limits of this grid were not drawn in for what happens between the places that are looked at
            grid, spare = self._last if self._last.s is motion.s else Grid(self, motion.s), SPARE
            self._last = grid
        most = float(np.sqrt(max(grid.speed(motion).max(), grid.acceleration(motion).max()))) * (1 + spare)
        return motion if most <= 1.0 else motion.slower(1.0 / (most * (1 + 1e-12)))

    def _between(self, low: Floats, high: Floats, rows: tuple[Floats, Floats, Floats, Floats], near: Motion | None) -> Motion:
        """The optimum on the grid, its limits of speed and acceleration drawn in where they were exceeded between grid points, until next to nothing
        is left."""
        count = self._kinematic[0].shape[1]
        scale, ceiling = np.ones_like(low), self.ceiling
        scale[:, :count] -= SPARE
        guess = None if near is None else near.squared(self.s)
        motion = Motion(self.path, self.s, solve(self.s, ceiling, rows, low * scale, high * scale, guess))
        for _ in range(TIGHTENINGS):
            fast, worst = self.grid.speed(motion), self.grid.acceleration(motion)
            if worst.max() <= 1 - 0.5 * SPARE and fast.max() <= 1:
                break
            ceiling = ceiling * _beside(np.where(fast > 1, (1 - 1e-9) / np.maximum(fast, 1.0), 1.0))
            scale[:, :count] *= _beside(np.minimum((1 - SPARE) / worst, 1.0))[:, None]
            motion = Motion(self.path, self.s, solve(self.s, ceiling, rows, low * scale, high * scale, motion.x))
        return motion

    def kinematic_ratio(self, seen: Sampled) -> float:
        """Largest speed over its limit, and root of the largest acceleration over its limit: how much slower a motion would have to be."""
        low, high = self.bounds(seen.q1)
        speed = float((np.abs(seen.qd) / self.speed).max())
        acceleration = float(np.maximum(seen.qdd / high, seen.qdd / low).max())
        fast, hard = self.limits.tip_speed, self.limits.tip_acceleration
        if fast is not None or hard is not None:
            one, two = tip_derivatives(self.arm, self.path, seen.s)
            v, u = seen.speed[:, None], seen.u[:, None]
            speed = max(speed, float(np.linalg.norm(one * v, axis=1).max()) / (fast or np.inf))
            acceleration = max(acceleration, float(np.linalg.norm(one * u + two * v * v, axis=1).max()) / (hard or np.inf))
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


def _beside(shares: Floats) -> Floats:
    """The lesser share of the two intervals beside each point, (n,) of (n - 1,)."""
    return np.minimum(np.append(shares, 1.0), np.append(1.0, shares))


def _refuse(limits: JointLimits) -> None:
    """Raises for a limit that motions of learning would ignore."""
    for name in REFUSED:
        if getattr(limits, name) is not None:
            raise BadParameter(
                f"limit {name} cannot be kept while learning: motions are pieces of constant path acceleration. Leave {name} out of the limits; "
                f"or, where the load and the friction are known, state them and time the path with 'guideway arm time', which keeps {name}"
            )


def _needed(limits: JointLimits, name: str, joints: int) -> Floats:
    found = limits.per_joint(name, joints)
    if found is None:
        raise BadParameter(f"learning needs a limit of {name}: a number above 0, or one for each of the {joints} joints")
    return found
