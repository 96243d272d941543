"""How an arm really moved in a trial: measured angles, their speeds and accelerations.

A controller that lags or overshoots moves the joints otherwise than it was asked to, and its torques are those of what it did. The reference is known
exactly, so only what angles deviate from it is smoothed and differentiated (a cubic over 15 samples, Savitzky and Golay's way): noise stays small.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.log import Log
from guideway.arm.model import direction

Floats = NDArray[np.float64]

HALF = 7
"""Samples either side that the cubic is fitted to."""
EXACT = 1e-9
"""Deviations of angles below this are none, rad."""
MOVES = 0.01
"""From that speed on a joint's direction is what was measured, rad/s; below it, the one that was asked for."""


def measured(log: Log) -> tuple[Floats, Floats, Floats, Floats] | None:
    """Angles, speeds, accelerations and directions of the joints, (n, joints) each; None where they are those of the reference."""
    seen = log.reference
    away = log.q - seen.q
    if np.abs(away).max() < EXACT:
        return None
    place, speed, acceleration = _derivatives(away, float(np.median(np.diff(log.t))))
    qd = seen.qd + speed
    return seen.q + place, qd, seen.qdd + acceleration, np.where(np.abs(qd) > MOVES, np.sign(qd), direction(seen.q1))


def _derivatives(values: Floats, step: float) -> tuple[Floats, Floats, Floats]:
    """Smoothed values (n, joints), first and second derivatives, samples ``step`` (s) apart; the ends go on as they are."""
    at = np.arange(-HALF, HALF + 1)
    kernels = np.linalg.pinv(np.vander(at, 4, increasing=True))
    around = np.lib.stride_tricks.sliding_window_view(np.pad(values, ((HALF, HALF), (0, 0)), mode="edge"), len(at), 0)
    place, first, second = (around @ kernel for kernel in kernels[:3])
    return place, first / step, 2 * second / step**2
