"""Via points on the warehouse map: passed exactly, without a stop, with continuous speed and acceleration, certified."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import guideway as gw
from guideway.jobs import Job, run

WAREHOUSE = Path(gw.__file__).parent / "data" / "warehouse.yaml"
LIMITS = gw.Limits(speed=1.0, acceleration=0.5, deceleration=0.5, jerk=2.0, turn_rate=1.0, lateral_acceleration=0.5)
ROUTES = [
    [(6.67, 10.72), (13.16, -3.80), (-5.94, 4.51), (11.53, 17.50)],
    [(13.24, -5.86), (-14.22, -13.87), (-1.88, -0.10), (-8.50, -1.92)],  # comes back on both via points
    [(9.63, 23.32), (2.11, -16.39), (11.09, 23.90), (6.15, 0.56)],  # turns round
]


@pytest.mark.parametrize("route", ROUTES)
def test_no_stop_at_via_points(route):
    start, *via, goal = route
    outcome = run(Job(gw.World.load(str(WAREHOUSE)), start, goal, via=via, footprint={"disc": 0.35}, clearance=0.1, limits=LIMITS))
    assert outcome.record["certificate"]["ok"]
    assert outcome.record["unmet"] == []
    motion = outcome.trajectory
    assert motion is not None
    # No stop on the way at all: one motion, without turns in place, whose speed is zero at its ends alone.
    pieces = motion.pieces
    assert all("turn" not in piece for piece in pieces)
    assert all(piece["speed"] > 0 for piece in pieces[1:])
    for last, piece in pairwise(pieces):
        dt, jerk = last["duration"], last["jerk"]
        assert piece["acceleration"] == pytest.approx(last["acceleration"] + jerk * dt, abs=1e-9)
        assert piece["speed"] == pytest.approx(last["speed"] + dt * (last["acceleration"] + 0.5 * jerk * dt), abs=1e-9)
    s = 0.0
    for point in via:
        rows = outcome.path.eval(np.linspace(s, outcome.path.length, 200_001))
        points = np.asarray(rows).reshape(200_001, -1)[:, :2]
        distance = np.hypot(*(points - point).T)
        near = int(np.argmax(distance < 2e-3))
        near += int(np.argmin(distance[near : near + 200]))
        s += near * (outcome.path.length - s) / 200_000
        assert distance[near] < 1e-3  # the certificate holds it to 1e-6
