"""No learning: the time optimum under torque limits by the nominal model, as if nothing were carried and nothing rubbed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.task import Task


@dataclass
class Nominal:
    """One motion: right where the model is."""

    task: Task

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The motion, once."""
        if logs:
            return None
        bound = np.broadcast_to(self.task.torque, self.task.q.shape)
        return self.task.optimum(self.task.nominal, -bound, bound)
