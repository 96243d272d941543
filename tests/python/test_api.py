"""The Python package as its users call it."""

import threading

import numpy as np
import pytest

import guideway as gw

ROOM = np.zeros((40, 60), bool)
ROOM[10:30, 20:24] = ROOM[5:12, 40:44] = True


@pytest.fixture
def world():
    return gw.World(ROOM, resolution=0.1, origin=(1.0, 2.0, 0.0))


def test_scurve_regression():
    motion = gw.scurve(34**0.5, speed=2.0, acceleration=5.0, jerk=10.0)
    assert motion.duration == pytest.approx(3.80990, abs=1e-5)
    assert gw.scurve(1.0, speed=2.0, acceleration=5.0, deceleration=3.0, jerk=10.0, start=(0.0, 0.5)).duration == pytest.approx(1.43805, abs=1e-5)
    end = motion.at([0.0, motion.duration])
    assert end[:, 0] == pytest.approx([0.0, 34**0.5], abs=1e-9)
    with pytest.raises(gw.Infeasible) as error:
        gw.scurve(0.01, speed=2.0, acceleration=1.0, jerk=1.0, start=(2.0, 0.0))
    assert error.value.best_end_speed is not None
    with pytest.raises(gw.BadParameter):
        gw.scurve(1.0, speed=-1.0, acceleration=1.0, jerk=1.0)


def test_from_map_to_motion(world):
    query = gw.Query(world, start=(1.5, 4.0, 0.0), goal=(6.5, 4.0), footprint=gw.Disc(0.15), clearance=0.05)
    solution = gw.plan(query)
    path = gw.refine(solution.path, query).path
    motion = gw.time(path, gw.Limits(turn_rate=1.0), start_yaw=query.start_yaw)
    assert gw.certify(path, query, motion)["ok"]
    table = motion.sample(100.0)
    assert table.shape[1] == 8
    assert table[-1, 1:3] == pytest.approx(path.control_points[-1])
    assert path.eval([0.0, path.length], order=2).shape == (3, 2, 2)
    assert gw.reference(query, solution)["any_angle_gap"] == 0.0


def test_arrays(world):
    assert (world.occupancy() == ROOM).all()
    assert world.clearance([[2.0, 3.0], [3.05, 4.0]]).shape == (2,)
    assert world.clearance_field().shape == ROOM.shape
    from scipy import ndimage

    assert gw.distance_transform(ROOM) == pytest.approx(ndimage.distance_transform_edt(~ROOM), abs=1e-12)
    length, turns = world.shortest((0, 0), (59, 39))
    assert turns[0] == (0, 0)
    assert turns[-1] == (59, 39)
    query = gw.Query(world, *world.cell_centers([(0, 0), (59, 39)]), corners="clear")
    solution = gw.plan(query, "astar")
    assert solution.cost == pytest.approx(length * 0.1)
    assert solution.cells[0].tolist() == [0, 0]
    assert solution.grid_path.shape == solution.cells.shape


@pytest.mark.parametrize("wrong", [np.zeros((0, 3)), np.zeros(3), "map", [[1, 2], [3]], np.zeros((2, 2, 2))])
def test_wrong_maps(wrong):
    with pytest.raises(gw.BadParameter):
        gw.World(wrong)


@pytest.mark.parametrize(
    "arguments",
    [
        {"start": (1.5, 4.0), "goal": "there"},
        {"start": (1.5, 4.0), "goal": (2.0, 4.0, 0.0, 1.0)},
        {"start": (1.5, 4.0), "goal": (2.0, 4.0), "footprint": gw.Disc(-1)},
        {"start": (1.5, 4.0), "goal": (2.0, 4.0), "footprint": {"circle": 1}},
        {"start": (1.5, 4.0), "goal": (2.0, 4.0), "corners": "round"},
        {"start": (1.5, 4.0), "goal": (2.0, 4.0), "material": "feather"},
    ],
)
def test_wrong_queries(world, arguments):
    with pytest.raises(gw.BadParameter):
        gw.Query(world, **arguments)


def test_observers_see_and_stop_and_raise(world):
    blocked = np.random.default_rng(1).random((1500, 1500)) < 0.2
    blocked[0, 0] = blocked[-1, -1] = False
    big = gw.World(blocked)
    ends = big.cell_centers([(0, 0), (1499, 1499)]).tolist()
    query = gw.Query(big, *ends)
    seen = []
    with pytest.raises(gw.Cancelled):
        gw.plan(query, "dijkstra", observe=lambda state: seen.append(state) or True)
    assert seen[0].keys() == {"iteration", "evaluations", "best", "share", "seconds"}

    def broken(state):
        raise RuntimeError("observer")

    with pytest.raises(RuntimeError, match="observer"):
        gw.plan(query, "dijkstra", observe=broken)


def test_threads_share_a_world(world):
    query = gw.Query(world, (1.5, 4.0), (6.5, 4.0), footprint=gw.Disc(0.15))
    costs = []
    threads = [threading.Thread(target=lambda: costs.append(gw.plan(query, "jump-point").cost)) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(costs)) == 1
    assert len(costs) == 8
