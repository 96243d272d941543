"""Values that nobody should pass to the API: an error that names them, never a crash, never a certificate."""

import math

import pytest

import guideway as gw

NAN, INF = math.nan, math.inf


@pytest.fixture(scope="module")
def planned():
    world = gw.World([[0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]])
    query = gw.Query(world, (0.5, 0.5), (2.5, 2.5))
    path = gw.refine(gw.plan(query).path, query).path
    return world, query, path, gw.time(path, gw.Limits())


@pytest.mark.parametrize("value", [NAN, INF, -1.0, 0.0])
def test_a_certificate_takes_no_senseless_bounds(planned, value):
    _, query, path, motion = planned
    with pytest.raises(gw.BadParameter, match="step"):
        gw.certify(path, query, motion, step=value)
    with pytest.raises(gw.BadParameter, match="max_curvature"):
        gw.certify(path, query, motion, max_curvature=value)


@pytest.mark.parametrize("value", [NAN, INF, -1.0])
def test_a_certificate_takes_no_senseless_clearance(planned, value):
    world, _, path, _ = planned
    with pytest.raises(gw.BadParameter, match="clearance"):
        gw.certify(path, gw.Query(world, (0.5, 0.5), (2.5, 2.5), clearance=value))


def test_a_certificate_is_for_the_motion_along_its_path(planned):
    _, query, path, motion = planned
    assert gw.certify(path, query, motion)["ok"]
    other = gw.time(gw.Path.polyline([[0.5, 0.5], [0.5, 2.5], [2.5, 2.5]]), gw.Limits())
    with pytest.raises(gw.BadParameter, match="another path"):
        gw.certify(path, query, other)


def test_only_planar_paths_are_driven(planned):
    _, query, _, _ = planned
    for points in ([[0.5], [2.5]], [[0, 0, 0], [1, 1, 1]]):
        path = gw.Path(1, [0, 0, 1, 1], points)
        assert path.eval(0.5).shape[-1] == len(points[0])
        for call in (gw.measure, gw.refine, gw.polyline, gw.certify):
            with pytest.raises(gw.BadParameter, match="planar"):
                call(path, query)
        for call in (gw.time, gw.ceiling):
            with pytest.raises(gw.BadParameter, match="planar"):
                call(path, gw.Limits())


@pytest.mark.parametrize("points", [[], [[0, 0], [NAN, 1]], [[0, INF]]])
def test_polylines_need_finite_points(points):
    with pytest.raises(gw.BadParameter, match="points"):
        gw.Path.polyline(points if points else [[0.0, 0.0]][:0])


def test_ragged_control_points_are_refused():
    with pytest.raises(gw.BadParameter, match="row 1"):
        gw.Path(1, [0, 0, 1, 1], [[0, 0], [1], [1]])


@pytest.mark.parametrize("value", [NAN, INF])
def test_headings_are_finite(planned, value):
    world = planned[0]
    with pytest.raises(gw.BadParameter, match="start yaw"):
        gw.plan(gw.Query(world, (0.5, 0.5, value), (2.5, 2.5)))
    with pytest.raises(gw.BadParameter, match="goal yaw"):
        gw.plan(gw.Query(world, (0.5, 0.5), (2.5, 2.5, value)))


def test_messages_name_what_is_no_number(planned):
    world, query, _, motion = planned
    with pytest.raises(gw.BadParameter, match="float values"):
        gw.plan(query, budget=gw.Budget(seconds=NAN))
    with pytest.raises(gw.BadParameter, match="1e300"):
        gw.plan(gw.Query(world, (0.5, 0.5), (2.5, 2.5), clearance=1e300))
    with pytest.raises(gw.BadParameter, match="a time in s"):
        motion.at(NAN)
    with pytest.raises(gw.BadParameter, match="radius"):
        world.segment_free((0.5, 0.5), (2.5, 0.5), NAN)
