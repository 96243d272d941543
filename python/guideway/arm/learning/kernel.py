"""The solver that motions are planned with: the core's on a fixed grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from guideway import _core

Floats = NDArray[np.float64]

ROUNDS = 12
SETTLED = 1e-6
"""Rounds end when no squared speed changes by more than this share."""


def solve(s: Floats, ceiling: Floats, rows: tuple[Floats, Floats, Floats, Floats], low: Floats, high: Floats) -> Floats:
    """Squared speeds of the fastest motion from rest to rest under ``low <= a u + b x + d sqrt(x) + c <= high``; ``rows`` is (a, b, d, c).

    The root is taken as ``x / sqrt(x')`` with ``x'`` from the round before. That is exact once settled, and exact at rest from the first round on:
    unlike with a tangent, no round asks for more torque at standstill than there is.
    """
    a, b, d, c = (np.ascontiguousarray(part) for part in rows)
    low, high = (np.ascontiguousarray(np.broadcast_to(bound, a.shape)) for bound in (low, high))
    if not d.any():
        return np.asarray(_core.topp_kernel(s, ceiling, a, b, c, low, high))
    x = 0.25 * ceiling
    least = 1e-6 * float(ceiling.max())
    for _ in range(ROUNDS):
        slope = b + d / np.sqrt(np.maximum(x, least))[:, None]
        found = np.asarray(_core.topp_kernel(s, ceiling, a, slope, c, low, high))
        settled = np.abs(found - x).max() <= SETTLED * float(ceiling.max())
        x = found
        if settled:
            break
    return x
