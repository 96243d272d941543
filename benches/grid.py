"""Grid queries from Python beside nano-astar (C++ A*) in the same run: mean times, load times, ratios, and every length compared.

Run with a release build of guideway and `pip install -r benches/requirements.txt`:

    GUIDEWAY_DATA=../shared/data python benches/grid.py [--maps dao/den312d ...] [--large 4000] [--passes 3]

Both answer the same question (8-connected, no corner cutting) on the same rows: the scenario rows of each map thinned to about 150,
and random free pairs on a random map with 20 % blocked. A query's time is CPU time, best of the passes for both. `load` is the time
to make a `World` from the array and to answer a first query from a cell to itself, which builds every table that does not grow with
the queries. The lists of jump points grow with the queries: their cost is in `first`, the mean of our first pass.
"""

from __future__ import annotations

import argparse
import gzip
import math
import os
import time
from pathlib import Path

import nano_astar
import numpy as np

import guideway as gw

MAPS = ["dao/den312d", "cities/Boston_2_512", "mazes/maze512-8-0", "rooms/16room_000", "random/random512-20-0"]
GOALS = {"dao/den312d": 25, "cities/Boston_2_512": 250, "mazes/maze512-8-0": 110, "rooms/16room_000": 32, "random/random512-20-0": 2.3, "random": 2.3}


def lines_of(path: Path) -> list[str]:
    with gzip.open(path, "rt") as file:
        return file.read().split("\n")


def moving_ai(root: Path, name: str):
    """Blocked cells (row 0 on top) and the rows (start, goal as (column, row), optimum)."""
    lines = lines_of(root / f"maps/{name}.map.gz")
    size = {line.split()[0]: int(line.split()[1]) for line in lines[1:3]}
    blocked = np.array([[c not in ".GS" for c in line[: size["width"]]] for line in lines[4 : 4 + size["height"]]])
    fields = [line.split() for line in lines_of(root / f"scen/{name}.map.scen.gz")[1:] if line.strip()]
    rows = [((int(f[4]), int(f[5])), (int(f[6]), int(f[7])), float(f[8])) for f in fields]
    return blocked, rows[:: max(1, len(rows) // 150)]


def random_map(side: int, pairs: int):
    """A random map, 20 % blocked, and pairs of free cells."""
    rng = np.random.default_rng(4000)
    blocked = rng.random((side, side)) < 0.2
    free = np.argwhere(~blocked)
    ends = free[rng.integers(len(free), size=(pairs, 2))]
    return blocked, [(tuple(map(int, a[::-1])), tuple(map(int, b[::-1])), None) for a, b in ends]


def timed(call, rounds: int):
    """Result of the last call, CPU seconds of each."""
    seconds = []
    for _ in range(rounds):
        t = time.process_time_ns()
        result = call()
        seconds.append((time.process_time_ns() - t) * 1e-9)
    return result, seconds


def batch(queries, call, passes: int):
    """Runs all queries pass by pass: results, mean seconds of the first pass, and of the best pass."""
    means, results = [], []
    for _ in range(passes):
        t = time.process_time_ns()
        results = [call(q) for q in queries]
        means.append((time.process_time_ns() - t) * 1e-9 / len(queries))
    return results, means[0], min(means)


def load_world(blocked):
    column, row = (int(v) for v in np.argwhere(~blocked)[0][::-1])

    def load():
        world = gw.World(blocked)
        world.shortest((column, row), (column, row))
        return world

    world, seconds = timed(load, 20 if blocked.size < 1e6 else 3)
    return world, float(np.median(seconds))


def check(name: str, rows, ours, theirs) -> int:
    """Every length against the peer's and the scenario's."""
    for row, mine, peer in zip(rows, ours, theirs, strict=True):
        if (mine is None) != (peer is None):
            raise SystemExit(f"{name} {row}: one finds a path, the other does not")
        if mine is None:
            continue
        points = np.asarray(mine[1], float)
        steps = np.abs(np.diff(points, axis=0))
        length = float((steps.max(axis=1) + (math.sqrt(2) - 1) * steps.min(axis=1)).sum()) if len(steps) else 0.0
        for other in (mine[0], peer[1], row[2]):
            if other is not None and abs(other - length) > 0.01:
                raise SystemExit(f"{name} {row}: length {length}, other {other}")
    return len(rows)


def measure(name: str, blocked, rows, passes: int) -> str:
    """One line of the table."""
    world, load = load_world(blocked)
    spare, _ = load_world(blocked)
    batch(rows, lambda q: spare.shortest(q[0], q[1]), 1)  # Warms up the code, not the tables of the world that is measured.
    occupied = np.ascontiguousarray(blocked.astype(np.uint8))
    mine, first, best = batch(rows, lambda q: world.shortest(q[0], q[1]), passes)
    peers, _, peer = batch([((s[1], s[0]), (g[1], g[0])) for s, g, _ in rows], lambda q: nano_astar.astar(occupied, q[0], q[1]), min(passes, 2))
    count = check(name, rows, mine, peers)
    goal = GOALS.get(name, GOALS["random"] if name.startswith("random") else "")
    us = 1e6
    return (
        f"| {name} | {count} | {peer * us:.1f} | {first * us:.2f} | {best * us:.2f} | {peer / first:.1f} | {peer / best:.1f} | {goal} "
        f"| {load * us:.1f} | {peer / load:.1f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--maps", nargs="*", default=MAPS)
    parser.add_argument("--large", type=int, default=4000, help="side of the large random map; 0 leaves it out")
    parser.add_argument("--pairs", type=int, default=12, help="queries on the large map")
    parser.add_argument("--passes", type=int, default=3)
    args = parser.parse_args()
    root = Path(os.environ.get("GUIDEWAY_DATA", Path(__file__).resolve().parents[1] / "../shared/data")) / "moving_ai"
    print("| map | queries | nano-astar us | ours first us | ours us | ratio first | ratio | goal | load us | nano/load (goal 4) |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name in args.maps:
        print(measure(name, *moving_ai(root, name), args.passes), flush=True)
    if args.large:
        print(measure(f"random {args.large}", *random_map(args.large, args.pairs), min(args.passes, 2)), flush=True)


if __name__ == "__main__":
    main()
