"""What continuous planners leave, for figures: trees, populations over the generations, homotopy classes, speed along the path."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .geometry import listed, points

INK, SOFT, CLASS, LIMIT = "#17212b", "#55626f", "#c8500a", "#b3261e"


def trace_of(result: Mapping[str, Any]) -> Mapping[str, Any]:
    """The trace of a result; empty where there is none."""
    trace = result.get("trace")
    return trace if isinstance(trace, Mapping) else {}


def speed_of(result: Mapping[str, Any]) -> Mapping[str, Any]:
    """Ceiling, first pass and motion of a result, speed over arc length; empty where there is none."""
    speed = trace_of(result).get("speed")
    return speed if isinstance(speed, Mapping) and len(points(speed.get("after"))) > 1 else {}


def draw_trace(axes: Any, trace: Mapping[str, Any]) -> None:
    """Edges of a tree, populations (older ones paler), the shortest path of each homotopy class with its number."""
    from matplotlib.collections import LineCollection

    edges = points(trace.get("tree"), 4)
    if len(edges):
        axes.add_collection(LineCollection(list(edges.reshape(-1, 2, 2)), colors=SOFT, linewidths=0.35, alpha=0.6, zorder=2))
    generations = [each for each in listed(trace.get("population")) if isinstance(each, Mapping)]
    for age, each in enumerate(reversed(generations)):
        for line in map(points, listed(each.get("paths"))):
            if len(line):
                axes.plot(line[:, 0], line[:, 1], color=INK, linewidth=0.5, alpha=max(0.08, 0.5 / (1 + age)), zorder=3)
    for number, each in enumerate(listed(trace.get("classes")), 1):
        line = points(each.get("path")) if isinstance(each, Mapping) else points([])
        if len(line) > 1:
            axes.plot(line[:, 0], line[:, 1], color=CLASS, linewidth=0.9, linestyle=(0, (5, 3)), zorder=3)
            axes.annotate(str(number), line[np.abs(np.linspace(0, 1, len(line)) - 0.5).argmin()], color=CLASS, fontsize=7, zorder=6)


def draw_speed(axes: Any, speed: Mapping[str, Any]) -> None:
    """Speed along the path before and after its correction, the overspeed regions tinted, the ceiling shaded."""
    ceiling, before, after = (points(speed.get(key)) for key in ("ceiling", "before", "after"))
    top = 1.08 * max(float(rows[:, 1].max()) for rows in (ceiling, before, after) if len(rows))
    if len(ceiling):
        axes.fill_between(ceiling[:, 0], ceiling[:, 1], top, color=LIMIT, alpha=0.1, linewidth=0, label="above the ceiling")
    for region in listed(speed.get("regions_before")):
        axes.axvspan(region["from"], region["to"], color=LIMIT, alpha=0.12, linewidth=0)
    if len(before):
        axes.plot(before[:, 0], before[:, 1], color=SOFT, linewidth=1.1, linestyle=(0, (4, 3)), label="first pass")
    axes.plot(after[:, 0], after[:, 1], color="#0072b2", linewidth=1.8, label="motion")
    axes.set(xlabel="along the path in m", ylabel="speed in m/s", ylim=(0, top))
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8, loc="lower center", ncols=3)
