"""A user's own planners on his own maps, and parameters sought for a method."""

import json

import numpy as np
import pytest

import guideway as gw
from guideway import lab
from guideway.lab import journal


class Straight:
    """Right where the way is free."""

    def plan(self, query):
        return np.array([query.start, query.goal])


class Counts:
    """Would remember the runs before, if it lived on."""

    def __init__(self):
        self.calls = 0

    def plan(self, query, seed=0):
        self.calls += 1
        if self.calls > 1:
            raise ValueError(f"call {self.calls}")
        return gw.plan(query, "rrt-connect", seed=seed)


def a_wall():
    blocked = np.zeros((12, 16), bool)
    blocked[2:10, 8] = True
    return gw.Query(gw.World(blocked, 0.5, (1.0, 2.0, 0.0)), (1.75, 5.0), (8.0, 5.0), footprint=gw.Disc(0.1), clearance=0.1)


def statuses(found, method):
    return [record["status"] for record in found.records if record["method"] == method]


def test_own_planners_on_own_maps(tmp_path):
    free = gw.Query(gw.World(np.zeros((5, 5), bool)), (0.5, 0.5), (4.5, 4.5))
    worlds = [free, a_wall(), "scene:pso-aco-1", gw.scenes.complexity(12, 0.2, 1), {"name": "maze", "make": "environment", "kind": "maze", "seed": 1}]
    found = lab.compare({"straight": Straight(), "counts": Counts(), "exact": "visibility"}, worlds, seeds=2, out=tmp_path, workers=2)
    assert len(found.records) == 5 * 3 * 2
    assert statuses(found, "straight") == ["ok", "ok"] + ["invalid"] * 8
    assert statuses(found, "counts") == statuses(found, "exact") == ["ok"] * 10
    exact = gw.plan(a_wall(), "visibility").length
    assert [r["measures"]["length"] for r in found.records if r["method"] == "exact" and r["world"] == "world 2"] == pytest.approx(
        [exact, exact], rel=1e-5
    )
    assert "straight   2/10" in str(found)


def test_a_comparison_goes_on_where_it_stopped(tmp_path):
    first = lab.compare({"exact": "visibility"}, [a_wall()], seeds=2, out=tmp_path, workers=1)
    with pytest.raises(gw.BadParameter, match="resume=True"):
        lab.compare({"exact": "visibility"}, [a_wall()], seeds=3, out=tmp_path, workers=1)
    more = lab.compare({"exact": "visibility"}, [a_wall()], seeds=3, out=tmp_path, workers=1, resume=True)
    assert more.records[:2] == first.records
    assert len(more.records) == 3


def test_what_cannot_be_compared_is_told(tmp_path):
    for planners, worlds, told in (
        ({}, [a_wall()], "at least one planner"),
        ({"none": object()}, [a_wall()], "plan\\(query\\)"),
        ({"unknown": "a-star"}, [a_wall()], "a-star"),
        ({"lost": "nowhere.py:Name"}, [a_wall()], "no such file"),
        ({"locked": type("Locked", (), {"plan": lambda self, query: 0, "__reduce__": lambda self: 1 / 0})()}, [a_wall()], "cannot be copied"),
    ):
        with pytest.raises(gw.GuidewayError, match=told):
            lab.compare(planners, worlds, seeds=1, out=tmp_path / str(len(list(tmp_path.iterdir()))), workers=1)


OWN = """
import guideway as gw
class Own:
    def __init__(self, better=True):
        self.better = better
    def plan(self, query, seed, budget):
        return gw.plan(query, "astar" if self.better else "dijkstra").path
def make():
    return Own()
"""

FILE = """
schema = 1
name = "own"
kind = "plan"
seeds = 1
[[worlds]]
name = "one"
source = "scene:m20"
[[methods]]
name = "{planner} {better}"
planner = "own.py:{planner}"
each = { planner = ["Own"], "set.better" = [true, false] }
[[methods]]
name = "made"
planner = "own.py:make"
"""


def test_a_planner_is_named_by_file_and_name(tmp_path):
    (tmp_path / "own.py").write_text(OWN)
    (tmp_path / "own.toml").write_text(FILE)
    trial = lab.read(tmp_path / "own.toml")
    assert [method["name"] for method in trial.methods] == ["Own true", "Own false", "made"]
    assert lab.run(trial, tmp_path / "out", workers=1) == {"ok": 3}
    (tmp_path / "own.toml").write_text(FILE.replace("own.py:make", "own.py:missing"))
    with pytest.raises(gw.BadFile, match="missing"):
        lab.read(tmp_path / "own.toml")


TUNE = """
schema = 1
name = "sought"
kind = "plan"
seeds = 2
budget = { evaluations = 200 }
metrics = ["gap"]
[[worlds]]
name = "random {size}"
make = "complexity"
density = 0.3
seed = 1
each = { size = [12, 14] }
[[methods]]
name = "aco"
planner = "aco"
set = { preset = "paper" }
[tune]
method = "aco"
metric = "gap"
trials = 6
seeds = 2
check = 4
groups = { small = ["random 12"], both = ["random *"] }
[tune.space]
ants = { low = 5, high = 30 }
evaporation = { low = 0.01, high = 0.9, log = true }
beta = { low = 1.0, high = 15.0, step = 0.5 }
heuristic = { among = ["goal", "detour"] }
"""


def test_a_search_for_parameters_goes_on_where_it_stopped(tmp_path):
    pytest.importorskip("optuna")
    path = tmp_path / "sought.toml"
    path.write_text(TUNE)
    whole = lab.tune(lab.read(path), tmp_path / "whole", workers=2)
    (tmp_path / "broken").mkdir()
    lines = (tmp_path / "whole" / "sought.tune.jsonl").read_bytes().splitlines(keepends=True)
    (tmp_path / "broken" / "sought.tune.jsonl").write_bytes(b"".join(lines[:20]) + lines[20][:50])
    with pytest.raises(gw.BadParameter, match="--resume"):
        lab.tune(lab.read(path), tmp_path / "broken", workers=1)
    assert lab.tune(lab.read(path), tmp_path / "broken", workers=1, resume=True) == whole
    keys = [journal.key_of(record) for record in journal.read(tmp_path / "broken" / "sought.tune.jsonl")]
    assert len(set(keys)) == len(keys) == len(lines)
    assert json.loads((tmp_path / "whole" / "sought.tuned.json").read_text()) == whole
    small, both = whole["groups"]
    assert (small["worlds"], both["worlds"]) == (["random 12"], ["random 12", "random 14"])
    assert len(small["trials"]) == 6
    assert small["best"]["value"] == min(trial["value"] for trial in small["trials"] if not trial["failed"])
    assert small["evidence"]["seeds"] == [2, 3, 4, 5]
    assert small["trials"][0]["set"] == {"preset": "paper"}


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('method = "aco"', 'method = "pso"', "field method"),
        ('metric = "gap"\ntrials', 'metric = "gab"\ntrials', "field metric"),
        ('["random 12"]', '["nothing*"]', "groups"),
        ("low = 5, high = 30", "low = 30, high = 5", "field high"),
        ("low = 0.01", "low = 0", "field high"),
        ("step = 0.5", "step = 50.0", "field step"),
        ('among = ["goal", "detour"]', "among = []", "field among"),
        ("low = 5, high = 30", "low = 5, height = 30", "field high"),
        ("trials = 6", "trials = 0", "field trials"),
    ],
)
def test_what_is_wrong_with_a_search_is_named(tmp_path, old, new, told):
    assert old in TUNE
    path = tmp_path / "sought.toml"
    path.write_text(TUNE.replace(old, new))
    with pytest.raises(gw.BadFile) as error:
        lab.read(path)
    assert told in str(error.value)
