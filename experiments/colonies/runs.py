"""Runs of planners over scenes and seeds, several at a time: a record per run in a JSON Lines file, so that a stopped experiment goes on.

A scene is named by a tuple: ("scene", name), ("calibrated", class, seed), ("environment", kind, seed, size) or ("complexity", size, density, seed).
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import time
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

import guideway as gw

Row = dict[str, Any]
SQRT2 = math.sqrt(2.0)


@dataclass(frozen=True)
class Method:
    """What is run under a ``name``: planner, parameters, budget, material of the query, exact fallback."""

    name: str
    planner: str
    set: dict[str, Any] = field(default_factory=dict)
    budget: gw.Budget | None = None
    material: str = "standard"
    fallback: bool = False
    refine: str = ""
    """A refinement whose result is measured too."""


@dataclass(frozen=True)
class Part:
    """One method on one scene with some seeds; results go to ``folder``."""

    scene: tuple
    method: Method
    seeds: tuple[int, ...]
    folder: str


def options(about: str) -> argparse.ArgumentParser:
    """The options that all experiments have."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--out", type=Path, default=Path("experiments/results"), help="folder of records, tables and CSV (%(default)s)")
    parser.add_argument("--workers", type=int, default=multiprocessing.cpu_count(), help="processes (%(default)s)")
    parser.add_argument("--docs", action="store_true", help="put the tables into docs/experiments.md")
    return parser


def label(scene: tuple) -> str:
    return "-".join(map(str, scene))


@cache
def grid(scene: tuple, folder: str) -> gw.scenes.GridScene:
    """The scene; those that take long to make are kept in the folder."""
    kind, *words = scene
    if kind == "scene":
        return gw.scenes.load(*words)
    if kind == "environment":
        return gw.scenes.environment(*words)
    if kind == "complexity":
        return gw.scenes.complexity(*words)
    kept = Path(folder) / "scenes" / f"{label(scene)}.txt"
    if not kept.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        beside = kept.with_suffix(f".{multiprocessing.current_process().pid}")
        beside.write_text(gw.scenes.calibrated(*words).text())
        beside.replace(kept)
    blocked = np.array([[c == "#" for c in line] for line in kept.read_text().split()])
    last = len(blocked) - 1
    return gw.scenes.GridScene(words[0], blocked, (0, last), (last, 0), words[1])


@cache
def optimum(scene: tuple, folder: str, material: str) -> tuple[float, int]:
    """Exact shortest length in cells and the fewest turns at it, under the corner rule of the material."""
    of = grid(scene, folder)
    corners = "clear" if material == "long" else "touch"
    found = gw.lattice_optimum(of.world, of.start, of.goal, corners)
    assert found is not None
    return found["diagonals"] * SQRT2 + found["straights"], found["turns"]


def steps_of(cells: np.ndarray) -> tuple[int, int, int]:
    """Diagonal and straight steps and turns of a path of neighbouring cells."""
    steps = np.diff(np.asarray(cells, int), axis=0)
    diagonals = int(np.all(steps != 0, axis=1).sum())
    turns = int(np.any(np.diff(steps, axis=0) != 0, axis=1).sum()) if len(steps) else 0
    return diagonals, len(steps) - diagonals, turns


def last_improvement(history: np.ndarray) -> int:
    """First iteration from which on the best cost is final within 1e-6 of it."""
    final = history[-1][1]
    return int(next(iteration for iteration, cost in history if cost <= final * (1 + 1e-6)))


def run(scene: tuple, method: Method, seed: int, folder: str) -> Row:
    """The record of one run."""
    query = grid(scene, folder).query(material=method.material)
    row: Row = {"scene": label(scene), "method": method.name, "seed": seed, "error": None}
    more = {"exact_fallback": True} if method.fallback else {}
    begun = time.process_time()
    try:
        found = gw.plan(query, planner=method.planner, seed=seed, budget=method.budget, set=method.set or None, **more)
    except gw.GuidewayError as error:
        return row | {"error": type(error).__name__, "ms": 1e3 * (time.process_time() - begun)}
    row["ms"] = 1e3 * (time.process_time() - begun)
    best, fewest = optimum(scene, folder, method.material)
    measured = gw.measure(found.path, query)
    row |= {"length": measured["length"], "turns": measured["turns"], "turning": measured["total_turning"], "smoothness": measured["smoothness"]}
    if found.cells is not None:
        diagonals, straights, turns = steps_of(found.cells)
        length = diagonals * SQRT2 + straights
        gap = 0.0 if abs(length - best) < 1e-9 else length / best - 1
        row |= {"diagonals": diagonals, "straights": straights, "turns": turns, "length": length, "gap": gap, "more_turns": turns - fewest}
    row |= {"energy": row["length"] + 0.5 * row["turns"], "ok": bool(gw.certify(found.path, query)["ok"])}
    row |= {"evaluations": found.evaluations, "iterations": found.iterations, "last": last_improvement(np.asarray(found.history))}
    row["fallback"] = bool(getattr(found, "fallback", False))
    if method.refine:
        refined = gw.refine(found.path, query, method.refine).path
        after = gw.measure(refined, query)
        row |= {f"refined_{name}": after[name] for name in ("length", "turns", "total_turning", "smoothness", "energy")}
        row["ok"] = row["ok"] and bool(gw.certify(refined, query)["ok"])
    return row


def _part(part: Part) -> list[Row]:
    return [run(part.scene, part.method, seed, part.folder) for seed in part.seeds]


def read(path: Path) -> list[Row]:
    """The records of a file; a line that was cut off when a run was stopped does not count."""
    rows = []
    for line in path.read_text().splitlines() if path.exists() else []:
        try:
            rows.append(json.loads(line))
        except ValueError:
            continue
    return rows


def everything(name: str, parts: list[tuple[tuple, Method, range]], out: Path, workers: int) -> list[Row]:
    """Runs what has no record in ``out/NAME.jsonl`` yet and returns the records of all parts, in their order."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"{name}.jsonl"
    have = {(row["scene"], row["method"], row["seed"]): row for row in read(path)}
    todo = []
    for scene, method, seeds in parts:
        missing = tuple(seed for seed in seeds if (label(scene), method.name, seed) not in have)
        if missing:
            todo.append(Part(scene, method, missing, str(out)))
    bar = tqdm(total=sum(len(part.seeds) for part in todo), desc=name, unit="run", disable=None)
    with multiprocessing.Pool(workers) as pool, path.open("a") as file, bar:
        for rows in pool.imap_unordered(_part, todo):
            file.write("".join(json.dumps(row) + "\n" for row in rows))
            file.flush()
            bar.update(len(rows))
            have |= {(row["scene"], row["method"], row["seed"]): row for row in rows}
    return [have[label(scene), method.name, seed] for scene, method, seeds in parts for seed in seeds]
