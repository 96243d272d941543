"""A control loop of one's own: the pilot drives a kinematic robot that is written here."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import guideway as gw
from guideway.errors import BadParameter

LIMITS = gw.Limits(speed=1.0, acceleration=1.0, deceleration=1.0, jerk=5.0, turn_rate=2.0, turn_acceleration=4.0)
ROOM = {"bounds": (0, 0, 10, 6), "resolution": 0.05}


def motion(world, start=(1, 3), goal=(9, 3)):
    query = gw.Query(world, start, goal, footprint={"disc": 0.25}, clearance=0.1, limits=LIMITS)
    path = gw.refine(gw.plan(query).path, query).path
    return query, gw.time(path, LIMITS, start_yaw=0.0)


class Base:
    """A unicycle without lags; accelerations are limited."""

    def __init__(self, x, y, yaw=0.0):
        self.pose, self.v, self.w = [x, y, yaw], 0.0, 0.0

    def move(self, v, w, dt=0.05):
        self.v += min(max(v - self.v, -LIMITS.deceleration * dt), LIMITS.acceleration * dt)
        self.w += min(max(w - self.w, -4 * dt), 4 * dt)
        x, y, yaw = self.pose
        middle = yaw + 0.5 * self.w * dt
        self.pose = [x + self.v * dt * math.cos(middle), y + self.v * dt * math.sin(middle), yaw + self.w * dt]


def loop(pilot, base, seconds, tracks=(), start=0.0):
    steps = []
    for k in range(round(seconds / 0.05)):
        step = pilot.step(start + 0.05 * k, base.pose, base.v, base.w, tracks=list(tracks))
        base.move(step["v"], step["w"])
        steps.append(step)
    return steps


def test_a_loop_of_ones_own_arrives():
    world = gw.World(**ROOM, shapes=[{"disc": {"center": [5, 3], "radius": 0.6}}])
    query, trajectory = motion(world)
    pilot = gw.Pilot(query, trajectory, "tracker")
    base = Base(1.0, 3.0)
    steps = loop(pilot, base, trajectory.duration + 4)
    assert math.dist(base.pose[:2], (9, 3)) < 0.1
    assert pilot.replans == 0
    assert pilot.path[0].tolist() == [1.0, 3.0]
    assert len(pilot.sub_goals) >= 2
    assert steps[0]["sub_goal"] == pilot.sub_goals[0].tolist()


def test_a_parked_obstacle_is_planned_around_and_told_in_events():
    world = gw.World(**ROOM)
    query, trajectory = motion(world)
    pilot = gw.Pilot(query, trajectory, "tracker")
    base = Base(1.0, 3.0)
    parked = {"position": (5.0, 3.0), "shape": {"disc": 0.4}}
    steps = loop(pilot, base, 30, [parked])
    kinds = [event["kind"] for step in steps for event in step["events"]]
    assert pilot.replans >= 1
    assert {"stop", "blocked", "tabu", "replan", "go"} <= set(kinds)
    assert math.dist(base.pose[:2], (9, 3)) < 0.1
    assert any(step["stop"] and "mover 0" in step["stop"] for step in steps)
    assert steps[0]["tracks"] == [[5.0, 3.0, 0.4, 0.0, 0.0]]


def test_override_stop_and_go():
    query, trajectory = motion(gw.World(**ROOM))
    pilot = gw.Pilot(query, trajectory, "tracker")
    base = Base(1.0, 3.0)
    loop(pilot, base, 3.0)
    pilot.override = 0.5
    assert pilot.override == 0.5
    half = loop(pilot, base, 2.0, start=3.0)
    assert 0.3 < half[-1]["v"] < 0.55
    pilot.stop()
    held = loop(pilot, base, 2.0, start=5.0)
    assert (held[-1]["v"], held[-1]["w"], held[-1]["stop"]) == (0.0, 0.0, "held")
    pilot.go()
    loop(pilot, base, 20, start=7.0)
    assert math.dist(base.pose[:2], (9, 3)) < 0.1
    for share in (-0.1, 1.1, math.nan):
        with pytest.raises(BadParameter, match="override"):
            pilot.override = share


def test_scans_instead_of_tracks_and_a_lidar_that_goes_silent():
    query, trajectory = motion(gw.World(**ROOM))
    pilot = gw.Pilot(query, trajectory, "tracker", lidar={"beams": 90, "range": 12.0}, map="none")
    nothing = np.full(90, np.inf)
    steps = [pilot.step(0.05 * k, (1, 3, 0), 0, 0, scan=nothing) for k in range(4)]
    assert steps[-1]["stop"] is None
    silent = [pilot.step(0.2 + 0.05 * k, (1, 3, 0), 0, 0) for k in range(20)]
    assert silent[0]["stop"] is None
    assert silent[-1]["stop"] == "nothing is seen"
    assert silent[-1]["v"] == 0.0
    broken = pilot.step(2.0, (1, 3, 0), 0, 0, scan=np.full(90, np.nan))
    assert broken["stop"] == "nothing is seen"


@pytest.mark.parametrize(
    ("how", "match"),
    [
        ({"controller": "nobody"}, "controller"),
        ({"map": "some"}, "map"),
        ({"map": "none"}, "map"),
        ({"lidar": {"beams": -1}}, "lidar"),
        ({"lidar": {"rate": 0}}, "rate"),
        ({"lidar": {"beams": 9}, "mover_speed": -1.0}, "mover_speed"),
        ({"planner": "nobody"}, "planner"),
    ],
)
def test_what_makes_no_sense_is_refused(how, match):
    query, trajectory = motion(gw.World(**ROOM))
    given = {"controller": "tracker"} | how
    with pytest.raises(BadParameter, match=match):
        gw.Pilot(query, trajectory, given.pop("controller"), **given)


def test_tracks_that_make_no_sense_are_refused():
    query, trajectory = motion(gw.World(**ROOM))
    pilot = gw.Pilot(query, trajectory, "tracker")
    for track in ({"position": (1, 2)}, {"position": (1e10, 2), "shape": {"disc": 0.1}}, {"position": (1, 2), "shape": {"disc": 0.1}, "bound": -1}):
        with pytest.raises(BadParameter, match="tracks"):
            pilot.step(0.0, (1, 3, 0), 0, 0, tracks=[track])
    with pytest.raises(BadParameter, match="lidar"):
        pilot.step(0.0, (1, 3, 0), 0, 0, scan=[1.0])


def test_plans_can_be_made_in_another_thread():
    query, trajectory = motion(gw.World(**ROOM))
    parked = {"position": (5.0, 3.0), "shape": {"disc": 0.4}}
    pilot = gw.Pilot(query, trajectory, "tracker", wait=False)
    base, made = Base(1.0, 3.0), []
    for k in range(600):
        step = pilot.step(0.05 * k, base.pose, base.v, base.w, tracks=[parked])
        base.move(step["v"], step["w"])
        assert pilot.replans == len(made), "a step after"
        if pilot.plan_due:
            assert not step["replanned"]
            assert [event["kind"] for event in step["events"]][-1] == "asked"
            with ThreadPoolExecutor(1) as other:
                made.append(other.submit(pilot.plan).result())
    assert made == [True] * len(made)
    assert made
    assert not pilot.plan(), "nothing is due"
    assert math.dist(base.pose[:2], (9, 3)) < 0.1
    asleep = gw.Pilot(query, trajectory, "tracker", wait=False)
    base = Base(1.0, 3.0)
    steps = loop(asleep, base, 30, [parked])
    assert asleep.plan_due
    assert asleep.replans == 0
    assert steps[-1]["stop"]
    assert base.pose[0] < 4.4, "it waits for its plan"
