"""What the source leaves out: which part of PSO-ACO helps, on its scenes and on harder maps, preset=paper, equal evaluations.

python experiments/colonies/harder.py [--maps 6] [--seeds 10] [--evaluations 5000] [--docs]
"""

from __future__ import annotations

import statistics

import tables
from runs import Method, Row, everything, options

import guideway as gw

NEVER = 10**6
NEAR = 0.01
"""Gap that counts as reached for the expected evaluations."""


def methods(evaluations: int) -> list[Method]:
    paper, budget = {"preset": "paper"}, gw.Budget(evaluations=evaluations)
    endless = paper | {"iterations": NEVER, "patience": NEVER}
    return [
        Method("pso-aco", "pso-aco", endless, budget),
        Method("bidirectional-aco", "bidirectional-aco", endless, budget),
        Method("grouped-pso", "grouped-pso", paper | {"iterations": evaluations // 80, "patience": 0}, budget),
        Method("aco", "aco", paper | {"iterations": NEVER}, budget),
    ]


def scenes(maps: int) -> dict[str, list[tuple]]:
    kinds: dict[str, list[tuple]] = {"scenes 1 and 2": [("scene", "pso-aco-1"), ("scene", "pso-aco-2")]}
    kinds |= {f"{kind} 30": [("environment", kind, seed, 30) for seed in range(maps)] for kind in ("crowded", "maze")}
    for size, density in ((50, 0.3), (50, 0.5), (70, 0.3)):
        kinds[f"complexity {size}, {density:.0%}"] = [("complexity", size, density, seed) for seed in range(maps)]
    return kinds


def main() -> None:
    parser = options(__doc__.splitlines()[0])
    parser.add_argument("--maps", type=int, default=6, help="maps of each kind (%(default)s)")
    parser.add_argument("--seeds", type=int, default=10, help="seeds (%(default)s)")
    parser.add_argument("--evaluations", type=int, default=5000, help="paths costed (%(default)s)")
    asked = parser.parse_args()
    kinds, compared = scenes(asked.maps), methods(asked.evaluations)
    parts = [(scene, method, range(asked.seeds)) for members in kinds.values() for scene in members for method in compared]
    rows = everything("harder", parts, asked.out, asked.workers)
    tables.write_csv(asked.out / "harder.csv", rows)
    lines = []
    for kind, members in kinds.items():
        names = {"-".join(map(str, scene)) for scene in members}
        lines += of_kind(kind, {method.name: [row for row in rows if row["method"] == method.name and row["scene"] in names] for method in compared})
    head = ["maps", "planner", "runs", "without a path", "gap 0 %", "mean gap %", "+-", "evaluations to 1 %", "A12 against pso-aco", "p"]
    failed = sum(not row["ok"] for row in rows if row["error"] is None)
    text = tables.markdown(head, lines) + f"\nPaths under the independent checker: {sum(row['error'] is None for row in rows)}, failed: {failed}.\n"
    words = f"python experiments/colonies/harder.py --maps {asked.maps} --seeds {asked.seeds} --evaluations {asked.evaluations} --docs"
    tables.publish("harder", words, text, asked.out, asked.docs)


def of_kind(kind: str, by: dict[str, list[Row]]) -> list[list[str]]:
    """A line per planner. A run without a path counts as the worst in ranks and is left out of means."""
    ours = [row.get("gap", 1e9) for row in by["pso-aco"]]
    others = [name for name in by if name != "pso-aco"]
    ranks = {name: [row.get("gap", 1e9) for row in by[name]] for name in others}
    corrected = dict(zip(others, tables.holm([tables.signed_rank(ours, ranks[name]) for name in others]), strict=True))
    lines = []
    for name, rows in by.items():
        gaps = [row["gap"] for row in rows if row["error"] is None]
        near = sum(gap <= NEAR for gap in gaps)
        mean, half = tables.interval([100 * gap for gap in gaps]) if gaps else (float("nan"), float("nan"))
        work = sum(row.get("evaluations", 0) for row in rows)
        expected = f"{work / near:.0f}" if near else "never"
        against = ["", ""] if name == "pso-aco" else [f"{tables.a12(ours, ranks[name]):.2f}", f"{corrected[name]:.2g}"]
        exact = tables.percent(statistics.mean(row.get("gap") == 0 for row in rows))
        lines.append([kind, f"`{name}`", str(len(rows)), str(len(rows) - len(gaps)), exact, f"{mean:.2f}", f"{half:.2f}", expected, *against])
    return lines


if __name__ == "__main__":
    main()
