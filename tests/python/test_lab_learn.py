"""Runs of learning: the judgement of trials, random plants, and what is refused."""

from __future__ import annotations

import math

import pytest

from guideway.errors import BadParameter, Infeasible
from guideway.lab.experiment import Run
from guideway.lab.kinds import learn
from test_lab_drive import experiment

pytest.importorskip("pinocchio")
STAR = {"name": "star", "make": "arm", "payload": 5.0}


def asked(method, world=None, seed=0) -> Run:
    return Run("test", "learn", ".", world or STAR, {"name": ""}, {"name": "m", **method}, seed, {}, {})


def test_a_run_is_judged_against_the_optimum_of_the_true_plant() -> None:
    found = learn.run(asked({"learner": "source", "trials": 40}, seed=2))
    told = found.measures
    assert set(told) == set(learn.METRICS)
    assert told["optimum"] == pytest.approx(2.3053, abs=2e-3)
    assert told["last_ratio"] == pytest.approx(told["duration"] / told["optimum"])
    assert told["feasible"]
    assert told["violation"] <= 0
    assert told["to_feasible"] <= told["trials"]
    assert [row[0] for row in found.curve] == sorted({row[0] for row in found.curve})
    assert found.curve[0][0] == told["to_feasible"]
    assert found.curve[-1][1] == told["ratio"]
    assert told["within"]
    again = learn.run(asked({"learner": "source", "trials": 40}, seed=2))
    assert again.measures == told
    assert again.curve == found.curve


def test_no_learning_is_too_fast_and_has_no_feasible_trial() -> None:
    told = learn.run(asked({"learner": "kinematic", "trials": 1})).measures
    assert told["ratio"] is None
    assert told["to_feasible"] is None
    assert not told["feasible"]
    assert told["last_ratio"] < 0.9
    assert told["violation"] > 30
    assert told["time_over"] > 0.5


def test_the_default_learner_meets_its_targets() -> None:
    told = learn.run(asked({"learner": "structured", "trials": 6}, {**STAR, "noise": 0.5}, seed=1)).measures
    assert told["soon"]
    assert told["late"]
    assert told["close"]
    assert 0.9 < told["bound_ratio"] <= 1


def test_a_random_plant_is_a_function_of_the_seed() -> None:
    task = learn._task("ur5e", "star", 10.0, learn._torque({}))
    one, same, other = (learn.random_plant(task, number) for number in (3, 3, 5))
    assert one.arm.payload == same.arm.payload
    assert one.friction == same.friction
    assert one.arm.payload.mass != other.arm.payload.mass


def test_what_cannot_stand_still_is_infeasible() -> None:
    with pytest.raises(Infeasible):
        learn.run(asked({"learner": "nominal", "trials": 1}, {**STAR, "payload": 50.0}))


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"worlds": ({"name": "w"},)}, "make None"),
        ({"worlds": ({"name": "w", "make": "arm", "plant": "clay"},)}, "plant 'clay'"),
        ({"worlds": ({"name": "w", "make": "arm", "payload": -1.0},)}, "payload -1.0"),
        ({"worlds": ({"name": "w", "make": "arm", "noise": math.nan},)}, "noise nan"),
        ({"methods": ({"name": "m", "learner": "guess"},)}, "learner 'guess'"),
        ({"methods": ({"name": "m", "learner": "source", "trials": 0},)}, "trials 0"),
        ({"methods": ({"name": "m", "learner": "source", "set": {"stride": 1}},)}, "stride"),
        ({"worlds": ({"name": "w", "make": "arm", "friction": "wet"},)}, "friction 'wet'"),
        ({"worlds": ({"name": "w", "make": "arm", "torque": [1.0, 2.0]},)}, "torque"),
        ({"worlds": ({"name": "w", "make": "arm", "robot": "r2d2"},)}, "robot 'r2d2'"),
        ({"worlds": ({"name": "w", "make": "arm", "random": 1},)}, "random 1"),
    ],
)
def test_what_is_not_known_is_said_before_any_run(changes, word) -> None:
    words = {"worlds": (STAR,), "methods": ({"name": "m", "learner": "source"},)} | changes
    with pytest.raises(BadParameter, match=word):
        learn.check(experiment(**words))
