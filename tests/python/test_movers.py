"""Motions among movers, judged at every millisecond by positions alone."""

import numpy as np
import pytest

import guideway as gw

KEPT = 0.3


def least(trajectory, scene):
    """Smallest distance (m) to the outlines of boxes and discs, from the tracks alone."""
    rows = trajectory.sample(1000.0)
    t, points = rows[:, 0], rows[:, 1:3]
    gaps = []
    for mover in scene.movers:
        track = np.asarray(mover.track, dtype=float)
        period, tau = track[-1, 0], t + mover.phase
        match mover.loop:
            case "shuttle":
                tau = period - np.abs(tau % (2 * period) - period)
            case "cycle":
                tau = tau % period
        place = np.stack([np.interp(tau, track[:, 0], track[:, axis]) for axis in (1, 2)], axis=1)
        apart = points - place
        if mover.shape.box:
            half = np.asarray(mover.shape.box) / 2
            gaps.append(np.hypot(*np.maximum(np.abs(apart) - half, 0).T))
        else:
            gaps.append(np.hypot(*apart.T) - mover.shape.disc)
    return min(gap.min() for gap in gaps)


@pytest.mark.parametrize(("name", "enough"), [("w0", 0), ("w1", 10)])
def test_along_the_shortest_path(name, enough):
    solved, reasons = 0, []
    for seed in range(10):
        room = gw.scenes.load(name, seed=seed)
        query = room.query()
        assert query.clearance == pytest.approx(KEPT)
        path = gw.plan(query, "iascv", set={"movers": False}).path
        try:
            trajectory = gw.time(path, room.limits, among=query)
        except gw.errors.Infeasible as error:
            reasons.append(str(error))
            continue
        solved += 1
        assert least(trajectory, room.scene) >= KEPT - 1e-9
        assert trajectory.among["movers"] == len(room.scene.movers)
        assert gw.certify(path, query, trajectory)["ok"]
    assert solved >= enough
    assert all("mover " in reason for reason in reasons)


@pytest.mark.parametrize("name", ["w0", "w1"])
@pytest.mark.parametrize("planner", ["iascv", "aide"])
def test_planners_find_a_way(name, planner):
    for seed in range(3):
        room = gw.scenes.load(name, seed=seed)
        query = room.query()
        solution = gw.plan(query, planner, seed=1)
        told = solution.trace["speed"]["movers"]
        assert told["timed"]
        assert told["movers"] == len(room.scene.movers)
        assert least(solution.trajectory, room.scene) >= KEPT - 1e-9
        assert gw.certify(solution.path, query, solution.trajectory)["ok"]


def test_planners_tell_what_became_of_the_movers():
    room = gw.scenes.load("w1")
    query = room.query()
    solution = gw.plan(query, "iascv")
    told = solution.trace["speed"]["movers"]
    assert not told["timed"] or least(solution.trajectory, room.scene) >= KEPT - 1e-9
    assert gw.plan(query, "iascv", set={"movers": False}).trace["speed"]["movers"] is None
    assert gw.time(solution.path, room.limits).among is None
