"""How long a new plan takes on 512 x 512 cells after a corridor was blocked: ``python benches/replanning.py [--cases 100]``.

Three ways: the changed world brought up to date (``World.updated``) and planned, smoothed and timed anew; the same with the world built anew; and the
replans of whole drives, where a mover appears in the corridor when the robot comes (path, smoothing, timing and cost-to-go together).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

import guideway as gw

SIDE, CELL = 512, 0.05
LIMITS = gw.Limits(speed=1.0, acceleration=1.0, deceleration=1.0, jerk=5.0, turn_rate=2.0, turn_acceleration=4.0)


def hall(rng: np.random.Generator) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Walls across with two gaps each, and pillars; the gaps (column, row) of the middle wall."""
    blocked = np.zeros((SIDE, SIDE), bool)
    for _ in range(60):
        row, column = rng.integers(20, SIDE - 40, 2)
        blocked[row : row + rng.integers(4, 16), column : column + rng.integers(4, 16)] = True
    gaps = []
    for column in (128, 256, 384):
        blocked[:, column - 20 : column + 24] = False
        blocked[:, column : column + 4] = True
        for low in (60, 320):
            row = int(rng.integers(low, low + 100))
            blocked[row : row + 32, column : column + 4] = False
            if column == 256:
                gaps.append((column, row))
    blocked[236:276, 10:50] = blocked[236:276, SIDE - 50 : SIDE - 10] = False
    return blocked, gaps


def query(world: gw.World, start: tuple[float, ...]) -> gw.Query:
    """Across the hall with a disc of 0.25 m."""
    return gw.Query(world, start, (SIDE * CELL - 1.5, 12.8), footprint={"disc": 0.25}, clearance=0.1, limits=LIMITS)


def motion(asked: gw.Query) -> gw.Trajectory:
    """Planned, smoothed and timed."""
    return gw.time(gw.refine(gw.plan(asked).path, asked).path, LIMITS, start_yaw=asked.start_yaw)


def timed(work: Callable[[], object]) -> float:
    """Wall-clock time, s."""
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def case(seed: int) -> tuple[float, float, float] | None:
    """Seconds of each way, or None where there is no way across the hall."""
    rng = np.random.default_rng(seed)
    blocked, gaps = hall(rng)
    world = gw.World(blocked, CELL)
    try:
        first = gw.plan(query(world, (1.5, 12.8)))
    except gw.NoPath:
        return None
    world.clearance_field()
    places = first.path.planar(np.linspace(0.0, first.path.length, 4000))
    crossing = places[int(np.argmax(places[:, 0] >= 256 * CELL))]
    column, gap = min(gaps, key=lambda g: abs(g[1] + 16 - (SIDE - crossing[1] / CELL)))
    here = tuple(places[int(np.argmax(places[:, 0] >= 200 * CELL)), :2])
    changed = blocked.copy()
    changed[gap : gap + 32, column : column + 4] = True
    part = np.ones((32, 4), bool)
    near = timed(lambda: motion(query(world.updated(part, row=gap, column=column), here)))
    anew = timed(lambda: motion(query(gw.World(changed, CELL), here)))
    mover = {"shape": {"box": [0.6, 1.6]}, "track": [[0.0, (column + 2) * CELL, (SIDE - gap - 16) * CELL]], "loop": "once", "phase": 0.0}
    asked = query(world.with_movers([{**mover, "appears": {"within": 3.0}}]), (1.5, 12.8))
    run = gw.drive(asked, motion(asked), "tracker", seed=seed)
    return near, anew, run["plan_seconds"]["p99"] if run["replans"] else float("nan")


def main() -> None:
    """Prints a line for each way."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=100)
    rows = [row for seed in range(parser.parse_args().cases) if (row := case(seed)) is not None]
    columns = np.array(rows).T * 1e3
    for name, values in zip(("world updated, new plan", "world built anew, new plan", "replans in drives, the slowest"), columns, strict=True):
        known = values[np.isfinite(values)]
        print(f"{name:32} {len(known):4} cases   median {np.median(known):7.2f} ms   99 % {np.percentile(known, 99):7.2f} ms")


if __name__ == "__main__":
    main()
