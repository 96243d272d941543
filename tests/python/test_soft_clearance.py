"""Soft clearance: ways that keep off obstacles where there is room, by the command line, scene files and Python."""

import json

import numpy as np
import pytest

import guideway as gw
from guideway.cli import main

BLOCK = np.zeros((41, 80), bool)
BLOCK[20:, 30:50] = True  # lower half of the picture: the straight line runs along its upper edge
START, GOAL = (0.25, 2.15), (7.75, 2.15)


def world() -> gw.World:
    return gw.World(BLOCK, resolution=0.1)


def nearest(path: gw.Path, room: gw.World) -> float:
    points = path.eval(np.linspace(0.0, path.length, 500))
    return float(room.clearance(points.reshape(-1, 2)).min())


@pytest.mark.parametrize("planner", ["astar", "dijkstra"])
def test_ways_keep_off_where_there_is_room(planner: str) -> None:
    room = world()
    hard = gw.Query(room, START, GOAL, clearance=0.05)
    soft = gw.Query(room, START, GOAL, clearance=0.05, soft_clearance=(0.6, 4.0))
    near, far = (gw.plan(query, planner, seed=0) for query in (hard, soft))
    assert nearest(near.path, room) < 0.2 < 0.45 < nearest(far.path, room)
    assert far.cost >= far.length - 1e-9
    assert far.length >= near.length
    assert near.cost == near.length
    assert soft.soft_clearance == (0.6, 4.0)
    assert hard.soft_clearance is None
    smooth = gw.refine(far.path, soft).path
    assert nearest(smooth, room) > 0.4


def test_command_and_record(tmp_path, capsys) -> None:
    scene = tmp_path / "room.toml"
    scene.write_text(
        "[world]\nbounds = [0, 0, 8, 4]\n[[polygon]]\npoints = [[3, 0], [5, 0], [5, 2], [3, 2]]\n"
        "[query]\nstart = [0.25, 2.15]\ngoal = [7.75, 2.15]\nclearance = 0.05\nsoft_clearance = [0.6]\n"
    )
    out = tmp_path / "plan.json"
    assert main(["plan", str(scene), "--out", str(out)]) == 0
    record = json.loads(out.read_text())
    assert record["planner"] == "astar"
    assert record["query"]["soft_clearance"] == [0.6, 2.0]
    assert record["metrics"]["min_clearance"] > 0.4
    assert record["certificate"]["ok"]
    assert main(["plan", str(scene), "--soft-clearance", "0,0", "--out", str(out)]) == 0
    assert json.loads(out.read_text())["metrics"]["min_clearance"] < 0.2
    capsys.readouterr()
    for words in (["--planner", "visibility"], ["--soft-clearance", "-1"], ["--soft-clearance", "x"], ["--soft-clearance", "1,2,3"]):
        assert main(["plan", str(scene), *words]) == 2
        assert capsys.readouterr().err.count("\n") <= 3
