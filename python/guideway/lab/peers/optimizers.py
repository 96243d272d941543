"""pygmo's and SciPy's optimizers on an objective of ours: ``f(x)`` is a number, bounds are (d, 2). Evaluations are counted here, the same for all."""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import guideway as gw
from guideway.lab.peers import Answer

Objective = Callable[[np.ndarray], float]
Problem = tuple[Objective, Any]


class _Counted:
    """An objective that counts, remembers the best and refuses to go beyond the budget: what is asked after it is infinite and not counted."""

    def __init__(self, f: Objective, most: float) -> None:
        self.f, self.most = f, most
        self.count, self.best, self.x = 0, math.inf, None
        self.history: list[list[float]] = []

    def __call__(self, x: Any) -> float:
        if self.count >= self.most:
            return math.inf
        value = float(self.f(np.asarray(x, float)))
        self.count += 1
        if value < self.best:
            self.best, self.x = value, np.array(x, float)
            self.history.append([self.count, value])
        return value

    def answer(self, seconds: float) -> Answer:
        """What was found."""
        if self.x is None:
            raise gw.GuidewayError("no value of the objective was finite")
        return Answer(x=self.x.tolist(), value=self.best, evaluations=self.count, history=self.history, seconds=seconds)


def _begin(problem: Problem, budget: Mapping[str, Any]) -> tuple[_Counted, np.ndarray, int]:
    most = budget.get("evaluations")
    if not most:
        raise gw.BadParameter("this optimizer needs a budget of evaluations")
    f, bounds = problem
    return _Counted(f, most), np.asarray(bounds, float), int(most)


def pygmo(problem: Problem, *, seed: int, budget: Mapping[str, Any], algorithm: str, population: int = 50) -> Answer:
    """An algorithm of pygmo with a population, for as many generations as the budget lets it; tolerances that would stop it are off."""
    package: Any = importlib.import_module("pygmo")
    counted, box, most = _begin(problem, budget)

    class Asked:
        def fitness(self, x: Any) -> list[float]:
            return [counted(x)]

        def get_bounds(self) -> tuple[list[float], list[float]]:
            return box[:, 0].tolist(), box[:, 1].tolist()

        def __deepcopy__(self, _memo: object) -> Any:  # pygmo copies problems; the count must stay one
            return self

    words: dict[str, Any] = {"gen": max(most // population - 1, 1), "seed": seed}
    if algorithm in ("de", "sade", "de1220", "cmaes"):
        words |= {"ftol": 0.0, "xtol": 0.0}
    words |= {"cmaes": {"force_bounds": True}, "gaco": {"ker": population // 2}}.get(algorithm, {})
    begun = time.perf_counter()
    individuals = package.population(package.problem(Asked()), population, seed=seed)
    package.algorithm(getattr(package, algorithm)(**words)).evolve(individuals)
    return counted.answer(time.perf_counter() - begun)


def scipy_de(problem: Problem, *, seed: int, budget: Mapping[str, Any], population: int = 50, strategy: str = "best1bin") -> Answer:
    """SciPy's differential evolution from a uniform random population; tolerances are off and nothing is polished."""
    package: Any = importlib.import_module("scipy.optimize")
    counted, box, most = _begin(problem, budget)
    first = box[:, 0] + (box[:, 1] - box[:, 0]) * np.random.default_rng(seed).random((population, len(box)))
    words: dict[str, Any] = {"strategy": strategy, "maxiter": max(most // population - 1, 1), "tol": 0, "atol": 0, "polish": False, "init": first}
    begun = time.perf_counter()
    package.differential_evolution(counted, [tuple(row) for row in box.tolist()], rng=np.random.default_rng(seed), **words)
    return counted.answer(time.perf_counter() - begun)


def scipy_dual_annealing(problem: Problem, *, seed: int, budget: Mapping[str, Any]) -> Answer:
    """SciPy's dual annealing without its local search, which would need gradients by differences."""
    package: Any = importlib.import_module("scipy.optimize")
    counted, box, most = _begin(problem, budget)
    begun = time.perf_counter()
    package.dual_annealing(
        counted, [tuple(row) for row in box.tolist()], maxfun=most, no_local_search=True, maxiter=most, rng=np.random.default_rng(seed)
    )
    return counted.answer(time.perf_counter() - begun)
