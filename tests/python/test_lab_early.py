"""What is wrong with an experiment is told before any run, and planners of users do not get in the way of each other."""

from __future__ import annotations

import math
import random
import sys

import numpy as np
import pytest

import guideway as gw
from guideway import lab
from guideway.lab import journal, read
from guideway.lab.execute import execute
from guideway.lab.experiment import Run
from guideway.lab.pool import Local
from guideway.lab.summary import summary

TEXT = """
schema = 1
name = "early"
kind = "{kind}"
seeds = 2
{world}
{query}
[[methods]]
name = "m"
planner = "aco"
{method}
"""
WORLD = '[[worlds]]\nname = "w"\nsource = "scene:pso-aco-1"'


def said(tmp_path, kind="plan", world=WORLD, query="", method=""):
    path = tmp_path / "early.toml"
    path.write_text(TEXT.format(kind=kind, world=world, query=query, method=method), "utf-8")
    with pytest.raises(gw.BadFile) as found:
        read(path)
    return str(found.value)


@pytest.mark.parametrize("kind", ["plan", "drive"])
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"world": '[[worlds]]\nname = "w"\nsource = "none.map"'}, ["'none.map'", "no file"]),
        ({"world": '[[worlds]]\nname = "w"\nsource = "none.json.gz#3"'}, ["no file", "none.json.gz"]),
        ({"world": '[[worlds]]\nname = "w"\nsource = "scene:none"'}, ["scene:none"]),
        ({"world": '[[worlds]]\nname = "w"\nmake = "complexity"\nsize = 100000\ndensity = 0.1\nseed = 0'}, ["size 100000"]),
        ({"query": '[[queries]]\nname = "q"\nmaterial = "wool"'}, ["material", "wool"]),
        ({"query": '[[queries]]\nname = "q"\nclearance = -1.0'}, ["clearance -1.0"]),
        ({"query": '[[queries]]\nname = "q"\nstart = [nan, 1.0]'}, ["start", "nan"]),
        ({"query": '[[queries]]\nname = "q"\nstart = ["a", 1.0]'}, ["start"]),
        ({"query": '[[queries]]\nname = "q"\nlimits = [1]'}, ["limits [1]"]),
        ({"query": '[[queries]]\nname = "q"\nlimits = { velocity = 1 }'}, ["limits.velocity"]),
        ({"query": '[[queries]]\nname = "q"\ngoal_cell = [true, 1]'}, ["goal_cell"]),
        ({"method": "set = { preset = 'none' }"}, ["preset", "none"]),
        ({"method": "set = { evaporation = -1 }"}, ["evaporation", "-1"]),
        ({"method": "set = { evaporation = 'much' }"}, ["evaporation", "much"]),
        ({"method": "[tune]\nmethod = 'm'\nmetric = 'success'\n[tune.space]\nevaporation = { low = 0.1, high = 7.0 }"}, ["evaporation", "7"]),
        ({"method": "[tune]\nmethod = 'm'\nmetric = 'success'\n[tune.space]\nheuristic = { among = ['goal', 'luck'] }"}, ["heuristic", "luck"]),
    ],
)
def test_what_would_fail_in_every_run_is_told_first(tmp_path, kind, changes, words):
    told = said(tmp_path, kind, **changes)
    assert all(word in told for word in words), told


def test_a_map_without_a_query_is_told_first(tmp_path):
    (tmp_path / "hall.map").write_text("type octile\nheight 3\nwidth 4\nmap\n....\n....\n....\n")
    world = '[[worlds]]\nname = "hall"\nsource = "hall.map"'
    told = said(tmp_path, world=world)
    assert "no start is given" in told
    assert "query = { start" in told
    path = tmp_path / "early.toml"
    path.write_text(TEXT.format(kind="plan", world=world + "\nquery = { start = [0.5, 0.5], goal = [3.5, 2.5] }", query="", method=""), "utf-8")
    assert len(read(path).runs()) == 2


@pytest.mark.parametrize(("missing", "world"), [("pinocchio", ""), ("mujoco", "plant = 'mujoco'")])
def test_learning_without_its_libraries_is_told_first(tmp_path, monkeypatch, missing, world):
    pytest.importorskip("pinocchio")
    monkeypatch.setitem(sys.modules, missing, None)
    path = tmp_path / "early.toml"
    text = f"schema = 1\nname = 'early'\nkind = 'learn'\n[[worlds]]\nname = 'w'\nmake = 'arm'\n{world}\n[[methods]]\nname = 'm'\nlearner = 'source'\n"
    path.write_text(text, "utf-8")
    with pytest.raises(gw.BadFile, match="pip install 'guideway"):
        read(path)


class Gives:
    """Returns anything."""

    def __init__(self, thing):
        self.thing = thing

    def plan(self, query):
        return self.thing


class History:
    """Arrays as history."""

    def plan(self, query):
        exact = gw.plan(query, "visibility")
        return type("Found", (), {"path": exact.path, "evaluations": 3, "history": np.array([[1.0, 90.0], [3.0, 50.0]])})()


class Careless:
    """Draws from what all of Python shares."""

    def plan(self, query):
        return gw.plan(query, "rrt-connect", seed=random.randrange(1000) + int(1000 * np.random.rand()))


class Wrecks:
    """Leaves nothing as it was."""

    def plan(self, query):
        import os

        sys.path.clear()
        os.environ.clear()
        os.chdir("/")
        gw._core.certify = lambda *_: {"ok": True}
        gw.plan = None
        return [query.start, query.goal]


def test_what_is_no_path_says_what_it_is(tmp_path):
    things = {"none": None, "nan": [(0.5, 0.5), (math.nan, 1.0)], "one": [(0.5, 0.5)], "text": "left, then right"}
    found = lab.compare({name: Gives(thing) for name, thing in things.items()}, ["scene:pso-aco-1"], seeds=1, out=tmp_path, workers=1)
    told = {record["method"]: (record["status"], record["error"]["type"], record["error"]["message"]) for record in found.records}
    for name, words in {"none": "it returned None", "nan": "not finite", "one": "shape (1, 2)", "text": "'left, then right'"}.items():
        assert told[name][:2] == ("invalid", "NotAPath")
        assert words in told[name][2]
    assert "none: 1 invalid, NotAPath: it returned None" in str(found)


def test_planners_of_users_do_not_meet(tmp_path):
    others = {"astar": "astar", "careless": Careless(), "history": History()}
    alone = lab.compare(others, ["scene:pso-aco-1", "scene:m20"], seeds=2, out=tmp_path / "a", workers=1)
    among = lab.compare({"wrecks": Wrecks(), **others}, ["scene:pso-aco-1", "scene:m20"], seeds=2, out=tmp_path / "b", workers=1)
    mine = [record for record in among.records if record["method"] != "wrecks"]
    assert [record["status"] for record in alone.records] == ["ok"] * 12
    key = ("world", "method", "seed", "status", "measures", "path", "curve")
    assert [[record[name] for name in key] for record in mine] == [[record[name] for name in key] for record in alone.records]
    lengths = {record["seed"]: record["measures"]["length"] for record in mine if (record["method"], record["world"]) == ("careless", "scene:m20")}
    assert len(set(lengths.values())) == 2


def test_workers_are_replaced_after_a_planner_of_a_user_alone(tmp_path):
    (tmp_path / "mine.py").write_text("class One:\n    def plan(self, query):\n        return [query.start, query.goal]\nTwo = One\n", "utf-8")
    methods = [{"name": str(number), "planner": name} for number, name in enumerate(["astar", "mine.py:One", "dijkstra", "mine.py:Two"])]
    runs = [
        Run("x", "plan", str(tmp_path), {"name": "w", "source": "scene:m20"}, {"name": ""}, method, seed, {}, {"seconds": 60, "memory_mib": 4096})
        for seed in range(4)
        for method in methods
    ]
    crew, processes, owners = Local(1), set(), []
    for record in crew.records(runs, "d"):
        child = crew._children[0]
        processes.add(child.process.pid)
        owners.append(record["method"])
    crew.close()
    assert len(owners) == 16
    assert len(processes) == 2  # ours and One, Two
    assert sorted(owners[:8]) == ["0"] * 4 + ["2"] * 4


def test_errors_of_any_text_are_kept(tmp_path):
    (tmp_path / "mine.py").write_text("class Odd:\n    def plan(self, query):\n        raise ValueError('\\ud800 odd')\n", "utf-8")
    world, method = {"name": "w", "source": "scene:m20"}, {"name": "odd", "planner": "mine.py:Odd"}
    record = execute(Run("x", "plan", str(tmp_path), world, {"name": ""}, method, 0, {}, {"seconds": 60, "memory_mib": 4096}), "d")
    assert record["error"] == {"type": "ValueError", "message": "? odd"}


def test_a_changed_file_is_another_experiment(tmp_path):
    pytest.importorskip("statsmodels")
    for place in (tmp_path, tmp_path / "elsewhere"):
        place.mkdir(exist_ok=True)
        (place / "hall.map").write_text("type octile\nheight 3\nwidth 4\nmap\n....\n....\n....\n")
        (place / "mine.py").write_text("class One:\n    def plan(self, query):\n        return [query.start, query.goal]\n", "utf-8")
        world = '[[worlds]]\nname = "w"\nsource = "hall.map"\nquery = { start = [0.5, 0.5], goal = [3.5, 2.5] }'
        text = TEXT.format(kind="plan", world=world, query="", method="").replace('"aco"', '"mine.py:One"')
        (place / "early.toml").write_text(text, "utf-8")
    first = read(tmp_path / "early.toml")
    assert read(tmp_path / "elsewhere" / "early.toml").digest == first.digest
    lab.run(first, tmp_path / "out", workers=1)
    assert read(tmp_path / "out" / "early.toml").digest == first.digest  # the copy knows where the files are
    for name in ("hall.map", "mine.py"):
        path = tmp_path / "elsewhere" / name
        path.write_text(path.read_text().replace("3", "4").replace("query.goal]", "query.goal, query.goal]"))
        changed = read(tmp_path / "elsewhere" / "early.toml", check=False)
        assert changed.digest != first.digest
        records = journal.read(tmp_path / "out" / "early.jsonl")
        assert [summary(one, records)["runs"]["stale"] for one in (first, changed)] == [0, 2]
        with pytest.raises(gw.BadParameter, match="another version"):
            lab.run(changed, tmp_path / "out", workers=1, resume=True)
        path.write_text((tmp_path / name).read_text())


def test_seeds_that_are_too_many_are_refused(tmp_path):
    path = tmp_path / "early.toml"
    path.write_text(TEXT.format(kind="plan", world=WORLD, query='[[queries]]\nname = "a"\n[[queries]]\nname = "b"', method=""), "utf-8")
    assert len(lab.with_seeds(read(path), 50_000).runs()) == 100_000
    with pytest.raises(gw.BadParameter, match="100002 runs"):
        lab.with_seeds(read(path), 50_001)
