"""Every comparison with other packages, one after the other: `make bench`. Prints Markdown tables; each compares in one run on this machine."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STEPS = {
    "Grid search beside nano-astar": [sys.executable, "benches/grid.py"],
    "Distance transform beside SciPy": [sys.executable, "benches/distance.py"],
    "S-curve beside rsruckig": ["cargo", "run", "--quiet", "--release", "--package", "peers-rs"],
    "Point-to-point motion of several axes beside Ruckig": [sys.executable, "benches/axes.py"],
    "Ants on corners beside the any-angle optimum": [sys.executable, "benches/sparse_ants.py", "--seeds", "3"],
    "Shortest paths among discs beside OMPL": [sys.executable, "benches/continuous.py"],
    "Ant colonies beside aco-routing": [sys.executable, "benches/colonies.py"],
    "Optimizers beside pygmo and SciPy": [sys.executable, "benches/optimizers.py"],
    "Candidates of continuous planners": ["cargo", "run", "--quiet", "--release", "--package", "guideway", "--example", "curves"],
    "Time-optimal timing of joints beside copp-py and toppra": [sys.executable, "benches/topp.py"],
    "The whole plan of a warehouse": [sys.executable, "benches/whole_plan.py"],
}


def main() -> int:
    failed = []
    for title, words in STEPS.items():
        print(f"\n# {title}\n", flush=True)
        environment = os.environ | {"OMP_NUM_THREADS": "1"}
        if subprocess.run(words, cwd=ROOT, env=environment, check=False).returncode != 0:
            failed.append(title)
    for title in failed:
        print(f"failed: {title}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
