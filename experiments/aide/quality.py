"""How good is ``aide``? The closed loop in rooms and random layouts, the best known objective, the gap to the lower bound, and the time of a plan.

python experiments/aide/quality.py loop | best | speed | via   (all of them if nothing is named)
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import guideway as gw
from guideway import jobs
from guideway.commands.plan import job_of_scene
from guideway.io import load

SEEDS = range(30)
ENGINES = ("de", "improved-de", "firefly", "l-shade", "cma-es")
EVALUATIONS = 1_000_000


def asked(name: str) -> gw.Query:
    """The query of a room without what moves."""
    return gw.scenes.load(name).query("static")


def ended(query: gw.Query, seed: int) -> gw.Solution | None:
    """A plan if its loop ended with nothing too fast and its motion keeps every limit at 1 kHz, else nothing."""
    found = gw.plan(query, "aide", seed=seed)
    certificate = gw.certify(found.path, query, found.trajectory)
    left = found.trace["loop"][-1]["remaining"] + found.trace["speed"]["regions_after"]
    return found if certificate["ok"] and not left else None


def loop() -> None:
    """The loop ends without overspeed, seed by seed."""
    for name in ("w0", "w1"):
        query = asked(name)
        good = [found for seed in SEEDS if (found := ended(query, seed)) is not None]
        values = sorted(found.cost for found in good)
        gaps = [found.trace["bound"]["gap"] for found in good]
        regions = sum(len(stage["found"]) for found in good for stage in found.trace["loop"])
        gap = f"gap to the lower bound {100 * statistics.median(gaps):.2f} %"
        print(
            f"{name}: {len(good)} of {len(SEEDS)} without overspeed ({regions} regions on the way), "
            f"f median {statistics.median(values):.6f}, {values[0]:.6f} to {values[-1]:.6f}, {gap}"
        )
    good, gaps = 0, []
    for seed in range(100):
        found = ended(gw.scenes.layout(seed).query("static"), seed)
        good += found is not None
        gaps += [] if found is None else [found.trace["bound"]["gap"]]
    gap = f"median {100 * statistics.median(gaps):.2f} %, {100 * max(gaps):.2f} % at most"
    print(f"random layouts: {good} of 100 without overspeed, gap to the lower bound {gap}")


def best() -> None:
    """The best objective that runs of a million evaluations find in w0, without hints and inside the loop; takes minutes."""
    query, budget = asked("w0"), gw.Budget(evaluations=EVALUATIONS)
    values: list[float] = []
    for engine in ENGINES:
        plain = {"points": 5, "scales": True, "hints": False, "patience": 0} | ({} if engine in ("firefly",) else {"tolerance": 0.0})
        for label, name, settings in (
            (f"{engine} without hints", engine, plain),
            (f"aide with {engine}", "aide", {"points": 5, "scales": True, "engine": engine, "generations": EVALUATIONS, "stages": 1}),
        ):
            found = [gw.plan(query, name, seed=seed, budget=budget, set=settings).cost for seed in range(2)]
            values += found
            print(f"{label}: f {', '.join(f'{value:.6f}' for value in found)}")
    print(f"best known f in w0: {min(values):.6f}")


def speed() -> None:
    """Time of one thread per plan in the rooms."""
    for name in ("w0", "w1"):
        query, times = asked(name), []
        for seed in SEEDS:
            begun = time.process_time()
            gw.plan(query, "aide", seed=seed)
            times.append(1e3 * (time.process_time() - begun))
        print(f"{name}: {statistics.median(times):.1f} ms of one thread, {min(times):.1f} to {max(times):.1f}")


def via() -> None:
    """Through the warehouse by two points without a stop."""
    job = job_of_scene(load("scene:warehouse"))
    job.planner, job.via = "aide", [(-4.6, 1.0), (4.0, 13.5)]
    begun = time.process_time()
    outcome = jobs.run(job)
    rows = outcome.trajectory.sample(1000.0)
    for point in job.via:
        near = ((rows[:, 1] - point[0]) ** 2 + (rows[:, 2] - point[1]) ** 2).argmin()
        print(f"via {point}: passed at {rows[near, 4]:.3f} m/s")
    print(
        f"warehouse: {outcome.record['metrics']['length']:.2f} m in {rows[-1, 0]:.2f} s, certificate {outcome.record['certificate']['ok']}, "
        f"{1e3 * (time.process_time() - begun):.0f} ms of one thread"
    )


PARTS: dict[str, Callable[[], None]] = {"loop": loop, "best": best, "speed": speed, "via": via}

if __name__ == "__main__":
    for part in sys.argv[1:] or PARTS:
        PARTS[part]()
