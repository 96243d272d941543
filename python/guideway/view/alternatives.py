"""A figure of the alternatives of a plan, for papers."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .figure import draw_world, extent, save
from .geometry import listed, points
from .scenery import Scenery


def alternatives_figure(result: Mapping[str, Any], world: Scenery | None, path: str | os.PathLike[str]) -> list[Path]:
    """Writes the alternatives of a plan as ``path`` with the endings ``.png`` (300 dpi) and ``.svg``: on the map, and as length against turns,
    both coloured by their clearance.

    ``result`` is a dictionary as in ``plan.json`` with ``alternatives``. Raises ``ValueError`` where it has none, ``ImportError`` without matplotlib.
    """
    try:
        from matplotlib import colormaps
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.colors import Normalize
        from matplotlib.figure import Figure
    except ImportError as error:
        raise ImportError("figures for papers need matplotlib: pip install 'guideway[figures]'") from error
    rows = [row for row in listed(result.get("alternatives")) if isinstance(row, Mapping)]
    if not rows:
        raise ValueError("this plan has no alternatives: plan with --pareto")
    clear = [row.get("min_clearance") for row in rows]
    finite = [value for value in clear if value is not None]
    most = max(finite, default=0.0)
    tone = np.array([most if value is None else value for value in clear])
    norm, colours = Normalize(min(tone.min(), most), max(tone.max(), tone.min() + 1e-9)), colormaps["viridis_r"]
    sheet = Figure(figsize=(7.2, 3.4), layout="constrained")
    FigureCanvasAgg(sheet)
    left, right = sheet.subplots(1, 2)
    if world is not None:
        draw_world(left, world)
    for row, value in zip(rows, tone, strict=True):
        line = points(row.get("grid_path"))
        if len(line):
            left.plot(line[:, 0], line[:, 1], color=colours(norm(value)), linewidth=1.2)
    low_x, low_y, high_x, high_y = extent([result], world)
    left.set(xlim=(low_x, high_x), ylim=(low_y, high_y), aspect="equal", xlabel="x in m", ylabel="y in m")
    dots = right.scatter(
        [row["length"] for row in rows], [row["turns"] for row in rows], c=tone, cmap=colours, norm=norm, edgecolors="white", zorder=3
    )
    right.set(xlabel="length in m", ylabel="turns")
    right.yaxis.get_major_locator().set_params(integer=True)
    right.grid(alpha=0.25)
    if finite:
        sheet.colorbar(dots, ax=right, label="clearance in m")
    return save(sheet, Path(path))
