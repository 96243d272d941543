"""A job (map, query, method, limits) through the whole flow: plan, refine, time, certify, measure against the exact optimum."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from guideway import _core, alternatives
from guideway.errors import BadParameter, Infeasible
from guideway.records import Budget, Limits
from guideway.traces import trace_record

Observer = Callable[[dict[str, Any]], bool]


SOFT = ("astar", "dijkstra")
"""Planners that weigh soft clearance."""


@dataclass
class Job:
    """Everything that decides a plan. ``footprint`` is a record (``{"disc": 0.35}``), points in m, yaw in rad."""

    world: _core.World
    start: tuple[float, ...]
    goal: tuple[float, ...]
    via: list[tuple[float, float]] = field(default_factory=list)
    footprint: dict[str, Any] = field(default_factory=lambda: {"disc": 0.0})
    clearance: float = 0.0
    half_width: float = 0.0
    soft_clearance: tuple[float, float] | None = None
    corners: str | None = None
    material: str = "standard"
    planner: str = "visibility"
    set: dict[str, Any] = field(default_factory=dict)
    seed: int = 0
    budget: Budget = field(default_factory=Budget)
    refine: str = "smooth"
    max_curvature: float | None = None
    limits: Limits = field(default_factory=Limits)
    order: str = "given"
    keep_out: list[str] = field(default_factory=list)
    speed_mask: str | None = None
    timing: bool = True
    threads: int = 1
    exact_fallback: bool = False
    pareto: bool = False
    drive: dict[str, Any] = field(default_factory=dict)
    """What a scene says of the drive: ``arrival`` (m), ``time_limit`` (s), ``stop``, ``mover_speed`` (m/s), ``lidar``."""
    observe: Observer | None = None

    def speed_map(self) -> _core.SpeedMap | None:
        """The map of speeds that the mask means for the top speed of this job."""
        return None if self.speed_mask is None else _core.SpeedMap.load(self.speed_mask, self.limits.speed)

    def query(self) -> _core.Query:
        """The core query of this job."""
        return _core.Query(
            self.world,
            self.start,
            self.goal,
            via=self.via,
            footprint=self.footprint,
            clearance=self.clearance,
            half_width=self.half_width,
            soft_clearance=self.soft_clearance,
            corners=self.corners,
            material=self.material,
            limits=self.limits,
        )


@dataclass
class Outcome:
    """A finished job: the record of ``plan.json`` and the objects behind it."""

    record: dict[str, Any]
    query: _core.Query
    solution: _core.Solution
    path: _core.Path
    trajectory: _core.Trajectory | None


def run(job: Job, folder: str | os.PathLike[str] = ".") -> Outcome:
    """Plans, refines, times, certifies and measures; ``folder`` is where the record will lie (its map is named relative to it).

    Raises the errors of :mod:`guideway.errors`; on Ctrl-C ``KeyboardInterrupt`` with an attribute ``outcome`` (or None).
    """
    if job.soft_clearance is not None and job.planner not in SOFT:
        raise BadParameter(f"{job.planner} does not weigh soft clearance: plan with {' or '.join(SOFT)}, or leave the soft clearance out")
    query, tour = toured(job)
    if job.pareto:
        alternatives.check(query)
    try:
        solution = _core.plan(
            query,
            job.planner,
            seed=job.seed,
            budget=job.budget,
            set=job.set or None,
            observe=job.observe,
            threads=job.threads,
            exact_fallback=job.exact_fallback,
        )
    except KeyboardInterrupt as interrupt:
        found: _core.Solution | None = getattr(interrupt, "solution", None)
        interrupt.outcome = None if found is None else finish(job, query, found, folder, quick=True)  # type: ignore[attr-defined]
        raise
    outcome = finish(job, query, solution, folder)
    if tour is not None:
        outcome.record["tour"] = tour
    if job.pareto:
        try:
            outcome.record.update(alternatives.records(query, job.budget.seconds, job.observe))
        except KeyboardInterrupt as interrupt:
            outcome.record.update(getattr(interrupt, "fields", None) or {})
            interrupt.outcome = outcome  # type: ignore[attr-defined]
            raise
    return outcome


def toured(job: Job) -> tuple[_core.Query, dict[str, Any] | None]:
    """The query of a job, with its via points in the best order where that is asked for; and the tour then."""
    query = job.query()
    if job.order == "given":
        return query, None
    if job.order != "best":
        raise BadParameter(f"order {job.order!r} is not known: given or best")
    found = _core.tour(query)
    job.via = [(x, y) for x, y in found["via"]]
    return job.query(), {name: found[name] for name in ("order", "length", "bound")}


def finish(job: Job, query: _core.Query, solution: _core.Solution, folder: str | os.PathLike[str], quick: bool = False) -> Outcome:
    """From a planner's solution to the outcome; ``quick`` leaves out refinement, timing and references."""
    trajectory = solution.trajectory  # of planners that plan path and speed at once: their path stays as it is
    how = "none" if quick or trajectory is not None else job.refine
    from guideway import products  # it builds on this module

    refined = products.refine(job, query, solution, how)
    zones, among = job.speed_map(), None
    if job.timing and not quick and (trajectory is None or zones is not None):
        trajectory, among = timed(job, query, refined.path, solution.trace, zones)
    certificate = _core.certify(refined.path, query, trajectory, max_curvature=job.max_curvature, speed_map=zones)
    if not certificate["ok"]:
        failed = ", ".join(check["name"] for check in certificate["checks"] if not check["ok"])
        from guideway.errors import CertificateFailed

        raise CertificateFailed(f"the result failed its certificate ({failed}); it is withheld. This is a bug in Guideway: please report it")
    record = {
        "guideway": _core.__version__,
        "schema": 1,
        "planner": job.planner,
        "parameters": _core.parameters(job.planner, job.set or None, query),
        "seed": job.seed,
        "world": world_record(job.world, folder, job.keep_out),
        "query": query_record(query),
        "path": path_record(refined.path),
        "polyline": _core.polyline(refined.path, query).tolist(),
        "grid_path": None if solution.grid_path is None else solution.grid_path.tolist(),
        "raw_path": _core.polyline(solution.path, query).tolist(),
        "refine": how,
        "metrics": products.metrics(refined.path, query, trajectory),
        "search": search_record(solution),
        "reference": reference_record(query, solution, quick, job.observe),
        "certificate": certificate,
        "unmet": refined.unmet,
        "trajectory": None if trajectory is None else trajectory_record(trajectory, job.limits),
        "speed_ceiling": None if trajectory is None else _core.ceiling(refined.path, job.limits).tolist(),
    }
    if job.speed_mask is not None:
        record["speed_mask"] = mask_record(job.speed_mask, folder)
    if job.drive:
        record["drive"] = job.drive
    if refined.candidates:
        record["candidates"] = refined.candidates
    if (trace := trace_record(solution.trace)) is not None:
        record["trace"] = trace
        if among is not None:
            trace["speed"]["movers"] |= among
    return Outcome(record, query, solution, refined.path, trajectory)


def timed(
    job: Job, query: _core.Query, path: _core.Path, trace: dict[str, Any], zones: _core.SpeedMap | None
) -> tuple[_core.Trajectory, dict[str, Any] | None]:
    """A path in time. Where the planner kept its motion off the movers this one keeps off them too; else the second value says why not."""
    among = ((trace or {}).get("speed") or {}).get("movers") or {}
    alone = {"timed": False, "reason": among.get("reason", "")}

    def motion(others: _core.Query | None) -> _core.Trajectory:
        return _core.time(path, job.limits, start_yaw=query.start_yaw, goal_yaw=query.goal_yaw, speed_map=zones, among=others)

    if among.get("timed"):
        try:
            found = motion(query)
        except Infeasible as error:
            alone["reason"] = f"at the speeds that the mask allows there is none that keeps off them ({error})"
        else:
            told = found.among or {}
            return found, {name: told[name] for name in ("passive", "delay", "waiting")}
    return motion(None), (alone if among else None)


def world_record(world: _core.World, folder: str | os.PathLike[str], keep_out: Sequence[str] = ()) -> dict[str, Any]:
    """The ``world`` of a record; files are named relative to ``folder`` where they can be. ``keep_out``: the masks applied to its source."""
    source = world.source
    if source is not None:
        plain, mark, number = source.partition("#")  # number N of a collection
        source = relative(plain, folder) + mark + number
    size = {"width": world.width, "height": world.height, "resolution": world.resolution, "origin": list(world.origin)}
    record = {"source": source, "sha256": world.sha256, "files": world.files} | size
    return record | ({"keep_out": [mask_record(path, folder) for path in keep_out]} if keep_out else {})


def mask_record(path: str, folder: str | os.PathLike[str]) -> dict[str, Any]:
    """A mask in a record: where it is and what it was."""
    from guideway.io.masks import read_mask

    return {"source": relative(path, folder), "files": read_mask(path)[2]}


def relative(path: str, folder: str | os.PathLike[str]) -> str:
    """A file as seen from ``folder``; as it is where it does not exist."""
    if not os.path.exists(path):
        return path
    try:
        return os.path.relpath(path, folder)
    except ValueError:  # another drive
        return os.path.abspath(path)


def query_record(query: _core.Query) -> dict[str, Any]:
    """The ``query`` of a record."""
    return {
        "start": list(query.start) + ([] if query.start_yaw is None else [query.start_yaw]),
        "goal": list(query.goal) + ([] if query.goal_yaw is None else [query.goal_yaw]),
        "via": [list(point) for point in query.via],
        "footprint": query.footprint,
        "clearance": query.clearance,
        "half_width": query.half_width,
        "soft_clearance": None if query.soft_clearance is None else list(query.soft_clearance),
        "corners": query.corners,
        "material": query.material,
    }


def path_record(path: _core.Path) -> dict[str, Any]:
    """The ``path`` of a record."""
    return {"degree": path.degree, "knots": path.knots.tolist(), "control_points": path.control_points.tolist()}


def search_record(solution: _core.Solution) -> dict[str, Any]:
    """The ``search`` of a record; under ``fallback`` that of the exact search, with what the planner found in ``heuristic``."""
    record = plain_search(solution)
    heuristic = solution.heuristic
    return record | {"fallback": solution.fallback, "heuristic": None if heuristic is None else plain_search(heuristic)}


def plain_search(solution: _core.Solution) -> dict[str, Any]:
    """What one search did."""
    return {
        "iterations": solution.iterations,
        "evaluations": solution.evaluations,
        "seconds": solution.seconds,
        "stop": solution.stop,
        "history": [[int(iteration), cost] for iteration, cost in solution.history.tolist()],
        "raw_length": solution.length,
    }


def reference_record(query: _core.Query, solution: _core.Solution, quick: bool, observe: Observer | None = None) -> dict[str, Any]:
    """The exact optima of the same model and the gaps to them; null where there is none."""
    empty = {"grid_optimum": None, "grid_gap": None, "any_angle_optimum": None, "any_angle_gap": None, "proved": False, "path": None}
    empty |= {"grid_turns": None, "grid_energy": None, "grid_energy_gap": None}
    if quick:
        return empty
    return empty | _core.reference(query, solution, observe=observe)


def trajectory_record(trajectory: _core.Trajectory, limits: Limits) -> dict[str, Any]:
    """The ``trajectory`` of a record."""
    kept = ("speed", "acceleration", "deceleration", "jerk", "turn_rate", "turn_acceleration", "lateral_acceleration")
    nominal = limits.to_dict()
    return {"duration": trajectory.duration, "limits": {name: nominal[name] for name in kept}, "pieces": trajectory.pieces}


def cell_to_point(world: _core.World, cell: tuple[int, int]) -> tuple[float, float]:
    """Centre (m) of a cell as the image has it: column, row, row 0 on top."""
    x, y = world.cell_centers([cell])[0].tolist()
    return x, y
