"""Which parameters for which map and robot: what searches recommended and maps that they had not seen confirmed (docs/guidance.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from guideway._core import Query, planners
from guideway.errors import BadParameter


@dataclass(frozen=True)
class Advice:
    """Parameters of a planner, and where they were found to be better than its defaults."""

    planner: str
    where: str
    least_share: float
    """Share of blocked cells from which on they are recommended."""
    least_side: int
    """Cells of the longer side from which on they are."""
    set: Mapping[str, Any]
    evidence: str
    """The experiment that shows it."""


ADVICE = (
    Advice(
        "pso-aco",
        "grids with 20 % or more of their cells blocked, and mazes",
        0.2,
        0,
        {"particles": 50, "swarm_iterations": 5, "ants": 40, "beta": 9.0, "evaporation": 0.2},
        "guide-pso-aco",
    ),
    Advice(
        "improved-aco",
        "grids of every kind that was looked at",
        0.0,
        1,
        {"ants": 40, "beta": 16.0, "evaporation": 0.05, "o3": False, "polish": 2, "horizon": 15.0},
        "guide-improved-aco",
    ),
)
"""What is recommended beside the defaults. Planners that are not here keep theirs: for them a search found nothing that held on other maps."""


def recommended(planner: str, query: Query) -> dict[str, Any]:
    """Parameters for a planner on the map of a query, for ``set``; empty where the defaults are the best that is known.

    >>> import guideway as gw
    >>> gw.lab.recommended("mmas", gw.scenes.load("m20").query())
    {}
    """
    known = [entry["name"] for entry in planners()]
    if planner not in known:
        raise BadParameter(f"planner {planner!r} is not known: one of {', '.join(known)}")
    cells = query.world.occupancy()
    share = 0.0 if cells is None else float((np.asarray(cells) > 0).mean())
    side = 0 if cells is None else max(query.world.width, query.world.height)
    fits = (advice for advice in ADVICE if advice.planner == planner and share >= advice.least_share and side >= advice.least_side)
    best = next(fits, None)
    return {} if best is None else dict(best.set)
