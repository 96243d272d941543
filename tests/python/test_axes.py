"""Point-to-point motion of several axes from Python, and against linear programmes that know nothing of its derivation."""

import json
from pathlib import Path

import numpy as np
import pytest

import guideway as gw

LIMITS = {"velocity": 1.0, "acceleration": 2.0, "jerk": 8.0}
KNOWN = Path(__file__).parents[1] / "data" / "ruckig_known_cases.json"


def test_axes_arrive_together_and_within_their_limits():
    motion = gw.point_to_point([0, 1, 2], [1, -1, 2.2], limits=LIMITS, start_velocity=[0.2, 0, -0.1])
    assert np.all(motion.durations == motion.duration)
    rows = motion.sample(1000)
    assert rows["q"].shape == (len(rows["t"]), 3)
    assert np.allclose(rows["q"][0], [0, 1, 2])
    assert np.allclose(rows["q"][-1], [1, -1, 2.2], atol=1e-12)
    for name, limit in (("qd", 1.0), ("qdd", 2.0), ("qddd", 8.0)):
        assert np.abs(rows[name]).max() <= limit * (1 + 1e-9)
    assert np.allclose(np.gradient(rows["q"], rows["t"], axis=0)[1:-1], rows["qd"][1:-1], atol=1e-4)
    assert [len(p) for p in motion.phases] == [len(p) for p in motion.phases if p.shape[1] == 5]
    assert motion.at(99.0)["q"][1] == -1


def test_a_problem_is_planned_again_and_again():
    problem = gw.PointToPoint([0.0], [1.0], limits=LIMITS, cycle=0.01)
    assert problem.plan().duration == problem.plan().duration
    assert problem.plan().duration == pytest.approx(round(problem.plan().duration, 2))


def test_synchronisation():
    duration = {sync: gw.point_to_point([0, 0], [1, 0.3], limits=LIMITS, sync=sync) for sync in ("none", "time", "phase")}
    assert duration["none"].durations[1] < duration["none"].durations[0] == duration["time"].duration
    assert duration["phase"].straight
    states = duration["phase"].sample(200)["q"]
    assert np.allclose(states[:, 1], 0.3 * states[:, 0], atol=1e-12)


def test_goals_without_position_and_axes_that_take_no_part():
    motion = gw.point_to_point([0, 0, 5], [1, None, 9], goal_velocity=[0, 0.5, 0], limits=LIMITS, enabled=[True, True, False])
    end = motion.at(motion.duration)
    assert end["qd"][1] == 0.5
    assert end["q"][2] == 5
    assert gw.point_to_point([0.0], None, limits=LIMITS).duration == 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"start": [float("nan"), 0]}, "start position of axis 0"),
        ({"goal": [1]}, "one for each of 2 axes"),
        ({"limits": {"velocity": 1, "acceleration": 2}}, "no jerk"),
        ({"limits": LIMITS | {"speed": 1}}, "speed"),
        ({"limits": LIMITS | {"jerk": 0}}, "jerk limit of axis 0"),
        ({"limits": LIMITS | {"velocity": [1, 2, 3]}}, "one for each of 2 axes"),
        ({"goal_velocity": [0, 1.5]}, "goal velocity of axis 1"),
        ({"sync": "some"}, "time, phase or none"),
        ({"cycle": -1.0}, "cycle"),
        ({"minimum_duration": float("inf")}, "minimum_duration"),
        ({"enabled": [True]}, "one for each of 2 axes"),
        ({"goal": [[0, 1], [1, 2]]}, "goal"),
    ],
)
def test_errors_say_what_is_wrong(change, words):
    asked = {"start": [0, 0], "goal": [1, 1], "limits": LIMITS} | change
    with pytest.raises(gw.BadParameter, match=words):
        gw.point_to_point(**asked)


def test_times_that_are_no_times():
    motion = gw.point_to_point([0.0], [1.0], limits=LIMITS)
    for call in (lambda: motion.at(float("nan")), lambda: motion.sample(0.0), lambda: motion.sample(times=[float("nan")])):
        with pytest.raises(gw.BadParameter):
            call()


def test_a_velocity_limit_of_zero_forbids_a_direction():
    with pytest.raises(gw.Infeasible, match="axis 0"):
        gw.point_to_point([0.0], [-1.0], limits=LIMITS | {"min_velocity": 0.0})


def known(case):
    given = case["input"]
    by_velocity = given.get("control_interface") == "Velocity"
    limits = {"velocity": given["max_velocity"], "acceleration": given["max_acceleration"], "jerk": given["max_jerk"]}
    limits |= {key: given.get(key) for key in ("min_velocity", "min_acceleration")}
    return gw.point_to_point(
        given["current_position"],
        None if by_velocity else given["target_position"],
        start_velocity=given["current_velocity"],
        start_acceleration=given["current_acceleration"],
        goal_velocity=given["target_velocity"],
        goal_acceleration=given["target_acceleration"],
        limits=limits,
        minimum_duration=given.get("minimum_duration") or 0.0,
        cycle=0.004 if given.get("duration_discretization") == "Discrete" else None,
    )


@pytest.mark.parametrize("case", json.loads(KNOWN.read_text())["cases"], ids=lambda case: f"line {case['source_line']}")
def test_known_durations(case):
    assert known(case).duration == pytest.approx(case["duration_by_ruckig_0.19.4"], rel=1e-10, abs=1e-10)


def reach(time, start, end, limits, pieces):
    """Least and most distance in exactly `time` with jerk constant on `pieces` equal parts, limits kept at their ends: a linear programme."""
    optimize = pytest.importorskip("scipy.optimize")
    (v0, a0), (v1, a1) = start, end
    vmin, vmax, amin, amax, jerk = limits
    h, number = time / pieces, np.arange(1, pieces + 1)
    after, before = number[:, None], np.arange(pieces)[None, :]
    accelerations = np.where(before < after, h, 0.0)
    velocities = np.where(before < after, h * h * (after - before - 0.5), 0.0)
    left = pieces - np.arange(pieces)
    distance = h**3 * (left**2 / 2 - left / 2 + 1 / 6)
    drift = v0 + a0 * h * number
    rows = np.vstack([accelerations, -accelerations, velocities, -velocities])
    bounds = np.concatenate([np.full(pieces, amax - a0), np.full(pieces, a0 - amin), vmax - drift, drift - vmin]) + 1e-12
    found = []
    for sign in (1, -1):
        answer = optimize.linprog(
            sign * distance,
            A_ub=rows,
            b_ub=bounds,
            A_eq=np.vstack([accelerations[-1], velocities[-1]]),
            b_eq=[a1 - a0, v1 - v0 - a0 * time],
            bounds=[(-jerk, jerk)] * pieces,
            method="highs",
        )
        if answer.status != 0:
            return None
        found.append(v0 * time + a0 * time * time / 2 + sign * answer.fun)
    return found


def probe(cases, pieces, seed):
    """Durations at random: ours says whether an axis can have them, the linear programme (a little poorer in motions) says it too."""
    rng = np.random.default_rng(seed)
    possible = impossible = 0
    for _ in range(cases):
        vmax, amax, jerk = rng.uniform(0.3, 2, 3)
        vmin, amin = -rng.uniform(0.3, 2, 2)
        v0, a0, v1 = rng.uniform(vmin, vmax), rng.uniform(amin, amax), rng.uniform(vmin, vmax)
        a1 = np.clip(a0 * rng.uniform(0.3, 1.2), amin, amax) if rng.random() < 0.4 else rng.uniform(amin, amax)
        distance = rng.normal() * (0.3 if rng.random() < 0.5 else 3)
        if not vmin <= v0 + a0 * abs(a0) / (2 * jerk) <= vmax:
            continue
        limits = {"velocity": vmax, "acceleration": amax, "jerk": jerk, "min_velocity": vmin, "min_acceleration": amin}
        ends = {"start_velocity": v0, "start_acceleration": a0, "goal_velocity": v1, "goal_acceleration": a1}

        def first(time, distance=distance, limits=limits, ends=ends):
            try:
                return gw.point_to_point([0.0], [distance], limits=limits, minimum_duration=time, **ends).duration
            except gw.GuidewayError:
                return float("inf")

        fastest = first(0.0)
        scale = fastest if np.isfinite(fastest) else 3.0
        for time in scale * np.concatenate([rng.uniform(0.02, 0.999, 3), rng.uniform(1.02, 3, 3)]):
            ours = abs(first(time) - time) < 1e-9
            span = reach(time, (v0, a0), (v1, a1), (vmin, vmax, amin, amax, jerk), pieces)
            theirs = span is not None and span[0] - 1e-9 <= distance <= span[1] + 1e-9
            assert ours or not theirs, (time, fastest, span, distance, limits, ends)
            if ours:
                slack = 30 * jerk * time**3 / pieces**2
                assert span is None or span[0] - slack <= distance <= span[1] + slack, (time, fastest, span, distance, limits, ends)
            possible, impossible = possible + ours, impossible + (not ours)
    assert possible > cases
    assert impossible > cases
    return possible, impossible


def test_durations_against_linear_programmes():
    probe(6, 40, 1)


@pytest.mark.slow
def test_many_durations_against_linear_programmes():
    probe(200, 100, 2)
