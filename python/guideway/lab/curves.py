"""How fast methods get where they get: convergence curves, expected running time, empirical distributions, performance profiles.

A curve is a list of ``[evaluations, best]`` with best values that only improve (a cost: lower is better); it holds its last value for ever.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .statistics import quantile

Curve = Sequence[Sequence[float]]
TARGETS = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 1e-4, 1e-6)
"""Gaps to the reference that the distribution over evaluations counts, as shares."""
SETTLED = 1e-6
"""A curve has converged when it stays within this share of its final value."""


@dataclass(frozen=True)
class Expected:
    """Expected running time to a target: evaluations of all runs until the target, or their end, over the number of runs that reached it.

    ``value`` is None where no run did.
    """

    value: float | None
    successes: int
    runs: int
    evaluations: float

    def to_dict(self) -> dict[str, Any]:
        """As in summary.json."""
        return asdict(self)


class Course(list[tuple[float, float]]):
    """A checked curve: finite points, evaluations that grow, best values that only improve."""

    end: float | None = None
    """Evaluations at the last point, improving or not."""


def usable(curve: Any) -> Course:
    """A curve from a record, checked; empty where there is none."""
    if isinstance(curve, Course):
        return curve
    course = Course()
    for row in curve if isinstance(curve, list | tuple) else ():
        if not (isinstance(row, list | tuple) and len(row) >= 2 and all(isinstance(v, int | float) and math.isfinite(v) for v in row[:2])):
            continue
        at, best = float(row[0]), float(row[1])
        if course.end is not None and at < course.end:
            continue
        course.end = at
        if not course or best < course[-1][1]:
            course.append((at, best))
    return course


def last_evaluation(curve: Any) -> float | None:
    """Evaluations at the last point of a curve, improving or not; None without one."""
    return usable(curve).end


def reached(curve: Any, target: float) -> float | None:
    """Evaluations after which a curve is at or below ``target``; None if it never is."""
    points = usable(curve)
    i = bisect_left(points, -target, key=lambda point: -point[1])
    return points[i][0] if i < len(points) else None


def convergence(curve: Any, settled: float = SETTLED) -> float | None:
    """Evaluations from which the best value stays within ``settled`` of its final size; None without a curve."""
    points = usable(curve)
    if not points:
        return None
    final = points[-1][1]
    return reached(points, final + settled * abs(final))


def expected(runs: Iterable[tuple[Any, float | None]], target: float) -> Expected | None:
    """Expected evaluations to a target from (curve, evaluations used) of every run, failed ones included.

    ``None`` if it is unknown how many evaluations some run without success used.
    """
    total, successes, count = 0.0, 0, 0
    for curve, used in runs:
        count += 1
        at = reached(curve, target)
        spent = at if at is not None else used if used is not None else last_evaluation(curve)
        if spent is None:
            return None
        total, successes = total + spent, successes + (at is not None)
    return Expected(total / successes if successes else None, successes, count, total) if count else None


def value_at(curve: Course, evaluations: float) -> float | None:
    """Best value of a curve after some evaluations; None before its first point."""
    i = bisect_right(curve, (evaluations, math.inf))
    return curve[i - 1][1] if i else None


def band(curves: Sequence[Any], most: int = 96) -> list[list[float | None]]:
    """Median and quartiles of several runs over evaluations: rows ``[evaluations, lower quartile, median, upper quartile]``, at most ``most``.

    A run without a value yet counts as infinitely bad, so a quartile is ``None`` where too few runs have one. Rows where nothing changes are left
    out.
    """
    every = [course for course in map(usable, curves) if course]
    if not every:
        return []
    places = sorted({at for curve in every for at, _ in curve})
    end = max(course.end or 0.0 for course in every)
    rows: list[list[float | None]] = []
    for at in thin(places, most - 1):
        values = sorted(math.inf if (v := value_at(curve, at)) is None else v for curve in every)
        row = [at, *(None if math.isinf(v) else v for v in (quantile(values, q) for q in (0.25, 0.5, 0.75)))]
        if not rows or row[1:] != rows[-1][1:]:
            rows.append(row)
    return rows if rows[-1][0] == end else [*rows, [end, *rows[-1][1:]]]


def thin(places: Sequence[float], most: int) -> list[float]:
    """At most ``most`` of sorted places, first and last among them, evenly on a logarithmic scale."""
    if len(places) <= most:
        return list(places)
    wanted = np.geomspace(max(places[0], 1.0), max(places[-1], 1.0), most)
    kept = {min(len(places) - 1, int(np.searchsorted(places, at))) for at in wanted} | {0, len(places) - 1}
    return [places[i] for i in sorted(kept)]


def distribution(times: Sequence[float | None], most: int = 200) -> list[list[float]]:
    """Empirical distribution over all trials, those that never succeeded (None) included: rows ``[time, share]``."""
    known = sorted(t for t in times if t is not None and math.isfinite(t))
    rows = [[t, (i + 1) / len(times)] for i, t in enumerate(known) if i + 1 == len(known) or known[i + 1] != t]
    if len(rows) <= most:
        return rows
    return [rows[round(i * (len(rows) - 1) / (most - 1))] for i in range(most)]


def profile(table: Mapping[str, Sequence[float | None]], most: int = 200) -> dict[str, list[list[float]]]:
    """Performance profiles of Dolan and More: per method rows ``[ratio, share]``: share of problems solved within ``ratio`` times the best method's
    cost.

    ``table``: cost per method, one per problem; ``None`` is a failure. Costs must be positive; at a best cost of 0 a method counts as ratio 1 if it
    is 0 too and as failed otherwise. Problems that no method solved count as failures of all.
    """
    ratios: dict[str, list[float | None]] = {name: [] for name in table}
    for costs in zip(*table.values(), strict=True):
        known = [c for c in costs if c is not None and math.isfinite(c)]
        best = min(known, default=math.inf)
        for name, cost in zip(table, costs, strict=True):
            ratios[name].append(ratio(cost, best))
    return {name: distribution(row, most) for name, row in ratios.items()}


def ratio(cost: float | None, best: float) -> float | None:
    """Cost over the best cost, at least 1; None for a failure."""
    if cost is None or not math.isfinite(cost):
        return None
    if cost <= best * (1 + 1e-9):
        return 1.0
    return cost / best if best > 0 else None
