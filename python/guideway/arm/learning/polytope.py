"""Which numbers are still possible when every measurement is off by no more than a known bound: a box around the polytope of them.

Upper ends of the box are linear programs, solved by an interior-point method (Mehrotra's predictor and corrector); whatever the method returns, its
dual makes the end a proven one: for any ``y >= 0``, ``c.z <= y.b + |c - A'y|.w`` on ``{A z <= b, |z| <= w}``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEPS = 40
CLOSE = 1e-7
"""Steps end at this gap between the program and its dual."""


def upper_end(c: Floats, a: Floats, b: Floats, width: Floats) -> float:
    """A proven upper bound of ``c.z`` over ``{a z <= b, |z| <= width}``: the best of those that the steps of the method prove."""
    rows, columns = a.shape
    best = float(np.abs(c) @ width)
    z, slack, dual = np.zeros(columns), np.maximum(b, 1.0), np.full(rows, float(np.abs(c).max()) / np.sqrt(rows))
    for _ in range(STEPS):
        primal, stationary = b - a @ z - slack, c - a.T @ dual
        best = min(best, float(dual @ b + np.abs(stationary) @ width))
        gap = float(slack @ dual) / rows
        if rows * gap < CLOSE * (1 + abs(float(c @ z))) and np.abs(primal).max() < CLOSE:
            break
        weight = dual / slack
        normal = a.T @ (weight[:, None] * a)
        normal[np.diag_indices(columns)] += 1e-12 * (1 + np.diag(normal))
        factor = np.linalg.inv(normal)
        step = _step(a, factor, (primal, stationary, -slack * dual), (slack, weight))
        along = min(1.0, _longest(slack, step[1])), min(1.0, _longest(dual, step[2]))
        wanted = float((slack + along[0] * step[1]) @ (dual + along[1] * step[2])) / rows
        centre = (wanted / gap) ** 3 * gap
        step = _step(a, factor, (primal, stationary, centre - slack * dual - step[1] * step[2]), (slack, weight))
        along = min(1.0, 0.99 * _longest(slack, step[1])), min(1.0, 0.99 * _longest(dual, step[2]))
        z, slack, dual = z + along[0] * step[0], slack + along[0] * step[1], dual + along[1] * step[2]
    return best


def _step(a: Floats, factor: Floats, errors: tuple[Floats, Floats, Floats], point: tuple[Floats, Floats]) -> tuple[Floats, Floats, Floats]:
    """Newton's step of (z, slack, dual)."""
    primal, stationary, complement = errors
    slack, weight = point
    right = stationary + a.T @ (weight * primal - complement / slack)
    dz = factor @ right
    ds = primal - a @ dz
    return dz, ds, complement / slack - weight * ds


def _longest(values: Floats, step: Floats) -> float:
    """How far one may go before a value becomes 0."""
    falling = step < 0
    return float(np.min(-values[falling] / step[falling], initial=np.inf))
