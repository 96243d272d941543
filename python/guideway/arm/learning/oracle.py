"""The best there is: the time optimum of the true plant. For judging learners; it asks what no learner may know."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.dynamics import Rows
from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.task import Task

Floats = NDArray[np.float64]
TrueRows = Callable[[Task, Floats], Rows]
"""Rows of the true plant on a task's grid, friction as it is at squared speeds ``x``."""

ROUNDS = 8
INTERVALS = 2000


def optimum(task: Task, rows: TrueRows) -> Motion:
    """The optimum under the true torques. Friction that is no linear function of the speed is taken at the speeds of the round before."""
    fine = Task(task.path, task.arm, task.limits, INTERVALS)
    motion = fine.optimum()
    bound = np.broadcast_to(fine.torque, fine.q.shape)
    for _ in range(ROUNDS):
        before = motion
        true = rows(fine, motion.x)
        motion = fine.optimum(true, -bound, bound, motion)
        if np.allclose(before.x, motion.x, rtol=1e-6, atol=1e-9):
            break
    return motion


@dataclass
class Oracle:
    """One motion: :func:`optimum`."""

    task: Task
    rows: TrueRows

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The motion, once."""
        return None if logs else optimum(self.task, self.rows)
