"""Tours through four targets of the 30 x 30 stand-in, static and among movers:
``python experiments/driving/tour.py [--seeds 30] [--docs]``.

Targets 1, 2, 3, 4 in fixed order and in the best one. The moving version: three discs of radius 0.3 to 0.5 m that cross the path at 30, 50 and
70 % of its length at 0.2 to 0.6 m/s, and one that appears on it when the robot is 3 m away.
The robot: a disc of 0.25 m, 1 m/s, 1 m/s2, 2 rad/s, 4 rad/s2.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
from pathlib import Path
from typing import Any

import numpy as np

import guideway as gw
from guideway.driving import Drive

DOCS = Path(__file__).parents[2] / "docs" / "experiments.md"
TARGETS = ((0, 0), (19, 6), (8, 21), (29, 29))
LIMITS = gw.Limits(speed=1.0, acceleration=1.0, deceleration=1.0, jerk=5.0, turn_rate=2.0, turn_acceleration=4.0)
PUBLISHED = {"static": (61.34, 0.64, 54), "moving": (69.02, 0.59, 62)}


def query(world: gw.World, places: list[tuple[float, float]]) -> gw.Query:
    """Through the places in order."""
    return gw.Query(world, places[0], places[-1], via=places[1:-1], footprint={"disc": 0.25}, clearance=0.05, limits=LIMITS)


def motion(asked: gw.Query) -> gw.Trajectory:
    """Exact, smoothed and timed."""
    return gw.time(gw.refine(gw.plan(asked).path, asked).path, LIMITS)


def smoothness(points: np.ndarray) -> float:
    """1 minus the mean turn between headings 1 m apart as a share of a half turn, the path sampled every 0.1 m."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    s = np.concatenate([[0.0], np.cumsum(steps)])
    keep = np.concatenate([[True], steps > 0])
    even = np.stack([np.interp(np.arange(0, s[-1], 0.1), s[keep], points[keep, k]) for k in (0, 1)], axis=1)
    headings = np.arctan2(*np.diff(even, axis=0).T[::-1])[::10]
    turns = np.abs((np.diff(headings) + math.pi) % (2 * math.pi) - math.pi)
    return 1.0 - float(turns.mean()) / math.pi


def movers(path: gw.Path, world: gw.World, seed: int) -> list[dict[str, Any]]:
    """Three that cross and one that appears."""
    rng = np.random.default_rng(seed)
    field, height = world.clearance_field(), world.height
    room = lambda p: field[min(max(height - 1 - int(p[1]), 0), height - 1), min(max(int(p[0]), 0), world.width - 1)]  # noqa: E731
    found = []
    for share in (0.3, 0.5, 0.7):
        radius, speed = rng.uniform(0.3, 0.5), rng.uniform(0.2, 0.6)
        x, y, heading, _ = path.planar([share * path.length])[0]
        across = np.array([-math.sin(heading), math.cos(heading)])
        ends = []
        for side in (1.0, -1.0):
            reach = 0.0
            while reach < 2.0 and room(np.array([x, y]) + side * (reach + 0.1) * across) >= radius:
                reach += 0.1
            ends.append(np.array([x, y]) + side * max(reach, 0.2) * across)
        length = float(np.hypot(*(ends[1] - ends[0])))
        track = [[0.0, *ends[0].tolist()], [length / speed, *ends[1].tolist()]]
        found.append({"shape": {"disc": radius}, "track": track, "loop": "shuttle", "phase": float(rng.uniform(0, 10))})
    x, y, _, _ = path.planar([rng.uniform(0.8, 0.9) * path.length])[0]
    found.append({"shape": {"disc": 0.3}, "track": [[0.0, float(x), float(y)]], "loop": "once", "phase": 0.0, "appears": {"within": 3.0}})
    return found


def run(work: tuple[str, str, int]) -> dict[str, Any]:
    """One tour."""
    kind, order, seed = work
    world = gw.scenes.load("m30").world
    places = [tuple(p) for p in world.cell_centers(TARGETS).tolist()]
    asked = query(world, places)
    if order == "best":
        asked = query(world, [places[0], *[tuple(p) for p in gw.tour(asked)["via"]], places[-1]])
    planned = motion(asked)
    if kind == "moving":
        asked = query(world.with_movers(movers(planned.path, world, seed)), [tuple(p) for p in (asked.start, *asked.via, asked.goal)])
    record = gw.drive(asked, planned, seed=seed)
    driven = np.array(record["driven"])[:, 1:3]
    return {
        "kind": kind,
        "order": order,
        "arrived": record["outcome"] == "arrived",
        "outcome": record["outcome"],
        "unavoidable": bool(record["collision"] and record["collision"]["unavoidable"]),
        "length": record["tracking"]["length"],
        "smoothness": smoothness(driven),
        "replans": record["replans"],
        "time": record["time"],
        "planned": planned.path.length,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    lines = ["| version | order | arrived | length m | planned m | smoothness | replans | time s |", "|---|---|---|---|---|---|---|---|"]
    for kind in ("static", "moving"):
        for order in ("given", "best"):
            some = [row for row in rows if (row["kind"], row["order"]) == (kind, order)]
            if some:
                mean = {name: np.mean([row[name] for row in some]) for name in ("length", "planned", "smoothness", "replans", "time")}
                there = sum(row["arrived"] for row in some)
                lines.append(
                    f"| {kind} | {order} | {there} of {len(some)} | {mean['length']:.2f} | {mean['planned']:.2f} | {mean['smoothness']:.3f} "
                    f"| {mean['replans']:.2f} | {mean['time']:.1f} |"
                )
        length, smooth, _ = PUBLISHED[kind]
        lines.append(f"| {kind} | published (another map) | | {length:.2f} | | {smooth:.2f} | | |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Runs, prints, and writes the docs if asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--docs", action="store_true")
    given = parser.parse_args()
    work = [(kind, order, seed) for kind in ("static", "moving") for order in ("given", "best") for seed in range(given.seeds)]
    with multiprocessing.Pool(given.workers) as pool:
        rows = pool.map(run, work, chunksize=1)
    text = table(rows)
    print(text)
    for row in rows:
        if not row["arrived"]:
            print(row)
    if given.docs:
        made = f"Made by `python experiments/driving/tour.py --seeds {given.seeds} --docs`; controller `{Drive.controller}`.\n\n"
        whole = DOCS.read_text("utf-8")
        begin, end = "<!-- begin tour -->\n", "<!-- end tour -->"
        head, rest = whole.split(begin)
        DOCS.write_text(head + begin + made + text + end + rest.split(end, 1)[1], "utf-8")


if __name__ == "__main__":
    main()
