"""``guideway plan MAP --scen FILE``: every row of a Moving AI scenario, one JSON object per row."""

from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

from guideway import _core
from guideway.commands import options, plan
from guideway.errors import BadParameter, PlanningError
from guideway.records import Budget
from guideway.worlds import world_of


def run_scenario(arguments: argparse.Namespace) -> int:
    """Plans every row; rows with errors are reported in their row, not raised."""
    from guideway.io import load_scenario

    rows = load_scenario(arguments.scen)
    world = world_of(plan.read(arguments))
    rows = rows if arguments.limit is None else rows[: arguments.limit]
    done: list[str] = []
    options.writable(arguments.out, inputs=(arguments.map, arguments.scen))
    try:
        for number, row in enumerate(rows):
            line = json.dumps(_row(arguments, world, number, row), allow_nan=False)
            done.append(line)
            sys.stdout.write(line + "\n")
    finally:
        if arguments.out:
            options.write(arguments.out, "".join(line + "\n" for line in done))
    return 0


def _row(arguments: argparse.Namespace, world: _core.World, number: int, row: Any) -> dict[str, Any]:
    record = {
        "row": number,
        "start_cell": list(row.start),
        "goal_cell": list(row.goal),
        "published": row.length,
        "length": None,
        "seconds": 0.0,
        "error": None,
    }
    begun = time.perf_counter()
    try:
        for cell in (row.start, row.goal):
            if not (0 <= cell[0] < world.width and 0 <= cell[1] < world.height):
                record["error"] = "OutsideMap"
                return record
        start, goal = world.cell_centers([row.start, row.goal]).tolist()
        query = _core.Query(
            world,
            start,
            goal,
            footprint=options.footprint(arguments.footprint) if arguments.footprint else None,
            clearance=arguments.clearance or 0.0,
            half_width=arguments.half_width or 0.0,
            corners=arguments.corners or "clear",
            material=arguments.material or "standard",
        )
        budget = Budget(arguments.iterations, arguments.evaluations, arguments.seconds)
        settings = dict(options.setting(text) for text in arguments.set) or None
        begun = time.perf_counter()
        solution = _core.plan(
            query, arguments.planner or "visibility", seed=arguments.seed or 0, budget=budget, set=settings, threads=arguments.threads
        )
        record["length"], record["seconds"] = solution.length, solution.seconds
    except BadParameter:
        raise
    except PlanningError as error:
        record["error"], record["seconds"] = type(error).__name__, time.perf_counter() - begun
    return record
