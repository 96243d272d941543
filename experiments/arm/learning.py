"""Velocity self-learning along the star: every method on the reference plant, the source's method in all its settings, random plants, a simulated
arm.

python experiments/arm/learning.py methods|source|targets|random|mujoco [--seeds N] [--plants N] [--workers N] [--docs]
    # resumes: a line of JSON per run in experiments/results/learning-NAME.jsonl
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # runs are small: threads of the linear algebra only get into each other's way
import numpy as np
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import tables

import guideway as gw
from guideway.arm.learning import make_learner
from guideway.arm.learning.loop import run
from guideway.arm.learning.oracle import optimum
from guideway.arm.learning.task import Task
from guideway.arm.model import direction
from guideway.plants.arm import IdealArm, Sensors, make_arm, usual_friction
from guideway.plants.arm_friction import JointFriction

Row = dict[str, Any]
OUT = Path(__file__).resolve().parents[1] / "results"
PAYLOADS = (0.0, 3.0, 5.0)
OFF = (0.03, 0.02, 0.08)
"""The payload that is not on the axis of the flange, m."""
JUDGED = 10
"""Of so many random plants one is compared with its optimum: that takes as long as its trials."""


@cache
def task(acceleration: float = 10.0) -> Task:
    """The star, with the torques that make it hard."""
    arm = gw.arm.robot("ur5e")
    limits = gw.arm.JointLimits(speed=arm.speed_limits(), acceleration=acceleration, torque=gw.arm.STAR_TORQUE)
    return Task(gw.arm.joint_path(arm, gw.arm.star()).path, arm, limits)


@cache
def oracle(payload: float, friction: str = "reference", plant: str = "ideal", at: tuple[float, ...] = (0.0, 0.0, 0.08)) -> float:
    """Duration of the true optimum, s."""
    return optimum(task(), make_arm(plant, task(), payload=payload, payload_at=at, friction=friction).rows).duration


def methods(args: argparse.Namespace) -> Iterable[Row]:
    trials = {"kinematic": 1, "nominal": 1, "structured": 6, "ilc2": 20, "uniform": 20, "source": 40, "rl": 500}
    for learner, most in trials.items():
        for payload in PAYLOADS:
            for seed in range(min(args.seeds, 3) if learner == "rl" else args.seeds):
                yield {"payload": payload, "learner": learner, "trials": most, "seed": seed}


def one_method(key: Row) -> Row:
    settings = {"seed": key["seed"]} if key["learner"] == "rl" else key.get("settings", {})
    plant = make_arm("ideal", task(key.get("acceleration", 10.0)), payload=key["payload"], seed=key["seed"], noise=key.get("noise", 0.5))
    found = run(
        task(key.get("acceleration", 10.0)), make_learner(key["learner"], task(key.get("acceleration", 10.0)), settings), plant, key["trials"]
    )
    star = oracle(key["payload"])
    rows = [[t.duration / star, t.true, t.time_over, t.measured, t.clean, t.stopped, (t.lower_bound or math.nan) / star] for t in found.trials]
    kept = [(k, row) for k, row in enumerate(rows, 1) if row[4]]
    fastest = min(kept, key=lambda pair: pair[1][0], default=None)
    clean = [kept[0][0], fastest[0], fastest[1][0]] if fastest else None
    return {"rows": rows if len(rows) <= 60 else rows[-1:], "count": len(rows), "finished": found.finished, "best": found.best, "clean": clean}


def source(args: argparse.Namespace) -> Iterable[Row]:
    settings = [(40, 0.03, "corrected"), (40, 0.01, "corrected"), (40, 0.1, "corrected"), (20, 0.03, "corrected"), (80, 0.03, "corrected")]
    settings += [(80, 0.01, "corrected"), (40, 0.03, "literal"), (80, 0.03, "literal")]
    for payload in PAYLOADS:
        for segments, step, reading in settings:
            usual = (segments, step, reading) == settings[0]
            chosen = {"segments": segments, "step": step, "reading": reading}
            for seed in range(args.seeds if usual else 1):
                yield {"payload": payload, "learner": "source", "trials": 40, "seed": seed, "settings": chosen}
            yield {"payload": payload, "learner": "source", "trials": 40, "seed": 0, "noise": 0.0, "settings": {**chosen, "margin": 0.0}}


def targets(args: argparse.Namespace) -> Iterable[Row]:
    for noise in (0.5, 0.0, 2.0):
        for payload in PAYLOADS:
            for seed in range(args.seeds if noise == 0.5 else min(5, args.seeds)):
                yield {"payload": payload, "learner": "structured", "trials": 6, "seed": seed, "noise": noise}


def random(args: argparse.Namespace) -> Iterable[Row]:
    return ({"plant": number} for number in range(args.plants))


def random_plant(number: int) -> tuple[IdealArm, int]:
    """Payload 0 to 5 kg with a random centre within 0.1 m of (0, 0, 0.08) and random inertia, friction of each joint scaled by 0.5 to 1.5, half of
    the plants with all effects of friction, noise 0.1 to 1 N m; and how many were drawn before, which cannot even hold and rub slowly."""
    draw = np.random.default_rng([20, number])
    for refused in range(1000):
        mass, centre = draw.uniform(0, 5), np.array([0, 0, 0.08]) + draw.uniform(-1, 1, 3) * 0.1 / math.sqrt(3)
        viscous, coulomb = (np.asarray(part) * draw.uniform(0.5, 1.5, 6) for part in usual_friction(task()))
        arm = task().arm.with_payload(gw.arm.Payload(mass, tuple(centre.tolist()), float(mass * draw.uniform(0.0005, 0.005))))
        friction = JointFriction.of(draw.choice(["reference", "full"]), tuple(viscous), tuple(coulomb))
        plant = IdealArm(arm, friction, Sensors.usual(float(draw.uniform(0.1, 1.0)), 6), task().torque, seed=number)
        if needed(plant).max() < 0.98:
            return plant, refused
    raise AssertionError("no plant out of 1000 can hold and rub")


def needed(plant: IdealArm) -> Any:
    """Shares (joints,) of their torque limits that joints need to hold and rub, at the worst place and the worst of some low speeds."""
    limits, ways = task().torque, direction(task().q1)
    still = plant.arm.rnea(task().q, np.zeros_like(task().q), np.zeros_like(task().q))
    slow = (plant.friction.torque(speed * ways, ways) for speed in (0.0, 0.02, 0.035, 0.05, 0.08, 0.15))
    return np.max([np.abs(plant.friction.gain(task().q) * (still + rub)).max(0) for rub in slow], 0) / limits


def one_random(key: Row) -> Row:
    plant, refused = random_plant(key["plant"])
    found = run(task(), make_learner("structured", task()), plant, key.get("trials", 4))
    star = optimum(task(), plant.rows).duration if key["plant"] % JUDGED == 0 else math.nan
    rows = [[t.duration, t.true, t.time_over, t.clean, t.lower_bound or math.nan] for t in found.trials]
    about = {"full": plant.friction.ripple > 0, "mass": plant.arm.payload.mass, "noise": plant.sensors.noise[0], "needed": float(needed(plant).max())}
    return {"refused": refused} | about | {"oracle": star, "rows": rows}


def mujoco(args: argparse.Namespace) -> Iterable[Row]:
    for friction, feedforward in (("full", "learned"), ("full", "nominal"), ("reference", "learned")):
        for seed in range(min(args.seeds, 10)):
            for robot, payloads in (("ur5e", PAYLOADS), ("irb6700", BIG)):
                for payload in payloads:
                    for at in ((0.0, 0.0, 0.08), OFF) if payload else ((0.0, 0.0, 0.08),):
                        yield {
                            "robot": robot,
                            "payload": payload,
                            "at": at,
                            "friction": friction,
                            "feedforward": feedforward,
                            "seed": seed,
                            "trials": 6,
                        }


BIG = (150.0, 180.0, 200.0)
"""Payloads of the larger robot, kg; its controller and the learner know of the first."""


@cache
def large() -> Task:
    """The IRB 6700 with estimated masses along a loop of its joints, 5 s at full speed; its torques hold 200 kg there, and half as much
    again: its description states none."""
    arm = gw.arm.robot("irb6700", estimated=True, payload=BIG[0])
    turn = np.linspace(0, 2 * np.pi, 25)[:-1]
    waves = ([0.5, 0.3, 0.25, 0.3, 0.3, 0.4], [1, 2, 1, 3, 2, 3], [0.0, 0.4, 1.1, 0.2, 0.9, 0.5])
    way = np.stack([size * np.sin(count * turn + phase) for size, count, phase in zip(*waves, strict=True)], 1)
    path = gw.arm.joint_path(arm, np.vstack([way, way[:1]]) + np.array([0.0, 0.1, 0.1, 0.0, 0.4, 0.0]))
    q, still = path.path.eval(np.linspace(0, path.path.length, 200))[0], np.zeros((200, 6))
    torque = 1.5 * np.abs(arm.with_payload(BIG[-1], OFF).rnea(q, still, still)).max(0)
    torque = np.maximum(torque, torque.max() * np.array([0.3, 0.3, 0.3, 0.1, 0.1, 0.1]))
    limits = gw.arm.JointLimits(speed=arm.speed_limits(), acceleration=5.0, torque=tuple(torque.tolist()))
    return Task(path.path, arm, limits)


def one_mujoco(key: Row) -> Row:
    given = large() if key.get("robot") == "irb6700" else task()
    words = {name: key[name] for name in ("payload", "friction", "seed", "feedforward")}
    plant = make_arm("mujoco", given, payload_at=key["at"], **words)
    stars = [optimum(given, plant.rows).duration]  # friction warms up: each trial has an optimum of its own
    found = run(given, make_learner("structured", given), plant, key["trials"], observe=lambda _: stars.append(optimum(given, plant.rows).duration))
    star = stars[-1]
    less = replace(given.limits, torque=tuple((0.99 * given.torque).tolist()))
    price = optimum(Task(given.path, given.arm, less), plant.rows).duration / star
    rows = [
        [t.duration / own, t.true, t.time_over, t.measured, t.clean, t.stopped, (t.lower_bound or math.nan) / own, t.duration / star]
        for t, own in zip(found.trials, stars[:-1], strict=True)
    ]
    return {"rows": rows, "best": found.best, "oracle": star, "price": price}


EXPERIMENTS: dict[str, tuple[Callable[[argparse.Namespace], Iterable[Row]], Callable[[Row], Row]]] = {
    "methods": (methods, one_method),
    "source": (source, one_method),
    "targets": (targets, one_method),
    "random": (random, one_random),
    "mujoco": (mujoco, one_mujoco),
}


def worked(job: tuple[str, Row]) -> Row:
    name, key = job
    try:
        return {"key": key} | EXPERIMENTS[name][1](key)
    except gw.Infeasible as error:
        return {"key": key, "error": str(error)}


def rows_of(name: str, args: argparse.Namespace) -> list[Row]:
    """All runs, those that are on file and those that are done now."""
    OUT.mkdir(exist_ok=True)
    file = OUT / f"learning-{name}.jsonl"
    keys = [json.loads(json.dumps(key)) for key in EXPERIMENTS[name][0](args)]
    known = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    missing = [key for key in keys if all(row["key"] != key for row in known)]
    with file.open("a") as out, multiprocessing.get_context("spawn").Pool(args.workers) as pool:
        for row in tqdm(pool.imap_unordered(worked, [(name, key) for key in missing]), total=len(missing), disable=not sys.stderr.isatty()):
            out.write(json.dumps(row) + "\n")
            out.flush()
            known.append(row)
    return [next(row for row in known if row["key"] == key) for key in keys]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", choices=EXPERIMENTS)
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--plants", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--docs", action="store_true")
    args = parser.parse_args()
    import learning_report

    found = rows_of(args.name, args)
    size = f" --plants {args.plants}" if args.name == "random" else f" --seeds {args.seeds}"
    tables.publish(
        f"learning-{args.name}",
        f"python experiments/arm/learning.py {args.name}{size} --docs",
        learning_report.TEXTS[args.name](found),
        OUT,
        args.docs,
    )


if __name__ == "__main__":
    main()
