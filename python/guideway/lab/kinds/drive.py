"""Runs of driving: a motion is planned, timed and driven among what moves, and plan and drive are measured."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import guideway as gw
from guideway.errors import BadParameter
from guideway.lab import driven, movers, planning, worlds
from guideway.lab.experiment import Experiment, Metric, Run
from guideway.lab.kinds import NotAResult, Outcome
from guideway.plants import PLANTS
from guideway.products import REFINEMENTS

FIELDS = (
    *("planner", "set", "refine", "timing", "resolution", "blind"),
    *("controller", "control", "replanner", "sense", "lidar", "map", "plant", "arrival", "time_limit", "time_factor", "way"),
)
"""Of the plan: ``planner`` (any of kind plan; default visibility), ``refine`` (default none), ``timing`` (default time-optimal; ``own``: that of the
planner), ``resolution`` of a room's cells (m), ``blind``: nothing that moves is known to it. Of the drive: the keywords of :func:`guideway.drive`
(``control`` is its ``set``, ``replanner`` its ``planner``), ``time_factor``: limit of time in durations of the plan, ``way``: whether a way exists at
all is measured.
"""
WORLD_FIELDS = worlds.WORLD_FIELDS
"""Of these ``crossed`` is known here alone: movers go to and fro across the exact path, drawn from the run's seed."""
QUERY_FIELDS = (*worlds.QUERY_FIELDS, "order")
"""``order`` of the ``via`` points: ``given`` or ``best``."""
TIMINGS = ("time-optimal", "iascv", "trapezoid", "own")
CHOICES = {"sense": ("truth", "lidar"), "map": ("known", "none"), "timing": TIMINGS, "refine": REFINEMENTS, "plant": tuple(PLANTS)}
MOST_ROWS = 400
"""Most points of a driven path in a record."""

_UNITS = {
    "m": ("length", "planned", "length_deviation", "deviation", "arrived_deviation"),
    "s": ("time", "duration", "stopped"),
    "cm": ("tpe", "tte", "path_error"),
    "m/s2": ("peak_acceleration",),
    "m/s3": ("peak_jerk", "rms_jerk"),
    "deg": ("tilt",),
    "deg/m": ("ts",),
    "J/m": ("ttec",),
    "W h": ("moec",),
    "": ("hit", "hit_moving", "hit_parked", "timeout", "stuck", "ssf", "asf", "over", "replans", "stops", "hindered", "objective"),
}
_LOWER = {name: unit for unit, names in _UNITS.items() for name in names}
_HIGHER = {
    "arrived": "",
    "success": "",
    "near_success": "",
    "separation": "m",
    "ms": "%",
    "psi": "%",
    "smoothness": "",
    "accuracy": "%",
    "clean": "",
    "reached": "",
    "auc": "",
    "free": "",
}
METRICS = {
    **{name: Metric(name, unit, "lower", 3) for name, unit in _LOWER.items()},
    **{name: Metric(name, unit, "higher", 3) for name, unit in _HIGHER.items()},
    "way": Metric("way", "", None, 3),
    "evaluations": Metric("evaluations", "", "lower", 0),
    "iterations": Metric("iterations", "", "lower", 0),
    "plan_cpu": Metric("plan_cpu", "s", "lower", 4),
    "sptec": Metric("sptec", "W s", "lower", 2),
    "tsec": Metric("tsec", "kW h", "lower", 3),
    "step_p99": Metric("step_p99", "s", "lower", 5),
}
"""Outcome (``arrived``, hits while moving and while parked, ``success``: arrived and at all times 0.3 m from everything, or the query's clearance
where that is less, ``near_success``: 0.25 m; ``clean``: no hit while moving; ``reached``: arrived, where a way exists; ``arrived_deviation``: of
those that arrived);
drive (see :mod:`guideway.lab.driven`; errors in cm); motion (jerk, steps, ``over``: samples beyond a limit); plan (``planned`` length, ``auc``).
The last four depend on the machine."""


@dataclass(frozen=True, eq=False)
class Site:
    """What is driven (``query``), what its plan may know (``still``: nothing that moves), and the limits."""

    query: gw.Query
    still: gw.Query

    @property
    def limits(self) -> gw.Limits:
        """Of the robot."""
        return gw.Limits(**self.query.limits)


def run(run: Run) -> Outcome:
    """Plans, drives, measures. Raises what the planner raises."""
    method, site = run.method, site_of(run)
    begun, cpu = time.perf_counter(), time.process_time()
    found, motion = planned(site, run)
    times = {"plan": time.perf_counter() - begun, "plan_cpu": time.process_time() - cpu}
    if motion is None:
        raise NotAResult(planning.complaint(found))
    certified = bool(gw.certify(motion.path, site.still)["ok"])
    record = driving(site, motion, method, run.seed)
    measures = plan_measures(found, motion, site) | drive_measures(record, site.query)
    if method.get("way"):
        measures["way"] = movers.way_exists(site.query, _limit(method, motion) or record["time"])
        measures["reached"] = measures["arrived"] if measures["way"] else None
    times |= {f"step_{name}": record["step_seconds"][name] for name in ("mean", "p95", "p99")}
    times |= driven.plan_energies(record, times["plan_cpu"])
    plain = {name: value.item() if isinstance(value, np.generic) else value for name, value in measures.items()}
    certified &= all(value is None or math.isfinite(value) for value in plain.values())
    rows = np.asarray(record["driven"], float)[:, 1:3]
    points = rows[np.unique(np.linspace(0, len(rows) - 1, MOST_ROWS).astype(int))].round(4).tolist()
    return Outcome(measures=plain, path=points, certified=certified, times=times)


def site_of(run: Run) -> Site:
    """The query to drive and the one without movers; in order, with its cells, and with movers across its exact path where they are asked for."""
    resolution = run.method.get("resolution")
    world = {**run.world, **({} if resolution is None else {"resolution": resolution})}
    asked = {key: value for key, value in run.query.items() if key != "order"}
    query = worlds.query(world, asked, run.folder, run.seed)
    if run.query.get("order") == "best":
        query = in_world(query, query.world, via=gw.tour(query)["via"])
    still = in_world(query, query.world.with_movers([]))
    if run.world.get("crossed"):
        exact = gw.refine(gw.plan(still).path, still).path
        query = in_world(query, query.world.with_movers([*query.world.movers, *movers.across(exact, query.world, run.seed)]))
    return Site(query, still)


def in_world(query: gw.Query, world: gw.World, **changes: Any) -> gw.Query:
    """The same query in another world."""
    yaws = ("start_yaw", "start"), ("goal_yaw", "goal")
    ends = {end: (*getattr(query, end), *(() if getattr(query, yaw) is None else (getattr(query, yaw),))) for yaw, end in yaws}
    words = {name: getattr(query, name) for name in ("via", "footprint", "clearance", "half_width", "soft_clearance", "corners", "material")}
    return gw.Query(world, **ends, **(words | changes), limits=gw.Limits(**query.limits))


def planned(site: Site, run: Run) -> tuple[planning.Planned, gw.Trajectory | None]:
    """What the planner found, and its motion; None where what it returned is no path."""
    method = {"planner": "visibility", **run.method}
    query = site.still if method.get("blind") else site.query
    found = planning.planner(method, run.folder)(query, run.seed, gw.Budget(**dict(run.budget)))
    path, own = planning.path_of(found), getattr(found, "trajectory", None)
    timing = method.get("timing", "time-optimal")
    if path is None or (timing == "own" and own is not None):
        return found, own if path is not None else None
    refine = method.get("refine", "none")
    if refine != "none":
        path = gw.refine(path, query, refine).path
    return found, gw.time(path, site.limits, method="time-optimal" if timing == "own" else timing)


def driving(site: Site, motion: gw.Trajectory, method: Mapping[str, Any], seed: int) -> dict[str, Any]:
    """The record of the drive."""
    words = {name: method[name] for name in ("sense", "lidar", "map", "plant", "arrival") if name in method}
    if "replanner" in method:
        words["planner"] = method["replanner"]
    controller = method.get("controller", "improved-dwa")
    return gw.drive(site.query, motion, controller, set=method.get("control"), seed=seed, time_limit=_limit(method, motion), **words)


def _limit(method: Mapping[str, Any], motion: gw.Trajectory) -> float | None:
    factor = method.get("time_factor")
    return method.get("time_limit") if factor is None else factor * motion.duration


def plan_measures(found: planning.Planned, motion: gw.Trajectory, site: Site) -> dict[str, Any]:
    """Of the plan and its motion."""
    told = {"planned": motion.path.length, "duration": motion.duration, "over": driven.over_ceiling(motion, site.limits)}
    told |= driven.jerks(motion) | driven.hindrance(motion, site.query.world)
    return told | {
        "objective": getattr(found, "cost", None),
        "evaluations": getattr(found, "evaluations", None),
        "iterations": getattr(found, "iterations", None),
    }


def drive_measures(record: Mapping[str, Any], query: gw.Query) -> dict[str, Any]:
    """Of the drive."""
    outcome, hit, nearest, tracking = record["outcome"], record["collision"], record["min_separation"], record["tracking"]
    arrived = outcome == "arrived"
    asked = min(query.clearance, driven.SAFE)
    told = {
        "arrived": arrived,
        "success": arrived and (nearest is None or nearest >= asked),
        "near_success": arrived and (nearest is None or nearest >= min(asked, driven.NEARLY)),
        "hit": hit is not None,
        "clean": not (hit and not hit["unavoidable"]),
        "hit_moving": bool(hit and not hit["unavoidable"]),
        "hit_parked": bool(hit and hit["unavoidable"]),
        "timeout": outcome == "timeout",
        "stuck": outcome == "stuck",
        "separation": nearest,
        "time": record["time"],
        "replans": record["replans"],
        "stops": record["emergency_stops"],
        "stopped": tracking["stopped"],
        "length": tracking["length"],
        "length_deviation": tracking["length_deviation"],
        "ts": tracking["ts"],
        "deviation": driven.deviation(record, query),
        "accuracy": driven.accuracy(record),
        "smoothness": driven.smoothness(np.asarray(record["driven"], float)[:, 1:3]),
    }
    told["arrived_deviation"] = told["deviation"] if arrived else None
    told |= {name: None if tracking[name] is None else 100 * tracking[name] for name in ("tpe", "tte", "path_error")}
    return told | driven.tilts(record["driven"]) | driven.energies(record)


def check(experiment: Experiment) -> None:
    """Raises :class:`guideway.BadParameter` for what is not known, before any run."""
    for query in experiment.queries:
        for key in query:
            if key not in ("name", *QUERY_FIELDS):
                raise BadParameter(f"query {query['name']!r}: {key!r} is not known: one of {', '.join(QUERY_FIELDS)}")
        if query.get("order", "given") not in ("given", "best"):
            raise BadParameter(f"query {query['name']!r}: order {query['order']!r} is not known: given or best")
    worlds.check_all(experiment)
    planning.check_tune(experiment)
    for method in experiment.methods:
        _check_method(method, experiment)


def _check_method(method: Mapping[str, Any], experiment: Experiment) -> None:
    where = f"method {method['name']!r}"
    planning.check({"planner": "visibility", **method}, experiment.folder)
    for name, allowed in CHOICES.items():
        if name in method and method[name] not in allowed:
            raise BadParameter(f"{where}: {name} {method[name]!r} is not known: one of {', '.join(allowed)}")
    known = {entry["name"]: [parameter["name"] for parameter in entry["parameters"]] for entry in gw.controllers()}
    controller = method.get("controller", "improved-dwa")
    if controller not in known:
        raise BadParameter(f"{where}: controller {controller!r} is not known: one of {', '.join(known)}")
    for name in method.get("control", {}):
        if name not in known[controller]:
            raise BadParameter(f"{where}: control: {name!r} is no parameter of {controller}: {', '.join(known[controller])}")
    for name in ("arrival", "time_limit", "time_factor", "resolution"):
        value = method.get(name, 1.0)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < 1e6:
            raise BadParameter(f"{where}: {name} {value!r} is not a number above 0")
    if "replanner" in method and method["replanner"] not in [entry["name"] for entry in gw.planners()]:
        raise BadParameter(f"{where}: replanner {method['replanner']!r} is not a registered planner")
