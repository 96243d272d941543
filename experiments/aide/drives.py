"""A-I-DE beside ACO, fireflies, DE and IASCV: planned, timed, and driven by the same tracker on the same plant, in two rooms under three conditions.

python experiments/aide/drives.py [--seeds 10] [--search-seeds 30] [--layouts 100] [--evaluations 20000] [--docs]
"""

from __future__ import annotations

import argparse
import contextlib
import json
import multiprocessing
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "colonies"))
import claims
import measures
import tables

import guideway as gw

Row = dict[str, Any]
PAPER = {"preset": "paper"}
NEVER = 10**9
METHODS: dict[str, tuple[str, dict[str, Any], str]] = {
    "ACO": (
        "aco",
        {**PAPER, "ants": 40, "alpha": 1.0, "beta": 2.0, "evaporation": 0.5, "deposit": 1.0, "initial": 1.0, "iterations": NEVER},
        "trapezoid",
    ),
    "FA": ("firefly", PAPER, "trapezoid"),
    "DE": ("de", PAPER, "trapezoid"),
    "IASCV": ("iascv", {}, "own"),
    "A-I-DE": ("aide", {}, "own"),
}
"""Planner, its settings, and how its path is timed: by the trapezoidal baseline, or by itself."""
ROOMS, CONDITIONS = ("w0", "w1"), gw.scenes.CONDITIONS
BLIND = ("ACO", "FA", "DE")
"""Methods that do not look at what moves: their plan is that of the static room."""
LONG = 160_000
"""Evaluations of the long searches: 40 individuals for 4000 generations."""
LIMIT = 60.0
"""Longest drive, s."""


def asked(room: str, seed: int, condition: str, method: str) -> gw.Query:
    """The query that a method plans; the colony walks on cells of 0.1 m."""
    scene = gw.scenes.load(room, seed)
    query = scene.query(condition)
    if method != "ACO":
        return query
    world = gw.World(bounds=query.world.bounds, shapes=query.world.shapes, movers=query.world.movers, resolution=0.1)
    return gw.Query(world, query.start, query.goal, clearance=query.clearance, limits=scene.limits)


def planned(query: gw.Query, method: str, seed: int, evaluations: int) -> tuple[gw.Solution, gw.Trajectory, float]:
    """What the planner found, its motion, and CPU seconds of both."""
    planner, settings, timing = METHODS[method]
    limits = gw.Limits(**query.limits)
    begun = time.process_time()
    found = gw.plan(query, planner, seed=seed, set=settings, budget=gw.Budget(evaluations=evaluations))
    path = gw.refine(found.path, query, "simplify").path if method == "ACO" else found.path
    motion = found.trajectory if timing == "own" and found.trajectory is not None else None
    if motion is None:
        motion = gw.time(path, limits, method="iascv" if timing == "own" else timing)
    return found, motion, time.process_time() - begun


def driven(task: tuple[str, str, int, int]) -> Row:
    """The plans and drives of a method with one seed, a row for each condition."""
    room, method, seed, evaluations = task
    plans: dict[str, Any] = {}
    rows = []
    for condition in CONDITIONS:
        plain = "static" if method in BLIND and condition == "dynamic" else condition
        row: Row = {"room": room, "condition": condition, "method": method, "seed": seed, "error": None}
        try:
            if plain not in plans:
                plans[plain] = planned(asked(room, seed, plain, method), method, seed, evaluations)
        except gw.GuidewayError as error:
            rows.append(row | {"error": type(error).__name__, "success": False, "touched": False})
            continue
        rows.append(row | measured(asked(room, seed, condition, method), plans[plain], seed))
    return {"rows": rows}


def measured(query: gw.Query, plan: tuple[gw.Solution, gw.Trajectory, float], seed: int) -> Row:
    """A drive of a plan, and all that is measured of both."""
    found, motion, seconds = plan
    limits = gw.Limits(**query.limits)
    record = gw.drive(query, motion, "tracker", seed=seed, time_limit=LIMIT)
    mean, rms = measures.leaning(record["driven"])
    nearest, arrived = record["min_separation"], record["outcome"] == "arrived"
    row = {
        "f": found.cost,
        "evaluations": found.evaluations,
        "ok": bool(gw.certify(motion.path, query)["ok"]),
        "length": motion.path.length,
        "duration": motion.duration,
        "plan_ms": 1e3 * seconds,
        "outcome": record["outcome"],
        "time": record["time"],
        "nearest": nearest,
        "success": arrived and (nearest is None or nearest >= measures.SAFE),
        "near_success": arrived and (nearest is None or nearest >= measures.SAFE - 0.05),
        "touched": record["collision"] is not None,
        "unavoidable": bool(record["collision"] and record["collision"]["unavoidable"]),
        "stops": record["emergency_stops"],
        "replans": record["replans"],
        "lean_mean": mean,
        "lean_rms": rms,
        "broken": measures.over_ceiling(motion, limits),
        "scores": measures.confidence(motion, query.world),
    }
    row |= {key: record["tracking"][key] for key in ("tpe", "tte", "path_error", "ts")}
    return row | measures.jerks(motion) | measures.energies(record, seconds)


def searched(task: tuple[str, str, int, int]) -> Row:
    """One search in the static room: f and the homotopy class of its path."""
    room, planner, seed, evaluations = task
    scene = gw.scenes.load(room)
    row: Row = {"room": room, "planner": planner, "seed": seed, "budget": evaluations, "error": None}
    try:
        found = gw.plan(scene.query("static"), planner, seed=seed, set=PAPER, budget=gw.Budget(evaluations=evaluations))
    except gw.GuidewayError as error:
        return row | {"error": type(error).__name__}
    points = found.path.planar(np.linspace(0.0, found.path.length, 400))[:, :2]
    history = found.history
    last = int(next(i for i, cost in history if cost <= history[-1][1] * (1 + 1e-6))) if len(history) else 0
    return row | {"f": found.cost, "class": measures.signature(points, scene.discs), "last": last, "evaluations": found.evaluations}


def looped(task: tuple[str, int]) -> Row:
    """One run of A-I-DE with its closed loop, by room or random layout; and the correction alone, of the first pass over an early path of DE."""
    room, seed = task
    scene = gw.scenes.layout(seed) if room == "layout" else gw.scenes.load(room)
    query = scene.query("static")
    row: Row = {"room": room, "seed": seed, "error": None}
    try:
        found = gw.plan(query, "aide", seed=seed)
    except gw.GuidewayError as error:
        return row | {"error": type(error).__name__}
    motion = found.trajectory
    assert motion is not None
    stages = found.trace.get("loop") or []
    found_regions = sum(len(stage.get("found", [])) for stage in stages)
    left = len(found.trace["speed"]["regions_after"])
    fastest = gw.time(motion.path, scene.limits).duration
    early = _early(query, seed)
    corrected = None if early is None else gw.correct(early.path, scene.limits)
    return row | {
        "early": None if corrected is None else len(corrected["regions_before"]),
        "early_left": None if corrected is None else len(corrected["regions_after"]),
        "f": found.cost,
        "found": found_regions,
        "left": left,
        "broken": measures.over_ceiling(motion, scene.limits),
        "ok": bool(gw.certify(motion.path, query, motion)["ok"]),
        "slower": motion.duration / fastest,
    }


def _early(query: gw.Query, seed: int) -> gw.Solution | None:
    """What plain DE has after 2000 evaluations: a rough path, whose first pass is too fast in its bends."""
    try:
        return gw.plan(query, "de", seed=seed, set=PAPER, budget=gw.Budget(evaluations=2000))
    except gw.NoPath:
        return None


def memory(task: tuple[str, str, int]) -> Row:
    """Peak growth of resident memory during one planning call, in a process of its own, MB; None where the system does not tell."""
    room, method, evaluations = task
    query = asked(room, 0, "static", method)
    with contextlib.suppress(gw.NoPath):  # also a search in vain takes memory
        planned(query, method, 1, 200)  # what is loaded once
    try:
        Path("/proc/self/clear_refs").write_text("5")
        before = _status("VmRSS")
        with contextlib.suppress(gw.NoPath):
            planned(query, method, 0, evaluations)
        return {"room": room, "method": method, "mb": max(0.0, _status("VmHWM") - before)}
    except OSError:
        return {"room": room, "method": method, "mb": None}


def _status(name: str) -> float:
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(name))
    return int(line.split()[1]) / 1024


def collect(name: str, run: Callable[[Any], Row], tasks: list[tuple], out: Path, workers: int) -> list[Row]:
    """Runs the tasks that have no record in ``out/NAME.jsonl`` yet; the records of all, in order."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"{name}.jsonl"
    have: dict[tuple, Row] = {}
    for line in path.read_text().splitlines() if path.exists() else []:
        try:
            record = json.loads(line)
        except ValueError:
            continue
        have[tuple(record["task"])] = record
    todo = [task for task in tasks if task not in have]
    with multiprocessing.Pool(workers, maxtasksperchild=1 if run is memory else None) as pool, path.open("a") as file:
        for task, row in zip(todo, tqdm(pool.imap(run, todo), total=len(todo), desc=name, unit="run", disable=None), strict=True):
            have[task] = row | {"task": list(task)}
            file.write(json.dumps(have[task]) + "\n")
            file.flush()
    return [have[task] for task in tasks]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10, help="seeds of the drives (%(default)s)")
    parser.add_argument("--search-seeds", type=int, default=30, help="seeds of the searches and of the closed loop (%(default)s)")
    parser.add_argument("--layouts", type=int, default=100, help="random layouts of the closed loop (%(default)s)")
    parser.add_argument("--evaluations", type=int, default=20_000, help="evaluations of every search (%(default)s)")
    parser.add_argument("--out", type=Path, default=Path("experiments/results/aide"), help="folder of records and tables (%(default)s)")
    parser.add_argument("--workers", type=int, default=multiprocessing.cpu_count(), help="processes (%(default)s)")
    parser.add_argument("--docs", action="store_true", help="put the tables into docs/experiments.md")
    given = parser.parse_args()
    n, out, workers = given.evaluations, given.out, given.workers
    methods = {name: way for name, way in METHODS.items() if way[0] in {entry["name"] for entry in gw.planners()}}
    drives = [(room, method, seed, n) for method in [*methods][::-1] for room in ROOMS for seed in range(given.seeds)]  # the slow ants last
    rows = [row for task in collect("drives", driven, drives, out, workers) for row in task["rows"]]
    budgets = sorted({n, LONG})
    searches = [("w0", planner, seed, count) for count in budgets for planner in ("de", "improved-de") for seed in range(given.search_seeds)]
    found = collect("searches", searched, searches, out, workers)
    loops = [(room, seed) for room in ROOMS for seed in range(given.search_seeds)] + [("layout", seed) for seed in range(given.layouts)]
    closed = collect("loops", looped, loops, out, workers) if "A-I-DE" in methods else []
    heap = collect("memory", memory, [("w0", method, n) for method in methods], out, 1)
    words = f"--seeds {given.seeds} --search-seeds {given.search_seeds} --layouts {given.layouts} --evaluations {n} --docs"
    factor = claims.calibrated([row for row in rows if row["method"] == "DE" and row["room"] == "w0" and row["condition"] == "static"])
    text = "\n".join(
        [
            claims.drives(rows, factor, methods),
            claims.work(rows, heap, methods),
            claims.roc(rows, methods),
            claims.verdicts(rows, found, closed, methods),
        ]
    )
    tables.publish("aide", f"python experiments/aide/drives.py {words}", text, out, given.docs)


if __name__ == "__main__":
    main()
