"""A kind of experiment for tests of the lab: small searches of the core, and methods that misbehave at seed 1."""

import contextlib
import ctypes
import os
import time
from functools import cache

import numpy as np

import guideway as gw
from guideway.lab import Metric, Outcome

METRICS = {"length": Metric("length", "m"), "turns": Metric("turns")}
FIELDS = ("planner", "how", "seconds")
WORLD_FIELDS = ("size", "source")
QUERY_FIELDS = ("corners",)


@cache
def query(size, corners):
    blocked = np.random.default_rng(size).random((size, size)) < 0.15
    blocked[0, :] = blocked[:, -1] = False
    return gw.Query(gw.World(blocked), (0.5, size - 0.5), (size - 0.5, 0.5), corners=corners)


def forever():
    found = []
    while True:
        found.append(bytes(100_000))


def scribble():
    for descriptor in range(3, 100):
        with contextlib.suppress(OSError):
            os.write(descriptor, b"\0\0\0\4none")


def leave():
    raise SystemExit(3)


def nothing():
    raise gw.NoPath("there is none")


MISCHIEF = {
    "segfault": lambda: ctypes.string_at(0),
    "hang": lambda: ctypes.PyDLL(None).sleep(1000),  # holds the lock of the interpreter
    "sleep": lambda: time.sleep(1000),
    "leave": leave,
    "exit": lambda: os._exit(4),
    "abort": os.abort,
    "close": lambda: os.closerange(0, 1000),
    "large": lambda: bytearray(1 << 33),
    "many": forever,
    "none": nothing,
    "error": lambda: [][object()],
    "scribble": scribble,
    "fork": os.fork,
    "killed": lambda: os.kill(os.getpid(), 9),
}
"""What methods do instead of work."""

RESULTS = {
    "nan": Outcome({"length": float("nan")}),
    "infinite": Outcome({"length": 1.0}, path=[[0.0, 0.0], [float("inf"), 1.0]]),
    "colliding": Outcome({"length": 1.0}, path=[[0.0, 0.0], [1.0, 1.0]], certified=False),
    "nonsense": "a path",
}
"""Results that are none."""


def run(run):
    how = run.method.get("how", "")
    if run.seed == 1 and how in MISCHIEF:
        MISCHIEF[how]()
    if run.seed == 1 and how in RESULTS:
        return RESULTS[how]
    time.sleep(run.method.get("seconds", 0.0))
    if "planner" not in run.method:
        return Outcome({"length": float(run.seed)})
    asked = query(run.world["size"], run.query.get("corners", "touch"))
    found = gw.plan(asked, run.method["planner"], seed=run.seed, budget=gw.Budget(**run.budget))
    curve = [[float(iteration), cost] for iteration, cost in found.history.tolist()]
    points = gw.polyline(found.path, asked).tolist()
    return Outcome({"length": found.length, "evaluations": found.evaluations}, curve, points, gw.certify(found.path, asked)["ok"])
