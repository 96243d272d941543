"""What is recommended for which map."""

from __future__ import annotations

import pytest

import guideway as gw
from guideway.lab import packaged, read


def test_dense_maps_and_mazes_get_a_short_swarm() -> None:
    for scene in (gw.scenes.complexity(30, 0.5, 0), gw.scenes.complexity(70, 0.5, 3), gw.scenes.environment("maze", 7, 30)):
        query = scene.query()
        found = gw.recommended("pso-aco", query)
        assert found["swarm_iterations"] == 5
        assert gw.plan(query, "pso-aco", set=found, budget=gw.Budget(evaluations=2500)).planner == "pso-aco"
    assert gw.recommended("pso-aco", gw.scenes.complexity(30, 0.1, 0).query()) == {}
    assert gw.recommended("pso-aco", gw.scenes.load("w0").query("static")) == {}
    assert gw.recommended("improved-aco", gw.scenes.complexity(30, 0.1, 0).query())["polish"] == 2
    assert gw.recommended("astar", gw.scenes.load("m20").query()) == {}
    with pytest.raises(gw.BadParameter, match="planner = acco"):
        gw.recommended("acco", gw.scenes.load("m20").query())


@pytest.mark.parametrize("advice", gw.advice(), ids=lambda advice: advice["planner"])
def test_advice_is_what_its_experiment_judges(advice) -> None:
    experiment = read(packaged()[advice["evidence"]])
    methods = [method for method in experiment.methods if method["planner"] == advice["planner"]]
    assert any({**advice["set"], "seeding": "off"} == {"seeding": "off", **method["set"]} for method in methods)
    gw.parameters(advice["planner"], advice["set"])


def test_the_recommended_swarm_is_better_where_it_is_recommended() -> None:
    query = gw.scenes.environment("maze", 21, 30).query()
    best = gw.plan(query, "jump-point").cost
    gaps = {}
    for name, settings in (("default", {}), ("recommended", {"preset": "recommended"})):
        runs = [gw.plan(query, "pso-aco", seed=s, set={"seeding": "off", **settings}, budget=gw.Budget(evaluations=2500)) for s in range(5)]
        gaps[name] = sum(run.cost / best - 1 for run in runs)
    assert gaps["recommended"] <= gaps["default"]
