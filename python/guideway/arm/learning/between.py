"""A grid along a task's path, and what motions on it do between its points: how much of the limits of speed and acceleration they take."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from guideway.arm.rows import tip_derivatives

if TYPE_CHECKING:
    from guideway.arm.learning.motion import Motion
    from guideway.arm.learning.task import Task

Floats = NDArray[np.float64]

INSIDE = 10
"""Parts of an interval in which speeds and accelerations are checked."""


class Grid:
    """Places ``s`` (n,) of a task's path, with :data:`INSIDE` parts of each interval between them."""

    def __init__(self, task: Task, s: Floats) -> None:
        self.task, self.s = task, s
        places = np.minimum(_within(s), s[-1])
        _, q1, q2 = task.path.eval(places.ravel(), 2)
        self._places = places
        self._q1, self._q2 = (part.reshape(*places.shape, -1) for part in (q1, q2))
        # where a joint turns round, what speeds it up before slows it down after: the lower one of both limits counts on all of the interval
        forward = self._q1 >= 0
        self._turns = forward.any(0) & ~forward.all(0)
        low, high = task.bounds(self._q1)
        least = np.minimum(task.acceleration, task.deceleration)
        self._low, self._high = np.where(self._turns, -least, low), np.where(self._turns, least, high)

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest accelerations (n, joints) of the joints at the grid's points, for both intervals beside each."""
        ends = [np.concatenate([part[0], part[-1:, -1]]) for part in (self._low, self._high)]
        before = [np.concatenate([part[:1, 0], part[-1]]) for part in (self._low, self._high)]
        return np.maximum(ends[0], before[0]), np.minimum(ends[1], before[1])

    def speed(self, motion: Motion) -> Floats:
        """Largest share of its limit, squared, that the speed of any joint or of the tip takes on each interval, (n - 1,)."""
        return np.asarray((_within(motion.x) * self._steepest).max(0))

    def acceleration(self, motion: Motion) -> Floats:
        """Largest share of its limit that the acceleration of any joint or of the tip takes on each interval, (n - 1,)."""
        x, u = _within(motion.x)[:, :, None], motion.u[:, None]
        found = self._q1 * u + self._q2 * x
        worst = np.maximum(found / self._high, found / self._low).max((0, 2))
        limit = self.task.limits.tip_acceleration
        if limit is not None:
            one, two = self._tip
            worst = np.maximum(worst, np.linalg.norm(one * u + two * x, axis=2).max(0) / limit)
        return np.asarray(worst)

    @cached_property
    def _steepest(self) -> Floats:
        """Share of the limits of speed, squared, that a squared path speed of 1 takes, (inside + 1, n - 1)."""
        found, limit = ((self._q1 / self.task.speed) ** 2).max(2), self.task.limits.tip_speed
        return np.asarray(found if limit is None else np.maximum(found, (self._tip[0] ** 2).sum(2) / limit**2))

    @cached_property
    def _tip(self) -> tuple[Floats, Floats]:
        """First and second derivative of the tip's position, (inside + 1, n - 1, 3)."""
        one, two = tip_derivatives(self.task.arm, self.task.path, self._places.ravel())
        return one.reshape(*self._places.shape, 3), two.reshape(*self._places.shape, 3)


def _within(values: Floats) -> Floats:
    """Values (n,) at the ends of each interval and between, linear, (inside + 1, n - 1)."""
    share = np.linspace(0.0, 1.0, INSIDE + 1)[:, None]
    return np.asarray(values[:-1] * (1 - share) + values[1:] * share)
