"""The correction of a speed profile alone: the first pass over early, rough paths of plain DE, whose bends it takes too fast, before and after.

python experiments/aide/correction.py [--seeds 30] [--layouts 100]
"""

from __future__ import annotations

import argparse

import guideway as gw

EARLY = 2000
"""Evaluations of the search."""


def corrected(scene: gw.scenes.RoomScene, seed: int) -> tuple[int, int] | None:
    """Overspeed regions before and after the correction; None where the search has no path yet."""
    try:
        early = gw.plan(scene.query("static"), "de", seed=seed, set={"preset": "paper"}, budget=gw.Budget(evaluations=EARLY))
    except gw.NoPath:
        return None
    found = gw.correct(early.path, scene.limits)
    return len(found["regions_before"]), len(found["regions_after"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=30, help="seeds in each room (%(default)s)")
    parser.add_argument("--layouts", type=int, default=100, help="random layouts (%(default)s)")
    given = parser.parse_args()
    groups = {room: [(gw.scenes.load(room), seed) for seed in range(given.seeds)] for room in ("w0", "w1")}
    groups["layout"] = [(gw.scenes.layout(seed), seed) for seed in range(given.layouts)]
    print("| room | paths | with regions | with regions after correction |\n|---|---|---|---|")
    for name, group in groups.items():
        rows = [row for scene, seed in group if (row := corrected(scene, seed)) is not None]
        print(f"| {name} | {len(rows)} | {sum(before > 0 for before, _ in rows)} | {sum(after > 0 for _, after in rows)} |", flush=True)


if __name__ == "__main__":
    main()
