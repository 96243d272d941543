"""Motion planning for industrial robots: a map in, a motion out.

>>> import guideway as gw
>>> world = gw.World([[0, 0, 0], [0, 1, 0], [0, 0, 0]])
>>> query = gw.Query(world, start=(0.5, 0.5), goal=(2.5, 2.5))
>>> round(gw.plan(query, planner="visibility").cost, 4)
3.1623

Units are SI, angles radians, frames as REP-103 (x forward or east, y left or north). Arrays of cells have row 0 on top, as images do.
"""

from __future__ import annotations

from guideway._core import Path, Query, Solution, World, plan, planners
from guideway.errors import GuidewayError
from guideway.records import Box, Budget, Disc, Limits, Polygon, progress

__version__ = "0.1.0"

__all__ = [
    "Box",
    "Budget",
    "Disc",
    "GuidewayError",
    "Limits",
    "Path",
    "Polygon",
    "Query",
    "Solution",
    "World",
    "plan",
    "planners",
    "progress",
]
