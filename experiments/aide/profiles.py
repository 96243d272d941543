"""Every speed profile on w0, w1 and random layouts at 1 kHz: violations of its limits, and its time beside the search and the trapezoid.

``python experiments/aide/profiles.py [layouts]`` plans the shortest path with rounded corners (planner ``iascv``), times it three ways and
samples each motion.
The trapezoid has no limit of jerk and bounds every time from below.
"""

from __future__ import annotations

import sys

import guideway as gw

SLACK = 1 + 1e-6


def violations(motion: gw.Trajectory, limits: gw.Limits) -> int:
    """Samples at 1 kHz out of the limits of speed, acceleration, deceleration, jerk or turn rate."""
    rows = motion.sample(1000.0)
    speed, acceleration, jerk, curvature = rows[:, 4], rows[:, 5], rows[:, 6], rows[:, 7]
    bad = (speed > limits.speed * SLACK) | (acceleration > limits.acceleration * SLACK)
    bad |= (-acceleration > (limits.deceleration or limits.acceleration) * SLACK) | (abs(jerk) > limits.jerk * SLACK)
    if limits.turn_rate is not None:
        bad |= abs(curvature * speed) > limits.turn_rate * SLACK
    if limits.lateral_acceleration is not None:
        bad |= abs(curvature) * speed**2 > limits.lateral_acceleration * SLACK
    return int(bad.sum())


def main(layouts: int) -> None:
    """Prints a line per group of worlds."""
    groups = {"w0": [gw.scenes.load("w0")], "w1": [gw.scenes.load("w1")], "layouts": [gw.scenes.make("layout", seed) for seed in range(layouts)]}
    for name, scenes in groups.items():
        bad, left, nodes, bounds, regions = 0, 0, [], [], 0
        for scene in scenes:
            query = scene.query()
            limits = scene.limits
            solution = gw.plan(query, "iascv", seed=0)
            loop = gw.correct(solution.path, limits)
            regions += len(loop["regions_before"])
            left += len(loop["regions_after"])
            times = {method: gw.time(solution.path, limits, method=method) for method in ("time-optimal", "iascv", "trapezoid")}
            bad += sum(violations(times[method], limits) for method in ("time-optimal", "iascv"))
            nodes.append(times["iascv"].duration / times["time-optimal"].duration)
            bounds.append(times["time-optimal"].duration / times["trapezoid"].duration)
        mean = sum(nodes) / len(nodes)
        print(f"{name}: {len(scenes)} worlds, {bad} samples out of limits, {regions} regions found, {left} left;", end=" ")
        print(f"nodes / search: mean {mean:.4f}, most {max(nodes):.4f}; search / trapezoid: most {max(bounds):.4f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
