"""OMPL's planners in the plane, with the exact tests of our worlds as their checks of states and motions.

OMPL has one seed for a whole process, which only counts before anything random was drawn. So each call runs in a process of its own: the same seed
and budget of evaluations then give the same path. An evaluation is a check of a state or of a segment.
"""

from __future__ import annotations

import importlib
import json
import math
import os
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import guideway as gw
from guideway.lab.peers import Answer

PATIENCE = 600.0
"""Longest life of a process that is asked for something, s; the lab's own limit comes first."""
SIMPLIFYING = 1.0
"""Longest time of the simplification, s."""


def plan(
    query: gw.Query,
    *,
    seed: int,
    budget: Mapping[str, Any],
    planner: str,
    simplify: bool = False,
    range: float | None = None,
) -> Answer:
    """The path that an OMPL planner has when its budget is spent (a planner without costs: its first one). With ``simplify`` OMPL shortens it.

    The robot is the disc of ``query.radius``. Raises ``NoPath``, ``BadParameter`` where no budget or one of iterations is given.
    """
    if not budget.get("evaluations") and not budget.get("seconds"):
        raise gw.BadParameter("a planner of OMPL needs a budget of evaluations or seconds")
    query.validate()
    order = {"query": _described(query), "seed": seed, "planner": planner, "simplify": simplify, "range": range, "budget": dict(budget)}
    reply = _child(order)
    if "error" in reply:
        raise gw.GuidewayError(f"OMPL {planner}: {reply['error']}")
    if reply["points"] is None:
        raise gw.NoPath(f"OMPL {planner} found no path within its budget")
    return Answer(reply["points"], evaluations=reply["evaluations"], history=reply["history"], seconds=reply["seconds"])


def _described(query: gw.Query) -> dict[str, Any]:
    world, occupied = query.world, query.world.occupancy()
    words: dict[str, Any] = {"resolution": world.resolution, "shapes": world.shapes}
    if occupied is None:
        words["bounds"] = world.bounds
    else:
        words |= {"blocked": occupied.tolist(), "origin": world.origin}
    places = [list(query.start[:2]), *[list(place[:2]) for place in query.via], list(query.goal[:2])]
    return {"world": words, "places": places, "radius": query.radius}


def _child(order: Mapping[str, Any]) -> dict[str, Any]:
    """Runs the order in a fresh process, which ends with this one: it dies when its input is closed."""
    words = [sys.executable, "-m", "guideway.lab.peers.ompl"]
    roots = [str(Path(gw.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(part for part in roots if part)}
    pipe = subprocess.PIPE
    with subprocess.Popen(words, env=environment, text=True, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        watch = threading.Timer(PATIENCE, process.kill)
        watch.start()
        try:
            process.stdin.write(json.dumps(order) + "\n")
            process.stdin.flush()  # stays open: the child ends once it is closed
            line = process.stdout.readline()
        finally:
            watch.cancel()
            process.kill()
    if not line:
        raise gw.GuidewayError(f"OMPL {order['planner']}: its process ended without an answer")
    return json.loads(line)


class _Search:
    """One search in this process: what counts, and what was found so far."""

    def __init__(self, order: Mapping[str, Any]) -> None:
        base, geometric, util = (importlib.import_module(f"ompl.{part}") for part in ("base", "geometric", "util"))
        self.base: Any = base
        self.order = order
        util.setLogLevel(util.LOG_NONE)
        util.RNG.setSeed(int(order["seed"]) + 1)  # 0 means the clock
        asked = order["query"]
        world = gw.World(**asked["world"])
        self.free, self.radius, self.places = world.segment_free, asked["radius"], asked["places"]
        self.checks, self.begun = 0, time.perf_counter()
        self.history: list[list[float]] = []
        self.space = base.RealVectorStateSpace(2)
        self._bound(world)
        self.setup = geometric.SimpleSetup(self.space)
        information = self.setup.getSpaceInformation()
        self.setup.setStateValidityChecker(self.valid)
        self.checker = _motion_checker(self, information)
        information.setMotionValidator(self.checker)
        self.setup.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
        self.planner = getattr(geometric, order["planner"])(information)
        if order["range"] is not None:
            self.planner.setRange(float(order["range"]))
        self.setup.setPlanner(self.planner)

    def _bound(self, world: gw.World) -> None:
        low_high = world.bounds
        bounds = self.base.RealVectorBounds(2)
        for axis in (0, 1):
            bounds.setLow(axis, low_high[axis])
            bounds.setHigh(axis, low_high[axis + 2])
        self.space.setBounds(bounds)

    def valid(self, state: Any) -> bool:
        """Is the robot free there?"""
        self.checks += 1
        place = (state[0], state[1])
        return self.free(place, place, self.radius)

    def done(self) -> bool:
        """Is the budget spent? Asked after every step of a search; also where improvements are seen."""
        best = self.planner.bestCost().value() if hasattr(self.planner, "bestCost") else math.inf
        if math.isfinite(best) and best > 0 and (not self.history or best < self.history[-1][1]):
            self.history.append([self.checks, best])
        budget = self.order["budget"]
        return self.checks >= budget.get("evaluations", math.inf) or time.perf_counter() - self.begun >= budget.get("seconds", math.inf)

    def solve(self) -> dict[str, Any]:
        """The answer, as it goes through the pipe."""
        start, goal = self.space.allocState(), self.space.allocState()
        start[0], start[1], goal[0], goal[1] = *self.places[0], *self.places[-1]
        self.setup.setStartAndGoalStates(start, goal)
        self.setup.setup()
        self.begun = time.perf_counter()
        self.planner.solve(self.base.PlannerTerminationCondition(self.done))
        problem = self.setup.getProblemDefinition()
        points = None
        if problem.hasExactSolution():
            if self.order["simplify"]:
                self.setup.simplifySolution(SIMPLIFYING)
            points = [[state[0], state[1]] for state in self.setup.getSolutionPath().getStates()]
            length = sum(math.dist(a, b) for a, b in pairwise(points))
            if not self.history or length < self.history[-1][1] - 1e-12:
                self.history.append([self.checks, length])
        seconds = time.perf_counter() - self.begun
        return {"points": points, "evaluations": self.checks, "history": self.history, "seconds": seconds}


def _motion_checker(search: _Search, information: Any) -> Any:
    class Checker(search.base.MotionValidator):
        """Is the segment free? Exact, so no resolution is needed."""

        def checkMotion(self, first: Any, second: Any) -> bool:  # OMPL's name
            search.checks += 1
            return search.free((first[0], first[1]), (second[0], second[1]), search.radius)

    return Checker(information)


def _serve() -> None:
    """The child: one order from the standard input, one answer to the standard output."""
    order = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        if len(order["query"]["places"]) != 2:
            raise ValueError("via points are not possible here")
        reply = _Search(order).solve()
    except (ValueError, RuntimeError, ImportError) as error:
        reply = {"error": str(error)}
    sys.stdout.write(json.dumps(reply) + "\n")
    sys.stdout.flush()
    os._exit(0)  # OMPL's bindings complain at a regular exit


def _end_with_parent() -> None:
    sys.stdin.read()
    os._exit(1)


if __name__ == "__main__":
    _serve()
