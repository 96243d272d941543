"""Runs of optimizers in the lab."""

from __future__ import annotations

import numpy as np
import pytest

import guideway as gw
from guideway.lab import Run, problems, read
from guideway.lab.kinds import minimize


def run_of(method: dict, world: dict, seed: int = 0, evaluations: int = 1000) -> Run:
    return Run("test", "minimize", ".", {"name": "w", **world}, {"name": ""}, {"name": "m", **method}, seed, {"evaluations": evaluations}, {})


@pytest.mark.parametrize("function", problems.FUNCTIONS)
def test_functions_have_their_optimum_inside(function) -> None:
    problem = problems.problem({"name": "p", "function": function, "dimensions": 5})
    place = np.ones(5) if function == "rosenbrock" else np.zeros(5)
    assert problem.one(place) == pytest.approx(0.0, abs=1e-12)
    low, high = problem.bounds.T
    assert (low < place).all()
    assert (place < high).all()
    assert (np.abs((low + high) / 2 - place) > 0.01).all()  # the middle is no minimum
    draws = np.random.default_rng(0).uniform(low, high, (50, 5))
    assert (problem.many(draws) > 0).all()
    assert problem.many(draws)[7] == problem.one(draws[7])


def test_functions_agree_with_the_compiled_ones() -> None:
    problem = problems.problem({"name": "p", "function": "ackley", "dimensions": 4})
    compiled = gw.minimize("ackley", problem.bounds, "de", seed=1, budget=400)
    assert problem.one(compiled.x) == pytest.approx(compiled.value, rel=1e-12)


def test_a_run_measures_what_was_found() -> None:
    found = minimize.run(run_of({"optimizer": "cma-es"}, {"function": "sphere", "dimensions": 5}, evaluations=3000))
    assert found.certified
    assert found.measures["error"] < 1e-6
    assert found.measures["log_error"] <= -6
    assert found.measures["evaluations"] <= 3000
    assert found.curve[-1][1] == pytest.approx(found.measures["value"])
    assert found.measures == minimize.run(run_of({"optimizer": "cma-es"}, {"function": "sphere", "dimensions": 5}, evaluations=3000)).measures


def test_way_points_among_discs() -> None:
    found = minimize.run(run_of({"optimizer": "l-shade"}, {"function": "ways"}, evaluations=20_000))
    assert found.measures["feasible"]
    assert 10.8 < found.measures["value"] < 11.6


def test_peers_have_the_same_budget() -> None:
    pytest.importorskip("scipy")
    found = minimize.run(run_of({"optimizer": "peer:scipy-de"}, {"function": "rastrigin", "dimensions": 5}))
    assert found.certified
    assert found.measures["evaluations"] <= 1000
    work = [n for n, _ in found.curve]
    assert work == sorted(set(work))


EXPERIMENT = """
schema = 1
name = "e"
kind = "minimize"
seeds = 1
budget = { evaluations = 100 }
"""
WORLD, METHOD = '[[worlds]]\nname = "w"\nfunction = "sphere"\n', '[[methods]]\nname = "m"\noptimizer = "de"\n'


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (WORLD.replace("sphere", "cube") + METHOD, "function 'cube' is not known"),
        (WORLD + "dimensions = 1\n" + METHOD, "dimensions 1 is not a whole number"),
        (WORLD + "seed = 1\n" + METHOD, "'seed' is no field of sphere"),
        (WORLD + "shift = 2\n" + METHOD, "shift 2 is not a share"),
        (WORLD + METHOD.replace("de", "ed"), "optimizer 'ed' is not known"),
        (WORLD + METHOD + "set = { scaling = 1 }\n", "'scaling' is no parameter of de"),
        (WORLD + METHOD.replace('"de"', '"peer:nobody"'), "peer 'nobody' is not known"),
    ],
)
def test_complaints_come_before_any_run(tmp_path, lines, words) -> None:
    (tmp_path / "e.toml").write_text(EXPERIMENT + lines)
    with pytest.raises(gw.BadFile) as caught:
        read(tmp_path / "e.toml")
    assert words in str(caught.value)
