"""What Han and Song 2024 print beside what their settings (preset=paper) give here: two scenes, the comparison, the products.

python experiments/colonies/published.py [--seeds 30] [--evaluations 5000] [--docs]
"""

from __future__ import annotations

import statistics

import tables
from runs import Method, Row, everything, options

import guideway as gw

NEVER = 10**6
PRINTED = {
    "pso-aco-1": {
        "sparrow": ("29.5145 / 32.9661", "6 / 7", "14 / 30"),
        "ga": ("29.7990 / 31.3102", "15 / 16", "22 / 23"),
        "pso": ("31.2100 / 33.4047", "8 / 10", "44 / 71"),
        "pso-aco": ("28.6240 / 28.6240", "3 / 3", "17 / 18"),
        "safest": ("29.2132 (15, 8)", "7", "E 32.7132"),
        "energy": ("28.6540", "4", "E 30.6540"),
    },
    "pso-aco-2": {
        "sparrow": ("30.6861 / 33.2445", "7 / 8", "16 / 27"),
        "ga": ("30.3848 / 32.7061", "15 / 17", "20 / 23"),
        "pso": ("31.5540 / 33.3227", "12 / 14", "63 / 82"),
        "pso-aco": ("29.7960 / 29.7960", "6 / 6", "19 / 21"),
        "safest": ("32.1421 (10, 18)", "13", "E 38.6421"),
        "energy": ("31.3274", "6", "E 34.3274"),
    },
}
"""Best and mean length, turns, iteration of the last improvement, as printed; for products length, turns and energy."""
OTHERS = ("sparrow", "ga", "pso")


def methods(evaluations: int) -> list[Method]:
    paper = {"preset": "paper"}
    budget = gw.Budget(evaluations=evaluations)
    swarm = paper | {"iterations": evaluations // 50, "patience": 0}
    found = [Method(name, name, swarm, budget) for name in OTHERS]
    found += [Method(f"{name}, way points", name, swarm | {"encoding": "way-points"}, budget) for name in ("sparrow", "pso")]
    found += [Method("sparrow, lattice", "sparrow", swarm | {"prune": False}, budget)]
    found += [Method("pso, loops left", "pso", swarm | {"cut": False}, budget)]
    found += [Method("pso-aco", "pso-aco", paper, budget), Method("aco", "aco", paper | {"iterations": NEVER}, budget)]
    found += [Method("safest", "pso-aco", paper, material="long"), Method("energy", "pso-aco", paper, material="heavy", refine="bspline")]
    return found


def main() -> None:
    parser = options(__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=30, help="seeds (%(default)s)")
    parser.add_argument("--evaluations", type=int, default=5000, help="paths costed by each of the compared (%(default)s)")
    asked = parser.parse_args()
    compared = methods(asked.evaluations)
    rows = everything(
        "published", [(("scene", name), method, range(asked.seeds)) for name in PRINTED for method in compared], asked.out, asked.workers
    )
    tables.write_csv(asked.out / "published.csv", rows)
    of = {
        (name, method.name): [row for row in rows if (row["scene"], row["method"]) == (f"scene-{name}", method.name)]
        for name in PRINTED
        for method in compared
    }
    head = [
        "scene",
        "method",
        "printed length best / mean",
        "here",
        "best as (diagonals, straights)",
        "printed turns",
        "here",
        "printed iteration",
        "here",
        "without a path",
    ]
    lines = [line(name, method.name, of[name, method.name]) for name in PRINTED for method in compared if method.name not in ("safest", "energy")]
    text = (
        tables.markdown(head, lines) + "\n" + products(of) + "\n" + "\n".join(f"* {words}" for name in PRINTED for words in verdicts(name, of)) + "\n"
    )
    failed = sum(not row["ok"] for row in rows if row["error"] is None)
    text += f"\nPaths under the independent checker: {sum(row['error'] is None for row in rows)}, failed: {failed}.\n"
    words = f"python experiments/colonies/published.py --seeds {asked.seeds} --evaluations {asked.evaluations} --docs"
    tables.publish("published", words, text, asked.out, asked.docs)


def values(rows: list[Row], name: str) -> list[float]:
    return [row[name] for row in rows if row["error"] is None]


def line(scene: str, name: str, rows: list[Row]) -> list[str]:
    printed = PRINTED[scene].get(name, ("-", "-", "-"))
    found = [row for row in rows if row["error"] is None]
    if not found:
        return [scene, name, printed[0], "-", "-", printed[1], "-", printed[2], "-", str(len(rows))]
    best = min(found, key=lambda row: (row["length"], row["turns"]))
    pair = f"({best['diagonals']}, {best['straights']})" if "diagonals" in best else "any angle"

    def both(key: str, digits: int) -> str:
        return f"{min(row[key] for row in found):.{digits}f} / {statistics.mean(row[key] for row in found):.{digits}f}"

    lasts = f"{best['last']} / {statistics.mean(row['last'] for row in found):.1f}"
    turns = f"{best['turns']} / {statistics.mean(row['turns'] for row in found):.1f}"
    return [scene, name, printed[0], both("length", 4), pair, printed[1], turns, printed[2], lasts, str(len(rows) - len(found))]


def products(of: dict[tuple[str, str], list[Row]]) -> str:
    lines = []
    for scene in PRINTED:
        for name, before in (("safest", ""), ("energy", "refined_")):
            rows, printed = [row for row in of[scene, name] if row["error"] is None], PRINTED[scene][name]
            length, turns, energy = (statistics.mean(row[before + key] for row in rows) for key in ("length", "turns", "energy"))
            shapes = sorted({(row["diagonals"], row["straights"]) for row in rows})
            lines.append([scene, name, ", ".join(printed), f"{length:.4f}, {turns:.2f}, E {energy:.4f}", " ".join(map(str, shapes))])
    return tables.markdown(["scene", "product", "printed: length, turns, energy", "here, means", "lattice (diagonals, straights)"], lines)


def verdicts(scene: str, of: dict[tuple[str, str], list[Row]]) -> list[str]:
    """The acceptance of the comparison, each part with what decides it."""
    lengths = {name: values(of[scene, name], "length") for name in (*OTHERS, "pso-aco")}
    mean = {name: statistics.mean(found) if found else float("inf") for name, found in lengths.items()}
    order = all(mean["pso"] >= mean[name] - 1e-9 for name in ("sparrow", "ga")) and all(
        mean[name] >= mean["pso-aco"] - 1e-9 for name in ("sparrow", "ga")
    )
    effects = {name: tables.a12(lengths["pso-aco"], lengths[name]) for name in OTHERS}
    corrected = tables.holm(
        [tables.signed_rank(lengths["pso-aco"], lengths[name]) if len(lengths[name]) == len(lengths["pso-aco"]) else 1.0 for name in OTHERS]
    )
    turns = {name: statistics.mean(values(of[scene, name], "turns")) for name in ("pso-aco", "ga")}
    hold = ["does not hold", "holds"]
    means = ", ".join(f"`{name}` {value:.4f}" for name, value in mean.items())
    others = ", ".join(f"`{name}` {effect:.2f} (p = {p:.2g})" for (name, effect), p in zip(effects.items(), corrected, strict=True))
    return [
        f"{scene}: order of mean lengths PSO >= SSA, GA >= PSO-ACO {hold[order]}: {means}.",
        f"{scene}: A12 above 0.9 against PSO-ACO {hold[all(effect > 0.9 for effect in effects.values())]}: {others}; Wilcoxon after Holm.",
        f"{scene}: mean turns of PSO-ACO at most GA's {hold[turns['pso-aco'] <= turns['ga']]}: {turns['pso-aco']:.2f} and {turns['ga']:.2f}.",
    ]


if __name__ == "__main__":
    main()
