"""Motion planning for industrial robots: a map in, a motion out.

>>> import guideway as gw
>>> world = gw.World([[0, 0, 0], [0, 1, 0], [0, 0, 0]])
>>> query = gw.Query(world, start=(0.5, 0.5), goal=(2.5, 2.5))
>>> round(gw.plan(query, planner="visibility").cost, 4)
3.1623

Units are SI, angles radians, frames as REP-103 (x forward or east, y left or north). Arrays of cells have row 0 on top, as images do.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from guideway import errors
from guideway._core import (
    JointMotion,
    Minimum,
    Path,
    Pilot,
    PointToPoint,
    PointToPointMotion,
    Profile,
    Query,
    Refined,
    Solution,
    SpeedMap,
    Trajectory,
    World,
    __version__,
    advice,
    ceiling,
    certify,
    controllers,
    correct,
    distance_transform,
    lattice_optimum,
    measure,
    minimize,
    optimizers,
    parameters,
    pareto,
    plan,
    planners,
    point_to_point,
    polyline,
    recommended,
    reference,
    refine,
    scurve,
    time,
    time_joints,
    tour,
)
from guideway.errors import (
    BadFile,
    BadParameter,
    Cancelled,
    CertificateFailed,
    GoalBlocked,
    GuidewayError,
    Infeasible,
    NoPath,
    NoResult,
    OutsideMap,
    PlanningError,
    StartBlocked,
)
from guideway.records import Box, Budget, Disc, Limits, Polygon, progress

if TYPE_CHECKING:
    from guideway import arm, io, lab, plants, scenes, schemas, view
    from guideway.driving import drive

__all__ = [
    "BadFile",
    "BadParameter",
    "Box",
    "Budget",
    "Cancelled",
    "CertificateFailed",
    "Disc",
    "GoalBlocked",
    "GuidewayError",
    "Infeasible",
    "JointMotion",
    "Limits",
    "Minimum",
    "NoPath",
    "NoResult",
    "OutsideMap",
    "Path",
    "Pilot",
    "PlanningError",
    "PointToPoint",
    "PointToPointMotion",
    "Polygon",
    "Profile",
    "Query",
    "Refined",
    "Solution",
    "SpeedMap",
    "StartBlocked",
    "Trajectory",
    "World",
    "__version__",
    "advice",
    "arm",
    "ceiling",
    "certify",
    "controllers",
    "correct",
    "distance_transform",
    "drive",
    "errors",
    "io",
    "lab",
    "lattice_optimum",
    "measure",
    "minimize",
    "optimizers",
    "parameters",
    "pareto",
    "plan",
    "planners",
    "plants",
    "point_to_point",
    "polyline",
    "progress",
    "recommended",
    "reference",
    "refine",
    "scenes",
    "schemas",
    "scurve",
    "time",
    "time_joints",
    "tour",
    "view",
]


def __getattr__(name: str) -> Any:
    """Loads the heavier parts when they are first used: a quick start matters on the command line."""
    if name in ("arm", "io", "lab", "plants", "scenes", "schemas", "view"):
        return importlib.import_module(f"guideway.{name}")
    if name == "drive":
        from guideway.driving import drive

        return drive
    raise AttributeError(f"module 'guideway' has no attribute {name!r}")
