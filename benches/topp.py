"""Time-optimal timing of six joints along splines, beside copp-py, toppra (Python) and toppra's C++ library.

python benches/topp.py [--intervals 1000] [--paths 5] [--reps 7] [--cpp BINARY]    # peers: pip install copp-py toppra

Speed and acceleration (and jerk) limits, the same paths, CPU time of one thread, in one run. BINARY: a program around toppra's C++
library that takes a file with the coefficients of a spline, the number of intervals, the solver and the number of repetitions, and
prints `ok SETUP SOLVE` (ms) and the squared speeds.
"""

from __future__ import annotations

import argparse
import logging
import statistics
import subprocess
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import guideway as gw
from guideway import _core

DOF = 6
SPEED, ACCELERATION, JERK = np.deg2rad(180.0), np.deg2rad(800.0), np.deg2rad(10000.0)
LIMITS = {"speed": float(SPEED), "acceleration": float(ACCELERATION), "jerk": float(JERK)}


class Spline:
    """A not-a-knot spline through random points: by its own parameter for the peers, and as a path of ours."""

    def __init__(self, points: int, seed: int) -> None:
        from scipy.interpolate import CubicSpline

        way = np.random.default_rng(seed).uniform(-1.5, 1.5, (points, DOF))
        self.knots = np.linspace(0, 1, points)
        self.curve = CubicSpline(self.knots, way)
        self.path = gw.Path.through(way, parameters=self.knots)


def median(run: Callable[[], Any], reps: int) -> tuple[float, Any]:
    """Median CPU time in ms, and the last result."""
    times, out = [], run()
    for _ in range(reps):
        start = time.process_time()
        out = run()
        times.append(time.process_time() - start)
    return 1e3 * statistics.median(times), out


def excess(spline: Spline, s: np.ndarray, x: np.ndarray, places: int = 20) -> tuple[float, float]:
    """Duration, and the largest excess over speed and acceleration in percent, between grid points, the path acceleration being constant there."""
    step, speed = np.diff(s), np.sqrt(np.maximum(x, 0))
    duration = float(np.sum(2 * step / np.maximum(speed[:-1] + speed[1:], 1e-12)))
    tau = np.linspace(0, 1, places + 1)
    at = (s[:-1, None] + step[:, None] * tau).ravel()
    inner = np.maximum(x[:-1, None] + np.diff(x)[:, None] * tau, 0).ravel()
    u = np.repeat(np.diff(x) / (2 * step), places + 1)
    first, second = spline.curve(at, 1), spline.curve(at, 2)
    worst = max(
        float((np.abs(first) * np.sqrt(inner)[:, None]).max()) / SPEED,
        float(np.abs(first * u[:, None] + second * inner[:, None]).max()) / ACCELERATION,
    )
    return duration, 100 * max(worst - 1, 0.0)


def moved(motion: Any, jerk: bool = False) -> float:
    """Largest excess of a motion of ours in percent, ten times inside every piece."""
    times = np.concatenate([p["t"] + p["duration"] * (np.arange(10) + 0.5) / 10 for p in motion.pieces])
    q = motion.sample(times=times)
    worst = max(np.abs(q["qd"]).max() / SPEED, np.abs(q["qdd"]).max() / ACCELERATION, np.abs(q["qddd"]).max() / JERK if jerk else 0.0)
    return 100 * max(float(worst) - 1, 0.0)


def kernel(spline: Spline, s: np.ndarray, reps: int) -> tuple[float, float, float]:
    first, second = np.ascontiguousarray(spline.curve(s, 1)), np.ascontiguousarray(spline.curve(s, 2))
    top = 1 / np.max((first / SPEED) ** 2, axis=1)
    bound = np.full(DOF, ACCELERATION)
    spent, x = median(lambda: _core.topp_kernel(s, top, first, second, None, -bound, bound), reps)
    return (spent, *excess(spline, s, x))


def torqued(spline: Spline, s: np.ndarray, reps: int, friction: dict[str, Any] | None = None) -> tuple[float, float, float]:
    """The kernel under the torques of an arm with 3 kg besides: time after the rows; the excess is that of speed and acceleration."""
    from guideway.arm.rows import coefficients_of

    arm = gw.arm.robot("ur5e", payload=3.0, friction=friction)
    q, first, second = (np.ascontiguousarray(spline.curve(s, k)) for k in range(3))
    found = coefficients_of(arm, q, first, second)
    still = np.zeros_like(first)
    a, b, c, d = (np.hstack(pair) for pair in ((first, found["a"]), (second, found["b"]), (still, found["c"]), (still, found["d"])))
    top = 1 / np.max((first / SPEED) ** 2, axis=1)
    bound = np.concatenate([np.full(DOF, ACCELERATION), arm.torque_limits()])
    spent, x = median(lambda: _core.topp_kernel(s, top, a, b, c, -bound, bound, d if d.any() else None), reps)
    return (spent, *excess(spline, s, x))


def rubbed(spline: Spline, s: np.ndarray, reps: int) -> tuple[float, float, float]:
    """The same with viscous friction: rows with the square root of x, linearised a few times."""
    return torqued(spline, s, reps, {"viscous": (8, 8, 8, 2, 2, 2), "coulomb": (7, 7, 7, 2, 2, 2)})


def copp(spline: Spline, s: np.ndarray, reps: int) -> tuple[float, float, float]:
    import copp_py

    ones = np.ones(DOF)

    def run() -> np.ndarray:
        robot = copp_py.Robot(DOF, capacity=len(s))
        robot.append_s(s)
        robot.set_q(*(np.ascontiguousarray(spline.curve(s, k)) for k in range(3)), 0)
        robot.add_velocity_limits(SPEED * ones, -SPEED * ones, start_idx_s=0, length=len(s))
        robot.add_acceleration_limits(ACCELERATION * ones, -ACCELERATION * ones, start_idx_s=0, length=len(s))
        start = time.process_time()
        problem = copp_py.solver.topp2_ra.Problem(robot.constraints, idx_s_interval=(0, len(s) - 1), a_boundary=(0.0, 0.0))
        x = np.asarray(copp_py.solver.topp2_ra.solve(problem))
        spent.append(time.process_time() - start)
        return x

    spent: list[float] = []
    x = [run() for _ in range(reps)][-1]
    return (1e3 * statistics.median(spent), *excess(spline, s, x))


def copp3(spline: Spline, s: np.ndarray, reps: int) -> tuple[float, float, float]:
    """Third order: time of both solvers together; the excess is that of speed and acceleration."""
    import copp_py

    ones = np.ones(DOF)

    def run() -> tuple[float, Any]:
        robot = copp_py.Robot(DOF, capacity=len(s))
        robot.append_s(s)
        q = [np.ascontiguousarray(spline.curve(s, k)) for k in range(4)]
        robot.set_q(q[0], q[1], q[2], 0, dddq=q[3])
        for add, bound in [(robot.add_velocity_limits, SPEED), (robot.add_acceleration_limits, ACCELERATION), (robot.add_jerk_limits, JERK)]:
            add(bound * ones, -bound * ones, start_idx_s=0, length=len(s))
        start = time.process_time()
        problem = copp_py.solver.topp2_ra.Problem(robot.constraints, idx_s_interval=(0, len(s) - 1), a_boundary=(0.0, 0.0))
        second = np.asarray(copp_py.solver.topp2_ra.solve(problem))
        robot.constraints.amax_substitute(second, 0)
        profile = copp_py.solver.topp3_socp.solve(copp_py.solver.topp3_socp.Problem(robot.constraints, second))
        return time.process_time() - start, profile

    runs = [run() for _ in range(max(1, reps // 3))]
    profile = runs[-1][1]
    duration = float(copp_py.interpolation.s_to_t_topp3(s, profile, 0.0)[0])
    return 1e3 * statistics.median(r[0] for r in runs), duration, excess(spline, s, np.asarray(profile.a))[1]


def toppra(spline: Spline, s: np.ndarray, reps: int) -> tuple[float, float, float]:
    import toppra as ta
    from toppra import algorithm, constraint

    logging.disable(logging.WARNING)
    both = np.stack([-np.ones(DOF), np.ones(DOF)], 1)
    path = ta.SplineInterpolator(spline.knots, spline.curve(spline.knots))
    limits = [
        constraint.JointVelocityConstraint(SPEED * both),
        constraint.JointAccelerationConstraint(ACCELERATION * both, discretization_scheme=constraint.DiscretizationType.Interpolation),
    ]
    instance = algorithm.TOPPRA(limits, path, gridpoints=s, solver_wrapper="seidel")
    spent, out = median(lambda: instance.compute_parameterization(0, 0, return_data=True), reps)
    return (spent, *excess(spline, s, np.asarray(out[1]) ** 2))


def library(spline: Spline, s: np.ndarray, reps: int, program: str) -> tuple[float, float, float]:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "path.txt")
        lines = [f"{len(spline.knots) - 1} {DOF}", " ".join(map(repr, spline.knots.tolist()))]
        for k in range(len(spline.knots) - 1):
            lines += [" ".join(f"{v:.17g}" for v in row) for row in spline.curve.c[:, k, :]]
        file.write_text("\n".join(lines) + "\n")
        out = subprocess.run([program, str(file), str(len(s) - 1), "seidel", str(reps)], capture_output=True, text=True, check=True).stdout.split(
            "\n"
        )
    return (float(out[0].split()[2]), *excess(spline, s, np.array(out[1].split(), float)))


def product(spline: Spline, _s: np.ndarray, reps: int) -> tuple[float, float, float]:
    spent, motion = median(lambda: gw.time_joints(spline.path, LIMITS), reps)
    return spent, motion.duration, moved(motion)


def smooth(spline: Spline, s: np.ndarray, reps: int) -> tuple[float, float, float]:
    spent, motion = median(lambda: gw.time_joints(spline.path, LIMITS, grid=len(s) - 1, jerk=True), reps)
    return spent, motion.duration, moved(motion, jerk=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--intervals", type=int, default=1000)
    parser.add_argument("--paths", type=int, default=5)
    parser.add_argument("--reps", type=int, default=7)
    parser.add_argument("--cpp", help="program around toppra's C++ library")
    parser.add_argument("--no-peers", action="store_true")
    args = parser.parse_args()
    warnings.filterwarnings("ignore")
    splines = [Spline(10, 1000 + k) for k in range(args.paths)]
    s = np.linspace(0, 1, args.intervals + 1)
    ours = {
        "guideway, kernel": kernel,
        "guideway, kernel, torques": torqued,
        "guideway, kernel, torques with viscous friction": rubbed,
        "guideway, whole": product,
        "guideway, jerk-limited": smooth,
    }
    peers: dict[str, Callable[..., tuple[float, float, float]]] = {
        "copp-py topp2_ra": copp,
        "copp-py topp3_socp (jerk)": copp3,
        "toppra seidel (Python)": toppra,
    }
    if args.cpp:
        peers["toppra seidel (C++)"] = lambda spline, s, reps: library(spline, s, reps, args.cpp)
    print(f"{args.paths} splines through 10 points, {args.intervals} intervals; CPU ms of a solution (median), mean duration,")
    print("largest excess between grid points\n")
    print("| method | ms | duration s | excess % |\n|---|---|---|---|")
    for name, run in (ours if args.no_peers else ours | peers).items():
        try:
            rows = [run(spline, s, args.reps) for spline in splines]
        except ImportError as error:
            print(f"| {name} | not installed: {error.name or error} | | |")
            continue
        spent, duration, worst = zip(*rows, strict=True)
        print(f"| {name} | {statistics.median(spent):.3f} | {statistics.mean(duration):.4f} | {max(worst):.5f} |", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
