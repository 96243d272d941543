"""Optimizers beside pygmo and SciPy: evaluations per second, and what equal budgets find on way points among discs. Prints Markdown tables."""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pygmo
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

import guideway as gw

Floats = NDArray[np.float64]
START, GOAL, SAFE, COUNT = np.array([0.4, 0.4]), np.array([9.5, 5.5]), 0.3, 10
LOW, HIGH = np.zeros(2 * COUNT), np.tile([10.0, 6.0], COUNT)
BOX = np.column_stack([LOW, HIGH])
POPULATION = 50
# Of the family; the first is that of the published comparison.
SCENES = (12, 100, 101, 104, 107)


class Scene:
    """Ten free way points from start to goal among twelve discs."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        discs: list[Floats] = []
        while len(discs) < 12:
            center, radius = rng.uniform([0.8, 0.4], [9.2, 5.6]), rng.uniform(0.25, 0.6)
            room = min(np.linalg.norm(center - START), np.linalg.norm(center - GOAL))
            apart = all(np.linalg.norm(center - other[:2]) >= radius + other[2] + 0.15 for other in discs)
            if room >= radius + SAFE + 0.1 and apart:
                discs.append(np.array([*center, radius]))
        self.centers, self.reach = np.array(discs)[:, :2], np.array(discs)[:, 2] + SAFE

    def parts(self, x: Floats) -> tuple[Floats, Floats]:
        """Length, and how far the segments enter the grown discs, summed; ``x`` of shape (n, 20)."""
        ends = [np.broadcast_to(p, (len(x), 1, 2)) for p in (START, GOAL)]
        points = np.concatenate([ends[0], x.reshape(len(x), COUNT, 2), ends[1]], axis=1)
        first, along = points[:, :-1], np.diff(points, axis=1)
        square = (along * along).sum(axis=2)
        to = self.centers[:, None, None] - first
        share = np.clip((to * along).sum(axis=3) / np.maximum(square, 1e-12), 0.0, 1.0)
        away = to - share[..., None] * along
        depth = np.maximum(self.reach[:, None, None] - np.sqrt((away * away).sum(axis=3)), 0.0)
        return np.sqrt(square).sum(axis=1), depth.sum(axis=(0, 2))

    def many(self, x: Floats) -> Floats:
        length, depth = self.parts(x)
        return length + 20.0 * depth

    def one(self, x: Floats) -> float:
        return float(self.many(np.asarray(x)[None])[0])

    def feasible(self, x: Floats) -> bool:
        return bool(self.parts(np.asarray(x)[None])[1][0] < 1e-3)


class Problem:
    """A scene as pygmo wants it."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    def fitness(self, x: Floats) -> list[float]:
        return [self.scene.one(x)]

    def get_bounds(self) -> tuple[list[float], list[float]]:
        return LOW.tolist(), HIGH.tolist()


Run = Callable[[Scene, int, int], Floats]


def ours(method: str, **set: object) -> Run:
    return lambda scene, seed, count: gw.minimize(scene.many, BOX, method, seed=seed, budget=count, set=set, vectorized=True).x


def evolved(make: Callable[[int, int], object]) -> Run:
    def run(scene: Scene, seed: int, count: int) -> Floats:
        population = pygmo.population(pygmo.problem(Problem(scene)), POPULATION, seed=seed)
        return pygmo.algorithm(make(count // POPULATION - 1, seed)).evolve(population).champion_x

    return run


def scipy_best(scene: Scene, seed: int, count: int) -> Floats:
    first = LOW + (HIGH - LOW) * np.random.default_rng(seed).random((POPULATION, 2 * COUNT))
    options = {"strategy": "best1bin", "maxiter": count // POPULATION - 1, "tol": 0, "atol": 0, "polish": False, "init": first, "rng": seed}
    return differential_evolution(scene.one, list(zip(LOW, HIGH, strict=True)), **options).x


METHODS: dict[str, Run] = {
    "guideway l-shade (default)": ours("l-shade"),
    "guideway cma-es": ours("cma-es"),
    "guideway cma-es, population 100": ours("cma-es", population=100),
    "guideway improved-de": ours("improved-de"),
    "guideway de": ours("de"),
    "guideway firefly": ours("firefly"),
    "pygmo cmaes": evolved(lambda g, s: pygmo.cmaes(gen=g, seed=s, force_bounds=True, ftol=0.0, xtol=0.0)),
    "pygmo de1220": evolved(lambda g, s: pygmo.de1220(gen=g, seed=s, ftol=0.0, xtol=0.0)),
    "pygmo sade": evolved(lambda g, s: pygmo.sade(gen=g, seed=s, ftol=0.0, xtol=0.0)),
    "scipy best1bin": scipy_best,
}


def quality(seeds: int, count: int, scenes: Sequence[int]) -> None:
    for scene_seed in scenes:
        scene = Scene(scene_seed)
        found = {name: [run(scene, seed, count) for seed in range(1, seeds + 1)] for name, run in METHODS.items()}
        values = {name: np.array([scene.one(x) for x in xs]) for name, xs in found.items()}
        best = min(v.min() for v in values.values())
        peer = min(float(np.median(v)) for name, v in values.items() if not name.startswith("guideway"))
        print(f"\n## Ten way points among the discs of seed {scene_seed}: {count} evaluations, {seeds} seeds, best known {best:.4f}\n")
        print("| method | median | beside the best peer's | best | worst | within 1 % of best | feasible |\n|---|---|---|---|---|---|---|")
        for name, v in sorted(values.items(), key=lambda item: float(np.median(item[1]))):
            feasible = sum(scene.feasible(x) for x in found[name])
            share = f"{100 * (np.median(v) / peer - 1):+.2f} %"
            near = int((v < 1.01 * best).sum())
            print(f"| {name} | {np.median(v):.4f} | {share} | {v.min():.4f} | {v.max():.3f} | {near} | {feasible} / {seeds} |", flush=True)


def ways(scene: Scene) -> Floats:
    """Ten points along the shortest path of each homotopy class, shape (k, 20)."""
    text = "[world]\nbounds = [0, 0, 10, 6]\nresolution = 0.05\n"
    for (x, y), reach in zip(scene.centers.tolist(), scene.reach.tolist(), strict=True):
        text += f"[[disc]]\ncenter = [{x!r}, {y!r}]\nradius = {reach - SAFE!r}\n"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "discs.toml"
        file.write_text(text, "utf-8")
        query = gw.Query(gw.World.load(str(file)), START.tolist(), GOAL.tolist(), clearance=SAFE)
    classes = gw.plan(query, "aide").trace["classes"]
    hints = []
    for one in classes:
        line = np.asarray(one["path"])
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        at = np.linspace(0.0, along[-1], COUNT + 2)[1:-1]
        hints.append(np.column_stack([np.interp(at, along, line[:, k]) for k in (0, 1)]).ravel())
    return np.array(hints)


def hinted(seeds: int, count: int, scenes: Sequence[int]) -> None:
    print(f"\n## The same with a hint in each homotopy class: {count} evaluations, {seeds} seeds\n")
    print("| scene | method | median | best | worst | feasible |\n|---|---|---|---|---|---|")
    for scene_seed in scenes:
        scene = Scene(scene_seed)
        hints = ways(scene)
        for method in ("l-shade", "cma-es", "improved-de"):
            options = {"budget": count, "vectorized": True, "hints": hints}
            found = [gw.minimize(scene.many, BOX, method, seed=seed, **options).x for seed in range(1, seeds + 1)]
            v = np.array([scene.one(x) for x in found])
            feasible = sum(scene.feasible(x) for x in found)
            print(f"| {scene_seed} | {method} | {np.median(v):.4f} | {v.min():.4f} | {v.max():.4f} | {feasible} / {seeds} |", flush=True)


def rate(run: Callable[[], int], repeats: int = 7) -> float:
    """Evaluations per second of CPU time, the best of some runs."""
    rates = []
    for _ in range(repeats):
        begun = time.process_time()
        count = run()
        rates.append(count / (time.process_time() - begun))
    return max(rates)


def compiled_speed(count: int = 400_000) -> None:
    box = [(-5.0, 10.0)] * 20
    problem = pygmo.problem(pygmo.rosenbrock(20))

    def peer(algorithm: object) -> int:
        population = pygmo.population(problem, 40, seed=1)
        population = pygmo.algorithm(algorithm).evolve(population)
        return population.problem.get_fevals()

    everything = {"patience": 0, "tolerance": 0.0}
    gens, tol = count // 40 - 1, {"ftol": 0.0, "xtol": 0.0, "seed": 1}
    runs: dict[str, Callable[[], int]] = {
        "pygmo de, rand/1/bin": lambda: peer(pygmo.de(gen=gens, F=0.6, CR=0.8, variant=7, **tol)),
        "pygmo de, rand/1/exp": lambda: peer(pygmo.de(gen=gens, F=0.6, CR=0.8, variant=2, **tol)),
        "guideway improved-de": lambda: gw.minimize("rosenbrock", box, "improved-de", budget=count, set=everything).evaluations,
        "guideway de": lambda: gw.minimize("rosenbrock", box, "de", budget=count, set=everything).evaluations,
        "guideway l-shade": lambda: gw.minimize("rosenbrock", box, "l-shade", budget=count, set=everything).evaluations,
        "guideway cma-es": lambda: gw.minimize("rosenbrock", box, "cma-es", budget=count // 10).evaluations,
        "guideway cma-es, population 40": lambda: gw.minimize("rosenbrock", box, "cma-es", budget=count // 10, set={"population": 40}).evaluations,
        "pygmo cmaes, population 40": lambda: peer(pygmo.cmaes(gen=gens // 10, **tol)),
    }
    table(f"Compiled Rosenbrock function of 20 numbers, {count} evaluations", runs, "pygmo de, rand/1/exp")


def nothing(x: Floats) -> float:
    return x[0]


def nothing_many(x: Floats) -> Floats:
    return x[:, 0]


def valley(x: Floats) -> float:
    """The Rosenbrock function as people write it."""
    return float(np.sum(100.0 * (x[1:] - x[:-1] ** 2) ** 2 + (1.0 - x[:-1]) ** 2))


def valley_many(x: Floats) -> Floats:
    return np.sum(100.0 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1.0 - x[:, :-1]) ** 2, axis=1)


def python_speed(title: str, f: Callable[[Floats], float], many: Callable[[Floats], Floats], count: int = 20_000) -> None:
    box = [(-5.0, 10.0)] * 20
    gens = count // 40 - 1

    class Mine:
        def fitness(self, x: Floats) -> list[float]:
            return [f(x)]

        def get_bounds(self) -> tuple[list[float], list[float]]:
            return [-5.0] * 20, [10.0] * 20

    def peer() -> int:
        population = pygmo.population(pygmo.problem(Mine()), 40, seed=1)
        return pygmo.algorithm(pygmo.de(gen=gens, seed=1, ftol=0.0, xtol=0.0)).evolve(population).problem.get_fevals()

    def deferred() -> int:
        calls = []

        def columns(x: Floats) -> Floats:
            calls.append(x.shape[1])
            return many(x.T)

        differential_evolution(columns, box, maxiter=gens, vectorized=True, updating="deferred", **same)
        return sum(calls)

    same = {"popsize": 2, "tol": 0, "atol": 0, "polish": False, "rng": 1}
    options = {"method": "improved-de", "budget": count, "set": {"patience": 0, "tolerance": 0.0, "stagnation": 0}}
    runs: dict[str, Callable[[], int]] = {
        "scipy differential_evolution": lambda: differential_evolution(f, box, maxiter=gens, **same).nfev,
        "scipy, vectorised": deferred,
        "pygmo de": peer,
        "guideway improved-de": lambda: gw.minimize(f, box, **options).evaluations,
        "guideway improved-de, vectorised": lambda: gw.minimize(many, box, vectorized=True, **options).evaluations,
    }
    table(f"{title}, 20 numbers, {count} evaluations", runs, "scipy differential_evolution")


def table(title: str, runs: dict[str, Callable[[], int]], peer: str) -> None:
    rates = {name: rate(run) for name, run in runs.items()}
    print(f"\n## {title}\n\n| method | evaluations per CPU second | us each | beside {peer} |\n|---|---|---|---|")
    for name, found in rates.items():
        print(f"| {name} | {found:,.0f} | {1e6 / found:.3f} | {found / rates[peer]:.2f} |", flush=True)


def main() -> None:
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--seeds", type=int, default=30)
    words.add_argument("--evaluations", type=int, default=20_000)
    words.add_argument("--scenes", type=int, nargs="*", default=SCENES)
    given = words.parse_args()
    compiled_speed()
    python_speed("A Python function that does nothing: the overhead", nothing, nothing_many)
    python_speed("Rosenbrock function in NumPy", valley, valley_many)
    quality(given.seeds, given.evaluations, given.scenes)
    hinted(given.seeds, given.evaluations, given.scenes)


if __name__ == "__main__":
    main()
