"""No learning: the time optimum under the limits of speed and acceleration alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.task import Task


@dataclass
class Kinematic:
    """One motion, the kinematic optimum: a lower bound of every duration; nothing keeps its torques inside."""

    task: Task

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The motion, once."""
        return None if logs else self.task.optimum()
