"""Which of the six improvements of the improved ant colony help? Rows with one switched on, all, and all but one, over generated maps and seeds.

Gaps are those of the lattice path to the exact lattice optimum of the same map, before smoothing. Methods are compared with the ant system (single
improvements) or with all six (leave one out) on the same maps and seeds: Wilcoxon's signed-rank test over the means of the maps, two sided, corrected
by Holm; A12 is the mean over the maps of the share of pairs of runs that the method wins (0.5: no difference, above: better).

    python experiments/improved_aco_ablation.py --maps 30 --seeds 30 --out ablation
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import os
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import wilcoxon
from tqdm import tqdm

import guideway as gw

SWITCHES = ("o1", "o2", "o3", "o4", "o5", "o6")
CURVATURE = 0.28
"""Limit of the smoothed paths, 1/m."""
SMOOTHED = 3
"""Seeds of each map whose paths are smoothed as well."""
FIELDS = ("preset", "row", "map", "seed", "gap", "to_one_percent", "evaluations", "iterations", "smoothed_gap", "smoothed_raw_gap")

Row = dict[str, Any]


def rows(preset: str) -> dict[str, tuple[dict[str, Any], str]]:
    """Settings of each row and the row that it is compared with."""
    base: dict[str, Any] = {"preset": preset, "seeding": "off"}
    if preset == "default":
        changes: dict[str, dict[str, Any]] = {
            "with O2": {"o2": True},
            "with O3": {"o3": True},
            "without O1": {"o1": False, "initial": 1.0},
            "without O4": {"o4": False},
            "without O6": {"o6": False},
            "without local search": {"polish": 0},
            "without restart": {"restart": 0.0},
            "without loop cutting": {"loop_cutting": False},
            "heuristic of the source": {"heuristic": "goal"},
            "beta = 5": {"beta": 5.0},
            "max-min bounds": {"bounds": "max-min"},
            "scale of the source": {"cone": 1e-4, "least": 1e-6},
        }
        return {"default": (base, "default")} | {name: (base | change, "default") for name, change in changes.items()}
    on = dict.fromkeys(SWITCHES, True) | {"o5": False}
    off = dict.fromkeys(SWITCHES, False)
    table: dict[str, tuple[dict[str, Any], str]] = {"ACO": (base | off, "ACO")}
    for switch in ("o1", "o2", "o3", "o4", "o6"):
        table[f"+{switch.upper()}"] = (base | off | {switch: True}, "ACO")
    table["all six"] = (base | on, "ACO")
    for switch in ("o1", "o2", "o3", "o4", "o6"):
        table[f"all but {switch.upper()}"] = (base | on | {switch: False}, "all six")
    table["+O1 literal"] = (base | off | {"o1": True, "o1_reading": "literal"}, "ACO")
    table["+O1, mean 1"] = (base | off | {"o1": True, "cone": 1.0}, "ACO")
    table["all six, O3 at a flat rate"] = (base | on | {"conversion": "rate"}, "all six")
    table["all six, loops cut"] = (base | on | {"loop_cutting": True}, "all six")
    return table


@cache
def scenes(count: int) -> list[gw.scenes.GridScene]:
    """Maps in turn: like m20, like m30, cluttered and maze."""
    kinds = ("m20", "m30", "cluttered", "maze")
    made = []
    for k in range(count):
        kind, seed = kinds[k % len(kinds)], 100 + k // len(kinds)
        made.append(gw.scenes.calibrated(kind, seed) if kind in ("m20", "m30") else gw.scenes.make(kind, seed))
    return made


def job(ask: tuple[str, int, int, int]) -> list[Row]:
    """All rows on one map with one seed."""
    preset, maps, number, seed = ask
    query = scenes(maps)[number].query()
    exact = gw.plan(query, planner="jump-point").cost
    straight = gw.plan(query).cost
    done = []
    for row, (settings, _) in rows(preset).items():
        solution = gw.plan(query, planner="improved-aco", seed=seed, set=settings)
        per = solution.evaluations / solution.iterations
        hits = [iteration for iteration, best in solution.history if best <= 1.01 * exact * (1 + 1e-9)]
        found: Row = {"preset": preset, "row": row, "map": number, "seed": seed, "gap": solution.cost / exact - 1}
        found |= {"to_one_percent": hits[0] * per if hits else "", "evaluations": solution.evaluations, "iterations": solution.history[-1][0]}
        if seed < SMOOTHED:
            refined = gw.refine(solution.path, query, max_curvature=CURVATURE)
            found |= {"smoothed_gap": refined.path.length / straight - 1, "smoothed_raw_gap": solution.cost / straight - 1}
        done.append(found)
    return done


def holm(p: list[float]) -> list[float]:
    """Holm's correction."""
    order = np.argsort(p)
    corrected, least = [0.0] * len(p), 0.0
    for rank, k in enumerate(order):
        least = max(least, min(1.0, (len(p) - rank) * p[k]))
        corrected[k] = least
    return corrected


def wilcoxon_p(a: np.ndarray, b: np.ndarray) -> float:
    """Two sided; 1 where nothing differs."""
    return 1.0 if np.allclose(a, b, rtol=0, atol=1e-12) else float(wilcoxon(a, b).pvalue)


def a12(a: np.ndarray, b: np.ndarray) -> float:
    """Mean over the maps (rows) of the share of pairs in which ``a`` is smaller; equal ones count half."""
    less = a[:, :, None] < b[:, None, :] - 1e-12
    equal = np.abs(a[:, :, None] - b[:, None, :]) <= 1e-12
    return float((less + 0.5 * equal).mean())


def matrix(found: Iterable[Row], row: str, key: str) -> np.ndarray:
    """Values of one row of the table, maps by seeds. Runs that never came within 1 % count with all their evaluations."""
    mine = sorted((f for f in found if f["row"] == row), key=lambda f: (f["map"], f["seed"]))
    seeds = len({f["seed"] for f in mine})
    return np.array([float(f[key]) if f[key] != "" else float(f["evaluations"]) for f in mine]).reshape(-1, seeds)


def summary(found: list[Row], preset: str) -> str:
    """The table of a preset as Markdown."""
    table = rows(preset)
    gaps = {row: matrix(found, row, "gap") for row in table}
    effort = {row: matrix(found, row, "to_one_percent") for row in table}
    tests = [row for row, (_, other) in table.items() if row != other]
    against = [table[row][1] for row in tests]
    p_gap = dict(zip(tests, holm([wilcoxon_p(gaps[a].mean(1), gaps[b].mean(1)) for a, b in zip(tests, against, strict=True)]), strict=True))
    p_effort = dict(zip(tests, holm([wilcoxon_p(effort[a].mean(1), effort[b].mean(1)) for a, b in zip(tests, against, strict=True)]), strict=True))
    lines = [
        "| row | mean gap % | optimal % of runs | within 1 % of runs | ERT(1 %) | last better | against | A12 gap | p gap | A12 effort | p effort |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row, (_, other) in table.items():
        mine = [f for f in found if f["row"] == row]
        within = [f for f in mine if f["to_one_percent"] != ""]
        spent = effort[row].sum()
        ert = f"{spent / len(within):.0f}" if within else "-"
        head = f"| {row} | {100 * gaps[row].mean():.3f} | {100 * (gaps[row] < 1e-9).mean():.1f} | {100 * len(within) / len(mine):.1f} | {ert} "
        last = np.mean([f["iterations"] for f in mine])
        tail = (
            "| | | | | |"
            if row == other
            else (f"| {other} | {a12(gaps[row], gaps[other]):.2f} | {p_gap[row]:.1e} | {a12(effort[row], effort[other]):.2f} | {p_effort[row]:.1e} |")
        )
        lines.append(f"{head}| {last:.1f} {tail}")
    smooth = [f for f in found if "smoothed_gap" in f]
    for row in ("ACO", "all six", "default"):
        mine = [f for f in smooth if f["row"] == row]
        if mine:
            before, after = (100 * np.mean([f[key] for f in mine]) for key in ("smoothed_raw_gap", "smoothed_gap"))
            lines.append(
                f"\nO5 on the paths of {row}: mean any-angle gap {before:.2f} % before and {after:.2f} % after smoothing ({len(mine)} paths)."
            )
    return "\n".join(lines)


def main() -> None:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--maps", type=int, default=30)
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--presets", nargs="+", default=["paper", "default"], choices=["paper", "default"])
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=Path("improved_aco_ablation"), help="name of the .csv and .md, without ending")
    args = parser.parse_args()
    jobs = [(preset, args.maps, k, seed) for preset in args.presets for k in range(args.maps) for seed in range(args.seeds)]
    found: list[Row] = []
    scenes(args.maps)  # before the processes start: they share them
    with multiprocessing.get_context("fork").Pool(args.processes) as pool:
        for part in tqdm(pool.imap_unordered(job, jobs), total=len(jobs), disable=not sys.stderr.isatty()):
            found += part
    found.sort(key=lambda f: (f["preset"], f["row"], f["map"], f["seed"]))
    with args.out.with_suffix(".csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, FIELDS)
        writer.writeheader()
        writer.writerows(found)
    text = "\n\n".join(f"## preset={preset}\n\n{summary([f for f in found if f['preset'] == preset], preset)}" for preset in args.presets)
    args.out.with_suffix(".md").write_text(text + "\n", encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
