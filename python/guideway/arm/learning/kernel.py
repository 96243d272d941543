"""The solver that motions are planned with: the core's on a fixed grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from guideway import _core
from guideway.errors import Infeasible

Floats = NDArray[np.float64]

FEW, MANY, ROUNDS, EASINGS = 4, 10, 20, 12
EASED = 0.7
SETTLED = 1e-6
"""Rounds end when no squared speed changes by more than this share of the largest one."""


def solve(s: Floats, ceiling: Floats, rows: tuple[Floats, Floats, Floats, Floats], low: Floats, high: Floats, guess: Floats | None = None) -> Floats:
    """Squared speeds of the fastest motion from rest to rest under ``low <= a u + b x + d sqrt(x) + c <= high``; ``rows`` is (a, b, d, c), ``guess``
    a first idea of the result.

    The root is replaced by its tangent at the result of the round before, which settles fast. Chords from 0 come first where there is no guess, and
    all the way where a tangent fails (it asks for too much at a place that has become much slower): they halve the error of a round, and never fail.

    Where viscous friction takes the last of a torque, the greatest speed before a place may be one from which only a stop there is within the limits,
    and no torque is left to go on. Such speeds are lowered. Raises :class:`guideway.errors.Infeasible` where that does not help.
    """
    at = 0.0
    for _ in range(EASINGS):
        x = _settled(s, ceiling, rows, low, high, guess)
        stands = (x[1:] <= 0) & (x[:-1] <= 0)
        if not stands.any():
            return x
        at = float(s[int(np.argmax(stands))])
        before, after = np.append(stands[1:], False), np.append(False, stands[:-1])
        ceiling = ceiling.copy()
        ceiling[:-1][before] = EASED * x[:-1][before]
        ceiling[1:][after] = EASED * x[1:][after]
    raise Infeasible(f"next to no torque is left at s = {at:.4f} rad of the path: no motion passes it within the limits")


def _settled(s: Floats, ceiling: Floats, rows: tuple[Floats, Floats, Floats, Floats], low: Floats, high: Floats, guess: Floats | None) -> Floats:
    """Squared speeds as of :func:`solve`, which may stand still over an interval."""
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
        settled = np.abs(found - x).max() <= SETTLED * float(found.max())
        x = found
        if settled:
            break
    # A place may be slowed down to a stop on the way here, and recover; where it does not, chords are the better guess.
    return x if (x[1:-1] > 0).all() else chords(MANY)


def _root(x: Floats, ceiling: Floats) -> Floats:
    """Speeds (n, 1), none of them 0: at a stop on the way a half of those beside it, or it would stay one, its root being so steep there."""
    beside = np.zeros_like(x)
    beside[1:-1] = np.where(x[1:-1] > 0, 0.0, 0.25 * np.maximum(x[:-2], x[2:]))
    return np.sqrt(np.maximum(np.maximum(x, beside), 1e-8 * float(ceiling.max())))[:, None]
