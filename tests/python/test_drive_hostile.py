"""Drives that go wrong end in a defined way: by the command line, and in a control loop of one's own."""

import json
import math

import numpy as np
import pytest

import guideway as gw
from guideway.cli import main

ROOM = """
[world]
bounds = [0, 0, 10, 6]
[robot]
footprint = { disc = 0.25 }
acceleration = 1.0
turn_rate = 2.0
turn_acceleration = 4.0
[query]
start = [2, 3, 0]
goal = [8, 3]
clearance = 0.1
"""
LIDAR = ["--sense", "lidar"]
NO_MAP = [*LIDAR, "--map", "none"]


def mover(x, y, radius, at=0.0):
    return f"[[mover]]\nshape = {{ disc = {radius} }}\npath = [[{x}, {y}]]\n" + (f"appears = {{ at = {at} }}\n" if at else "")


def ring(at):
    """14 discs around the start."""
    angles = (2 * math.pi * k / 14 for k in range(14))
    return "".join(mover(2 + 1.3 * math.cos(a), 3 + 1.3 * math.sin(a), 0.35, at) for a in angles)


def drive(tmp_path, movers, words, seconds):
    (tmp_path / "room.toml").write_text(ROOM + movers)
    code = main(["drive", str(tmp_path / "room.toml"), *words, "--time-limit", str(seconds), "--out", str(tmp_path / "run.json")])
    run = json.loads((tmp_path / "run.json").read_text())
    return code, run, {event["kind"] for event in run["events"]}


@pytest.mark.parametrize("words", [[], LIDAR, NO_MAP])
def test_walled_in_it_is_stuck_and_says_so(tmp_path, words):
    code, run, kinds = drive(tmp_path, ring(0.2), words, 60)
    assert (code, run["outcome"], run["collision"]) == (3, "stuck", None)
    assert "no-plan" in kinds
    assert run["min_separation"] > 0


@pytest.mark.parametrize("words", [[], LIDAR, NO_MAP])
def test_before_a_goal_that_stays_occupied_it_stands(tmp_path, words):
    code, run, kinds = drive(tmp_path, mover(8, 3, 0.4), words, 60)
    assert (code, run["collision"]) == (3, None)
    assert run["outcome"] in ("stuck", "timeout")
    assert {"stop", "no-plan"} & kinds
    assert run["min_separation"] > 0


@pytest.mark.parametrize("words", [[], LIDAR, NO_MAP])
def test_an_obstacle_that_appears_on_the_robot_is_a_collision_it_could_not_avoid(tmp_path, words):
    code, run, _ = drive(tmp_path, mover(2.05, 3, 0.5, at=0.1), words, 20)
    assert (code, run["outcome"]) == (3, "collision")
    assert run["collision"]["with"] == "mover 0"
    assert run["collision"]["unavoidable"]


def test_a_start_that_is_walled_in_on_the_map_has_no_plan(tmp_path, capsys):
    wall = "".join(
        f"[[disc]]\ncenter = [{2 + 1.3 * math.cos(a)}, {3 + 1.3 * math.sin(a)}]\nradius = 0.35\n" for a in np.arange(14) * 2 * math.pi / 14
    )
    (tmp_path / "room.toml").write_text(ROOM + wall)
    assert main(["drive", str(tmp_path / "room.toml")]) == 3
    assert "no path" in capsys.readouterr().err.lower()


class Loop:
    """A robot without lags behind a pilot with a lidar, 20 times a second."""

    def __init__(self):
        world = gw.World(bounds=(0, 0, 10, 6), resolution=0.05)
        limits = gw.Limits(1.0, 1.0, jerk=5.0, turn_rate=2.0, turn_acceleration=4.0)
        query = gw.Query(world, (1, 3), (9, 3), footprint={"disc": 0.25}, clearance=0.1, limits=limits)
        self.pilot = gw.Pilot(query, gw.time(gw.plan(query).path, limits), "improved-dwa", lidar={"beams": 90, "range": 12.0})
        self.x, self.v, self.t = 1.0, 0.0, 0.0

    def run(self, steps, scan, clock=lambda t: t):
        """Stops of these steps."""
        stops = []
        for _ in range(steps):
            step = self.pilot.step(clock(self.t), (self.x, 3.0, 0.0), self.v, 0.0, scan=scan)
            self.v += min(max(step["v"] - self.v, -0.05), 0.05)
            self.x, self.t = self.x + 0.05 * self.v, self.t + 0.05
            stops.append(step["stop"])
        return stops


CLEAR, BROKEN = np.full(90, np.inf), np.full(90, np.nan)


@pytest.mark.parametrize("scan", [None, BROKEN])
def test_a_lidar_that_goes_silent_or_measures_nothing_stops_it_until_it_sees(scan):
    loop = Loop()
    assert loop.run(40, CLEAR) == [None] * 40
    assert loop.v > 0.5
    blind = loop.run(60, scan)
    assert blind[0] is None
    assert blind[-1] == "nothing is seen"
    assert loop.v == 0.0
    stood = loop.x
    loop.run(40, CLEAR)
    assert loop.x > stood + 0.3


def test_a_clock_that_jumps_is_no_danger_and_no_end():
    loop = Loop()
    loop.run(20, CLEAR)
    for leap in (100.0, -50.0):
        assert loop.run(1, None, lambda t, leap=leap: t + leap) == ["nothing is seen"]
        before = loop.x
        stops = loop.run(30, CLEAR, lambda t, leap=leap: t + leap)
        assert stops[-1] is None
        assert loop.x > before + 0.2
    assert loop.run(1, CLEAR, lambda _: math.nan) == ["the pose, the speeds or the time are not finite"]
