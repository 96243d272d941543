"""The kinematic optimum, slowed as a whole until no violation is measured: bisection over trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.task import Task


@dataclass
class Uniform:
    """``closest``: done when the largest good and the smallest bad share of speed are that near; ``margin`` of the torque limit as for ``source``."""

    task: Task
    closest: float = 0.01
    margin: float = 0.03

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """Half way between what was good and what was not; the last motion is the best good one."""
        good, bad, share = 0.0, 1.0, 1.0
        for log in logs:
            clean = self.accepts(log)
            if clean:
                good = share
            else:
                bad = share
            if clean and (share == 1.0 or bad - good <= self.closest):
                return None
            share = good if good > 0 and bad - good <= self.closest else 0.5 * (good + bad)
        return self.task.optimum().slower(share) if share > 1e-3 else None

    def accepts(self, log: Log) -> bool:
        """Was no torque beyond its limit less the margin?"""
        return not (log.stopped or log.over(self.task.torque, self.margin).any())
