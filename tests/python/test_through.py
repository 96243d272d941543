"""Splines through points, beside SciPy's."""

import numpy as np
import pytest

import guideway as gw


def test_the_spline_is_the_not_a_knot_spline():
    scipy = pytest.importorskip("scipy.interpolate")
    rng = np.random.default_rng(3)
    for n in (4, 5, 10):
        points, t = rng.uniform(-2, 2, (n, 6)), np.cumsum(rng.uniform(0.1, 1.0, n))
        path, theirs = gw.Path.through(points, parameters=t), scipy.CubicSpline(t, points)
        ours = scipy.BSpline(path.knots, path.control_points, path.degree)
        at = np.linspace(t[0], t[-1], 200)
        assert np.abs(ours(at) - theirs(at)).max() < 1e-11


def test_points_that_are_no_numbers_are_refused():
    for bad in ([[0.0, np.nan], [1.0, 1.0]], [[0.0], ["a"]], [0.0, 1.0], np.zeros((0, 3)), np.zeros((3, 0))):
        with pytest.raises(gw.BadParameter):
            gw.Path.through(bad)
    with pytest.raises(gw.BadParameter):
        gw.Path.through([[0.0], [1.0]], parameters=[0.0, 0.0])
    assert gw.Path.through([[0.0, 0.0], [0.0, 0.0], [3.0, 4.0]]).length == 5.0
