"""Two-step iterative learning: correct the model by what it left unexplained, solve the optimal control problem again, iterate.

Source: [steinhauser2018] (idea). Departures: the correction is a function of the path alone, ``r(s) = measured - nominal torque``, with a relaxation
of 0.6; it is only right near the speeds it was measured at, so no squared speed rises by more than 20 % from one trial to the next, and none where a
trial that was stopped early never came. What a correction of the path alone cannot hold is that torques step where the motion goes over from speeding
up to braking: these places move from trial to trial, and with them the error of a payload that the model does not carry.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.dynamics import Rows
from guideway.arm.learning.log import Log, smooth
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.task import Task
from guideway.errors import Infeasible

Floats = NDArray[np.float64]

SMOOTH = 15
"""Samples of the moving average that the correction is taken from."""


@dataclass
class TwoStep:
    """``relaxation`` of the correction, ``trust`` region of squared speeds, ``margin`` of the limit, done when durations change by less than
    ``settled``."""

    task: Task
    relaxation: float = 0.6
    trust: float = 0.2
    margin: float = 0.01
    settled: float = 0.002
    scale: float = 0.4

    def __post_init__(self) -> None:
        self._correction = np.zeros_like(self.task.q)
        self._motion = self.task.optimum().slower(self.scale)
        self._learned = 0
        self._done = False

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The optimum of the corrected model, as far as the trust region allows."""
        for log in logs[self._learned :]:
            self._learned += 1
            before = self._motion
            self._correct(log)
            self._motion = self._next(before, log)
            clean = not log.stopped and not log.violations(self.task.torque).any()
            self._done = clean and abs(self._motion.duration / before.duration - 1) < self.settled
        return None if self._done else self._motion

    def _correct(self, log: Log) -> None:
        seen = log.reference
        q, q1, q2 = self.task.path.eval(seen.s, 2)
        left = smooth(log.tau - self.task.dynamics.nominal(q, q1, q2).at(seen.u, seen.speed**2), SMOOTH)
        reached = self.task.s <= seen.s[-1] + 1e-9
        found = np.stack([np.interp(self.task.s, seen.s, column) for column in left.T], 1)
        share = self.relaxation if self._learned > 1 else 1.0
        self._correction[reached] += share * (found - self._correction)[reached]

    def _next(self, before: Motion, log: Log) -> Motion:
        """The optimum of the corrected model whose squared speeds are at most ``trust`` above those of the last motion, and not above them where that
        did not get. Where the correction alone is beyond a limit (it holds what friction and the payload took at that speed) the model knows no
        motion at all: there, squared speeds fall by ``trust``. Slower as a whole where no optimum exists."""
        nominal, torque = self.task.nominal, self.task.torque
        rows = Rows(nominal.a, nominal.b, nominal.d, nominal.c + self._correction)
        room, least = np.broadcast_to(torque * (1 - self.margin), rows.c.shape), 1.001 * np.abs(rows.c) + 1e-3 * torque
        rise = np.where((self.task.s <= log.reference.s[-1]) | (not log.stopped), 1 + self.trust, 1.0)
        rise[(least > room).any(1)] = 1 - self.trust
        room = np.maximum(room, least)
        near = copy(self.task)
        near.ceiling = np.minimum(self.task.ceiling, np.maximum(rise * before.x, 1e-6 * self.task.ceiling))
        try:
            return near.optimum(rows, -room, room)
        except Infeasible:
            return before.slower(np.sqrt(1 - self.trust))
