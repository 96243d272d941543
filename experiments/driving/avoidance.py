"""500 random rooms with crossing movers: the improved window beside the classic one, and the default controller under its guarantee.

python experiments/driving/avoidance.py [--scenes 500] [--workers 2] [--out avoidance.jsonl]    # resumes; prints the tables
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage, stats
from tqdm import tqdm

import guideway as gw

Row = dict[str, Any]
DOCS = Path(__file__).parents[2] / "docs" / "experiments.md"
PAPER = {"preset": "paper"}
CASES: dict[str, tuple[str, dict[str, Any], str]] = {
    "classic": ("dwa", {"safety": 0.35}, "paper"),
    "improved": ("improved-dwa", PAPER, "paper"),
    "default": ("improved-dwa", {}, "default"),
}
"""Controller, its settings, and the robot."""
CELL, TICK, RADIUS = 0.1, 0.1, 0.2
NEAR = 1.5
"""A mover nearer than this, m, is avoided."""


def way_exists(scene: gw.scenes.RoomScene, limit: float) -> bool:
    """Is there a way in space and time for a point that goes 0.1 m in 0.1 s, or waits, among the true motions? What appears is there all along."""
    x0, y0, x1, y1 = scene.scene.bounds
    xs, ys = np.arange(x0, x1 + 1e-9, CELL), np.arange(y0, y1 + 1e-9, CELL)
    px, py = np.meshgrid(xs, ys, indexing="ij")
    free = np.ones(px.shape, bool)
    for x, y, r in scene.discs:
        free &= np.hypot(px - x, py - y) >= r + RADIUS
    query = scene.query()
    at = tuple(round((query.start[k] - (x0, y0)[k]) / CELL) for k in (0, 1))
    goal = np.hypot(px - query.goal[0], py - query.goal[1]) <= 0.2
    reached = np.zeros(px.shape, bool)
    reached[at] = True
    cross = ndimage.generate_binary_structure(2, 1)
    for k in range(round(limit / TICK) + 1):
        open_now = free.copy()
        for mover in scene.scene.movers:
            x, y = place(mover, k * TICK)
            open_now &= np.hypot(px - x, py - y) >= (mover.shape.disc or 0.0) + RADIUS
        reached &= open_now
        if (reached & goal).any():
            return True
        reached = ndimage.binary_dilation(reached, cross)
    return False


def place(mover: Any, t: float) -> tuple[float, float]:
    """Where a mover is."""
    track = mover.track
    period = track[-1][0]
    if period == 0:
        return track[0][1], track[0][2]
    u = (t + mover.phase) % (2 * period)
    r = (u if u <= period else 2 * period - u) / period
    return track[0][1] + r * (track[-1][1] - track[0][1]), track[0][2] + r * (track[-1][2] - track[0][2])


def deviation(run: Row, scene: gw.scenes.RoomScene) -> float | None:
    """Mean distance (m) of the driven path from the first plan, from the nearest approach to the first avoided mover on."""
    line = np.array(run["plan"]["polyline"])
    driven = np.array(run["driven"])[::5]
    gaps = [
        min(math.dist(place(m, t), (x, y)) - (m.shape.disc or 0.0) - RADIUS for m in scene.scene.movers if m.appears is None)
        for t, x, y in driven[:, :3]
    ]
    met = [i for i in range(1, len(gaps) - 1) if gaps[i] < NEAR and gaps[i] <= gaps[i - 1] and gaps[i] <= gaps[i + 1]]
    if not met:
        return None
    p, a, b = driven[met[0] :, None, 1:3], line[None, :-1], line[None, 1:]
    e = b - a
    r = np.clip(((p - a) * e).sum(-1) / np.maximum((e * e).sum(-1), 1e-12), 0, 1)
    return float(np.hypot(*np.moveaxis(p - a - r[..., None] * e, -1, 0)).min(1).mean())


def driven(task: tuple[int, str]) -> Row:
    """One drive."""
    seed, case = task
    controller, settings, robot = CASES[case]
    scene = gw.scenes.crossings(seed, robot)
    path = gw.plan(scene.query("static")).path
    motion = gw.time(gw.refine(path, scene.query("static"), "smooth").path, scene.limits)
    limit = 4 * motion.duration
    run = gw.drive(scene.query(), motion, controller, set=settings, seed=seed, arrival=0.2, time_limit=limit)
    hit = run["collision"]
    row = {"seed": seed, "case": case, "outcome": run["outcome"], "time": run["time"], "planned": motion.duration, "replans": run["replans"]}
    row |= {"moving": bool(hit and not hit["unavoidable"]), "parked": bool(hit and hit["unavoidable"])}
    row |= {"deviation": deviation(run, scene), "separation": run["separation"]["movers"], "step": run["step_seconds"]["p50"]}
    if case == "default":
        row["way"] = way_exists(scene, limit)
    return row


def wilson(k: int, n: int) -> str:
    """A share with its 95 % interval."""
    z, p = 1.959964, k / max(n, 1)
    middle, half = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return f"{k} of {n} ({100 * (middle - half) / (1 + z * z / n):.1f} to {100 * (middle + half) / (1 + z * z / n):.1f} %)"


def mean(values: list[float], digits: int) -> str:
    """The mean, or a dash where there is none."""
    return f"{np.mean(values):.{digits}f}" if values else "-"


def report(rows: list[Row]) -> str:
    """The tables."""
    by = {case: {r["seed"]: r for r in rows if r["case"] == case} for case in CASES}
    by = {case: rows for case, rows in by.items() if rows}
    lines = ["| | arrived | hit while moving | hit while parked | mean time, s | mean deviation after avoidance, m |", "|---|---|---|---|---|---|"]
    for case, all_ in by.items():
        n, some = len(all_), list(all_.values())
        there = [r["time"] for r in some if r["outcome"] == "arrived"]
        off = [r["deviation"] for r in some if r["deviation"] is not None]
        shares = [wilson(sum(r[k] for r in some), n) for k in ("moving", "parked")]
        lines.append(f"| {case} | {wilson(len(there), n)} | {shares[0]} | {shares[1]} | {mean(there, 1)} | {mean(off, 3)} |")
    lines += paired(by.get("improved", {}), by.get("classic", {}))
    way = [r for r in by.get("default", {}).values() if r["way"]]
    if way:
        lines += ["", f"default, where a way exists: arrived {wilson(sum(r['outcome'] == 'arrived' for r in way), len(way))}"]
        lines += [f"not arrived: {[(r['seed'], r['outcome']) for r in way if r['outcome'] != 'arrived']}"]
    return "\n".join(lines) + "\n"


def paired(new: dict[int, Row], old: dict[int, Row]) -> list[str]:
    """The two windows on the scenes that both have: deviation (Wilcoxon, A12) and what became of the runs (McNemar, exact)."""
    lines, seeds = [""], sorted(new.keys() & old.keys())
    both = [(new[s]["deviation"], old[s]["deviation"]) for s in seeds if new[s]["deviation"] is not None and old[s]["deviation"] is not None]
    if both:
        a, b = np.array(both).T
        a12 = (np.sum(a[:, None] < b[None]) + 0.5 * np.sum(a[:, None] == b[None])) / len(a) ** 2
        p = float(np.asarray(stats.wilcoxon(a, b))[1])
        lines += [
            f"improved against classic, {len(both)} scenes: deviation {a.mean():.3f} and {b.mean():.3f} m, Wilcoxon p = {p:.2g}, A12 = {a12:.3f}",
            "",
        ]
    for name, test in (
        ("hit", lambda r: r["moving"] or r["parked"]),
        ("hit while moving", lambda r: r["moving"]),
        ("arrived", lambda r: r["outcome"] == "arrived"),
    ):
        one, other = (sum(test(x[s]) and not test(y[s]) for s in seeds) for x, y in ((new, old), (old, new)))
        if one + other:
            p = stats.binomtest(one, one + other).pvalue
            lines += [f"{name}: only improved {one}, only classic {other} of {len(seeds)} scenes, McNemar p = {p:.2g}", ""]
    return lines


def write_docs(text: str, cases: list[str]) -> None:
    """Puts the tables into docs/experiments.md."""
    begin, end = "<!-- begin avoidance -->\n", "<!-- end avoidance -->"
    head, rest = DOCS.read_text("utf-8").split(begin)
    made = f"Made by `python experiments/driving/avoidance.py --cases {' '.join(cases)} --docs`.\n\n"
    DOCS.write_text(head + begin + made + text + end + rest.split(end, 1)[1], "utf-8")


def main() -> None:
    """Drives what is not there yet and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=500)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--cases", nargs="*", default=list(CASES))
    parser.add_argument("--out", type=Path, default=Path("avoidance.jsonl"))
    parser.add_argument("--docs", action="store_true", help="put the tables into docs/experiments.md")
    given = parser.parse_args()
    lines = given.out.read_text().splitlines() if given.out.exists() else []
    rows: list[Row] = [json.loads(line) for line in lines]
    done = {(r["seed"], r["case"]) for r in rows}
    tasks = [(s, c) for s in range(given.scenes) for c in given.cases if (s, c) not in done]
    with multiprocessing.get_context("spawn").Pool(given.workers) as pool, given.out.open("a") as out:
        for row in tqdm(pool.imap_unordered(driven, tasks), total=len(tasks), disable=None):
            out.write(json.dumps(row) + "\n")
            out.flush()
            rows.append(row)
    text = report(rows)
    print(text)
    if given.docs:
        write_docs(text, given.cases)


if __name__ == "__main__":
    main()
