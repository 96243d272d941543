"""Four discs that cross a room, 20 seeds: the default controller beside RVO and SFM of ir-sim, and the time of a control step.

python benches/local.py [--seeds 20] [--no-peers]    # peers: pip install ir-sim
"""

from __future__ import annotations

import argparse
import contextlib
import logging
import math
import os
import statistics
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import guideway as gw

START, GOAL, RADIUS, TICK, LIMIT, ARRIVAL = (0.6, 0.6), (9.4, 5.4), 0.2, 0.1, 40.0, 0.3
SCENE = """world: {{height: 6, width: 10, step_time: {dt}, sample_time: {dt}, collision_mode: 'stop', control_mode: 'auto'}}
robot:
  - kinematics: {{name: 'diff'}}
    shape: {{name: 'circle', radius: {r}}}
    state: [{sx}, {sy}, 0.5]
    goal: [{gx}, {gy}, 0]
    goal_threshold: {tol}
    vel_min: [-1, -2]
    vel_max: [1, 2]
    {behaviour}
obstacle:
{obstacles}"""


def movers(seed: int) -> list[tuple[float, float, float, float]]:
    """x, lower and upper end (m) and phase (rounds) of four discs of 0.3 m that go to and fro at 0.5 m/s."""
    rng = np.random.default_rng(seed)
    out = []
    for k in range(4):
        x = 2.0 + 1.9 * k + rng.uniform(-0.4, 0.4)
        y0, y1 = rng.uniform(0.6, 1.5), rng.uniform(4.5, 5.4)
        out.append((x, y0, y1, rng.uniform(0, 1)))
    return out


def height(mover: tuple[float, float, float, float], t: float) -> float:
    """y of a disc at a time."""
    _, y0, y1, phase = mover
    span = y1 - y0
    u = (phase * 2 * span + 0.5 * t) % (2 * span)
    return y0 + u if u < span else y1 - (u - span)


def ours(seed: int) -> tuple[str, float, float]:
    """Outcome, time to the goal (s) and median time of a control step (s)."""
    still = gw.World(bounds=(0, 0, 10, 6), resolution=0.1)
    moving: list[dict[str, Any]] = []
    for x, y0, y1, phase in movers(seed):
        span = (y1 - y0) / 0.5
        moving.append({"shape": {"disc": 0.3}, "track": [[0, x, y0], [span, x, y1]], "loop": "shuttle", "phase": phase * 2 * span})
    limits = gw.Limits(speed=1.0, acceleration=1.0, deceleration=1.0, jerk=10.0, turn_rate=2.0, turn_acceleration=4.0)
    room = gw.World(bounds=(0, 0, 10, 6), resolution=0.1, movers=moving)
    options: dict[str, Any] = {"footprint": {"disc": RADIUS}, "clearance": 0.05, "limits": limits}
    plan = gw.plan(gw.Query(still, START, GOAL, **options))
    run = gw.drive(
        gw.Query(room, START, GOAL, **options), gw.time(plan.path, limits), seed=seed, arrival=ARRIVAL, stop_at_goal=False, time_limit=LIMIT
    )
    return run["outcome"], run["driven"][-1][0], run["step_seconds"]["p50"]


def peer(behaviour: str, seed: int) -> tuple[str, float, float]:
    """The same with ir-sim; a step is its whole environment's."""
    import irsim

    discs = movers(seed)
    obstacles = "".join(
        f"  - kinematics: {{name: 'omni'}}\n    shape: {{name: 'circle', radius: 0.3}}\n    state: [{m[0]}, {height(m, 0)}, 0]\n"
        f"    vel_max: [0.5, 0.5]\n    vel_min: [-0.5, -0.5]\n"
        for m in discs
    )
    how = f"behavior: {{name: '{behaviour}'}}"
    ends = {"sx": START[0], "sy": START[1], "gx": GOAL[0], "gy": GOAL[1]}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        file.write_text(SCENE.format(dt=TICK, r=RADIUS, tol=ARRIVAL, behaviour=how, obstacles=obstacles, **ends))
        env = irsim.make(str(file), display=False, log_level="CRITICAL")
    steps, t = [], 0.0
    try:
        while t < LIMIT:
            pairs = zip(env.obstacle_list, discs, strict=True)
            actions = [np.array([[(m[0] - o.state[0, 0]) / TICK], [(height(m, t + TICK) - o.state[1, 0]) / TICK]]) for o, m in pairs]
            begun = time.perf_counter()
            env.step(actions, action_id=[o.id for o in env.obstacle_list])
            steps.append(time.perf_counter() - begun)
            t += TICK
            x, y = float(env.robot.state[0, 0]), float(env.robot.state[1, 0])
            if any(math.hypot(x - o.state[0, 0], y - o.state[1, 0]) < RADIUS + 0.3 - 1e-6 for o in env.obstacle_list):
                return "collision", t, statistics.median(steps)
            if math.dist((x, y), GOAL) < ARRIVAL:
                return "arrived", t, statistics.median(steps)
        return "timeout", t, statistics.median(steps)
    finally:
        env.end(0)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--no-peers", action="store_true")
    given = parser.parse_args()
    os.environ.setdefault("MPLBACKEND", "Agg")
    warnings.filterwarnings("ignore")
    logging.disable(logging.CRITICAL)
    cases: list[tuple[str, Any]] = [("guideway improved-dwa", ours)]
    if not given.no_peers:
        cases += [(f"ir-sim {name}", lambda seed, name=name: peer(name, seed)) for name in ("rvo", "sfm")]
    print("| | arrived | collisions | timeouts | median time, s | median step, ms |\n|---|---|---|---|---|---|")
    for name, run in cases:
        with open(os.devnull, "w") as quiet, contextlib.redirect_stdout(quiet):
            rows = [run(seed) for seed in range(given.seeds)]
        there = [r[1] for r in rows if r[0] == "arrived"]
        counts = [sum(r[0] == outcome for r in rows) for outcome in ("arrived", "collision", "timeout")]
        middle = statistics.median(there) if there else math.nan
        step = 1e3 * statistics.median(r[2] for r in rows)
        print(f"| {name} | {counts[0]} of {given.seeds} | {counts[1]} | {counts[2]} | {middle:.1f} | {step:.3f} |")


if __name__ == "__main__":
    main()
