"""Speed along a path as a spline with equidistant nodes, in both readings of the source.

Source: [nan2025], equations 11 to 15. Departures: ``corrected`` is a monotone cubic of the *square* of the speed, because the printed spline of the
speed never leaves rest (its acceleration ``V' V`` is 0 where V is 0, and ``ds / V`` has no finite integral). ``literal`` is the printed one, its
slope terms multiplied by the width of the segment (the print leaves it out), its end speeds raised to 0.02 rad/s: a small step of speed at start and
stop.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from guideway.errors import BadParameter

Floats = NDArray[np.float64]

READINGS = ("corrected", "literal")
FLOOR = 0.02
"""Lowest speed of the literal reading, rad/s."""


class SpeedSpline:
    """Squared speeds at fixed places from the speeds of ``segments + 1`` equidistant nodes on a path of ``length`` rad."""

    def __init__(self, length: float, segments: int, places: Floats, reading: str) -> None:
        if reading not in READINGS:
            raise BadParameter(f"reading {reading!r} is not known: one of {', '.join(READINGS)}")
        self.reading, self.width = reading, length / segments
        self.segment = np.minimum((places / self.width).astype(int), segments - 1)
        t = places / self.width - self.segment
        self._ends = (1 + 2 * t) * (1 - t) ** 2, (3 - 2 * t) * t**2
        self._slopes = self.width * t * (1 - t) ** 2, self.width * t**2 * (t - 1)

    def squared(self, speeds: Floats) -> Floats:
        """Squared speeds at the places, rad2/s2, from node speeds, rad/s."""
        if self.reading == "literal":
            values = np.maximum(speeds, FLOOR)
            return np.maximum(self._hermite(values, smooth_slopes(values, self.width)), FLOOR) ** 2
        values = speeds**2
        return np.maximum(self._hermite(values, monotone_slopes(values, self.width)), 0.0)

    def _hermite(self, values: Floats, slopes: Floats) -> Floats:
        i = self.segment
        found = self._ends[0] * values[i] + self._ends[1] * values[i + 1] + self._slopes[0] * slopes[i] + self._slopes[1] * slopes[i + 1]  # (13)
        return np.asarray(found)


def smooth_slopes(values: Floats, width: float) -> Floats:
    """Slopes of the cubic spline with continuous second derivative, which is 0 at both ends (Thomas algorithm)."""
    count = len(values)
    below, diagonal, right = np.ones(count), np.full(count, 4.0), np.empty(count)
    diagonal[[0, -1]] = 2.0
    right[1:-1] = 3 * (values[2:] - values[:-2]) / width
    right[0], right[-1] = 3 * (values[1] - values[0]) / width, 3 * (values[-1] - values[-2]) / width
    for i in range(1, count):
        share = below[i] / diagonal[i - 1]
        diagonal[i] -= share
        right[i] -= share * right[i - 1]
    slopes = right / diagonal
    for i in range(count - 2, -1, -1):
        slopes[i] = (right[i] - slopes[i + 1]) / diagonal[i]
    return slopes


def monotone_slopes(values: Floats, width: float) -> Floats:
    """Slopes of the shape-preserving cubic: harmonic means of neighbouring secants, 0 at turning points; at the ends those of the parabola through
    three nodes, kept between the secant (never 0: a motion from rest could not start) and three times that."""
    secants = np.diff(values) / width
    slopes = np.zeros(len(values))
    before, after = secants[:-1], secants[1:]
    same = before * after > 0
    slopes[1:-1][same] = 2 * before[same] * after[same] / (before[same] + after[same])
    for end, first, second in ((0, 0, 1), (-1, -1, -2)):
        if len(secants) == 1:
            slopes[end] = secants[0]
            continue
        wanted = 1.5 * secants[first] - 0.5 * secants[second]
        low, high = sorted((secants[first], 3 * secants[first]))
        slopes[end] = min(max(wanted, low), high)
    return slopes
