"""Runs of driving: what is measured, of which drive, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

import guideway as gw
from guideway.errors import BadParameter, NoPath
from guideway.lab import driven, movers
from guideway.lab.experiment import Experiment, Run
from guideway.lab.kinds import NotAResult, drive

W0 = {"name": "w0", "make": "room", "room": "w0", "seed": "run", "condition": "static"}
HALL = {"name": "hall", "make": "crossings", "robot": "default", "seed": "run"}
TOUR = {
    "name": "four",
    "start": [0.5, 29.5],
    "via": [[19.5, 23.5], [8.5, 8.5]],
    "goal": [29.5, 0.5],
    "footprint": {"disc": 0.25},
    "clearance": 0.05,
    "limits": {"speed": 1.0, "acceleration": 1.0, "deceleration": 1.0, "jerk": 5.0, "turn_rate": 2.0, "turn_acceleration": 4.0},
}


def asked(world, method, query=None, seed=0, **budget) -> Run:
    return Run("test", "drive", ".", world, query or {"name": ""}, {"name": "m", **method}, seed, budget, {})


def experiment(**changes) -> Experiment:
    words = {"worlds": ({"name": "w", **{k: v for k, v in W0.items() if k != "name"}},), "queries": ({"name": ""},), "methods": ({"name": "m"},)}
    words |= changes
    rest = dict.fromkeys(("title", "source", "table", "path", "digest"), "")
    more = {"seeds": (0,), "budget": {}, "limits": {}, "metrics": (), "reference": None, "published": (), "claims": (), "quick": {}, "tune": {}}
    return Experiment(name="x", kind="drive", folder=".", **rest, **more, **words)


def test_a_run_is_the_drive_that_the_api_makes() -> None:
    found = drive.run(asked(W0, {"planner": "aide", "timing": "own", "controller": "tracker"}, seed=3, evaluations=500))
    query = gw.scenes.load("w0", 3).query("static")
    plan = gw.plan(query, "aide", seed=3, budget=gw.Budget(evaluations=500))
    record = gw.drive(query, plan.trajectory, "tracker", seed=3)
    told = found.measures
    assert found.certified
    assert told["time"] == record["time"]
    assert told["tpe"] == 100 * record["tracking"]["tpe"]
    assert told["objective"] == plan.cost
    assert told["evaluations"] == plan.evaluations
    assert told["planned"] == plan.path.length
    assert set(told) | set(found.times) >= set(drive.METRICS) - {"way", "reached"}
    assert math.hypot(*np.subtract(found.path[-1], query.goal)) < 0.1


def test_runs_repeat_exactly_clocks_aside() -> None:
    run = asked(HALL, {"refine": "smooth", "arrival": 0.2, "time_factor": 4.0, "way": True, "blind": True}, seed=5)
    first, second = drive.run(run), drive.run(run)
    assert first.measures == second.measures
    assert first.path == second.path
    assert first.measures["reached"] == first.measures["arrived"]


def test_a_seed_is_another_room_and_methods_share_it() -> None:
    sites = {seed: drive.site_of(asked(HALL, {}, seed=seed)) for seed in (1, 2)}
    assert sites[1].query.world.movers != sites[2].query.world.movers
    assert drive.site_of(asked(HALL, {"controller": "dwa"}, seed=1)).query.world.movers == sites[1].query.world.movers
    assert not sites[1].still.world.movers
    assert sites[1].still.world.shapes == sites[1].query.world.shapes


def test_movers_cross_the_exact_path_whatever_the_planner() -> None:
    crossed = {"name": "moving", "source": "scene:m30", "crossed": True}
    one, other = (drive.site_of(asked(crossed, {"planner": name}, TOUR, seed=4)) for name in ("visibility", "astar"))
    assert one.query.world.movers == other.query.world.movers
    assert len(one.query.world.movers) == 4
    path = gw.refine(gw.plan(one.still).path, one.still).path
    line = path.planar(np.linspace(0, path.length, 2000))[:, :2]
    for mover, share in zip(map(movers.Moving, one.query.world.movers), movers.SHARES, strict=False):
        place = path.planar([share * path.length])[0][:2]
        track = np.linspace(mover.places[0], mover.places[-1], 50)
        assert np.hypot(*(track - place).T).min() < 0.1
        assert np.hypot(*(line[:, None] - track[None]).T).min() < 0.1


def test_the_best_order_is_never_longer() -> None:
    swapped = TOUR | {"via": TOUR["via"][::-1]}
    world = {"name": "m30", "source": "scene:m30"}
    lengths = [gw.plan(drive.site_of(asked(world, {}, swapped | {"order": order})).still).cost for order in ("given", "best")]
    assert lengths[1] < lengths[0]


def test_a_refusal_of_the_planner_is_raised_and_a_path_that_is_none_is_not_certified(tmp_path) -> None:
    with pytest.raises(NoPath):
        drive.run(asked(W0, {"planner": "firefly", "set": {"preset": "paper"}, "timing": "trapezoid"}, evaluations=41))
    text = "class Through:\n    def plan(self, query):\n        return [query.start, query.goal]\n"
    (tmp_path / "bad.py").write_text(text + text.replace("Through", "Nothing").replace("[query.start, query.goal]", "7"))
    through = Run("t", "drive", str(tmp_path), W0, {"name": ""}, {"name": "m", "planner": "bad.py:Through", "controller": "tracker"}, 0, {}, {})
    assert drive.run(through).certified is False
    nothing = Run("t", "drive", str(tmp_path), W0, {"name": ""}, {"name": "m", "planner": "bad.py:Nothing"}, 0, {}, {})
    with pytest.raises(NotAResult):
        drive.run(nothing)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"worlds": ({**W0, "condition": "windy"},)}, "condition 'windy'"),
        ({"worlds": ({"name": "w", "make": "crossings", "seed": 1, "sead": 2},)}, "'sead'"),
        ({"queries": ({"name": "q", "order": "random"},)}, "order 'random'"),
        ({"queries": ({"name": "q", "clearence": 1},)}, "'clearence'"),
        ({"methods": ({"name": "m", "controller": "pid"},)}, "controller 'pid'"),
        ({"methods": ({"name": "m", "controller": "dwa", "control": {"safty": 1.0}},)}, "control: 'safty'"),
        ({"methods": ({"name": "m", "planner": "best"},)}, "planner 'best'"),
        ({"methods": ({"name": "m", "timing": "soon"},)}, "timing 'soon'"),
        ({"methods": ({"name": "m", "time_limit": -1},)}, "time_limit -1"),
        ({"methods": ({"name": "m", "time_factor": math.nan},)}, "time_factor nan"),
        ({"methods": ({"name": "m", "replanner": "peer:nano-astar"},)}, "replanner"),
        ({"methods": ({"name": "m", "refine": "polish"},)}, "refine 'polish'"),
    ],
)
def test_what_is_not_known_is_said_before_any_run(changes, word) -> None:
    with pytest.raises(BadParameter, match=word):
        drive.check(experiment(**changes))


def test_a_good_experiment_passes() -> None:
    drive.check(experiment())


def test_steps_are_counted_as_runs() -> None:
    assert driven.runs(np.array([0, 4, 4, 0, -4, 0.0]), 3) == 2
    assert driven.runs(np.array([4.0]), 3) == 1
    assert driven.runs(np.array([]), 3) == 0


def test_tilt_of_a_steady_circle_and_stability() -> None:
    rows = [[0.02 * k, 0, 0, 0, 2.0, 1.0] for k in range(100)]
    mean, rms = driven.leaning(rows)
    assert mean == pytest.approx(math.degrees(2.0 / 9.81))
    assert rms == pytest.approx(mean)
    assert driven.stability(6.25) == 75
    assert driven.stability(30) == 0
    assert driven.leaning(rows[:1]) == (0.0, 0.0)


def test_smoothness_of_straight_and_square() -> None:
    assert driven.smoothness(np.array([[0, 0], [10, 0.0]])) == 1
    zigzag = np.array([[k, k % 2] for k in range(20)], float)
    assert driven.smoothness(zigzag) < 0.8
    assert driven.smoothness(np.array([[0, 0], [0.1, 0.0]])) == 1


def test_accuracy_and_deviation_of_a_drive_beside_its_plan() -> None:
    query = gw.scenes.crossings(1).query()
    driven_rows = [[0.1 * k, 0.1 * k, 0.25, 0, 1, 0] for k in range(100)]
    record = {"driven": driven_rows, "plan": {"polyline": [[0, 0], [20, 0]]}}
    assert driven.accuracy(record) == pytest.approx(75)
    still = query.world.with_movers([])
    assert driven.deviation(record, drive.in_world(query, still)) is None


def test_auc_is_that_of_mann_and_whitney() -> None:
    scores = [(0.9, True), (0.8, True), (0.4, True), (0.4, False), (0.1, False)]
    area, low, high, good, bad = driven.auc(scores)
    assert area == pytest.approx((2 + 2 + 1.5) / 6)
    assert low <= area <= high
    assert (good, bad) == (3, 2)
    assert driven.auc([(0.5, True)]) is None


def test_movers_go_to_and_fro_and_round() -> None:
    track = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0]]
    shuttle = movers.Moving({"track": track, "loop": "shuttle", "phase": 0.5, "shape": {"disc": 0.3}})
    assert shuttle.at(0.0).tolist() == [0.5, 0]
    assert shuttle.at(2.5).tolist() == [1.0, 0]
    assert shuttle.distance((0.5, 1.0), 0.0) == pytest.approx(0.7)
    cycle = movers.Moving({"track": track, "loop": "cycle", "phase": 0.0, "shape": {"box": (1.0, 0.5)}})
    assert cycle.at(3.0).tolist() == [1.0, 0]
    assert cycle.distance((1.0, 0.0), 3.0) == pytest.approx(-0.25)
    assert cycle.distance((2.0, 0.75), 3.0) == pytest.approx(math.hypot(0.5, 0.5))
    wedge = movers.Moving({"track": [[0.0, 0.0, 0.0]], "loop": "once", "phase": 0.0, "shape": {"polygon": [[0.3, 0.4], [-0.1, 0], [0, -0.1]]}})
    assert wedge.distance((2.5, 0.0), 0.0) == pytest.approx(2.0)
    parked = movers.Moving({"track": [[0.0, 1.0, 2.0]], "loop": "shuttle", "phase": 3.0, "shape": {"disc": 0.1}, "appears": {"within": 3.0}})
    assert parked.at(9.0).tolist() == [1, 2]
    assert parked.appears


def test_a_way_in_space_and_time() -> None:
    wall = [{"polygon": {"points": [[4, 0], [5, 0], [5, 4], [4, 4]]}}, {"polygon": {"points": [[4, 5], [5, 5], [5, 9], [4, 9]]}}]
    world = gw.World(bounds=[0, 0, 9, 9], resolution=0.1, shapes=wall)
    gate = {"shape": {"disc": 0.6}, "track": [[0.0, 4.5, 4.5]], "loop": "once", "phase": 0.0}
    query = gw.Query(world, (1, 4.5), (8, 4.5), footprint={"disc": 0.2})
    assert movers.way_exists(query, 20)
    assert not movers.way_exists(query, 5)
    assert not movers.way_exists(drive.in_world(query, world.with_movers([gate])), 60)
