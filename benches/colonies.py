"""Colonies on one thread: the two settings with a limit, growth with the side of the map, two threads beside one, and peers in the same run.

Run with a release build of guideway and `pip install -r benches/requirements.txt`:

    python benches/colonies.py [--calls 30] [--maps 3] [--pairs 30] [--peer-seeds 3]

Times are CPU times, medians after three calls to warm up, except those of two threads, which are wall times in pairs; a pair during
which other processes took more than a twentieth of a processor is taken again, with the same seed. The growth is
the slope of log t over log n with its 95 % interval over maps; the improved colony runs 50 ants and 100 generations with seeding off,
so that it is the ants that work. Peer: aco-routing, an ant colony for shortest paths in networkx graphs, pure Python, on the same graph
with as many ants and generations. The exact search of the same map stands beside.
"""

from __future__ import annotations

import argparse
import os
import random
import statistics
import time
from pathlib import Path

import networkx as nx
import numpy as np
from aco_routing import ACO
from scipy import stats

import guideway as gw

OFF = {"seeding": "off"}
SIZES, DENSITIES = (20, 30, 50, 70), (0.1, 0.3, 0.5, 0.7)
SOURCE = {0.1: 2.79, 0.7: 2.97}
"""Growth exponents of the source's own times, by density."""
LIMIT = 2.2


def seconds(call, calls: int) -> list[float]:
    """CPU seconds of each call after three that warm up."""
    found = []
    for number in range(calls + 3):
        begun = time.process_time_ns()
        call(number)
        found.append(1e-9 * (time.process_time_ns() - begun))
    return found[3:]


def colony(scene, planner: str, setting: dict | None = None, threads: int = 1):
    """A call that plans with the seed it is given."""
    query = scene.query()
    return lambda seed: gw.plan(query, planner=planner, seed=seed, set=setting, threads=threads)


def single(calls: int) -> None:
    one, m20, large = gw.scenes.load("pso-aco-1"), gw.scenes.load("m20"), gw.scenes.complexity(70, 0.7, seed=1)
    rows = [
        ("pso-aco, scene 1", one, "pso-aco", None, 25),
        ("pso-aco, scene 1, seeding off", one, "pso-aco", OFF, 25),
        ("pso-aco, scene 1, paper", one, "pso-aco", {"preset": "paper"}, None),
        ("improved-aco, 20 x 20 (m20)", m20, "improved-aco", None, 20),
        ("improved-aco, 20 x 20 (m20), seeding off", m20, "improved-aco", OFF, 20),
        ("improved-aco, 20 x 20 (m20), paper", m20, "improved-aco", {"preset": "paper"}, None),
        ("improved-aco, 70 x 70, 70 % blocked", large, "improved-aco", None, 150),
        ("improved-aco, 70 x 70, 70 % blocked, seeding off", large, "improved-aco", OFF, 150),
        ("improved-aco, 70 x 70, 70 % blocked, paper", large, "improved-aco", {"preset": "paper"}, None),
    ]
    print("| planner, map | CPU ms | limit ms | | exact `jump-point` us |\n|---|---|---|---|---|")
    for name, scene, planner, setting, limit in rows:
        ours = 1e3 * statistics.median(seconds(colony(scene, planner, setting), calls))
        exact = 1e6 * statistics.median(seconds(colony(scene, "jump-point"), calls))
        verdict = "" if limit is None else "met" if ours <= limit else "missed"
        print(f"| {name} | {ours:.1f} | {limit or ''} | {verdict} | {exact:.0f} |", flush=True)


def growth(maps: int, calls: int) -> None:
    head = ["graph", "blocked", *(f"{size} x {size} ms" for size in SIZES), "exponent", "95 %", f"limit {LIMIT}", "the source"]
    print(f"\n| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for graph, density in [(graph, density) for graph in ("lattice", "corners") for density in DENSITIES]:
        points, shown = [], []
        for size in SIZES:
            found = []
            for seed in range(maps):
                scene = gw.scenes.complexity(size, density, seed)
                found.append(statistics.median(seconds(colony(scene, "improved-aco", OFF | {"graph": graph}), calls)))
            points += [(np.log(size), np.log(t)) for t in found]
            shown.append(f"{1e3 * statistics.mean(found):.1f}")
        fit = stats.linregress(*np.array(points).T)
        half = stats.t.ppf(0.975, len(points) - 2) * fit.stderr
        verdict = "met" if fit.slope <= LIMIT else "missed"
        interval = f"{fit.slope - half:.2f}-{fit.slope + half:.2f}"
        print(f"| {graph} | {density:.0%} | {' | '.join(shown)} | {fit.slope:.2f} | {interval} | {verdict} | {SOURCE.get(density, '')} |", flush=True)


def others() -> float:
    """Seconds of processor time that all other processes have had so far, stolen time too; 0 where the system does not say."""
    stat = Path("/proc/stat")
    if not stat.exists():
        return 0.0
    user, nice, system, _, _, *rest = map(int, stat.read_text().split("\n", 1)[0].split()[1:9])
    return (user + nice + system + sum(rest)) / os.sysconf("SC_CLK_TCK") - time.process_time()


def pair_of(scene, seed: int) -> dict[int, float]:
    """Wall times with one and with two threads, their order changing; the paths must be the same bytes."""
    times, paths = {}, {}
    for count in (1, 2) if seed % 2 else (2, 1):
        begun = time.perf_counter()
        found = colony(scene, "improved-aco", OFF, count)(seed)
        times[count] = time.perf_counter() - begun
        paths[count] = np.asarray(found.cells).tobytes() + np.asarray(found.path.control_points).tobytes() + found.history.tobytes()
    if paths[1] != paths[2]:
        raise SystemExit(f"{scene.name}, seed {seed}: one and two threads give different paths")
    return times


def quiet_pair(scene, seed: int) -> tuple[dict[int, float], int]:
    """A pair that nothing else disturbed, and how many had to be thrown away for it. Waits at most an hour for it."""
    disturbed, until = 0, time.monotonic() + 3600
    while time.monotonic() < until:
        busy = others()
        time.sleep(0.25)
        before = others()
        if before - busy > 0.03:
            continue
        times = pair_of(scene, seed)
        # The system counts in hundredths of a second.
        if others() - before <= 0.02 + 0.05 * sum(times.values()):
            return times, disturbed
        disturbed += 1
    raise SystemExit("the machine is too busy to compare threads")


def threads(pairs: int) -> None:
    print("\n| improved-aco, 70 x 70 | one thread ms | two threads ms | speed-up, median | least to most | limit 1.5 | disturbed pairs |")
    print("|---|---|---|---|---|---|---|")
    for density in (0.3, 0.7):
        scene = gw.scenes.complexity(70, density, seed=1)
        pair_of(scene, pairs)
        times: dict[int, list[float]] = {1: [], 2: []}
        disturbed = 0
        for seed in range(pairs):
            found, again = quiet_pair(scene, seed)
            disturbed += again
            for count, taken in found.items():
                times[count].append(taken)
        ratio = sorted(a / b for a, b in zip(times[1], times[2], strict=True))
        one, two = (1e3 * statistics.median(times[count]) for count in (1, 2))
        middle = statistics.median(ratio)
        verdict = "met" if middle >= 1.5 else "missed"
        shown = f"{middle:.2f} | {ratio[0]:.2f}-{ratio[-1]:.2f} | {verdict} | {disturbed}"
        print(f"| {density:.0%} blocked, {pairs} pairs | {one:.1f} | {two:.1f} | {shown} |", flush=True)


def graph_of(scene) -> nx.DiGraph:
    """The lattice under the corner rule touch, as the colonies have it."""
    free, graph = ~scene.blocked, nx.DiGraph()
    height, width = free.shape
    for y, x in np.argwhere(free).tolist():
        for dx in (-1, 0, 1):
            for dy in (-1, 0, 1):
                u, v = x + dx, y + dy
                if (dx or dy) and 0 <= u < width and 0 <= v < height and free[v, u] and (free[y, u] or free[v, x]):
                    graph.add_edge((x, y), (u, v), cost=float(np.hypot(dx, dy)))
    return graph


def peers(count: int) -> None:
    print("\n| 50 ants, 100 generations, m20 (optimum 27.4558) | CPU s | length, mean | without a path | ratio |\n|---|---|---|---|---|")
    scene = gw.scenes.load("m20")
    ours = statistics.median(seconds(colony(scene, "improved-aco", OFF), 5))
    mean = statistics.mean(gw.plan(scene.query(), planner="improved-aco", seed=seed, set=OFF).cost for seed in range(count))
    print(f"| guideway `improved-aco`, seeding off | {ours:.4f} | {mean:.4f} | 0 of {count} | 1 |", flush=True)
    times, lengths = [], []
    for seed in range(count):
        random.seed(seed)
        method = ACO(graph_of(scene), ant_max_steps=6 * scene.blocked.size // 10, num_iterations=100, ant_random_spawn=False)
        begun = time.process_time()
        try:
            lengths.append(method.find_shortest_path(scene.start, scene.goal, num_ants=50)[1])
        except Exception:  # the peer raises a bare Exception where its last, greedy ant is caught
            lengths.append(None)
        times.append(time.process_time() - begun)
    found = [length for length in lengths if length is not None]
    shown = f"{statistics.mean(found):.4f}" if found else "-"
    theirs = statistics.median(times)
    print(f"| aco-routing 1.2.1 | {theirs:.2f} | {shown} | {len(lengths) - len(found)} of {count} | {theirs / ours:.0f} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=30)
    parser.add_argument("--maps", type=int, default=3)
    parser.add_argument("--pairs", type=int, default=30)
    parser.add_argument("--peer-seeds", type=int, default=3)
    asked = parser.parse_args()
    single(asked.calls)
    growth(asked.maps, max(3, asked.calls // 6))
    threads(asked.pairs)
    peers(asked.peer_seeds)


if __name__ == "__main__":
    main()
