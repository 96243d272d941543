"""500 random rooms with crossing movers: the improved window beside the classic one, and the default controller under its guarantee.

python experiments/driving/avoidance.py [--scenes 500] [--workers 2] [--out avoidance.jsonl]    # resumes; prints the tables
python experiments/driving/avoidance.py --cases default --scenes 100 --plan-times 0 0.05 0.2 --out waiting.jsonl    # new plans take time
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import multiprocessing
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats
from tqdm import tqdm

import guideway as gw
from guideway.lab import driven as measures
from guideway.lab import movers

Row = dict[str, Any]
Floats = npt.NDArray[np.float64]
DOCS = Path(__file__).parents[2] / "docs" / "experiments.md"
PAPER = {"preset": "paper"}
LITERAL = {"heading": 0.08, "path": 0.45, "aim": 0.1, "room": "least", "clear": True}
CASES: dict[str, tuple[str, dict[str, Any], str]] = {
    "classic": ("dwa", {"safety": 0.35}, "paper"),
    "improved": ("improved-dwa", PAPER, "paper"),
    "no path term": ("improved-dwa", PAPER | {"path": 0.0}, "paper"),
    "classic, centred": ("dwa", {"safety": 0.35, "centred": True}, "paper"),
    "improved, centred": ("improved-dwa", PAPER | {"centred": True}, "paper"),
    "first reading": ("improved-dwa", PAPER | LITERAL, "paper"),
    "default": ("improved-dwa", {}, "default"),
}
"""Controller, its settings, and the robot."""
PAIRS = [("improved", "classic"), ("improved", "no path term"), ("improved, centred", "classic, centred"), ("first reading", "classic")]
"""What is compared on the scenes that both have."""


def driven_into(run: Row, scene: gw.scenes.RoomScene) -> bool:
    """Would a robot that is parked where this one was hit be hit as well: does the mover come towards it?"""
    kind, _, number = run["collision"]["with"].partition(" ")
    if kind != "mover":
        return False
    mover, t = movers.Moving(scene.query().world.movers[int(number)]), run["collision"]["t"]
    before, after = (mover.distance(run["driven"][-1][1:3], t + h) for h in (-0.01, 0.01))
    return not mover.appears and after < before


def driven(task: tuple[int, str, float]) -> Row:
    """One drive."""
    seed, case, wait = task
    controller, settings, robot = CASES[case]
    scene = gw.scenes.crossings(seed, robot)
    path = gw.plan(scene.query("static")).path
    motion = gw.time(gw.refine(path, scene.query("static"), "smooth").path, scene.limits)
    limit = 4 * motion.duration
    run = gw.drive(scene.query(), motion, controller, set=settings, seed=seed, arrival=0.2, time_limit=limit, plan_time=wait)
    hit = run["collision"]
    row = {
        "seed": seed,
        "case": case,
        "outcome": run["outcome"],
        "time": run["time"],
        "planned": motion.duration,
        "replans": run["replans"],
        "plan_time": wait,
    }
    row |= {"moving": bool(hit and not hit["unavoidable"]), "parked": bool(hit and hit["unavoidable"]), "with": hit and hit["with"]}
    row |= {"into": bool(hit and driven_into(run, scene)), "length": run["tracking"]["length"], "still": run["separation"]["static"]}
    row |= {"deviation": measures.deviation(run, scene.query()), "separation": run["separation"]["movers"], "step": run["step_seconds"]["p50"]}
    if case == "default":
        row["way"] = movers.way_exists(scene.query(), limit)
    return row


def wilson(k: int, n: int) -> str:
    """A share with its 95 % interval."""
    z, p = 1.959964, k / max(n, 1)
    middle, half = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return f"{k} of {n} ({100 * max(0.0, middle - half) / (1 + z * z / n):.1f} to {100 * (middle + half) / (1 + z * z / n):.1f} %)"


def mean(values: list[float], digits: int) -> str:
    """The mean, or a dash where there is none."""
    return f"{np.mean(values):.{digits}f}" if values else "-"


def report(rows: list[Row]) -> str:
    """The tables."""
    by = {case: {r["seed"]: r for r in rows if r["case"] == case} for case in CASES}
    by = {case: rows for case, rows in by.items() if rows}
    named = "arrived | hit while moving | of these driven into | hit while parked | hits per 100 m | per arrival | mean time, s"
    lines = [f"| | {named} | mean deviation after avoidance, m |"]
    lines += ["|---" * 9 + "|"]
    for case, all_ in by.items():
        n, some = len(all_), list(all_.values())
        there = [r["time"] for r in some if r["outcome"] == "arrived"]
        off = [r["deviation"] for r in some if r["deviation"] is not None]
        moving, parked = (sum(r[k] for r in some) for k in ("moving", "parked"))
        into = sum(r["into"] and r["moving"] for r in some)
        hits, metres = moving + parked, sum(r["length"] for r in some)
        rates = f"{100 * hits / metres:.2f} | {hits / len(there):.2f}" if there else f"{100 * hits / metres:.2f} | -"
        cells = f"{wilson(len(there), n)} | {wilson(moving, n)} | {into} | {wilson(parked, n)} | {rates}"
        lines.append(f"| {case} | {cells} | {mean(there, 1)} | {mean(off, 3)} |")
    for one, other in PAIRS:
        lines += paired((one, other), by.get(one, {}), by.get(other, {}))
    way = [r for r in by.get("default", {}).values() if r["way"]]
    if way:
        lines += ["", f"default, where a way exists: arrived {wilson(sum(r['outcome'] == 'arrived' for r in way), len(way))}"]
        lines += [f"not arrived: {[(r['seed'], r['outcome']) for r in way if r['outcome'] != 'arrived']}"]
    return "\n".join(lines) + "\n"


def waiting(rows: list[Row], times: list[float]) -> str:
    """What becomes of the same scenes where plans take time; the first is what the others are compared with, where both arrive."""
    lines = ["| case | a new plan takes, s | arrived | hit while moving | hit while parked | new plans | mean time, s | more than the first, s |"]
    lines += ["|---" * 8 + "|"]
    for case in dict.fromkeys(r["case"] for r in rows):
        by = {t: {r["seed"]: r for r in rows if r["case"] == case and r["plan_time"] == t} for t in times}
        for t, all_ in by.items():
            there = {s: r["time"] for s, r in all_.items() if r["outcome"] == "arrived"}
            both = [seconds - by[times[0]][s]["time"] for s, seconds in there.items() if by[times[0]].get(s, {}).get("outcome") == "arrived"]
            counts = " | ".join(wilson(k, len(all_)) for k in (len(there), *(sum(r[hit] for r in all_.values()) for hit in ("moving", "parked"))))
            lines += [f"| {case} | {t:g} | {counts} | {sum(r['replans'] for r in all_.values())} | {mean([*there.values()], 2)} | {mean(both, 2)} |"]
    return "\n".join(lines) + "\n"


def compared(a: Floats, b: Floats) -> str:
    """Means, the paired difference with its 95 % interval, Wilcoxon, and how often a value of the first is the lower one (A12)."""
    d = a - b
    half = float(stats.t.ppf(0.975, len(d) - 1)) * d.std(ddof=1) / math.sqrt(len(d))
    a12 = (np.sum(a[:, None] < b[None]) + 0.5 * np.sum(a[:, None] == b[None])) / len(a) ** 2
    p = float(np.asarray(stats.wilcoxon(a, b))[1])
    change = f"paired difference {d.mean():.3f} m ({d.mean() - half:.3f} to {d.mean() + half:.3f}), median {np.median(d):.3f}"
    return f"{a.mean():.3f} and {b.mean():.3f} m, {change}, Wilcoxon p = {p:.2g}, A12 = {a12:.3f}"


def paired(names: tuple[str, str], new: dict[int, Row], old: dict[int, Row]) -> list[str]:
    """Two cases on the scenes that both have: deviation and what became of the runs (McNemar, exact)."""
    seeds = sorted(new.keys() & old.keys())
    if not seeds:
        return []
    lines = ["", f"**{names[0]} against {names[1]}**, {len(seeds)} scenes", ""]
    met = [s for s in seeds if new[s]["deviation"] is not None and old[s]["deviation"] is not None]
    arrived = [s for s in met if new[s]["outcome"] == old[s]["outcome"] == "arrived"]
    for chosen, what in ((met, "both met a mover"), (arrived, "both arrived")):
        if len(chosen) > 5:
            a, b = np.array([(new[s]["deviation"], old[s]["deviation"]) for s in chosen]).T
            lines += [f"- deviation where {what} ({len(chosen)}): {compared(a, b)}"]
    for name, test in (
        ("hit", lambda r: r["moving"] or r["parked"]),
        ("hit while moving", lambda r: r["moving"]),
        ("hit while moving, not driven into", lambda r: r["moving"] and not r["into"]),
        ("hit while parked", lambda r: r["parked"]),
        ("arrived", lambda r: r["outcome"] == "arrived"),
    ):
        one, other = (sum(test(x[s]) and not test(y[s]) for s in seeds) for x, y in ((new, old), (old, new)))
        if one + other:
            p = stats.binomtest(one, one + other).pvalue
            lines += [f"- {name}: only the first {one}, only the second {other}, McNemar p = {p:.2g}"]
    return lines


def write_docs(text: str, cases: list[str]) -> None:
    """Puts the tables into docs/experiments.md."""
    begin, end = "<!-- begin avoidance -->\n", "<!-- end avoidance -->"
    head, rest = DOCS.read_text("utf-8").split(begin)
    made = f"Made by `python experiments/driving/avoidance.py --cases {' '.join(c if c.isidentifier() else repr(c) for c in cases)} --docs`.\n\n"
    DOCS.write_text(head + begin + made + text + end + rest.split(end, 1)[1], "utf-8")


def main() -> None:
    """Drives what is not there yet and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=500)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--cases", nargs="*", default=list(CASES))
    parser.add_argument("--plan-times", nargs="+", type=float, default=[0.0], metavar="S", help="how long new plans take, s")
    parser.add_argument("--out", type=Path, default=Path("avoidance.jsonl"))
    parser.add_argument("--docs", action="store_true", help="put the tables into docs/experiments.md")
    given = parser.parse_args()
    lines = given.out.read_text().splitlines() if given.out.exists() else []
    rows: list[Row] = [json.loads(line) for line in lines]
    done = {(r["seed"], r["case"], r.setdefault("plan_time", 0.0)) for r in rows}
    tasks = [task for task in itertools.product(range(given.scenes), given.cases, given.plan_times) if task not in done]
    with multiprocessing.get_context("spawn").Pool(given.workers) as pool, given.out.open("a") as out:
        for row in tqdm(pool.imap_unordered(driven, tasks), total=len(tasks), disable=None):
            out.write(json.dumps(row) + "\n")
            out.flush()
            rows.append(row)
    rows = [r for r in rows if r["case"] in given.cases]
    if given.plan_times != [0.0]:
        print(waiting(rows, given.plan_times))
        return
    text = report([r for r in rows if r["plan_time"] == 0.0])
    print(text)
    if given.docs:
        write_docs(text, given.cases)


if __name__ == "__main__":
    main()
