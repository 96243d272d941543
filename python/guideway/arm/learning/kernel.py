"""The solver that motions are planned with: the core's on a fixed grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from guideway import _core
from guideway.errors import Infeasible

Floats = NDArray[np.float64]

FEW, MANY, ROUNDS = 4, 10, 12
SETTLED = 1e-6
"""Rounds end when no squared speed changes by more than this share of the largest one."""


def solve(s: Floats, ceiling: Floats, rows: tuple[Floats, Floats, Floats, Floats], low: Floats, high: Floats, guess: Floats | None = None) -> Floats:
    """Squared speeds of the fastest motion from rest to rest under ``low <= a u + b x + d sqrt(x) + c <= high``; ``rows`` is (a, b, d, c), ``guess``
    a first idea of the result.

    The root is replaced by its tangent at the result of the round before, which settles fast. Chords from 0 come first where there is no guess, and
    all the way where a tangent fails (it asks for too much at a place that has become much slower): they halve the error of a round, and never fail.
    """
    a, b, d, c = rows
    low, high = (np.ascontiguousarray(np.broadcast_to(bound, a.shape)) for bound in (low, high))
    if not d.any():
        return np.asarray(_core.topp_kernel(s, ceiling, a, b, c, low, high))

    def chords(count: int) -> Floats:
        x = 0.25 * ceiling
        for _ in range(count):
            x = np.asarray(_core.topp_kernel(s, ceiling, a, b + d / _root(x, ceiling), c, low, high))
        return x

    x, half = chords(FEW) if guess is None else guess, 0.5 * d
    for _ in range(ROUNDS):
        root = _root(x, ceiling)
        try:
            found = np.asarray(_core.topp_kernel(s, ceiling, a, b + half / root, c + half * root, low, high))
        except Infeasible:
            return chords(MANY)
        if (found[1:-1] <= 0).any():
            return chords(MANY)
        settled = np.abs(found - x).max() <= SETTLED * float(found.max())
        x = found
        if settled:
            break
    return x


def _root(x: Floats, ceiling: Floats) -> Floats:
    """Speeds (n, 1), none of them 0."""
    return np.sqrt(np.maximum(x, 1e-8 * float(ceiling.max())))[:, None]
