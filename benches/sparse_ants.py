"""Ants on the corners of obstacles beside the exact any-angle optimum: gap and time on public maps, seeding and fallback off.

Run with a release build of guideway:

    GUIDEWAY_DATA=../shared/data python benches/sparse_ants.py [--seeds 10] [--queries 30] [--planner improved-aco] [--radius 0.3]

Queries: of each Moving AI scenario the longest row and random ones; in the warehouse random pairs of free places, the longer half of
twice as many. The robot is a point; with `--radius` (m, warehouse only) it is a disc as well. One thread. Times are wall-clock and CPU
times of one call of the planner, the world being loaded and asked once before. Every path goes through the checker.
"""

from __future__ import annotations

import argparse
import gzip
import os
import random
import time
from pathlib import Path

import numpy as np

import guideway as gw

ROOT = Path(__file__).resolve().parents[1]
MAPS = ["dao/den312d", "dao/brc202d", "bg512/AR0011SR"]


def moving_ai(root: Path, name: str, count: int):
    """The world, the longest row of the scenario and random ones, as queries."""
    with gzip.open(root / f"moving_ai/maps/{name}.map.gz", "rt") as file:
        lines = file.read().split("\n")
    size = {line.split()[0]: int(line.split()[1]) for line in lines[1:3]}
    world = gw.World(np.array([[c not in ".GS" for c in line[: size["width"]]] for line in lines[4 : 4 + size["height"]]]))
    with gzip.open(root / f"moving_ai/scen/{name}.map.scen.gz", "rt") as file:
        rows = [line.split() for line in file.read().split("\n")[1:] if line.strip()]
    rows.sort(key=lambda row: float(row[8]))
    chosen = [rows[-1], *random.Random(0).sample(rows, min(count, len(rows)))]

    def point(x: str, y: str):
        return (int(x) + 0.5, size["height"] - int(y) - 0.5)

    return [gw.Query(world, point(r[4], r[5]), point(r[6], r[7])) for r in chosen]


def warehouse(count: int, radius: float):
    """Random pairs of free places, the longer half of twice as many."""
    world = gw.World.load(ROOT / "python/guideway/data/warehouse.yaml")
    draw, (x0, y0, x1, y1), queries = random.Random(0), world.bounds, []
    while len(queries) < 2 * count:
        ends = [(draw.uniform(x0, x1), draw.uniform(y0, y1)) for _ in range(2)]
        query = gw.Query(world, *ends, footprint=gw.Disc(radius))
        try:
            queries.append((gw.plan(query, planner="visibility", seed=0).cost, len(queries), query))
        except gw.GuidewayError:
            continue
    queries.sort(reverse=True)
    return [query for _, _, query in queries[: count + 1]]


def measure(queries, planner: str, seeds: int, parameters: dict):
    """Of every query and seed: gap, wall-clock and CPU time (s)."""
    rows, faults = [], 0
    for query in queries:
        optimum = gw.plan(query, planner="visibility", seed=0).cost
        for seed in range(seeds):
            wall, cpu = time.perf_counter(), time.process_time()
            found = gw.plan(query, planner=planner, seed=seed, set=parameters)
            rows.append((found.cost / max(optimum, 1e-12) - 1.0, time.perf_counter() - wall, time.process_time() - cpu))
            faults += not gw.certify(found.path, query)["ok"]
    return np.array(rows), faults


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--queries", type=int, default=30)
    parser.add_argument("--planner", default="improved-aco")
    parser.add_argument("--radius", type=float, default=0.3)
    parser.add_argument("--set", nargs="*", default=[], metavar="NAME=VALUE")
    given = parser.parse_args()
    root = Path(os.environ.get("GUIDEWAY_DATA", ROOT.parent / "shared/data"))
    parameters = {"graph": "corners", "seeding": "off"} | {k: float(v) if v[0].isdigit() else v for k, v in (s.split("=") for s in given.set)}
    cases = {name: lambda name=name: moving_ai(root, name, given.queries) for name in MAPS} if (root / "moving_ai").exists() else {}
    cases["warehouse, point"] = lambda: warehouse(given.queries, 0.0)
    cases[f"warehouse, disc of {given.radius} m"] = lambda: warehouse(given.queries, given.radius)
    print(f"{given.planner} with graph=corners, {given.seeds} seeds, one thread\n")
    print("| map | runs | optimum | gap, mean | largest | <= 1 % | time, median | largest | CPU, largest | collisions |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name, queries in cases.items():
        rows, faults = measure(queries(), given.planner, given.seeds, parameters)
        gap, wall, cpu = rows.T
        shares = f"{np.mean(gap <= 1e-9):.0%} | {gap.mean():.3%} | {gap.max():.2%} | {np.mean(gap <= 0.01):.1%}"
        print(f"| {name} | {len(gap)} | {shares} | {np.median(wall):.3f} s | {wall.max():.3f} s | {cpu.max():.3f} s | {faults} |", flush=True)


if __name__ == "__main__":
    main()
