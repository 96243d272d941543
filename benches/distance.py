"""Distance transform beside scipy.ndimage.distance_transform_edt in the same run: CPU time, best of the passes, and every value compared.

Run with a release build of guideway and `pip install -r benches/requirements.txt`:

    python benches/distance.py [--sides 1024 4000] [--passes 7] [--seed 1]

Both get a boolean array and return float64 distances in cells; ours blocked cells, scipy's free ones (its zeros are the obstacles).
The goal is at most 1/4 of scipy's time at 1024 x 1024.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy.ndimage import distance_transform_edt

import guideway as gw

GOAL = 0.25


def best(call, passes: int) -> float:
    """Least CPU time of a call, s."""
    times = []
    for _ in range(passes):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)


def kinds(side: int, seed: int):
    """Named boolean arrays: random at three densities, rooms with walls and doors, one blocked cell."""
    rng = np.random.default_rng(seed)
    for share in (0.2, 0.01, 0.0001):
        yield f"random {share:g}", rng.random((side, side)) < share
    rooms = np.zeros((side, side), bool)
    rooms[::64] = rooms[:, ::64] = True
    rooms[rng.integers(0, side, 40 * side // 64), :] &= rng.random((40 * side // 64, side)) < 0.9
    yield "rooms", rooms
    single = np.zeros((side, side), bool)
    single[side // 3, side // 5] = True
    yield "one cell", single


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sides", type=int, nargs="*", default=[1024])
    parser.add_argument("--passes", type=int, default=7)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    print(f"{'side':>6} {'kind':>14} {'guideway ms':>12} {'scipy ms':>10} {'ratio':>7}  goal {GOAL} at 1024")
    for side in args.sides:
        for name, blocked in kinds(side, args.seed):
            free = ~blocked
            if not np.array_equal(gw.distance_transform(blocked), distance_transform_edt(free)):
                raise SystemExit(f"{side} {name}: the two differ")
            ours = best(lambda b=blocked: gw.distance_transform(b), args.passes)
            theirs = best(lambda f=free: distance_transform_edt(f), max(3, args.passes // 2))
            print(f"{side:>6} {name:>14} {1e3 * ours:>12.2f} {1e3 * theirs:>10.2f} {ours / theirs:>7.3f}")


if __name__ == "__main__":
    main()
