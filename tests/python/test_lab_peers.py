"""Peers: the same answers for the same seed, budgets kept, refusals as ours, and no package needed to know them."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

import guideway as gw
from guideway.errors import BadParameter, NoPath
from guideway.lab import peers
from guideway.lab.extra import MissingExtra
from guideway.lab.peers import grids, optimizers

OMPL = [name for name in peers.PEERS if name.startswith("ompl")]
GRIDS = [name for name, peer in peers.PEERS.items() if peer.home.startswith("grids")]
SMALL = {"motion-planning-rrt-star": {"samples": 300}}


@pytest.fixture(scope="module")
def room() -> gw.Query:
    return gw.scenes.load("w0").query("static")


@pytest.mark.parametrize("name", OMPL)
def test_ompl_keeps_its_budget_and_repeats_itself(name, room) -> None:
    pytest.importorskip("ompl")
    plan = peers.planner(name)
    first, same, other = (plan(room, seed, gw.Budget(evaluations=2000)) for seed in (4, 4, 5))
    assert first.points == same.points
    assert first.evaluations == same.evaluations <= 2400
    assert first.points != other.points
    assert gw.certify(first.path, room)["ok"]
    assert first.path.length >= gw.plan(room).cost - 1e-9
    works, best = zip(*first.history, strict=True)
    assert list(works) == sorted(works)
    assert list(best) == sorted(best, reverse=True)
    assert best[-1] == pytest.approx(first.path.length)


def test_ompl_in_a_grid_and_where_there_is_no_path() -> None:
    pytest.importorskip("ompl")
    world = gw.World(np.array([[0, 1, 0], [0, 1, 0], [0, 1, 0]]))
    with pytest.raises(NoPath):
        peers.planner("ompl-rrt-star")(gw.Query(world, (0.5, 0.5), (2.5, 2.5)), 0, gw.Budget(evaluations=500))
    with pytest.raises(gw.StartBlocked):
        peers.planner("ompl-rrt-star")(gw.Query(world, (1.5, 1.5), (2.5, 2.5)), 0, gw.Budget(evaluations=500))
    query = gw.scenes.load("m20").query()
    answer = peers.planner("ompl-rrt-connect")(query, 1, gw.Budget(evaluations=5000))
    assert gw.certify(answer.path, query)["ok"]


def test_ompl_needs_a_budget_and_no_via(room) -> None:
    pytest.importorskip("ompl")
    with pytest.raises(BadParameter, match="budget"):
        peers.planner("ompl-rrt-star")(room, 0, gw.Budget(iterations=5))
    through = gw.Query(room.world, room.start, room.goal, via=[(1.0, 0.5)])
    with pytest.raises(gw.GuidewayError, match="via"):
        peers.planner("ompl-rrt-star")(through, 0, gw.Budget(evaluations=50))


@pytest.mark.parametrize("name", GRIDS)
def test_grid_planners_are_anchored_and_repeat_themselves(name) -> None:
    pytest.importorskip(peers.PEERS[name].module)
    query = gw.scenes.load("m20").query(corners="clear")
    plan = peers.planner(name, SMALL.get(name))
    first, same = (plan(query, 3) for _ in range(2))
    assert first.points == same.points
    assert first.points[0] == query.start
    assert first.points[-1] == query.goal


def test_grid_astars_have_the_exact_length() -> None:
    query = gw.scenes.load("m20").query(corners="clear")
    best = gw.lattice_optimum(query.world, (0, 19), (19, 0), corners="clear")["length"]
    for name in ("nano-astar", "motion-planning-astar"):
        pytest.importorskip(peers.PEERS[name].module)
        assert peers.planner(name)(query).path.length == pytest.approx(best)


def test_the_lattice_of_a_room_is_where_the_robot_fits(room) -> None:
    blocked, start, goal = grids.lattice(room)
    world = room.world
    centers = world.cell_centers([(c, r) for r in range(0, world.height, 7) for c in range(0, world.width, 7)])
    told = [bool(blocked[r, c]) for r in range(0, world.height, 7) for c in range(0, world.width, 7)]
    assert told == [d < room.radius - 1e-9 for d in world.clearance(centers)] or start in ((r, 0) for r in range(world.height))
    assert not blocked[start]
    assert not blocked[goal]
    ends = np.asarray(grids.through(room, [start, goal]))
    assert np.abs(ends[1] - room.start[:2]).max() <= world.resolution
    assert np.abs(ends[-2] - room.goal[:2]).max() <= world.resolution


def bowl(x) -> float:
    return float(((np.asarray(x) - 0.3) ** 2).sum())


@pytest.mark.parametrize("name", [name for name, peer in peers.PEERS.items() if peer.kind == "minimize"])
def test_optimizers_keep_their_budget_and_repeat_themselves(name) -> None:
    pytest.importorskip(peers.PEERS[name].module)
    minimize = peers.optimizer(name)
    first, same, other = (minimize(bowl, [(-1, 1)] * 3, seed, gw.Budget(evaluations=1000)) for seed in (1, 1, 2))
    assert first == same
    assert first.x != other.x
    assert first.evaluations <= 1000
    assert first.value == bowl(first.x) < 0.05
    assert first.history[-1][1] == first.value
    assert all(-1 <= v <= 1 for v in first.x)


def test_an_optimizer_needs_evaluations_and_finite_values() -> None:
    pytest.importorskip("scipy")
    with pytest.raises(BadParameter, match="evaluations"):
        peers.optimizer("scipy-de")(bowl, [(-1, 1)], 0, gw.Budget(seconds=1.0))
    with pytest.raises(gw.GuidewayError, match="finite"):
        peers.optimizer("scipy-de")(lambda _x: math.inf, [(-1, 1)] * 2, 0, gw.Budget(evaluations=100))
    counted = optimizers._Counted(bowl, 2)
    assert [counted([0.0]), counted([0.3]), counted([0.3])] == [pytest.approx(0.09), 0.0, math.inf]
    assert counted.count == 2


def test_unknown_names_and_settings_are_refused_without_a_package() -> None:
    with pytest.raises(BadParameter, match="not known for plan"):
        peers.find("peer:ruckig", "plan")
    with pytest.raises(BadParameter, match="no parameter 'depth'"):
        peers.planner("ompl-rrt-star", {"depth": 3})
    assert peers.find("peer:ompl-rrt-star", "plan") is peers.find("ompl-rrt-star", "plan")


def test_a_missing_package_is_one_clear_error(monkeypatch, room) -> None:
    monkeypatch.setitem(sys.modules, "nano_astar", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    with pytest.raises(MissingExtra, match=r"nano-astar is not installed: pip install 'guideway\[peers\]'"):
        peers.planner("nano-astar")(room)


def test_timing_peers_beside_ours() -> None:
    from guideway.lab.kinds import time
    from test_lab_time import AXES, LIMITS, SPLINE, asked

    ours = time.run(asked(SPLINE, "reachability", 4)).measures["duration"]
    for name in ("toppra", "copp-py"):
        pytest.importorskip(peers.PEERS[name].module)
        found = time.run(asked(SPLINE, f"peer:{name}", 4)).measures
        assert found["duration"] == pytest.approx(ours, rel=2e-3)
        assert 0 <= found["excess"] < 3
    smooth = time.run(asked(SPLINE, "peer:copp-py-jerk", 4, LIMITS | {"jerk": math.radians(10_000)}, set={"intervals": 300})).measures
    assert smooth["duration"] > ours
    with pytest.raises(BadParameter, match="jerk"):
        time.run(asked(SPLINE, "peer:toppra", 4, LIMITS | {"jerk": 100.0}))
    pytest.importorskip("ruckig")
    one, other = (time.run(asked(AXES, name, 6)).measures for name in ("point-to-point", "peer:ruckig"))
    assert one["duration"] == pytest.approx(other["duration"], abs=1e-9)
    assert other["kept"]
