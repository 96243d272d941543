"""Two-step iterative learning: correct the model by what it left unexplained, solve the optimal control problem again, iterate.

Source: [steinhauser2018] (idea). Departures: the correction is a function of the path alone, ``r(s) = measured - nominal torque``, with a relaxation
of 0.6; it is only right near the speeds it was measured at, so each motion stays within a trust region of the one before it (squared speeds within
20 %).
"""

from __future__ import annotations

from collections.abc import Sequence
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
            self._correct(log)
            before = self._motion
            self._motion = self._towards(before)
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

    def _towards(self, before: Motion) -> Motion:
        """From the last motion towards the new optimum, squared speeds changed by at most ``trust``; where no optimum exists, slower as a whole."""
        nominal, torque = self.task.nominal, self.task.torque
        rows = Rows(nominal.a, nominal.b, nominal.d, nominal.c + self._correction)
        room = np.maximum(np.broadcast_to(torque * (1 - self.margin), rows.c.shape), 1.001 * np.abs(rows.c))
        try:
            wanted = self.task.optimum(rows, -room, room)
        except Infeasible:
            return before.slower(np.sqrt(1 - self.trust))
        change = wanted.x - before.x
        inside = before.x > 0
        most = float(np.max(np.abs(change[inside]) / before.x[inside], initial=0.0))
        return Motion(before.path, before.s, before.x + min(1.0, self.trust / max(most, 1e-12)) * change)
