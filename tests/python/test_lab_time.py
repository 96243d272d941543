"""Runs of timing: courses, the dense check of limits, and answers of ours."""

from __future__ import annotations

import math

import numpy as np
import pytest

import guideway as gw
from guideway.errors import BadParameter
from guideway.lab import courses
from guideway.lab.experiment import Run
from guideway.lab.kinds import time
from test_lab_drive import experiment

LIMITS = {"speed": math.pi, "acceleration": math.radians(800)}
SPLINE, AXES = {"name": "s", "make": "spline", "seed": "run"}, {"name": "a", "make": "axes", "seed": "run", "asymmetric": True}


def asked(world, timing, seed=0, limits=None, **method) -> Run:
    query = {"name": "q", **({"limits": limits or LIMITS} if world is SPLINE else {})}
    return Run("test", "time", ".", world, query, {"name": "m", "timing": timing, **method}, seed, {}, {})


@pytest.mark.parametrize("timing", ["reachability", "bisection"])
def test_ours_keep_limits_between_grid_points(timing) -> None:
    found = time.run(asked(SPLINE, timing, 4, calls=2))
    assert found.measures["kept"] is True
    assert found.measures["excess"] == 0
    assert found.times["call_cpu"] > 0
    assert found.certified


def test_the_two_methods_agree_and_jerk_costs_time() -> None:
    one, other = (time.run(asked(SPLINE, name, 4)).measures["duration"] for name in ("reachability", "bisection"))
    assert one == pytest.approx(other, rel=1e-5)
    smooth = time.run(asked(SPLINE, "jerk", 4, LIMITS | {"jerk": math.radians(10_000)})).measures
    assert smooth["kept"]
    assert smooth["excess_jerk"] == 0
    assert smooth["duration"] > one


def test_excess_is_found_where_a_motion_is_too_fast() -> None:
    course = courses.Along(6, 3, 1, LIMITS)
    s = np.linspace(0, 1, 301)
    motion = gw.time_joints(course.path, course.limits)
    right = courses.Timed.ours(course, motion, 0.0)
    fast = courses.Timed.along(course, s, np.full(301, 4.0), 0.0)
    q1 = np.abs(course.curve(np.linspace(0, 1, 6001), 1)).max()
    assert right.excess == 0
    assert fast.duration == pytest.approx(0.5)
    assert fast.excesses["speed"] == pytest.approx(100 * (2 * q1 / math.pi - 1), rel=1e-3)


def test_a_profile_of_third_order_is_checked_for_jerk() -> None:
    course = courses.Along(6, 2, 1, LIMITS | {"jerk": 1000.0})
    s = np.linspace(0, 1, 401)
    # s = 10 t^3 - 15 t^4 + 6 t^5 over two seconds, from rest to rest
    t = np.linspace(0, 2, 20001) / 2
    v, u = (30 * t**2 - 60 * t**3 + 30 * t**4) / 2, (60 * t - 180 * t**2 + 120 * t**3) / 4
    path = 10 * t**3 - 15 * t**4 + 6 * t**5
    told = courses.Timed.third(course, s, np.interp(s, path, v) ** 2, np.interp(s, path, u), 2.0, 0.0)
    w = (60 - 360 * t + 360 * t**2) / 8
    at, q = path[:, None] * 0, [course.curve(path, order) for order in (1, 2, 3)]
    v, u, w = (part[:, None] for part in (v, u, w))
    jerk = np.abs(at + q[0] * w + 3 * q[1] * v * u + q[2] * v**3).max()
    assert told.excesses["jerk"] == pytest.approx(max(100 * (jerk / 1000 - 1), 0), abs=1.0)
    assert told.excesses["speed"] == pytest.approx(max(100 * (np.abs(q[0] * v).max() / math.pi - 1), 0), rel=1e-2)


def test_point_to_point_ends_at_its_goal_within_limits() -> None:
    for seed in range(20):
        told = time.run(asked(AXES, "point-to-point", seed)).measures
        assert told["kept"], seed


def test_states_are_drawn_from_the_seed_and_can_be_come_from() -> None:
    first, same, other = (time.course_of(AXES, {"name": ""}, seed) for seed in (1, 1, 2))
    assert np.array_equal(first.goal, same.goal)
    assert not np.array_equal(first.goal, other.goal)
    assert first.goal.shape == (7,)
    v, a, jerk = first.ends["goal_velocity"], first.ends["goal_acceleration"], first.limits["jerk"]
    before = v - a * np.abs(a) / (2 * jerk)
    assert (before < first.limits["velocity"]).all()
    assert (before > first.limits["min_velocity"]).all()


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"worlds": ({"name": "w", "make": "loop"},)}, "make 'loop'"),
        ({"worlds": ({**SPLINE, "axes": 3},)}, "'axes'"),
        ({"worlds": ({**SPLINE, "points": "ten"},)}, "points 'ten'"),
        ({"worlds": ({**SPLINE, "points": 1},)}, "points 1"),
        ({"worlds": ({**SPLINE, "joints": 2.5},)}, "joints 2.5"),
        ({"queries": ({"name": "q"},)}, "limits None"),
        ({"queries": ({"name": "q", "limits": {"speed": 1.0, "acceleration": -1.0}},)}, "above 0"),
        ({"queries": ({"name": "q", "limits": {"speed": 1.0, "acceleration": 1.0, "snap": 1.0}},)}, "snap"),
        ({"methods": ({"name": "m", "timing": "point-to-point"},)}, "axes"),
        ({"methods": ({"name": "m", "timing": "quick"},)}, "timing 'quick'"),
        ({"methods": ({"name": "m", "timing": "reachability", "calls": 0},)}, "calls 0"),
        ({"methods": ({"name": "m", "timing": "reachability", "set": {"gird": 1}},)}, "gird"),
        ({"methods": ({"name": "m", "timing": "peer:ompl-rrt-star"},)}, "ompl-rrt-star"),
        ({"methods": ({"name": "m", "timing": "peer:toppra", "set": {"grid": 1}},)}, "grid"),
    ],
)
def test_what_is_not_known_is_said_before_any_run(changes, word) -> None:
    words = {"worlds": (SPLINE,), "queries": ({"name": "q", "limits": LIMITS},), "methods": ({"name": "m", "timing": "reachability"},)}
    with pytest.raises(BadParameter, match=word):
        time.check(experiment(**(words | changes)))
