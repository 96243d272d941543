"""Point-to-point motion of several axes: ours beside Ruckig on the same random inputs, time, failures and durations.

Run with a release build of guideway and `pip install -r benches/requirements.txt`:

    python benches/axes.py [--inputs 20000] [--seed 11]

Inputs are made before the clock starts; both are timed in turns on the same batch, CPU time of one thread, the median of the batches.
Goals that cannot be come from within the limits of velocity are left out, as no motion keeps the limits; starts that cannot go on within
them stay in (both bring them back).
"1 : 10^4": limits and distances log-uniform, limits over that ratio, distances from 1e-4 to 1e4.
"""

from __future__ import annotations

import argparse
import dataclasses
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import ruckig

import guideway as gw

BATCH = 500
SAME = 1e-9
Floats = np.ndarray[Any, np.dtype[np.float64]]


@dataclasses.dataclass(frozen=True)
class Kind:
    """A kind of inputs: axes, whether limits differ by direction, the share of the limits that velocities and accelerations at the ends take up."""

    axes: int
    asymmetric: bool
    share: float
    wide: int = 0
    """Limits and distances log-uniform, limits over a ratio of 10 to this; 0: uniform, narrow."""

    def __str__(self) -> str:
        limits = ("asymmetric" if self.asymmetric else "symmetric") + (f", 1 : 10^{self.wide}" if self.wide else "")
        return f"{self.axes} | {limits} | {self.share:g}"


ENDS = ((0, 0), (0.5, 0), (1, 0), (0.5, 4), (0.5, 6))
KINDS = [Kind(axes, asymmetric, share, wide) for axes in (1, 7) for asymmetric in (False, True) for share, wide in ENDS]


def inputs(kind: Kind, count: int, seed: int) -> dict[str, Floats]:
    """Rows of `count` inputs, each (count, axes); every goal can be come from."""
    rng = np.random.default_rng(seed)
    shape = (4 * count if kind.axes == 1 else 40 * count, kind.axes)

    def drawn(low: float, high: float) -> Floats:
        return 10.0 ** rng.uniform(low, high, shape) if kind.wide else rng.uniform(low, high, shape)

    half = kind.wide / 2
    ranges = ((-half, half),) * 3 if kind.wide else ((0.5, 3), (1, 10), (5, 100))
    vmax, amax, jerk = (drawn(*r) for r in ranges)
    vmin, amin = (-drawn(*ranges[0]), -drawn(*ranges[1])) if kind.asymmetric else (-vmax, -amax)
    start = rng.uniform(-1, 1, shape) if kind.wide else rng.uniform(-3, 3, shape)
    goal = start + rng.choice([-1.0, 1.0], shape) * drawn(-4, 4) if kind.wide else rng.uniform(-3, 3, shape)
    found = {"start": start, "goal": goal, "velocity": vmax, "acceleration": amax, "jerk": jerk, "min_velocity": vmin, "min_acceleration": amin}
    for name in ("start", "goal"):
        found[f"{name}_velocity"] = kind.share * (vmin + (vmax - vmin) * rng.random(shape))
        found[f"{name}_acceleration"] = kind.share * (amin + (amax - amin) * rng.random(shape))
    a, v = found["goal_acceleration"], found["goal_velocity"]
    before = v - a * np.abs(a) / (2 * jerk)
    if kind.axes == 1:
        good = ((before > vmin) & (before < vmax))[:, 0]
        return {name: rows[good][:count] for name, rows in found.items()}
    # Axes are exchangeable: goals that cannot be come from are exchanged for those that can.
    good = ((before > vmin) & (before < vmax)).ravel()
    return {name: rows.ravel()[good][: count * kind.axes].reshape(-1, kind.axes) for name, rows in found.items()}


def ours(rows: dict[str, Floats], i: int) -> gw.PointToPoint:
    limits = {name: rows[name][i] for name in ("velocity", "acceleration", "jerk", "min_velocity", "min_acceleration")}
    ends = {name: rows[name][i] for name in ("start_velocity", "start_acceleration", "goal_velocity", "goal_acceleration")}
    return gw.PointToPoint(rows["start"][i], rows["goal"][i], limits=limits, **ends)


def theirs(rows: dict[str, Floats], i: int) -> ruckig.InputParameter:
    asked = ruckig.InputParameter(rows["start"].shape[1])
    asked.current_position, asked.target_position = rows["start"][i].tolist(), rows["goal"][i].tolist()
    asked.current_velocity, asked.target_velocity = rows["start_velocity"][i].tolist(), rows["goal_velocity"][i].tolist()
    asked.current_acceleration, asked.target_acceleration = rows["start_acceleration"][i].tolist(), rows["goal_acceleration"][i].tolist()
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = (
        rows["velocity"][i].tolist(),
        rows["acceleration"][i].tolist(),
        rows["jerk"][i].tolist(),
    )
    asked.min_velocity, asked.min_acceleration = rows["min_velocity"][i].tolist(), rows["min_acceleration"][i].tolist()
    return asked


def timed(calls: list[Callable[[], float]]) -> tuple[float, list[float]]:
    """CPU seconds per call, and durations; NaN where a call fails."""
    found = []
    begin = time.thread_time()
    for call in calls:
        try:
            found.append(call())
        except (gw.GuidewayError, ruckig.RuckigError, ValueError):
            found.append(float("nan"))
    return (time.thread_time() - begin) / len(calls), found


def compare(kind: Kind, count: int, seed: int) -> str:
    rows = inputs(kind, count, seed)
    planner, trajectory = ruckig.Ruckig(kind.axes), ruckig.Trajectory(kind.axes)

    def calculated(asked: ruckig.InputParameter) -> float:
        done = planner.calculate(asked, trajectory) in (ruckig.Result.Working, ruckig.Result.Finished)
        return trajectory.duration if done else float("nan")

    times: list[tuple[float, float]] = []
    mine: list[float] = []
    peer: list[float] = []
    total = len(rows["start"])
    for first in range(0, total, BATCH):
        batch = range(first, min(first + BATCH, total))
        problems, asked = [ours(rows, i) for i in batch], [theirs(rows, i) for i in batch]
        spent, found = timed([lambda p=p: p.plan().duration for p in problems])
        spent_peer, found_peer = timed([lambda a=a: calculated(a) for a in asked])
        times.append((spent, spent_peer))
        mine += found
        peer += found_peer
    a, b = np.array(mine), np.array(peer)
    both = ~np.isnan(a) & ~np.isnan(b)
    late = (a[both] - b[both]) / np.maximum(1.0, b[both])
    us, us_peer = (1e6 * statistics.median(t[k] for t in times) for k in (0, 1))
    failed, failed_peer = np.isnan(a).mean(), np.isnan(b).mean()
    slower, faster = int((late > SAME).sum()), int((late < -SAME).sum())
    cells = [f"{us:.2f}", f"{us_peer:.2f}", f"{us / us_peer:.2f}", f"{100 * failed:.2f} %", f"{100 * failed_peer:.2f} %"]
    return "| " + " | ".join([str(kind), str(total), *cells, str(slower), str(faster), f"{late.max():.1e}"]) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=11)
    asked = parser.parse_args()
    columns = ["axes", "limits", "share at the ends", "inputs", "ours, µs", "Ruckig, µs", "ratio"]
    columns += ["ours fails", "Ruckig fails", "ours slower", "ours faster", "largest excess"]
    print("| " + " | ".join(columns) + " |")
    print("|" + "---|" * 12)
    for kind in KINDS:
        count = asked.inputs if kind.axes == 1 else asked.inputs // 8
        print(compare(kind, count, asked.seed), flush=True)


if __name__ == "__main__":
    main()
