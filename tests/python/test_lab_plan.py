"""Runs of planners in the lab: measures, gaps, curves, and who may plan."""

from __future__ import annotations

import math

import numpy as np
import pytest

import guideway as gw
from guideway.lab import Run, measuring, read, worlds
from guideway.lab.kinds import NotAResult, plan

SCENE = {"name": "scene 1", "source": "scene:pso-aco-1"}
PAPER = {"preset": "paper"}


def run_of(method: dict, world=SCENE, query=None, seed=0, folder=".", budget=None) -> Run:
    budget = {"evaluations": 1000} if budget is None else budget
    return Run("test", "plan", str(folder), world, {"name": "", **(query or {})}, {"name": "m", **method}, seed, budget, {})


def test_measures_of_a_lattice_path() -> None:
    found = plan.run(run_of({"planner": "pso-aco", "set": PAPER}, budget={"evaluations": 5000}))
    direct = gw.plan(gw.scenes.load("pso-aco-1").query(), "pso-aco", seed=0, set=PAPER, budget=gw.Budget(evaluations=5000))
    told = found.measures
    assert found.certified
    assert told["length"] == pytest.approx(direct.cost, abs=1e-9)
    assert (told["diagonals"], told["straights"]) == (16, 6)
    assert told["length"] == pytest.approx(16 * math.sqrt(2) + 6, abs=1e-12)
    assert told["energy"] == told["length"] + 0.5 * told["turns"] == told["product_energy"]
    assert (told["gap"], told["hit"], told["accuracy"]) == (0.0, True, 100.0)
    assert told["any_angle_gap"] == pytest.approx(100 * (told["length"] / 27.286095473613887 - 1))
    assert told["evaluations"] == direct.evaluations
    assert found.curve[-1][1] == pytest.approx(told["length"])
    assert found.path[0] == [0.5, 0.5]
    assert set(found.times) >= {"plan", "plan_cpu"}


def test_equal_runs_have_equal_outcomes() -> None:
    run = run_of({"planner": "aco", "set": PAPER, "refine": "smooth"}, seed=4)
    one, other = plan.run(run), plan.run(run)
    assert (one.measures, one.curve, one.path) == (other.measures, other.curve, other.path)


def test_gap_is_that_of_the_own_model() -> None:
    free, bound = (plan.run(run_of({"planner": name})).measures for name in ("visibility", "jump-point"))
    assert free["gap"] == free["any_angle_gap"] == 0.0
    assert "diagonals" not in free
    assert bound["gap"] == 0.0
    assert bound["any_angle_gap"] > 4.9


def test_materials_and_products() -> None:
    safe = plan.run(run_of({"planner": "jump-point"}, query={"material": "long"})).measures
    same = plan.run(run_of({"planner": "jump-point", "query": {"material": "long"}})).measures
    assert (safe["diagonals"], safe["straights"], safe["gap"]) == (15, 8, 0.0)
    assert same == safe
    bent = plan.run(run_of({"planner": "jump-point", "refine": "bspline"})).measures
    assert bent["refined_length"] < bent["length"]
    assert bent["product_length"] == bent["refined_length"]
    assert bent["refined_any_angle_gap"] > 0


def test_curves_count_evaluations() -> None:
    found = plan.run(run_of({"planner": "improved-aco", "set": PAPER}, world={"name": "m30", "source": "scene:m30"}))
    work, best = np.array(found.curve).T
    assert (np.diff(work) > 0).all()
    assert (np.diff(best) < 0).all()
    assert work[-1] == found.measures["last_evaluation"] <= found.measures["evaluations"] == 1000
    near = [n for n, value in found.curve if value <= 1.01 * found.measures["optimum"]]
    assert found.measures["near"] == (near[0] if near else None)


def test_curves_are_thinned_evenly() -> None:
    rows = np.column_stack([np.arange(5000), -np.arange(5000)])
    kept = measuring.thinned(rows, 200)
    assert len(kept) == 200
    assert (kept[0] == rows[0]).all()
    assert (kept[-1] == rows[-1]).all()


def test_lattice_of_corner_points() -> None:
    world = gw.scenes.load("m20").world
    points = world.cell_centers([[0, 19], [3, 16], [3, 12], [5, 12]])
    steps = measuring.lattice(measuring.cells_of(points, world), 1.0)
    assert steps == {"diagonals": 3, "straights": 6, "turns": 2, "length": 3 * math.sqrt(2) + 6, "energy": 3 * math.sqrt(2) + 7}
    assert measuring.cells_of(points + 0.1, world) is None
    assert measuring.cells_of(world.cell_centers([[0, 19], [3, 15]]), world) is None


OWN = """
import guideway as gw
import numpy as np

class Corners:
    def __init__(self, planner="astar"):
        self.planner = planner
    def plan(self, query):
        return np.asarray(gw.plan(query, self.planner).path.control_points)

class Seeded:
    def plan(self, query, seed, budget):
        return gw.plan(query, "aco", seed=seed, budget=budget)

class Straight:
    def plan(self, query, **more):
        return [query.start[:2], query.goal[:2]]

class Nan:
    def plan(self, query):
        return [query.start[:2], [float("nan"), 0.0], query.goal[:2]]

class Words:
    def plan(self, query):
        return "no path"

class Crash:
    def plan(self, query):
        raise ZeroDivisionError("ha")

class Lazy:
    pass
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "own.py").write_text(OWN)
    return tmp_path


def test_planners_of_users(folder) -> None:
    for settings in ({}, {"planner": "dijkstra"}):
        told = plan.run(run_of({"planner": "own.py:Corners", "set": settings}, folder=folder))
        assert told.certified
        assert (told.measures["gap"], told.measures["diagonals"]) == (0.0, 16)
    found = plan.run(run_of({"planner": "own.py:Seeded"}, folder=folder, seed=3))
    same = plan.run(run_of({"planner": "aco"}, seed=3))
    assert found.measures == same.measures


def test_bad_paths_of_users_are_not_certified(folder) -> None:
    assert plan.run(run_of({"planner": "own.py:Straight"}, folder=folder)).certified is False


@pytest.mark.parametrize("name", ["Nan", "Words"])
def test_what_is_no_path_is_no_result(folder, name) -> None:
    with pytest.raises(NotAResult):
        plan.run(run_of({"planner": f"own.py:{name}"}, folder=folder))


def test_errors_of_users_are_raised(folder) -> None:
    with pytest.raises(ZeroDivisionError):
        plan.run(run_of({"planner": "own.py:Crash"}, folder=folder))
    blocked = {"name": "wall", "source": "wall.txt", "query": {"start_cell": [0, 0], "goal_cell": [2, 0]}}
    (folder / "wall.txt").write_text(".#.\n.#.\n.#.\n")
    with pytest.raises(gw.NoPath):
        plan.run(run_of({"planner": "aco"}, world=blocked, folder=folder))


def test_motions_are_timed_and_judged_among_movers() -> None:
    pytest.importorskip("scipy")
    room = {"name": "w0", "make": "room", "room": "w0", "seed": "run"}
    found = plan.run(run_of({"planner": "aide", "timing": "own"}, world=room, query={"condition": "static"}))
    told = found.measures
    assert found.certified
    assert told["over_limit"] == 0
    assert told["regions_left"] == 0
    assert told["objective_gap"] >= 0
    assert told["duration"] > told["length"] / 2.0
    dynamic = plan.run(run_of({"planner": "iascv", "timing": "own"}, world=room, seed=1)).measures
    assert dynamic["free"] + dynamic["hindered"] > 10


def test_homotopy_classes_differ() -> None:
    query = worlds.query({"name": "r", "source": "scene:w0"}, {"condition": "static"})
    ways = gw.plan(query, "aide", seed=0).trace["classes"]
    classes = {plan._class(gw.Path.polyline(np.asarray(way["path"])[:, :2]), query.world) for way in ways}
    assert len(classes) == len(ways) > 1


EXPERIMENT = """
schema = 1
name = "e"
kind = "plan"
seeds = 1
[[worlds]]
name = "w"
source = "scene:m20"
[[methods]]
name = "m"
"""


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ('planner = "acco"', "planner 'acco' is not known: one of dijkstra"),
        ('planner = "aco"\nset = { anst = 3 }', "anst"),
        ('planner = "aco"\nrefine = "polish"', "refine 'polish' is not known"),
        ('planner = "aco"\ntiming = "soon"', "timing 'soon' is not known"),
        ('planner = "aco"\nrepeats = 0', "repeats 0 is not a whole number"),
        ('planner = "own.py:Nobody"', "Nobody"),
        ('planner = "own.py:Lazy"', "no method plan"),
        ('planner = "peer:nobody"', "peer 'nobody' is not known"),
        ("planner = 3", "planner 3 is not a name"),
    ],
)
def test_complaints_come_before_any_run(folder, lines, words) -> None:
    (folder / "e.toml").write_text(EXPERIMENT + lines + "\n")
    with pytest.raises(gw.BadFile, match="method 'm'") as caught:
        read(folder / "e.toml")
    assert words in str(caught.value)


def test_heap_of_a_call() -> None:
    from guideway.lab.kinds.heap import growth

    found = growth(run_of({"planner": "aco"}, world={"name": "c", "make": "complexity", "size": 60, "density": 0.3, "seed": 0}))
    assert found is None or 0 <= found < 200
