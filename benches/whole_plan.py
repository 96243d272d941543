"""Wall time of the full `guideway plan` on a warehouse map: interpreter, load, plan, reference, smooth, time, certify, write."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from importlib.resources import files
from pathlib import Path

MAP = str(files("guideway").joinpath("data", "warehouse.yaml"))
ENDS = ["--start=-5.4,-19", "--goal=9.5,21.5"]
ROBOTS = {"a point": [], "a disc of 0.3 m, 0.1 m clear": ["--footprint", "disc:0.3", "--clearance", "0.1"]}
RUNS = 9


def main() -> None:
    print("| robot | median s | least s | most s |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        out = str(Path(folder) / "plan.json")
        for name, words in ROBOTS.items():
            times = []
            for _ in range(RUNS):
                begun = time.perf_counter()
                subprocess.run([sys.executable, "-m", "guideway", "plan", MAP, *ENDS, *words, "--out", out], check=True, capture_output=True)
                times.append(time.perf_counter() - begun)
            print(f"| {name} | {statistics.median(times):.3f} | {min(times):.3f} | {max(times):.3f} |")


if __name__ == "__main__":
    main()
