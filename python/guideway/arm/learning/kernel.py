"""The solver that motions are planned with: the core's on a fixed grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from guideway import _core
from guideway.errors import Infeasible

Floats = NDArray[np.float64]

ROUNDS = 12
SETTLED = 1e-6
"""Rounds end when no squared speed changes by more than this share of the largest one."""
NOTHING = 1e-9
"""Coefficients below this are those of a joint that does not move: they are rounding."""


def solve(s: Floats, ceiling: Floats, rows: tuple[Floats, Floats, Floats, Floats], low: Floats, high: Floats, guess: Floats | None = None) -> Floats:
    """Squared speeds of the fastest motion from rest to rest under ``low <= a u + b x + d sqrt(x) + c <= high``; ``rows`` is (a, b, d, c), ``guess`` a
    first idea of the result.

    The root is replaced by its chord from 0 in the first round, which is exact at rest, and by its tangent at the result of the round before in the
    others, which settles fast; where a tangent asks for more than there is at a place that has become much slower, the chord is taken again.
    """
    a, b, d, c = (np.where(np.abs(part) < NOTHING, 0.0, part) for part in rows)
    low, high = (np.ascontiguousarray(np.broadcast_to(bound, a.shape)) for bound in (low, high))
    if not d.any():
        return np.asarray(_core.topp_kernel(s, ceiling, a, b, c, low, high))
    x = 0.25 * ceiling if guess is None else guess
    least = 1e-8 * float(ceiling.max())

    def chord() -> Floats:
        return np.asarray(_core.topp_kernel(s, ceiling, a, b + d / root[:, None], c, low, high))

    for number in range(ROUNDS):
        root = np.sqrt(np.maximum(x, least))
        if number == 0:
            found = chord()
        else:
            half = 0.5 * d
            try:
                found = np.asarray(_core.topp_kernel(s, ceiling, a, b + half / root[:, None], c + half * root[:, None], low, high))
            except Infeasible:
                found = chord()
        settled = number > 0 and np.abs(found - x).max() <= SETTLED * float(found.max())
        x = found
        if settled:
            break
    return x
