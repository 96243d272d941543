"""Convergence and smoothness of the improved colony beside MMAS and ACO with the settings of Lu and others 2025 (preset=paper).

python experiments/colonies/improved.py [--seeds 30] [--iterations 150] [--maps 5] [--docs]
"""

from __future__ import annotations

import statistics

import tables
from runs import Method, everything, label, options

import guideway as gw

NAMES = ("aco", "mmas", "improved-aco")
PRINTED = {
    "m20": {"aco": (50, 28.46), "mmas": (29, 27.46), "improved-aco": (23, 25.87)},
    "m30": {"aco": (120, 43.45), "mmas": (104, 42.46), "improved-aco": (81, 41.03)},
}
"""Iteration and length as printed."""
SMOOTH = {
    "simple": ("0.62", "0.74", "0.94"),
    "cluttered": ("0.53", "0.69", "0.91"),
    "crowded": ("0.56", "0.71", "0.79"),
    "maze": ("0.48", "0.51", "0.65"),
}


def main() -> None:
    parser = options(__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=30, help="seeds on m20 and m30 (%(default)s)")
    parser.add_argument("--iterations", type=int, default=150, help="generations of 50 ants (%(default)s)")
    parser.add_argument("--maps", type=int, default=5, help="maps of each environment, six seeds each (%(default)s)")
    asked = parser.parse_args()
    text, rows = convergence(asked)
    more, others = smoothness(asked)
    tables.write_csv(asked.out / "improved.csv", rows + others)
    both = [row for row in rows + others if row["error"] is None]
    text += "\n" + more + f"\nPaths under the independent checker: {len(both)}, failed: {sum(not row['ok'] for row in both)}.\n"
    words = f"python experiments/colonies/improved.py --seeds {asked.seeds} --iterations {asked.iterations} --maps {asked.maps} --docs"
    tables.publish("improved", words, text, asked.out, asked.docs)


def convergence(asked):
    """Iteration of the last improvement and lattice length, with and without cutting of loops for all three."""
    budget = gw.Budget(evaluations=50 * asked.iterations)
    compared = [
        Method(f"{name}{', loops cut' if cut else ''}", name, {"preset": "paper", "iterations": asked.iterations, "loop_cutting": cut}, budget)
        for cut in (False, True)
        for name in NAMES
    ]
    parts = [(("scene", scene), method, range(asked.seeds)) for scene in PRINTED for method in compared]
    rows = everything("convergence", parts, asked.out, asked.workers)
    lines, verdict = [], []
    for scene, printed in PRINTED.items():
        lasts: dict[str, list[int]] = {}
        for method in compared:
            found = [row for row in rows if (row["scene"], row["method"]) == (f"scene-{scene}", method.name) and row["error"] is None]
            lasts[method.name] = [row["last"] for row in found]
            of = printed[method.planner]
            lengths = [row["length"] for row in found]
            mean, half = tables.interval(lasts[method.name])
            hits = sum(row["gap"] == 0 for row in found)
            gaps = f"{100 * statistics.mean(row['gap'] for row in found):.2f}"
            shown = [f"{mean:.1f} +- {half:.1f}", f"{min(lengths):.4f} / {statistics.mean(lengths):.4f}"]
            lines.append([scene, method.name, f"{of[0]}, {of[1]}", *shown, f"{hits}/{asked.seeds}", gaps])
        verdict += [order(scene, lasts, suffix) for suffix in ("", ", loops cut")]
    head = ["map", "planner", "printed: iteration, length", "last improvement", "length best / mean", "gap 0", "mean gap %"]
    return tables.markdown(head, lines) + "\n" + "\n".join(f"* {words}" for words in verdict) + "\n", rows


def order(scene: str, lasts: dict[str, list[int]], suffix: str) -> str:
    aco, mmas, improved = (lasts[name + suffix] for name in NAMES)
    holds = statistics.mean(improved) < statistics.mean(mmas) < statistics.mean(aco)
    p = tables.holm(
        [tables.signed_rank(improved, mmas) if len(improved) == len(mmas) else 1.0, tables.signed_rank(mmas, aco) if len(mmas) == len(aco) else 1.0]
    )
    effects = f"A12 {tables.a12(improved, mmas):.2f} (p = {p[0]:.2g}) and {tables.a12(mmas, aco):.2f} (p = {p[1]:.2g})"
    return f"{scene}{suffix}: order of iterations improved < MMAS < ACO {'holds' if holds else 'does not hold'}: {effects}."


def smoothness(asked):
    """Smoothness of lattice paths and after smoothing, by environment."""
    methods = [Method(f"{name}, smoothed", name, {"preset": "paper"}, refine="smooth") for name in NAMES]
    parts = [(("environment", kind, seed, 30), method, range(6)) for kind in SMOOTH for seed in range(asked.maps) for method in methods]
    rows = everything("smoothness", parts, asked.out, asked.workers)
    lines = []
    for kind, printed in SMOOTH.items():
        names = {label(("environment", kind, seed, 30)) for seed in range(asked.maps)}
        for method, figure in zip(methods, printed, strict=True):
            found = [row for row in rows if row["scene"] in names and row["method"] == method.name and row["error"] is None]
            means = {
                key: statistics.mean(row[key] for row in found)
                for key in ("smoothness", "turning", "length", "refined_smoothness", "refined_total_turning")
            }
            raw = [f"{means['smoothness']:.3f}", f"{means['turning']:.2f}", f"{means['length']:.2f}"]
            after = [f"{means['refined_smoothness']:.3f}", f"{means['refined_total_turning']:.2f}"]
            lines.append([kind, method.planner, figure, *raw, *after, len(found)])
    head = ["environment", "planner", "printed", "lattice smoothness", "turning rad", "length", "smoothed: smoothness", "turning rad", "runs"]
    return tables.markdown(head, lines), rows


if __name__ == "__main__":
    main()
