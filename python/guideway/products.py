"""Three products of one query by material: shortest (standard), safest (long), least energy (heavy)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from guideway import _core, jobs
from guideway.errors import PlanningError

MATERIALS = ("standard", "long", "heavy")
REFINEMENTS = ("none", "simplify", "smooth", "bspline")
OWN = {"standard": "none", "long": "simplify", "heavy": "smooth"}
"""Refinements of a lattice planner's three products where none is asked for: the lattice path, the tidied safe one, the one of least energy."""

ROOM = (0.25, 0.5)
"""Further clearance with which any-angle paths for heavy loads are tried, m: bends become wider."""
SPACING = (0.5, 1.0, 2.0)
"""Distances of control points that are tried for splines of heavy loads beside every cell, m."""
STRETCH = 0.1
"""Share of their legs that the wider of the tried bends may add."""
PRODUCT = ("query", "refine", "path", "polyline", "grid_path", "raw_path", "metrics", "search", "reference", "certificate", "unmet", "trajectory")
"""What a product has of its own in ``products`` of ``plan.json``; ``speed_ceiling``, ``candidates``, ``trace`` and ``warnings`` come with it."""


@dataclass
class Refinement:
    """A refined path, what could not be met, and for heavy loads the candidates it was chosen from."""

    path: _core.Path
    unmet: list[str]
    candidates: list[dict[str, Any]] = field(default_factory=list)


def refine(job: jobs.Job, query: _core.Query, solution: _core.Solution, how: str) -> Refinement:
    """Refines the planner's path as asked; ``smooth`` for heavy loads is the candidate that drives with the least energy."""
    if how == "smooth" and query.material == "heavy":
        return least_energy(job, query, solution)
    refined = _core.refine(solution.path, query, how, max_curvature=job.max_curvature)
    return Refinement(refined.path, refined.unmet)


def least_energy(job: jobs.Job, query: _core.Query, solution: _core.Solution) -> Refinement:
    """Of all candidates the one whose motion takes the least energy; those that keep the largest curvature asked for come first."""
    best: tuple[tuple[bool, float], Refinement, dict[str, Any]] | None = None
    rows = []
    for row, path, unmet in _candidates(job, query, solution):
        metrics = _core.measure(path, query)
        motion = _core.time(path, job.limits, start_yaw=query.start_yaw, goal_yaw=query.goal_yaw)
        kept = ("length", "turns", "max_curvature", "energy")
        row |= {name: metrics[name] for name in kept} | {"drive_energy": motion.energy, "duration": motion.duration, "chosen": False}
        rows.append(row)
        limit, peak = job.max_curvature, metrics["max_curvature"]
        above = limit is not None and (peak is None or peak > limit * (1 + 1e-6))
        rank = (above, row["drive_energy"])
        if best is None or rank < best[0]:
            told = [f"curvature {peak:.3f} 1/m is above {limit} 1/m"] if above and peak is not None and row["refine"] == "bspline" else []
            best = rank, Refinement(path, unmet + told), row
    assert best is not None  # the first candidate is always there
    best[2]["chosen"] = True
    best[1].candidates = rows
    return best[1]


def _candidates(job: jobs.Job, query: _core.Query, solution: _core.Solution) -> Iterator[tuple[dict[str, Any], _core.Path, list[str]]]:
    """Every candidate that is free: how it was made, its path, what it could not meet."""
    cell = job.world.resolution
    for room, path in _raw_paths(job, query, solution):
        wide = [STRETCH] if room else [None, STRETCH]
        ways: list[tuple[str, dict[str, Any]]] = [("smooth", {"stretch": stretch}) for stretch in wide]
        ways += [("bspline", {"spacing": 1.0})] if not room else []
        ways += [("bspline", {"spacing": distance / cell}) for distance in SPACING if distance > 1.5 * cell]
        for how, setting in ways:
            refined = _core.refine(path, query, how, max_curvature=job.max_curvature if how == "smooth" else None, **setting)
            # A spline that cannot be proved free is the path itself, which is a candidate of its own with its corners.
            if how == "smooth" or refined.path.degree > 1:
                spacing = setting["spacing"] * cell if how == "bspline" else None
                yield {"refine": how, "room": room, "spacing": spacing, "stretch": setting.get("stretch")}, refined.path, refined.unmet


def _raw_paths(job: jobs.Job, query: _core.Query, solution: _core.Solution) -> Iterator[tuple[float, _core.Path]]:
    """The planner's path and, of any-angle planners, those with more room around obstacles: wide bends cost less. Not under budgets of time."""
    yield 0.0, solution.path
    if solution.cells is not None or job.budget.seconds is not None:
        return
    for room in ROOM:
        wider = replace(job, clearance=job.clearance + room).query()
        try:
            wider.validate()
            yield room, _core.plan(wider, job.planner, seed=job.seed, budget=job.budget, set=job.set or None, threads=job.threads).path
        except PlanningError:
            return


def metrics(path: _core.Path, query: _core.Query, trajectory: _core.Trajectory | None) -> dict[str, Any]:
    """The measures of a path, and the energy of the motion along it in J (None without one)."""
    return _core.measure(path, query) | {"drive_energy": None if trajectory is None else trajectory.energy}


def compare(job: jobs.Job, folder: str | os.PathLike[str], own: bool) -> jobs.Outcome:
    """The outcome of the job with all three products of its query in ``record["products"]``.

    ``own``: lattice planners get the refinement of each product (:data:`OWN`) rather than the job's. A product that cannot be had is recorded as its
    error; that of the job itself is raised.
    """
    lattice = next((entry["lattice"] for entry in _core.planners() if entry["name"] == job.planner), False)
    outcomes: dict[str, jobs.Outcome] = {}
    failed: dict[str, dict[str, str]] = {}
    for material in sorted(MATERIALS, key=lambda name: name != job.material):
        try:
            outcomes[material] = jobs.run(replace(job, material=material, refine=OWN[material] if own and lattice else job.refine), folder)
        except KeyboardInterrupt as interrupt:
            if job.material in outcomes:
                interrupt.outcome = outcomes[job.material]  # type: ignore[attr-defined]
            raise
        except PlanningError as error:
            if material == job.material:
                raise
            failed[material] = {"error": type(error).__name__, "message": str(error)}
    asked = outcomes[job.material]
    products: dict[str, dict[str, Any]] = {}
    for name in MATERIALS:
        products[name] = dict(failed[name]) if name in failed else _product(outcomes[name].record)
    if "path" in products["standard"] and products["standard"]["path"] == products["heavy"].get("path"):
        for name in ("standard", "heavy"):
            products[name]["warnings"] = ["The shortest path is the one of least energy here: no wider bend that was tried saves what its way costs."]
    asked.record["products"] = products
    return asked


def _product(record: dict[str, Any]) -> dict[str, Any]:
    more = ("speed_ceiling", "candidates", "trace")
    return {name: record[name] for name in (*PRODUCT, *more) if name in record}


def table(products: dict[str, dict[str, Any]]) -> list[str]:
    """A few lines for people: a row per product."""
    lines = [f"{'product':<12} {'length':>9} {'turns':>6} {'clear':>8} {'energy':>9} {'drive':>9}"]
    for name, product in products.items():
        if "error" in product:
            lines.append(f"{name:<12} {product['error']}")
            continue
        found = product["metrics"]
        clear = "-" if found["min_clearance"] is None else f"{round(found['min_clearance'], 3) + 0.0:.3f} m"
        drive = "-" if found["drive_energy"] is None else f"{found['drive_energy']:.1f} J"
        lines.append(f"{name:<12} {found['length']:>7.3f} m {found['turns']:>6} {clear:>8} {found['energy']:>9.3f} {drive:>9}")
    return lines
