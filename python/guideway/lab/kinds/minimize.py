"""Runs of optimizers, ours and those of others, on functions inside a box with equal evaluations."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from guideway import _core
from guideway.errors import BadParameter
from guideway.lab import measuring, peers, problems
from guideway.lab.experiment import Experiment, Metric, Run
from guideway.lab.kinds import Outcome
from guideway.lab.planning import PEER
from guideway.records import Budget

FIELDS = ("optimizer",)
"""Fields of a method beside its name, settings and budget: a registered optimizer or ``peer:NAME``."""
WORLD_FIELDS = problems.FIELDS
QUERY_FIELDS = ()

METRICS = {
    metric.name: metric
    for metric in (
        Metric("value", "", "lower", 6),
        Metric("error", "", "lower", 6),
        Metric("log_error", "", "lower", 2),
        Metric("feasible", "", "higher", 3),
        Metric("evaluations", "", "lower", 0),
        Metric("iterations", "", "lower", 0),
        Metric("last_evaluation", "", "lower", 0),
    )
}
"""What a run measures: the least value found, its distance from the optimum where that is known (``log_error``: its decimal logarithm, at least -12),
and, for way points, whether the path is free."""

LEAST = 1e-12
"""Errors below this are equal."""


def run(run: Run) -> Outcome:
    """Minimises and measures."""
    problem, budget = problems.problem(run.world), Budget(**dict(run.budget))
    wall, cpu = time.perf_counter(), time.process_time()
    x, evaluations, iterations, history = _found(run.method, problem, run.seed, budget)
    times = {"plan": time.perf_counter() - wall, "plan_cpu": time.process_time() - cpu}
    value = problem.one(x)  # what it says of itself does not count
    low, high = problem.bounds.T
    inside = bool(np.isfinite(value) and (x >= low - 1e-9 * (high - low)).all() and (x <= high + 1e-9 * (high - low)).all())
    measures: dict[str, Any] = {"value": value, "evaluations": evaluations}
    if iterations is not None:
        measures["iterations"] = iterations
    if problem.optimum is not None:
        error = value - problem.optimum
        measures |= {"error": error, "log_error": float(np.log10(max(error, LEAST)))}
    if problem.feasible is not None:
        measures["feasible"] = problem.feasible(x)
    worked, curve = measuring.worked(history, None)
    return Outcome(measures=measures | worked, curve=curve, path=None, certified=inside, times=times)


def _found(method: Mapping[str, Any], problem: problems.Problem, seed: int, budget: Budget) -> tuple[np.ndarray, int, int | None, np.ndarray]:
    """Where the least value is, evaluations, iterations, and rows of evaluations and best so far."""
    name, settings = method["optimizer"], dict(method.get("set", {}))
    if name.startswith(PEER):
        answer = peers.find(name, "minimize").run((problem.one, problem.bounds), seed=seed, budget=budget.to_dict(), set=settings)
        history = np.asarray(answer.history, float).reshape(-1, 2)
        return np.asarray(answer.x, float), int(answer.evaluations), None, history
    found = _core.minimize(problem.many, problem.bounds, name, seed=seed, budget=budget, set=settings or None, vectorized=True)
    history = np.asarray(found.history, float).reshape(-1, 3)
    each = found.evaluations / max(found.iterations + 1, 1)
    work = np.clip(np.round((history[:, 0] + 1) * each), 0, found.evaluations)
    return np.asarray(found.x), found.evaluations, found.iterations, np.column_stack([work, history[:, 1]])


def check(experiment: Experiment) -> None:
    """Raises :class:`guideway.errors.BadParameter` naming what is wrong, before any run."""
    for world in experiment.worlds:
        problems.check(world)
    known = {entry["name"]: [parameter["name"] for parameter in entry["parameters"]] for entry in _core.optimizers()}
    for method in experiment.methods:
        where, name, settings = f"method {method.get('name', '')!r}", method.get("optimizer"), method.get("set", {})
        if isinstance(name, str) and name.startswith(PEER):
            _check_peer(where, name, settings)
        elif name not in known:
            raise BadParameter(f"{where}: optimizer {name!r} is not known: one of {', '.join(known)}, {PEER}NAME")
        else:
            for key in settings:
                if key not in known[name]:
                    raise BadParameter(f"{where}: set: {key!r} is no parameter of {name}: {', '.join(known[name])}")


def _check_peer(where: str, name: str, settings: Mapping[str, Any]) -> None:
    try:
        peers.find(name, "minimize").settings(settings)
    except BadParameter as error:
        raise BadParameter(f"{where}: {error}") from None
