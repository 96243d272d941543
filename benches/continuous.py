"""Shortest paths among discs: our planners at 10 ms beside the planners of OMPL at 1 s, every path under the same exact checker.

Run with a release build of guideway and `pip install -r benches/requirements.txt`:

    python benches/continuous.py [--scenes 3] [--seeds 5] [--seconds 1] [--planner NAME ...]

Rooms of 10 m x 6 m with 8 random discs, 0.3 m clearance. OMPL runs through its Python module: its validity checker is a Python function, which
takes most of its time, and motions are checked at points 5 cm apart, so its paths may cut into the clearance; those that our certificate refuses
are counted and left out. Seconds are CPU seconds of one thread; ours hold the making of world and query.
"""

from __future__ import annotations

import argparse
import itertools
import math
import statistics
import time

import numpy as np
from ompl import base, geometric, util

import guideway as gw

START, GOAL, CLEARANCE, BOUNDS = (0.4, 0.4), (9.5, 5.5), 0.3, (0.0, 0.0, 10.0, 6.0)
APART = 0.05
"""Points at which OMPL checks a motion, m."""
WITHIN = 0.01
"""Seconds of ours."""
PEERS = ("RRTstar", "InformedRRTstar", "BITstar", "AORRTC", "RRTConnect")
OURS = {
    "visibility": ({}, False),
    "informed-rrt-star": ({"samples": 10**9}, True),
    "rrt-star": ({"samples": 10**9}, True),
    "rrt-connect": ({}, True),
}
"""Planner: its settings, and does it get its time as a budget? The exact one ends by itself."""

Disc = tuple[float, float, float]


def room(seed: int) -> list[Disc]:
    """Eight discs of 0.5 to 1.2 m, three of them on the straight line at least, start and goal free."""
    rng = np.random.default_rng(seed)
    a, b = np.array(START), np.array(GOAL)
    along = (b - a) / np.linalg.norm(b - a)
    while True:
        discs: list[Disc] = []
        while len(discs) < 8:
            x, y, r = rng.uniform(0.8, 9.2), rng.uniform(0.6, 5.4), rng.uniform(0.25, 0.6)
            ends = min(math.dist((x, y), START), math.dist((x, y), GOAL)) < r + CLEARANCE + 0.1
            if not ends and all(math.hypot(x - u, y - v) >= r + q + 0.2 for u, v, q in discs):
                discs.append((x, y, r))
        across = [abs(along[0] * (y - a[1]) - along[1] * (x - a[0])) - r for x, y, r in discs]
        if sum(gap < CLEARANCE for gap in across) >= 3:
            return discs


def asked(discs: list[Disc]) -> gw.Query:
    shapes = [{"disc": {"center": [x, y], "radius": r}} for x, y, r in discs]
    return gw.Query(gw.World(bounds=BOUNDS, shapes=shapes, resolution=0.05), START, GOAL, clearance=CLEARANCE)


def accepted(points: list[list[float]], query: gw.Query) -> bool:
    return bool(gw.certify(gw.Path.polyline(points), query)["ok"])


def peer(name: str, discs: list[Disc], seconds: float) -> list[list[float]] | None:
    """The path that a planner of OMPL has after that many CPU seconds."""
    grown = [(x, y, (r + CLEARANCE) ** 2) for x, y, r in discs]

    def valid(state) -> bool:
        px, py = state[0], state[1]
        return all((px - x) * (px - x) + (py - y) * (py - y) >= square for x, y, square in grown)

    space, bounds = base.RealVectorStateSpace(2), base.RealVectorBounds(2)
    for axis in (0, 1):
        bounds.setLow(axis, BOUNDS[axis])
        bounds.setHigh(axis, BOUNDS[axis + 2])
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(valid)
    information = setup.getSpaceInformation()
    information.setStateValidityCheckingResolution(APART / space.getMaximumExtent())
    start, goal = space.allocState(), space.allocState()
    start[0], start[1], goal[0], goal[1] = *START, *GOAL
    setup.setStartAndGoalStates(start, goal)
    setup.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    setup.setPlanner(getattr(geometric, name)(information))
    setup.setup()
    begun = time.process_time()
    condition = base.PlannerTerminationCondition(lambda: time.process_time() - begun > seconds)
    setup.getPlanner().solve(condition)
    problem = setup.getProblemDefinition()
    if not problem.hasExactSolution():
        return None
    if name == "RRTConnect":
        setup.simplifySolution(max(0.01, seconds - (time.process_time() - begun)))
        return [[state[0], state[1]] for state in setup.getSolutionPath().getStates()]
    return [[state[0], state[1]] for state in problem.getSolutionPath().getStates()]


def ours(name: str, discs: list[Disc], seed: int) -> tuple[float, bool, float]:
    """Length, accepted, CPU seconds."""
    settings, budget = OURS[name]
    begun = time.process_time()
    query = asked(discs)
    left = WITHIN - (time.process_time() - begun) if budget else None
    try:
        solution = gw.plan(query, planner=name, seed=seed, set=settings, budget=gw.Budget(seconds=left))
    except gw.NoPath:
        return math.inf, False, time.process_time() - begun
    taken = time.process_time() - begun
    return solution.length, accepted(solution.path.control_points.tolist(), query), taken


def shown(values: list[float]) -> str:
    return f"{statistics.median(values):.4f}" if values else "-"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=3, help="rooms (%(default)s)")
    parser.add_argument("--seeds", type=int, default=5, help="seeds (%(default)s)")
    parser.add_argument("--seconds", type=float, default=1.0, help="CPU seconds of a planner of OMPL (%(default)s)")
    parser.add_argument("--planner", nargs="*", default=list(OURS), help="planners of ours (default: all of the table)")
    arguments = parser.parse_args()
    for name in arguments.planner:
        OURS.setdefault(name, ({}, True))
    util.setLogLevel(util.LOG_ERROR)
    util.RNG.setSeed(1)  # only the first call of a process has an effect
    cases = [(scene, seed) for scene in range(arguments.scenes) for seed in range(arguments.seeds)]
    rooms = {scene: room(40 + scene) for scene in range(arguments.scenes)}
    exact = {scene: gw.plan(asked(discs)).cost for scene, discs in rooms.items()}
    best = dict.fromkeys(cases, math.inf)
    print("| planner | seconds | solved | accepted | median length m | median gap to the exact optimum % | no longer than the best of OMPL |")
    print("|---|---|---|---|---|---|---|")
    for name in PEERS:
        found = {}
        for case in cases:
            points = peer(name, rooms[case[0]], arguments.seconds)
            if points is not None:
                length = sum(math.dist(p, q) for p, q in itertools.pairwise(points))
                found[case] = (length, accepted(points, asked(rooms[case[0]])))
        good = {case: length for case, (length, ok) in found.items() if ok}
        for case, length in good.items():
            best[case] = min(best[case], length)
        gaps = [100 * (length / exact[case[0]] - 1) for case, length in good.items()]
        solved, count = f"{len(found)} of {len(cases)}", f"{len(good)} of {len(found)}"
        print(f"| OMPL {name} | {arguments.seconds:g} | {solved} | {count} | {shown(list(good.values()))} | {shown(gaps)} | |", flush=True)
    for name in arguments.planner:
        rows = {case: ours(name, rooms[case[0]], case[1]) for case in cases}
        good = {case: row[0] for case, row in rows.items() if row[1]}
        wins = sum(length <= best[case] and rows[case][2] <= 1.5 * WITHIN for case, length in good.items())
        gaps = [100 * (length / exact[case[0]] - 1) for case, length in good.items()]
        solved, taken = sum(math.isfinite(row[0]) for row in rows.values()), statistics.median(row[2] for row in rows.values())
        words = f"{len(good)} of {solved} | {shown(list(good.values()))} | {shown(gaps)} | {wins} of {len(cases)}"
        print(f"| `{name}` | {taken:.4f} | {solved} of {len(cases)} | {words} |", flush=True)


if __name__ == "__main__":
    main()
