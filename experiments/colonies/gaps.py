"""Gaps to the exact lattice optimum on random calibrated scenes: seeding and exact fallback off and on, equal evaluations beside others.

python experiments/colonies/gaps.py [--maps 100] [--seeds 30] [--others 10] [--evaluations 5000] [--docs]
"""

from __future__ import annotations

import statistics

import tables
from runs import Method, Row, everything, options

import guideway as gw

NEVER = 10**6
"""An iteration count or patience that never ends a run."""
MOST, WITHIN = 0.02, 0.95
"""Largest gap that may ever be, and the share of runs that must have none, with seeding and fallback off."""
ON, OFF, EQUAL = "seeding and fallback on", "seeding and fallback off", "equal evaluations"


def methods(evaluations: int) -> dict[str, list[Method]]:
    """Those at their default budgets, then those at equal evaluations."""
    off = {"seeding": "off"}
    budget = gw.Budget(evaluations=evaluations)
    swarms = {"iterations": evaluations // 50, "patience": 0}
    ants = {"iterations": NEVER}
    equal = {
        "pso-aco": {**off, "iterations": NEVER, "patience": NEVER},
        "improved-aco": {**off, "iterations": evaluations // 50},
        "bidirectional-aco": {**off, "iterations": NEVER, "patience": NEVER},
        "aco": ants,
        "mmas": ants,
        "pso": swarms,
        "grouped-pso": swarms,
        "ga": swarms,
        "sparrow": swarms,
    }
    names = ["pso-aco", "improved-aco"]
    return {
        OFF: [Method(f"{name}, off", name, off) for name in names],
        ON: [Method(f"{name}, on", name, {}, fallback=True) for name in names],
        EQUAL: [Method(f"{name}, equal", name, parameters, budget) for name, parameters in equal.items()],
    }


def main() -> None:
    parser = options(__doc__.splitlines()[0])
    parser.add_argument("--maps", type=int, default=100, help="maps of each of the two classes (%(default)s)")
    parser.add_argument("--seeds", type=int, default=30, help="seeds with seeding and fallback off (%(default)s)")
    parser.add_argument("--on", type=int, default=30, help="seeds with seeding and fallback on (%(default)s)")
    parser.add_argument("--others", type=int, default=10, help="seeds at equal evaluations (%(default)s)")
    parser.add_argument("--other-maps", type=int, default=100, help="maps of each class at equal evaluations (%(default)s)")
    parser.add_argument("--evaluations", type=int, default=5000, help="paths costed at equal evaluations (%(default)s)")
    asked = parser.parse_args()
    groups = methods(asked.evaluations)
    runs = {OFF: (asked.maps, asked.seeds), EQUAL: (min(asked.maps, asked.other_maps), asked.others), ON: (asked.maps, asked.on)}
    parts = []
    for group, (maps, seeds) in runs.items():
        scenes = [("calibrated", name, seed) for seed in range(maps) for name in ("pso-aco-1", "pso-aco-2")]
        parts += [(scene, method, range(seeds)) for method in groups[group] for scene in scenes]
    rows = everything("gaps", parts, asked.out, asked.workers)
    tables.write_csv(asked.out / "gaps.csv", rows)
    by = {method.name: [row for row in rows if row["method"] == method.name] for members in groups.values() for method in members}
    numbers = f"--maps {asked.maps} --seeds {asked.seeds} --on {asked.on} --others {asked.others} --other-maps {asked.other_maps}"
    words = f"python experiments/colonies/gaps.py {numbers} --evaluations {asked.evaluations} --docs"
    text = "\n".join([table(groups, by), comparison(groups, by), verdicts(by, rows, asked)])
    tables.publish("gaps", words, text, asked.out, asked.docs)


def table(groups: dict[str, list[Method]], by: dict[str, list[Row]]) -> str:
    head = [
        "setting",
        "planner",
        "runs",
        "no path",
        "gap 0 %",
        "Wilson 95 %",
        "<= 2 %",
        "largest gap %",
        "mean gap %",
        "+-",
        "turns above least",
        "evaluations",
        "CPU ms",
        "time ratio",
    ]
    base = statistics.median(row["ms"] for row in by["pso-aco, off"])
    lines = []
    for group, members in groups.items():
        for method in members:
            rows = by[method.name]
            found = [row for row in rows if row["error"] is None]
            hits = sum(row["gap"] == 0 for row in found)
            low, high = tables.wilson(hits, len(rows))
            mean, half = tables.interval([100 * gap for gap in per_map(found, "gap")])
            time = statistics.median(row["ms"] for row in rows)
            near = sum(row["gap"] <= MOST for row in found) / len(rows)
            turns, work = (statistics.mean(row[key] for row in found) for key in ("more_turns", "evaluations"))
            most = max(row["gap"] for row in found)
            counts = [len(rows), len(rows) - len(found), tables.percent(hits / len(rows), 2), f"{100 * low:.1f}-{100 * high:.1f}"]
            gaps = [tables.percent(near, 2), f"{100 * most:.2f}", f"{mean:.3f}", f"{half:.3f}"]
            lines.append([group, f"`{method.planner}`", *counts, *gaps, f"{turns:.2f}", f"{work:.0f}", f"{time:.1f}", f"{time / base:.2f}"])
    return tables.markdown(head, lines)


def per_map(rows: list[Row], name: str) -> list[float]:
    """Mean of each map, so that seeds on one map do not count as independent."""
    of: dict[str, list[float]] = {}
    for row in rows:
        of.setdefault(row["scene"], []).append(row[name])
    return [statistics.mean(values) for values in of.values()]


def comparison(groups: dict[str, list[Method]], by: dict[str, list[Row]]) -> str:
    """Each method at equal evaluations against pso-aco: signed ranks of mean gaps per map, A12 over all runs."""
    names = [method.name for method in groups[EQUAL]]
    ours, others = names[0], names[1:]
    mean = {name: per_map([row for row in by[name] if row["error"] is None], "gap") for name in names}
    corrected = tables.holm([tables.signed_rank(mean[ours], mean[other]) if len(mean[ours]) == len(mean[other]) else 1.0 for other in others])
    gaps = {name: [row["gap"] for row in by[name] if row["error"] is None] for name in names}
    lines = [
        [f"`{other.split(',')[0]}`", f"{tables.a12(gaps[ours], gaps[other]):.3f}", f"{p:.2g}"] for other, p in zip(others, corrected, strict=True)
    ]
    words = (
        "Against `pso-aco` at equal evaluations (A12 above 0.5: the other has larger gaps; Wilcoxon signed ranks of the means per map, after Holm):"
    )
    return f"\n{words}\n\n" + tables.markdown(["planner", "A12", "p"], lines)


def verdicts(by: dict[str, list[Row]], rows: list[Row], asked) -> str:
    checked = [row for row in rows if row["error"] is None]
    failed = sum(not row["ok"] for row in checked)
    lines = [f"Paths under the independent checker: {len(checked)}, failed: {failed}. Runs without a path: {len(rows) - len(checked)}."]
    for name in ("pso-aco", "improved-aco"):
        off, on = by[f"{name}, off"], by[f"{name}, on"]
        share = sum(row.get("gap") == 0 for row in off) / len(off)
        most = max(row.get("gap", 1.0) for row in off)
        says = "holds" if share >= WITHIN and most <= MOST else "does not hold"
        lines.append(f"`{name}`, off: gap 0 in {100 * share:.2f} %, largest {100 * most:.2f} %: {says} (at least 95 %, never above 2 %).")
        zero = sum(row.get("gap") == 0 for row in on)
        fell = sum(bool(row.get("fallback")) for row in on)
        lines.append(
            f"`{name}`, on: gap 0 in {zero} of {len(on)}, the exact path was needed in {fell}: {'holds' if zero == len(on) else 'does not hold'}."
        )
    return "\n" + "\n".join(f"* {line}" for line in lines) + "\n"


if __name__ == "__main__":
    main()
