"""The torque that a learner expects along a motion, for controllers that take one (computed torque, ``effort`` of a ROS trajectory)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.motion import Sampled
from guideway.arm.learning.unknown import COULOMB, SPEEDS, Along
from guideway.arm.model import direction

Floats = NDArray[np.float64]

SLOW = 2
"""So many of the speeds of the curve of friction are passed too quickly to be known well."""


@dataclass(frozen=True)
class Expected:
    """Torques under ``numbers`` (p,) as a function of a sampled motion ``along`` the path they were learned on."""

    along: Along
    numbers: Floats

    def __call__(self, seen: Sampled) -> Floats:
        """N m, (n, joints). Masses are taken between grid points; friction and ripple at the very speeds and angles of the samples."""
        plain, bends, ripple = self.along.unknown.split(self.numbers)
        a, b, d, c = (self._between(part, seen.s) for part in self._smooth)
        ways, speed = direction(seen.q1), seen.speed[:, None]
        found = a * seen.u[:, None] + b * speed**2 + d * speed + c + plain[:, COULOMB] * ways
        if bends.size:
            found = found + (self.along.unknown.bends(seen.qd, ways) * _likely(bends, plain[:, COULOMB])).sum(-1)
        return found * (1 + (self.along.unknown.waves(seen.q) * ripple).sum(-1)) if ripple.size else found

    @cached_property
    def _smooth(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Rows on the grid without the part of friction that jumps where a joint turns round."""
        plain = self.along.unknown.split(self.numbers)[0].copy()
        plain[:, COULOMB] = 0.0
        rows = self.along.task.nominal + self.along.plain.times(plain)
        return rows.a, rows.b, rows.d, rows.c

    def _between(self, values: Floats, s: Floats) -> Floats:
        return np.stack([np.interp(s, self.along.task.s, column) for column in values.T], 1)


def _likely(bends: Floats, coulomb: Floats) -> Floats:
    """The curve of friction (joints, 12), near standstill only as far as friction can be: against the motion, and no more than it is just above."""
    grip = coulomb[:, None, None] + bends.reshape(len(bends), 2, len(SPEEDS))
    least = np.minimum(grip[:, :, SLOW:].min(2, keepdims=True), 0.0)
    grip[:, :, :SLOW] = np.clip(grip[:, :, :SLOW], least, grip[:, :, SLOW:].max(2, keepdims=True))
    return (grip - coulomb[:, None, None]).reshape(bends.shape)
