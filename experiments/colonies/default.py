"""The default preset on the two scenes: hits within 50 + 50 iterations, and with 1 + 1 without seeding; the safest product.

python experiments/colonies/default.py [--seeds 30] [--docs]
"""

from __future__ import annotations

import statistics

import tables
from runs import Method, Row, everything, options

TARGETS = {"pso-aco-1": {"standard": (16, 6, 3), "long": (15, 8, 7)}, "pso-aco-2": {"standard": (14, 10, 6), "long": (10, 18, 13)}}
"""(diagonals, straights, turns) by scene and material."""
OFF = {"seeding": "off"}
METHODS = [
    Method("default", "pso-aco"),
    Method("default, seeding off", "pso-aco", OFF),
    Method("default, 1 + 1, seeding off", "pso-aco", OFF | {"swarm_iterations": 1, "iterations": 1}),
    Method("paper", "pso-aco", {"preset": "paper"}),
    Method("paper, 1 + 1", "pso-aco", {"preset": "paper", "swarm_iterations": 1, "iterations": 1}),
    Method("default, safest", "pso-aco", material="long"),
    Method("default, safest, seeding off", "pso-aco", OFF, material="long"),
    Method("default, safest, 1 + 1, seeding off", "pso-aco", OFF | {"swarm_iterations": 1, "iterations": 1}, material="long"),
    Method("paper, safest", "pso-aco", {"preset": "paper"}, material="long"),
]


def line(method: Method, name: str, rows: list[Row]) -> list[str]:
    want = TARGETS[name][method.material]
    found = [row for row in rows if row["error"] is None]
    lengths = sum((row["diagonals"], row["straights"]) == want[:2] for row in found)
    hits = sum((row["diagonals"], row["straights"], row["turns"]) == want for row in found)
    mean = statistics.mean(row["length"] for row in found)
    turns, last = statistics.mean(row["turns"] for row in found), statistics.mean(row["last"] for row in found)
    return [
        name,
        method.name,
        f"({want[0]}, {want[1]}), {want[2]}",
        f"{lengths}/{len(rows)}",
        f"{hits}/{len(rows)}",
        f"{mean:.4f}",
        f"{turns:.2f}",
        f"{last:.1f}",
    ]


def main() -> None:
    parser = options(__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=30, help="seeds (%(default)s)")
    asked = parser.parse_args()
    parts = [(("scene", name), method, range(asked.seeds)) for name in TARGETS for method in METHODS]
    rows = everything("default", parts, asked.out, asked.workers)
    tables.write_csv(asked.out / "default.csv", rows)
    head = [
        "scene",
        "setting",
        "target (diagonals, straights), turns",
        "length hit",
        "and turns hit",
        "mean length",
        "mean turns",
        "last improvement",
    ]
    of = {key: [row for row in rows if (row["scene"], row["method"]) == key] for key in {(row["scene"], row["method"]) for row in rows}}
    text = tables.markdown(head, [line(method, name, of[f"scene-{name}", method.name]) for name in TARGETS for method in METHODS])
    failed = sum(not row["ok"] for row in rows if row["error"] is None)
    text += f"\nPaths under the independent checker: {sum(row['error'] is None for row in rows)}, failed: {failed}.\n"
    tables.publish("default", f"python experiments/colonies/default.py --seeds {asked.seeds} --docs", text, asked.out, asked.docs)


if __name__ == "__main__":
    main()
