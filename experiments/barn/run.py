"""Every world of BARN or DynaBARN, driven by lidar, scored as the BARN challenge does: our own kinematic simulation, not Gazebo.

    python experiments/barn/run.py --map none
    python experiments/barn/run.py --map known
    python experiments/barn/run.py --collection dynabarn

A record per run in a JSON Lines file: a stopped experiment goes on where it was.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import json
import math
import multiprocessing
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from tqdm import tqdm

import guideway as gw
from guideway import driving, jobs
from guideway.commands.plan import job_of_scene
from guideway.io.collections import find_collection, load_collection, world_numbers
from guideway.io.types import Footprint, Mover, Scene

Row = dict[str, Any]

LIMIT = 100.0
JUMP = 1.0  # s after a jump of an obstacle within which a hit is listed apart
MOMENT = 1e-4  # s, that the time of a hit may be off
REST = 0.01  # m/s and rad/s, below which a robot is at rest
FASTEST = 2.0  # m/s, of the optimal time


@dataclass(frozen=True)
class Part:
    """One run."""

    file: str
    kind: str
    world: int
    seed: int
    map: str
    controller: str
    set: str
    mover_speed: float | None = None
    plan_time: float = 0.0


@cache
def reference_lengths(file: str) -> dict[int, float]:
    """Length (m) of the reference path of each world of BARN, joined to start and goal."""
    table = Path(file).with_name("barn_reference_paths.csv")
    with table.open() as lines:
        return {int(row["world"]): float(row["path_length_start_m2.25"]) for row in csv.DictReader(lines)}


def optimal_time(part: Part, scene: Scene) -> float:
    """OT of the score, s: the reference path (DynaBARN: the straight line) at 2 m/s."""
    if part.kind == "barn":
        return reference_lengths(part.file)[part.world] / FASTEST
    query = scene.query
    if query is None or query.start is None or query.goal is None:
        raise SystemExit(f"{part.file}#{part.world} has no start or goal")
    return math.dist(query.start, query.goal) / FASTEST


def run(part: Part) -> Row:
    """One drive and its score."""
    scene = load_collection(f"{part.file}#{part.world}")
    if scene.query is None or scene.lidar is None:
        raise SystemExit(f"{part.file}#{part.world} has no query or no lidar")
    job = job_of_scene(scene)
    query = job.query()
    if part.map == "none":
        job.world = driving.unseen(job.world)
    begun = time.perf_counter()
    drive = driving.Drive(query, motion(job), job.limits, planner=job.planner, seed=part.seed, time_limit=scene.query.time_limit)
    drive.arrival, drive.stop_at_goal = scene.query.arrival, scene.query.stop
    drive.sense, drive.lidar, drive.map = "lidar", scene.lidar.to_dict(), part.map
    drive.mover_speed = scene.mover_speed if part.mover_speed is None else part.mover_speed
    drive.plan_time = part.plan_time
    if part.controller:
        drive.controller = part.controller
    drive.set = json.loads(part.set)
    record = driving.run(drive)
    return {"world": part.world, "seed": part.seed} | scored(part, scene, record) | {"wall": time.perf_counter() - begun}


def motion(job: jobs.Job) -> gw.Trajectory:
    """The first motion."""
    outcome = jobs.run(job)
    if outcome.trajectory is None:
        raise SystemExit("there is no motion in time")
    return outcome.trajectory


def scored(part: Part, scene: Scene, record: Row) -> Row:
    """The score of a run and what became of it."""
    best, t, outcome = optimal_time(part, scene), record["time"], record["outcome"]
    success = outcome == "arrived" and t < LIMIT
    hit = record["collision"]
    row: Row = {"outcome": outcome, "time": t, "score": best / min(max(t, 2 * best), 8 * best) if success else 0.0, "success": success}
    row |= {"length": record["tracking"]["length"], "replans": record["replans"], "separation": record["min_separation"]}
    row |= {"p50": record["step_seconds"]["p50"], "p99": record["step_seconds"]["p99"], "hit": None, "with": None, "jump": False, "turning": False}
    if hit is not None:
        row |= {"hit": "parked" if at_rest(record, hit["t"]) else "moving", "with": hit["with"], "jump": after_jump(scene, hit)}
        row["turning"] = row["hit"] == "moving" and met_parked(scene, record, hit)
    return row


def at_rest(record: Row, t: float) -> bool:
    """Was the robot at rest when it was hit?"""
    row = next(state for state in reversed(record["driven"]) if state[0] <= t + 1e-9)
    return abs(row[4]) < REST and abs(row[5]) < REST


def met_parked(scene: Scene, record: Row, hit: Row) -> bool:
    """Did it stand and only turn when it was hit, by a mover that would have run into it within a second had it stayed parked as it came to stand?"""
    kind, _, number = hit["with"].partition(" ")
    driven = [row for row in record["driven"] if row[0] <= hit["t"] + 1e-9]
    stood = list(itertools.takewhile(lambda row: abs(row[4]) < REST, reversed(driven)))
    if kind != "mover" or not stood:
        return False
    (since, *pose), mover = stood[-1][:4], scene.movers[int(number)]
    moments = (min(since + 0.005 * k, hit["t"] + JUMP) for k in range(math.ceil((hit["t"] + JUMP - since) / 0.005) + 1))
    return any(gap(scene.robot.footprint, pose, mover.shape, place(mover, t)) <= 0.0 for t in moments)


def gap(body: Footprint, pose: Sequence[float], disc: Footprint, at: tuple[float, float]) -> float:
    """Distance (m) of a disc or box at a pose to a disc at a place."""
    if disc.disc is None or (body.disc is None and body.box is None):
        raise SystemExit("hits are told apart for robots that are discs or boxes, among discs")
    (x, y, yaw), half = pose, tuple(0.5 * side for side in body.box or (0.0, 0.0))
    dx, dy, c, s = at[0] - x, at[1] - y, math.cos(yaw), math.sin(yaw)
    beside = (max(abs(c * dx + s * dy) - half[0], 0.0), max(abs(c * dy - s * dx) - half[1], 0.0))
    return math.hypot(*beside) - disc.disc - (body.disc or 0.0)


def place(mover: Mover, t: float) -> tuple[float, float]:
    """Where a mover that begins anew at the end of its track is at a time, m."""
    if mover.loop != "cycle":
        raise SystemExit(f"a mover that begins anew is expected, not {mover.loop}")
    t = (t + mover.phase) % mover.track[-1][0]
    for (t0, x0, y0), (t1, x1, y1) in itertools.pairwise(mover.track):
        if t <= t1:
            share = (t - t0) / (t1 - t0)
            return x0 + share * (x1 - x0), y0 + share * (y1 - y0)
    return mover.track[-1][1:]


def after_jump(scene: Scene, hit: Row) -> bool:
    """Was it hit by an obstacle that had jumped within the last second?"""
    kind, _, number = hit["with"].partition(" ")
    if kind != "mover":
        return False
    mover = scene.movers[int(number)]
    (_, *first), (period, *last) = mover.track[0], mover.track[-1]
    return mover.loop == "cycle" and math.dist(first, last) > 0.05 and hit["t"] >= period and (hit["t"] + mover.phase + MOMENT) % period <= JUMP


def read(path: Path) -> list[Row]:
    """The records of a file; a line that was cut off when a run was stopped does not count."""
    rows = []
    for line in path.read_text().splitlines() if path.exists() else []:
        try:
            rows.append(json.loads(line))
        except ValueError:
            continue
    return rows


def drive_all(parts: list[Part], path: Path, workers: int) -> list[Row]:
    """Runs what the file does not hold yet; all rows in order."""
    done = {(row["world"], row["seed"]) for row in read(path)}
    todo = [part for part in parts if (part.world, part.seed) not in done]
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as out, multiprocessing.Pool(workers) as pool:
        for row in tqdm(pool.imap_unordered(run, todo), total=len(todo), disable=None):
            out.write(json.dumps(row) + "\n")
            out.flush()
    wanted = {(part.world, part.seed) for part in parts}
    return sorted((row for row in read(path) if (row["world"], row["seed"]) in wanted), key=lambda row: (row["world"], row["seed"]))


def summary(name: str, rows: list[Row]) -> str:
    """One row of the table."""
    n = len(rows)
    moving = sum(row["hit"] == "moving" and not row["jump"] for row in rows)
    turning = sum(row.get("turning", False) and not row["jump"] for row in rows)
    parked = sum(row["hit"] == "parked" and not row["jump"] for row in rows)
    jumps = sum(row["jump"] for row in rows)
    late = sum(row["outcome"] in ("timeout", "stuck") for row in rows)
    arrived = [row["time"] for row in rows if row["success"]]
    mean_time = f"{sum(arrived) / len(arrived):.1f}" if arrived else "-"
    score, success = sum(row["score"] for row in rows) / n, sum(row["success"] for row in rows) / n
    worst = 1e3 * max(row["p99"] for row in rows)
    return f"| {name} | {n} | {score:.4f} | {100 * success:.1f} % | {moving} | {turning} | {parked} | {jumps} | {late} | {mean_time} | {worst:.2f} |"


COLUMNS = [
    "worlds, map",
    "runs",
    "score",
    "success",
    "hits moving",
    "of these parked too",
    "hits parked",
    "after a jump",
    "late or stuck",
    "mean time s",
]
COLUMNS += ["worst p99 of a step ms"]
HEAD = f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|"


def main() -> None:
    """Drives, prints the table, and puts it into the docs where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--collection", choices=["barn", "dynabarn"], default="barn")
    parser.add_argument("--worlds", metavar="FILE", help="the file of the collection (default: in GUIDEWAY_DATA)")
    parser.add_argument("--map", choices=["none", "known"], default="none")
    parser.add_argument("--seeds", type=int, default=3, metavar="N")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="every N-th world")
    parser.add_argument("--only", type=int, nargs="+", metavar="N", help="these worlds")
    parser.add_argument("--controller", default="", metavar="NAME")
    parser.add_argument("--set", default="{}", metavar="JSON", help="parameters of the controller")
    parser.add_argument("--mover-speed", type=float, metavar="V", help="top speed of what moves, m/s (default: that of the collection)")
    parser.add_argument("--plan-time", type=float, default=0.0, metavar="S", help="how long new plans take, s")
    parser.add_argument("--workers", type=int, default=multiprocessing.cpu_count(), metavar="N")
    parser.add_argument("--out", type=Path, default=Path("experiments/results/barn"), metavar="FOLDER")
    parser.add_argument("--docs", action="store_true", help="put the tables into docs/experiments.md")
    asked = parser.parse_args()
    file = str(find_collection(asked.collection, asked.worlds))
    worlds = asked.only or world_numbers(file)[:: asked.every]
    kind = (asked.map, asked.controller, asked.set, asked.mover_speed, asked.plan_time)
    parts = [Part(file, asked.collection, w, s, *kind) for s in range(asked.seeds) for w in worlds]
    late = f"-{asked.plan_time:g}" if asked.plan_time else ""
    rows = drive_all(parts, asked.out / f"{asked.collection}-{asked.map}{late}.jsonl", asked.workers)
    line = summary(f"{asked.collection.replace('dyna', 'Dyna').replace('barn', 'BARN')}, {asked.map}", rows)
    print(f"{HEAD}\n{line}")
    for row in rows:
        if not row["success"]:
            print(f"world {row['world']} seed {row['seed']}: {row['outcome']} after {row['time']:.1f} s {row['with'] or ''} {row['hit'] or ''}")
    if asked.docs:
        write_docs(f"{asked.collection}-{asked.map}", line)


def write_docs(name: str, line: str) -> None:
    """Replaces the row of the table in the docs."""
    path = Path("docs/experiments.md")
    text = path.read_text()
    begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->"
    head, _, rest = text.partition(begin)
    _, mark, tail = rest.partition(end)
    if not mark:
        raise SystemExit(f"{path} has no place for {name}")
    path.write_text(f"{head}{begin}{HEAD}\n{line}\n{mark}{tail}")


if __name__ == "__main__":
    main()
