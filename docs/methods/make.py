"""Draws the pictures of the method pages and measures their figures.

python docs/methods/make.py pictures | colonies | replanning | times | sampling
"""

from __future__ import annotations

import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

import guideway as gw
from guideway import jobs
from guideway.view import figure, search_figure

PICTURES = Path(__file__).resolve().parents[1] / "pictures"
SCENES = {"pso-aco-1": 20, "pso-aco-2": 20, "m20": 20, "m30": 30}
SEEDS = range(1, 31)
PAPER, BARE = {"preset": "paper"}, {"seeding": "off"}
SHOWN = {
    "aco": [("aco", {}, "aco"), ("aco", PAPER, "aco, preset paper")],
    "mmas": [("mmas", {}, "mmas"), ("aco", {}, "aco")],
    "improved-aco": [("improved-aco", BARE, "improved-aco, unseeded"), ("improved-aco", PAPER, "improved-aco, preset paper")],
    "bidirectional-aco": [
        ("bidirectional-aco", BARE, "bidirectional-aco, unseeded"),
        ("bidirectional-aco", PAPER, "bidirectional-aco, preset paper"),
    ],
    "pso-aco": [("pso-aco", PAPER, "pso-aco, preset paper"), ("bidirectional-aco", PAPER, "its ants without the swarm")],
    "pso": [("pso", PAPER, "pso"), ("grouped-pso", PAPER, "grouped-pso")],
    "grouped-pso": [("grouped-pso", PAPER, "grouped-pso"), ("pso", PAPER, "pso")],
    "ga": [("ga", PAPER, "ga"), ("grouped-pso", PAPER, "grouped-pso")],
    "sparrow": [("sparrow", PAPER | {"prune": False}, "sparrow, no pruning"), ("grouped-pso", PAPER, "grouped-pso")],
}
"""What each page's picture compares, on scene:m30 with seed 1; the first is on the map."""
SAMPLED = {
    "rrt-connect": [("rrt-connect", {}, "rrt-connect"), ("rrt-star", {}, "rrt-star")],
    "rrt-star": [("rrt-star", {}, "rrt-star"), ("rrt-star", PAPER, "rrt-star, preset paper")],
    "informed-rrt-star": [("informed-rrt-star", PAPER, "informed-rrt-star, preset paper"), ("rrt-star", PAPER, "rrt-star, preset paper")],
}
"""The same in scene:w0 without what moves."""
BLIND = PAPER | {"scales": False}
SPLINES = {
    "de": [("de", BLIND, "de, no hints"), ("improved-de", BLIND, "improved-de, no hints"), ("de", {}, "de")],
    "improved-de": [("improved-de", BLIND, "improved-de, no hints"), ("de", BLIND, "de, no hints"), ("improved-de", {}, "improved-de")],
    "firefly": [("firefly", BLIND, "firefly, no hints"), ("de", BLIND, "de, no hints"), ("firefly", {}, "firefly")],
    "l-shade": [("l-shade", BLIND, "l-shade, no hints"), ("de", BLIND, "de, no hints"), ("l-shade", {}, "l-shade")],
    "cma-es": [("cma-es", BLIND, "cma-es, no hints"), ("de", BLIND, "de, no hints"), ("cma-es", {}, "cma-es")],
}
"""The same for continuous planners, in scene:w0."""
COLONIES = [
    ("aco", {}), ("aco", PAPER), ("mmas", {}), ("mmas", PAPER), ("bidirectional-aco", {}), ("bidirectional-aco", BARE), ("bidirectional-aco", PAPER),
    ("improved-aco", BARE), ("pso-aco", {}), ("pso-aco", BARE), ("pso-aco", PAPER),
]  # fmt: skip


def corner_job(world: gw.World, planner: str, settings: dict, seed: int = 1) -> jobs.Job:
    """A job from the lower left cell of a square grid to the upper right one."""
    size = world.width * world.resolution
    half = world.resolution / 2
    ends = {"start": (half, half), "goal": (size - half, size - half)}
    return jobs.Job(world, **ends, planner=planner, set=settings, seed=seed, refine="none", timing=False)


def room_job(room: gw.scenes.RoomScene, planner: str, settings: dict, seed: int = 1) -> jobs.Job:
    """The query of a room as a job."""
    query = room.query("static")
    ends = {"start": tuple(query.start), "goal": tuple(query.goal), "clearance": query.clearance, "limits": room.limits}
    return jobs.Job(query.world, **ends, planner=planner, set=settings, seed=seed, refine="none", timing=False)


def put(name: str, written: list[Path]) -> None:
    """The PNG of a figure at the size of a page."""
    image = Image.open(written[0]).convert("RGB")
    image = image.resize((1400, round(1400 * image.height / image.width)), Image.Resampling.LANCZOS)
    image.quantize(255, dither=Image.Dither.NONE).save(PICTURES / f"method-{name}.png", optimize=True)
    print(PICTURES / f"method-{name}.png")


def pictures() -> None:
    """One picture per page."""
    world = gw.World.load("scene:m30")
    with tempfile.TemporaryDirectory() as folder:
        for name, rows in SHOWN.items():
            records = [jobs.run(corner_job(world, planner, settings)).record | {"label": label} for planner, settings, label in rows]
            put(name, search_figure(records, world, Path(folder) / name))
        room = gw.scenes.load("w0")
        for name, rows in SAMPLED.items():
            records = [jobs.run(room_job(room, planner, settings)).record | {"label": label} for planner, settings, label in rows]
            put(name, search_figure(records, room.world("static"), Path(folder) / name))
        still, robot = room.world("static"), gw.Limits(2.0, 5.0, 5.0, 10.0, turn_rate=2.0, lateral_acceleration=2.0)
        for name, rows in SPLINES.items():
            task = partial(jobs.Job, still, (0, 0), (5, 3), clearance=0.3, limits=robot, seed=1, budget=gw.Budget(evaluations=16000))
            records = [jobs.run(task(planner=planner, set=settings)).record | {"label": label} for planner, settings, label in rows]
            put(name, search_figure(records, still, Path(folder) / name))
        put("replanning", replanned(Path(folder) / "replanning"))
        put("sparse-graph", corners(Path(folder) / "sparse-graph"))


def replanned(path: Path) -> list[Path]:
    """A way that is shut, repaired and planned anew."""
    world = gw.World.load("scene:m30")
    first = gw.plan(corner_job(world, "bidirectional-aco", BARE).query(), "bidirectional-aco", seed=1, set=BARE)
    changed = shut(world, first.cells, 6)
    job = corner_job(changed, "bidirectional-aco", BARE)
    query = job.query()
    again = gw.plan(query, "bidirectional-aco", seed=1, set=BARE, previous=first)
    repaired = jobs.finish(job, query, again, ".").record | {"label": "repaired"}
    return search_figure([repaired, jobs.run(job).record | {"label": "planned anew"}], changed, path)


def shut(world: gw.World, cells: np.ndarray, reach: int) -> gw.World:
    """The world with a wall across the middle of a way, ``reach`` cells to either side along the falling diagonal."""
    blocked = np.asarray(world.occupancy()) != 0
    column, row = (int(v) for v in cells[len(cells) // 2])
    for k in range(-reach, reach + 1):
        for x, y in ((column + k, row + k), (column + k, row + k + 1)):
            if 1 <= x < blocked.shape[1] - 1 and 1 <= y < blocked.shape[0] - 1:
                blocked[y, x] = True
    return gw.World(blocked, resolution=world.resolution)


def corners(path: Path) -> list[Path]:
    """Ants on corners beside ants on the lattice, among rooms."""
    blocked = np.zeros((60, 60), bool)
    for wall, doors in ((15, (8, 47)), (30, (22, 40)), (45, (14, 52))):
        blocked[:, wall] = True
        for door in doors:
            blocked[door - 2 : door + 2, wall] = False
    world = gw.World(blocked, resolution=1.0)
    shown = [({"graph": "corners", **BARE}, "graph=corners"), (BARE, "lattice")]
    return figure([jobs.run(corner_job(world, "bidirectional-aco", s)).record | {"label": label} for s, label in shown], world, path)


def turns(cells: np.ndarray) -> int:
    """Changes of heading along cells."""
    steps = np.diff(cells, axis=0)
    return int((np.abs(np.diff(steps, axis=0)).sum(axis=1) > 0).sum())


def colonies() -> None:
    """Runs of 30 that reach the lattice optimum, and also its fewest turns; mean length in cells, mean turns, mean time."""
    worlds = {name: gw.World.load(f"scene:{name}") for name in SCENES}
    exact = {name: gw.plan(corner_job(world, "lexicographic", {}).query(), "lexicographic") for name, world in worlds.items()}
    print("| |", " | ".join(f"{name} ({best.cost:.4f}, {turns(best.cells)})" for name, best in exact.items()), "|")
    print("|---" * (len(SCENES) + 1) + "|")
    for planner, settings in COLONIES:
        row = []
        for name, world in worlds.items():
            runs = [gw.plan(corner_job(world, planner, settings, seed).query(), planner, seed=seed, set=settings) for seed in SEEDS]
            short = [abs(run.cost - exact[name].cost) < 1e-9 for run in runs]
            both = [hit and turns(run.cells) == turns(exact[name].cells) for hit, run in zip(short, runs, strict=True)]
            means = [np.mean([run.cost for run in runs]), np.mean([turns(run.cells) for run in runs])]
            row.append(f"{sum(short)}, {sum(both)}, {means[0]:.4f}, {means[1]:.1f}")
        print(f"| `{' '.join([planner, *(f'{k}={v}' for k, v in settings.items())])}` |", " | ".join(row), "|")


def replanning() -> None:
    """Repairs beside plans from nothing: 30 random maps of 50 x 50 with 20 % blocked, the way shut by two cells or by a wall."""
    print("| shut by | settings | | optimal | mean gap | evaluations | time |\n|---|---|---|---|---|---|---|")
    for reach, what in ((0, "two cells"), (8, "a wall of 17 cells")):
        for settings in ({}, BARE):
            rows = [repair(seed, reach, settings) for seed in SEEDS]
            for k, name in enumerate(("repaired", "planned anew")):
                table = np.array([row[k] for row in rows])
                gap, evaluations, time = table.mean(axis=0)
                hits = int((table[:, 0] < 1e-9).sum())
                said = " ".join(f"{key}={value}" for key, value in settings.items()) or "default"
                print(f"| {what} | {said} | {name} | {hits} of {len(table)} | {100 * gap:.2f} % | {evaluations:.0f} | {time:.0f} ms |")


def repair(seed: int, reach: int, settings: dict) -> list[list[float]]:
    """Gap, evaluations and time (ms) of a repair and of a plan from nothing on one map."""
    blocked = np.random.default_rng(seed).random((50, 50)) < 0.2
    blocked[:4, -4:] = blocked[-4:, :4] = False
    first = gw.plan(corner_job(gw.World(blocked, resolution=1.0), "pso-aco", settings).query(), "pso-aco", seed=seed, set=settings)
    query = corner_job(shut(gw.World(blocked, resolution=1.0), first.cells, reach), "pso-aco", settings).query()
    exact = gw.plan(query, "jump-point").cost
    runs = [gw.plan(query, "pso-aco", seed=seed, set=settings, previous=previous) for previous in (first, None)]
    return [[run.cost / exact - 1, run.evaluations, 1e3 * run.seconds] for run in runs]


def times() -> None:
    """Median time and gap of one plan, exact searches beside colonies."""
    worlds = {name: gw.World.load(f"scene:{name}") for name in ("pso-aco-1", "m30")}
    for size in (100, 300):
        blocked = np.random.default_rng(1).random((size, size)) < 0.25
        blocked[:4, -4:] = blocked[-4:, :4] = False
        worlds[f"random {size}"] = gw.World(blocked, resolution=1.0)
    for planner in ("jump-point", "lexicographic", "visibility", "bidirectional-aco", "pso-aco", "mmas"):
        row = []
        for world in worlds.values():
            query = corner_job(world, planner, {}).query()
            exact = gw.plan(query, "jump-point").cost
            runs = [gw.plan(query, planner, seed=seed) for seed in range(1, 8 if world.width < 300 else 2)]
            gap = np.mean([run.cost for run in runs]) / exact - 1
            row.append(f"{1e3 * np.median([run.seconds for run in runs]):.3g} ms" + (f", {100 * gap:+.2f} %" if abs(gap) > 1e-9 else ""))
        print(f"| `{planner}` |", " | ".join(row), "|")


def sampling() -> None:
    """Solved runs of 30, median and worst gap to the exact optimum and median time, in rooms and a maze, by default and as in the sources."""
    maze = gw.scenes.environment("maze", 1, 30)
    queries = {name: gw.scenes.load(name).query("static") for name in ("w0", "w1")} | {"a maze, 30 x 30": maze.query()}
    print("| |", " | ".join(queries), "|")
    print("|---" * (len(queries) + 1) + "|")
    more = [(name, {"preset": "paper", "samples": 20_000}) for name in ("rrt-star", "informed-rrt-star")]
    for planner, settings in [(name, way) for name in SAMPLED for way in ({}, PAPER)] + more:
        row = []
        for query in queries.values():
            exact = gw.plan(query).cost
            runs = []
            for seed in SEEDS:
                try:
                    runs.append(gw.plan(query, planner, seed=seed, set=settings))
                except gw.NoPath:
                    continue
            gaps = [100 * (run.cost / exact - 1) for run in runs]
            time = 1e3 * np.median([run.seconds for run in runs])
            row.append(f"{len(runs)}, {np.median(gaps):.2f} %, {max(gaps):.2f} %, {time:.2g} ms")
        print(f"| `{' '.join([planner, *(f'{k}={v}' for k, v in settings.items())])}` |", " | ".join(row), "|")


if __name__ == "__main__":
    known = {"pictures": pictures, "colonies": colonies, "replanning": replanning, "times": times, "sampling": sampling}
    if len(sys.argv) != 2 or sys.argv[1] not in known:
        sys.exit(__doc__)
    known[sys.argv[1]]()
