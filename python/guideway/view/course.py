"""Figures of a search: pheromone and population on the map, the best cost over the iterations (by matplotlib)."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import loop
from .figure import COLOURS, draw_world, extent, figure_sheet, save
from .geometry import Array, listed, points
from .report import labels
from .scenery import Scenery

SCENT = ("#fbe9c0", "#f6c566", "#e58e26", "#b4530f", "#6e2406")
"""Pheromone from weak to strong, as in the page: even steps of lightness."""
DECADES = 1000.0
"""Range of the pheromone's scale below its largest value."""


def search_figure(results: Sequence[Mapping[str, Any]], world: Scenery | None, path: str | os.PathLike[str]) -> list[Path]:
    """Writes how plans were found, as ``path`` with the endings ``.png`` (300 dpi) and ``.svg``; returns the two files.

    Left the map with the trace and path of the first result that has one, right the best cost of all of them and, of planners that plan path and
    speed at once, the speed along the path. Needs matplotlib, raises ``ImportError`` without it and ``ValueError`` where no result has a history of
    its search.
    """
    courses = [(result, label, course(result)) for result, label in zip(results, labels(results), strict=True)]
    if not any(len(rows) for _, _, (rows, _) in courses):
        raise ValueError("no result has a history of its search: exact searches have none")
    traced = next((result for result in results if isinstance(result.get("trace"), Mapping)), results[0])
    left, low, right, high = extent([traced], world)
    speeds = loop.speed_of(traced)
    ratio = min(1.4, max(1.0 if speeds else 0.6, (high - low) / max(right - left, 1e-9)))
    sheet = figure_sheet((9.0, 4.1 * ratio))
    map_axes, axes, *below = panels(sheet, 2 if speeds else 1)
    if world is not None:
        draw_world(map_axes, world, plain=True)
    draw_trace(sheet, map_axes, traced)
    map_axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", xlabel="x in m", ylabel="y in m")
    for index, (result, label, (rows, end)) in enumerate(courses):
        if len(rows):
            draw_course(axes, result, label, (rows, end), COLOURS[index % len(COLOURS)])
    objective = isinstance(loop.trace_of(traced).get("objective"), Mapping)
    axes.set(xlabel="generation" if objective else "iteration", ylabel="best objective" if objective else "best cost in m")
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(y=0.08)
    axes.legend(frameon=False, fontsize=8, loc="upper right")
    for each in below:
        loop.draw_speed(each, speeds)
    return save(sheet, Path(path))


def panels(sheet: Any, count: int) -> list[Any]:
    """A map on the left, charts one above the other on the right."""
    grid = sheet.add_gridspec(count, 2, width_ratios=(1.0, 1.15))
    return [sheet.add_subplot(grid[:, 0])] + [sheet.add_subplot(grid[row, 1]) for row in range(count)]


def course(result: Mapping[str, Any]) -> tuple[Array, float]:
    """The history of a search, rows iteration and best cost in m, and its last iteration."""
    search = result.get("search")
    found = search if isinstance(search, Mapping) else {}
    rows = points(found.get("history"))
    whole = found.get("iterations") if len(legs_of(result)) == 1 else None
    if len(rows) < 3 and not legs_of(result):  # an exact search
        return rows[:0], 0.0
    end = max(float(rows[-1, 0]), float(whole or 0)) if len(rows) else 0.0
    return (rows, end) if end > 0 else (rows[:0], 0.0)


def legs_of(result: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The legs of a result's trace."""
    trace = result.get("trace")
    return [leg for leg in listed(trace.get("legs")) if isinstance(leg, Mapping)] if isinstance(trace, Mapping) else []


def draw_course(axes: Any, result: Mapping[str, Any], label: str, history: tuple[Array, float], colour: str) -> None:
    """The best cost as steps, the optimum of the same model as a dotted line, the end of a swarm that went before."""
    rows, end = history
    axes.step([*rows[:, 0], end], [*rows[:, 1], rows[-1, 1]], where="post", color=colour, linewidth=1.8, label=label, zorder=3)
    axes.plot(rows[-1, 0], rows[-1, 1], "o", color=colour, markersize=4.5, markeredgecolor="white", zorder=4)
    reference, query = result.get("reference"), result.get("query")
    heavy = isinstance(query, Mapping) and query.get("material") == "heavy"
    optimum = reference.get("grid_optimum" if result.get("grid_path") else "any_angle_optimum") if isinstance(reference, Mapping) else None
    name, trace = "exact optimum", loop.trace_of(result)
    if "objective" in trace:
        name, optimum = "lower bound", (trace.get("bound") or {}).get("lower")
    drawn = [line.get_ydata()[0] for line in axes.lines if line.get_label() == name]
    if isinstance(optimum, float | int) and not heavy and optimum not in drawn:
        axes.axhline(optimum, color="#17212b", linestyle=(0, (1, 2)), linewidth=1.4, label=None if drawn else name, zorder=2)
    legs = legs_of(result)
    if len(legs) == 1 and legs[0].get("swarm_iterations"):
        axes.axvspan(0, legs[0]["swarm_iterations"], color=colour, alpha=0.08, linewidth=0, label=f"swarm of {label}", zorder=0)


def draw_trace(sheet: Any, axes: Any, result: Mapping[str, Any]) -> None:
    """Pheromone on a logarithmic scale, the last population as thin lines, the path that was found."""
    from matplotlib.colors import LinearSegmentedColormap, LogNorm
    from matplotlib.transforms import Affine2D

    cells = np.array([row for leg in legs_of(result) for row in points(leg.get("pheromone"), 3) if row[2] > 0])
    world = result.get("world")
    if len(cells) and isinstance(world, Mapping) and world.get("resolution"):
        left, low = cells[:, :2].min(axis=0).astype(int)
        width, height = (np.ptp(cells[:, :2], axis=0) + 1).astype(int)
        image = np.full((height, width), np.nan)
        for x, y, value in cells:
            place = int(y) - low, int(x) - left
            image[place] = np.fmax(image[place], value)
        most = float(np.nanmax(image))
        norm = LogNorm(max(float(np.nanmin(image)), most / DECADES) * (1 - 1e-9), most, clip=True)
        size = float(world["resolution"])
        x0, y0, yaw = (float(v) for v in [*listed(world.get("origin")), 0.0, 0.0, 0.0][:3])
        frame = Affine2D().rotate(yaw).translate(x0, y0) + axes.transData
        box = (left * size, (left + width) * size, low * size, (low + height) * size)
        ramp = LinearSegmentedColormap.from_list("scent", SCENT)
        drawn = axes.imshow(image, extent=box, origin="lower", cmap=ramp, norm=norm, interpolation="nearest", transform=frame, zorder=1)
        sheet.colorbar(drawn, ax=axes, shrink=0.7, pad=0.02, label="pheromone")
    for leg in legs_of(result):
        for line in map(points, listed(leg.get("paths"))):
            axes.plot(line[:, 0], line[:, 1], color="#17212b", linewidth=0.6, alpha=0.6, zorder=3)
    loop.draw_trace(axes, loop.trace_of(result))
    found = points(result.get("raw_path") or result.get("grid_path"))
    if len(found):
        axes.plot(found[:, 0], found[:, 1], color="white", linewidth=3.2, alpha=0.8, zorder=4)
        axes.plot(found[:, 0], found[:, 1], color=COLOURS[0], linewidth=1.9, zorder=5)
        for end, marker in ((found[0], "o"), (found[-1], "*")):
            axes.plot(*end, marker, color="#17212b", markersize=9 if marker == "*" else 5, markeredgecolor="white", zorder=6)
