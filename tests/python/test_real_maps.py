"""Every public ROS map loads, plans between two far free points, and reports; odd ones say what is odd."""

import numpy as np
import pytest
from scipy import ndimage

import guideway as gw
from guideway import jobs


def far_points(world, free):
    """Centres of the two cells of the largest free area that are farthest apart along a diagonal of the map."""
    labels, _ = ndimage.label(free)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    rows, columns = np.nonzero(labels == sizes.argmax())
    spans = [(np.ptp(rows + columns), rows + columns), (np.ptp(rows - columns), rows - columns)]
    key = max(spans, key=lambda span: span[0])[1]
    cells = [(columns[i], rows[i]) for i in (key.argmin(), key.argmax())]
    return world.cell_centers(cells).tolist()


def maps(data):
    found = sorted((data / "ros_maps").rglob("*.yaml"))
    assert len(found) >= 10
    return found


def test_every_map(data, tmp_path):
    for path in maps(data):
        world = gw.World.load(path)
        occupancy = world.occupancy()
        free = occupancy == 0
        if not free.any():
            with pytest.raises(gw.GuidewayError):
                gw.plan(gw.Query(world, world.cell_centers([(0, 0)])[0], world.cell_centers([(1, 1)])[0]))
            continue
        start, goal = far_points(world, free)
        outcome = jobs.run(jobs.Job(world, tuple(start), tuple(goal)), tmp_path)
        record = outcome.record
        assert record["certificate"]["ok"], path
        assert record["reference"]["any_angle_gap"] >= -1e-9, path
        target = tmp_path / "report.html"
        gw.view.report([record], target, worlds=[world])
        assert target.stat().st_size > 10_000


def test_a_real_robot_on_a_real_map(data, tmp_path):
    world = gw.World.load(data / "ros_maps/nav2/warehouse.yaml")
    job = jobs.Job(world, (-5.4, -19.0), (9.5, 21.5), footprint={"disc": 0.3}, clearance=0.05)
    record = jobs.run(job, tmp_path).record
    assert record["certificate"]["ok"]
    assert record["metrics"]["min_clearance"] >= 0.05 - 1e-9
    assert record["reference"]["proved"]
