"""Runs of planners: a path, checked by the certificate, with its measures, its gap to the exact optimum and its convergence."""

from __future__ import annotations

import json
import math
import statistics
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from guideway import _core
from guideway.errors import BadParameter
from guideway.io.files import show
from guideway.lab import driven, measuring, planning, worlds
from guideway.lab.experiment import Experiment, Metric, Run
from guideway.lab.kinds import NotAResult, Outcome
from guideway.products import REFINEMENTS
from guideway.records import Budget, Limits

FIELDS = ("planner", "set", "refine", "max_curvature", "exact_fallback", "timing", "repeats", "heap", "query")
"""Fields of a method beside its name and budget.

``query`` is what this method asks beside, or instead of, the query of the run; ``refine`` is one of :data:`guideway.products.REFINEMENTS`, its result
is measured as ``refined_...``; ``timing`` is a method of :func:`guideway.time`, or ``own`` for the motion of a planner that plans it; ``repeats``
calls are timed after three others and their median counts; for the first ``heap`` seeds (from 0) a planning call is repeated in a process of its own
to measure how far it makes the memory grow.
"""
WORLD_FIELDS, QUERY_FIELDS = worlds.WORLD_FIELDS, worlds.QUERY_FIELDS
TIMINGS = ("own", "time-optimal", "iascv", "trapezoid")
WARM_UP = 3
"""Calls before those that are timed."""

SHAPE = (
    Metric("length", "m", "lower", 4),
    Metric("turns", "", "lower", 2),
    Metric("turning", "rad", "lower", 2),
    Metric("smoothness", "", "higher", 3),
    Metric("curvature", "1/m", "lower", 3),
    Metric("clearance", "m", "higher", 3),
    Metric("energy", "cells", "lower", 4),
)
"""Measures of a path; also ``refined_...`` where a refinement is asked for, and ``product_...``: of the refined path if there is one."""

SHAPED = tuple(metric.name for metric in SHAPE)

METRICS = {
    metric.name: metric
    for metric in (
        *SHAPE,
        Metric("diagonals", "", None, 0),
        Metric("straights", "", None, 0),
        Metric("optimum", "m", None, 4),
        Metric("gap", "%", "lower", 2),
        Metric("any_angle_gap", "%", "lower", 2),
        Metric("accuracy", "%", "higher", 2),
        Metric("hit", "", "higher", 3),
        Metric("more_turns", "", "lower", 2),
        Metric("fewest", "", "higher", 3),
        Metric("evaluations", "", "lower", 0),
        Metric("iterations", "", "lower", 1),
        Metric("last", "", "lower", 1),
        Metric("last_evaluation", "", "lower", 0),
        Metric("near", "", "lower", 0),
        Metric("fallback", "", "lower", 3),
        *(replace(metric, name=f"refined_{metric.name}") for metric in SHAPE),
        Metric("refined_any_angle_gap", "%", "lower", 2),
        *(replace(metric, name=f"product_{metric.name}") for metric in SHAPE),
        Metric("plan", "s", "lower", 4),
        Metric("plan_cpu", "s", "lower", 4),
        Metric("cpu_share", "%", None, 0),
        Metric("heap_mib", "MiB", "lower", 2),
        Metric("over_limit", "", "lower", 0),
        Metric("auc", "", "higher", 3),
        Metric("free", "", None, 0),
        Metric("hindered", "", None, 0),
        Metric("duration", "s", "lower", 3),
        Metric("motion_energy", "J", "lower", 1),
        Metric("objective", "", "lower", 5),
        Metric("objective_gap", "%", "lower", 2),
        Metric("class", "", None, 0),
        Metric("regions", "", None, 1),
        Metric("regions_left", "", "lower", 1),
        Metric("stages", "", None, 1),
    )
}
"""What a run of a planner measures; see :mod:`guideway.lab.measuring`."""


def run(run: Run) -> Outcome:
    """Plans and measures. Raises what the planner raises: a refusal is not a result."""
    method, budget = run.method, Budget(**dict(run.budget))
    asked = {**run.query, **method.get("query", {})}
    query = worlds.query(run.world, asked, run.folder, run.seed)
    call = planning.planner(method, run.folder)
    found, times = _timed(call, query, run.seed, budget, int(method.get("repeats", 1)))
    path = planning.path_of(found)
    if hasattr(found, "seconds"):
        times["search"] = float(found.seconds)  # of peers without the process around it
    if path is None:
        raise NotAResult(planning.complaint(found))
    of = _exact(json.dumps([dict(run.world), asked], sort_keys=True, default=str), run.folder, run.seed if _drawn(run.world) else 0)
    measures, curve = measured(found, path, query, of)
    product, certified = path, True
    if "refine" in method:
        begun = time.perf_counter()
        product = _core.refine(path, query, method["refine"], max_curvature=method.get("max_curvature")).path
        times["refine"] = time.perf_counter() - begun
        measures |= measuring.shape(product, query, "refined_")
        measures["refined_any_angle_gap"] = measuring.gap(measures["refined_length"], of.any_angle)
        certified = _certified(path, query, None)
    measures |= {f"product_{name}": measures.get(f"refined_{name}", measures[name]) for name in SHAPED}
    trajectory = _motion(found, product, query, method.get("timing"), measures)
    kept = None if method.get("timing") == "trapezoid" else trajectory  # it has no limit of jerk: over_limit says how often it breaks it
    certified &= _certified(product, query, kept) and all(value is None or math.isfinite(value) for value in measures.values())
    if run.seed < method.get("heap", 0):
        from guideway.lab.kinds.heap import growth

        grown = growth(run)
        times |= {} if grown is None else {"heap_mib": grown}
    return Outcome(measures=_plain(measures), curve=curve, path=measuring.points_of(product, query), certified=certified, times=times)


def measured(
    found: planning.Planned, path: _core.Path, query: _core.Query, of: measuring.Exact
) -> tuple[measuring.Measures, list[list[float]] | None]:
    """Measures and curve of a plan, without what is asked for beside."""
    measures = measuring.shape(path, query)
    ours = isinstance(found, _core.Solution)
    cells = found.cells if ours else measuring.cells_of(np.asarray(_core.polyline(path, query), float), query.world)
    steps = None if cells is None else measuring.lattice(cells, query.world.resolution)
    if steps is not None:
        whole = abs(steps["length"] - measures["length"]) < 1e-6 * steps["length"]  # else it begins or ends beside a centre
        measures |= steps if whole else {name: steps[name] for name in ("diagonals", "straights")}
    measures |= measuring.gaps(measures, of, steps is not None)
    measures["accuracy"] = None if measures["gap"] is None or not measures["length"] else 100 / (1 + measures["gap"] / 100)
    curve = None
    if ours:
        same = math.isclose(found.cost, measures["length"], rel_tol=1e-6)  # else the search minimises something else
        searched, curve = measuring.searched(np.asarray(found.history), found.iterations, found.evaluations, measures["optimum"] if same else None)
        measures |= searched | {"fallback": found.fallback} | _continuous(found, query)
    else:
        evaluations, history = planning.work_of(found)
        worked, curve = measuring.worked(history, measures["optimum"])
        measures |= worked | ({} if evaluations is None else {"evaluations": evaluations})
    return measures, curve


def _continuous(found: _core.Solution, query: _core.Query) -> measuring.Measures:
    """Objective, bound, homotopy class and closed loop of planners over splines."""
    trace = found.trace or {}
    if not isinstance(trace, dict) or not isinstance(trace.get("objective"), dict):
        return {}
    told: measuring.Measures = {"objective": trace["objective"]["value"], "class": _class(found.path, query.world)}
    above = (trace.get("bound") or {}).get("gap")
    told["objective_gap"] = None if above is None else 100 * above
    stages, speed = trace.get("loop"), trace.get("speed") or {}
    if stages is not None:
        told |= {"stages": len(stages), "regions": sum(len(stage["found"]) for stage in stages)}
        left = speed.get("regions_after")
        told["regions_left"] = left if left is None or isinstance(left, int) else len(left)
    return told


def _class(path: _core.Path, world: _core.World) -> int | None:
    """A number for the homotopy class among discs: how often the path goes round each against the straight line, as digits to base 3."""
    discs = [shape for shape in world.shapes if "disc" in shape]
    if not discs or len(discs) != len(world.shapes):
        return None
    points = path.planar(np.linspace(0.0, path.length, 400))[:, :2]
    way, number = np.vstack([points, points[:1]]), 0
    for shape in discs:
        x, y = _centre(shape)
        angle = np.unwrap(np.arctan2(way[:, 1] - y, way[:, 0] - x))
        number = 3 * number + int(np.clip(round((angle[-1] - angle[0]) / (2 * math.pi)), -1, 1)) + 1
    return number


def _centre(shape: Mapping[str, Any]) -> tuple[float, float]:
    x, y = shape["disc"]["center"] if isinstance(shape["disc"], Mapping) else shape["center"]
    return float(x), float(y)


def _timed(call: planning.Call, query: _core.Query, seed: int, budget: Budget, repeats: int) -> tuple[planning.Planned, dict[str, float]]:
    """What the planner returned, and wall and processor seconds of a call: the median of several after some others if that is asked for."""
    for _ in range(WARM_UP if repeats > 1 else 0):
        call(query, seed, budget)
    walls, cpus, found = [], [], None
    for _ in range(max(repeats, 1)):
        wall, cpu = time.perf_counter(), time.process_time()
        found = call(query, seed, budget)
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
    wall, cpu = statistics.median(walls), statistics.median(cpus)
    return found, {"plan": wall, "plan_cpu": cpu, "cpu_share": 100 * cpu / max(wall, 1e-9)}


def _motion(found: planning.Planned, path: _core.Path, query: _core.Query, how: str | None, measures: measuring.Measures) -> _core.Trajectory | None:
    """The motion that is asked for, with its duration among the measures."""
    if how is None:
        return None
    own = getattr(found, "trajectory", None)
    motion = own if how == "own" and own is not None else _core.time(path, Limits(**query.limits), method="time-optimal" if how == "own" else how)
    limits = Limits(**query.limits)
    measures |= {"duration": motion.duration, "motion_energy": motion.energy, "over_limit": driven.over_ceiling(motion, limits)}
    if query.world.movers:
        measures |= driven.hindrance(motion, query.world)
    return motion


def _certified(path: _core.Path, query: _core.Query, trajectory: _core.Trajectory | None) -> bool:
    """Does the independent checker accept it?"""
    return bool(_core.certify(path, query, trajectory)["ok"])


def _plain(measures: measuring.Measures) -> dict[str, Any]:
    return {name: value.item() if isinstance(value, np.generic) else value for name, value in measures.items()}


def _drawn(world: Mapping[str, Any]) -> bool:
    return world.get("seed") == worlds.RUN


@lru_cache(maxsize=256)
def _exact(words: str, folder: str, seed: int) -> measuring.Exact:
    world, asked = json.loads(words)
    return measuring.exact(worlds.query(world, asked, folder, seed))


def check(experiment: Experiment) -> None:
    """Raises :class:`guideway.errors.BadParameter` naming what is wrong, before any run."""
    worlds.check_all(experiment)
    planning.check_tune(experiment)
    for method in experiment.methods:
        where = f"method {method.get('name', '')!r}"
        planning.check(method, experiment.folder)
        refine = method.get("refine")
        if refine is not None and refine not in REFINEMENTS:
            raise BadParameter(f"{where}: refine {show(refine)} is not known: one of {', '.join(REFINEMENTS)}")
        timing = method.get("timing")
        if timing is not None and timing not in TIMINGS:
            raise BadParameter(f"{where}: timing {show(timing)} is not known: one of {', '.join(TIMINGS)}")
        for name, low in (("repeats", 1), ("heap", 0)):
            count = method.get(name, low)
            if isinstance(count, bool) or not isinstance(count, int) or not low <= count <= 10_000:
                raise BadParameter(f"{where}: {name} {count!r} is not a whole number from {low} to 10000")
