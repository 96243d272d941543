"""Time-optimal timing of joints: public cases, an independent oracle, callbacks, windows, limits of jerk."""

import os
from pathlib import Path

import numpy as np
import pytest
import yaml

import guideway as gw
from guideway import _core

DATA = Path(os.environ.get("GUIDEWAY_DATA", Path(__file__).resolve().parents[3] / "shared/data")) / "topp"
LIMITS = {"speed": np.pi, "acceleration": 13.9626, "jerk": 174.53}


def spline(seed, points=8, joints=6):
    return gw.Path.through(np.random.default_rng(seed).uniform(-1.5, 1.5, (points, joints)))


def worst(motion, limits, jerk=False):
    """Largest use of the limits, 20 times inside every piece."""
    times = np.concatenate([p["t"] + p["duration"] * (np.arange(20) + 0.5) / 20 for p in motion.pieces])
    q = motion.sample(times=times)
    names = [("qd", "speed"), ("qdd", "acceleration")] + [("qddd", "jerk")] * jerk
    return max(float((np.abs(q[name]) / limits[limit]).max()) for name, limit in names)


@pytest.mark.parametrize("method", ["reachability", "bisection"])
def test_the_public_cases_are_solved_and_the_exact_optima_met(method):
    file = DATA / "toppra_problem_suite_1.yaml"
    if not file.exists():
        pytest.skip(f"no public cases in {DATA}")
    for name, case in yaml.safe_load(file.read_text()).items():
        way = np.array(case["waypoints"], float)
        limits = {"speed": [float(v) for v in case["vlim"]], "acceleration": [float(a) for a in case["alim"]]}
        for parameters in (None, np.linspace(0, 1, len(way))):
            path = gw.Path.through(way, parameters=parameters)
            for desired in case["desired_duration"]:
                motion = gw.time_joints(path, limits, method=method, duration=desired or None)
                assert worst(motion, {k: np.array(v) for k, v in limits.items()}) <= 1 + 1e-6, name
                if desired:
                    assert motion.duration == pytest.approx(desired, rel=1e-6)
                elif "optimal_duration" in case:
                    assert motion.duration == pytest.approx(case["optimal_duration"], rel=1e-6)
                assert np.allclose(motion.at(motion.duration)["q"], way[-1], atol=1e-12)


def oracle(s, top, a, b, bound, levels):
    """Fastest profile over a lattice of squared speeds, by dynamic programming from the end; limits at both ends of every interval."""
    ladder = np.linspace(0, top.max(), levels)
    cost = np.where(ladder == 0, 0.0, np.inf)
    for k in range(len(s) - 2, -1, -1):
        step = s[k + 1] - s[k]
        here, there = ladder[:, None], ladder[None, :]
        u = (there - here) / (2 * step)
        ok = (here <= top[k]) & (there <= top[k + 1]) & (here + there > 0)
        for i in range(a.shape[1]):
            ok &= np.abs(a[k, i] * u + b[k, i] * here) <= bound
            ok &= np.abs(a[k + 1, i] * u + b[k + 1, i] * there) <= bound
        root = np.sqrt(here) + np.sqrt(there)
        time = np.where(ok, 2 * step / np.where(root > 0, root, 1), np.inf)
        cost = (time + cost[None, :]).min(axis=1)
    return cost[0]


def test_profiles_on_a_lattice_of_speeds_are_as_fast():
    # On a given grid the greedy pass is the optimum but for places where a joint turns back; the lattice is coarse the other way.
    for seed in range(3):
        path = spline(seed, points=4, joints=2)
        s = np.linspace(0, path.length, 41)
        q = path.eval(s, 2)
        a, b = np.ascontiguousarray(q[1]), np.ascontiguousarray(q[2])
        top = np.minimum(1 / np.max((a / 3.0) ** 2, axis=1), 40.0)
        bound = np.full(2, 12.0)
        x = _core.topp_kernel(s, top, a, b, None, -bound, bound)
        assert (x >= 0).all()
        assert (x <= top * (1 + 1e-12)).all()
        u = np.diff(x) / (2 * np.diff(s))
        for shift in (0, 1):
            values = a[shift : len(u) + shift] * u[:, None] + b[shift : len(u) + shift] * x[shift : len(u) + shift, None]
            assert np.abs(values).max() <= 12.0 * (1 + 1e-9)
        duration = np.sum(2 * np.diff(s) / (np.sqrt(x[:-1]) + np.sqrt(x[1:])))
        found = oracle(s, top, a, b, 12.0, 900)
        assert 0.95 * duration < found < 1.05 * duration, seed


def test_limits_hold_between_grid_points_on_random_splines():
    for seed in range(25):
        motion = gw.time_joints(spline(seed, points=3 + seed % 10, joints=1 + seed % 7), LIMITS)
        assert worst(motion, LIMITS) <= 1 + 1e-6, seed
        assert np.diff(motion.s).min() > 0
        assert len(motion.active) == len(motion.s) == len(motion.mvc)


def test_limits_of_jerk_hold_and_have_a_price():
    for seed in range(4):
        path = spline(seed)
        second, motion = gw.time_joints(path, LIMITS), gw.time_joints(path, LIMITS, jerk=True)
        assert worst(motion, LIMITS, jerk=True) <= 1 + 1e-6, seed
        assert second.duration < motion.duration < 1.06 * second.duration
        assert sum(price for _, price in motion.price) == pytest.approx(motion.duration - second.duration, abs=2e-3 * second.duration)
    with pytest.raises(gw.BadParameter):
        gw.time_joints(path, {"speed": 1.0, "acceleration": 1.0}, jerk=True)


def test_what_a_callback_raises_is_raised_and_bad_answers_are_named():
    path = spline(1)

    def broken(s):
        raise ZeroDivisionError("in the model")

    with pytest.raises(ZeroDivisionError, match="in the model"):
        gw.time_joints(path, LIMITS, rows=broken)
    for answer in ({"a": np.full((1, 1), np.nan)}, {}, {"a": "no"}, {"a": np.ones((3, 2))}):
        with pytest.raises(gw.BadParameter, match="rows"):
            gw.time_joints(path, LIMITS, rows=lambda s, answer=answer: answer)
    with pytest.raises(gw.Infeasible, match=r"weight .* s = "):
        gw.time_joints(path, LIMITS, rows=lambda s: {"a": [1.0], "c": [5.0], "low": [-4.0], "high": [4.0]}, row_names=["weight"])


def test_a_ceiling_and_windows():
    path = spline(2)
    free = gw.time_joints(path, LIMITS)
    slow = gw.time_joints(path, LIMITS, ceiling=lambda s: np.full(len(s), 0.25))
    assert slow.x.max() <= 0.25 * (1 + 1e-6)
    assert "ceiling" in slow.active
    half = path.length / 2
    late = gw.time_joints(path, LIMITS, windows=[(half, free.duration)])
    assert late.at(free.duration)["s"] <= half * (1 + 1e-6)
    assert late.duration < 2 * free.duration
    with pytest.raises(gw.Infeasible):
        gw.time_joints(path, LIMITS, windows=[(half, 0.0, 0.01)])
    with pytest.raises(gw.BadParameter):
        gw.time_joints(path, LIMITS, windows=[(half,)])
    for jerk in (False, True):
        with pytest.raises(gw.BadParameter, match="a place on the path, up to"):
            gw.time_joints(path, LIMITS, windows=[(1.001 * path.length, free.duration)], jerk=jerk)
        last = gw.time_joints(path, LIMITS, windows=[(path.length, 2 * free.duration)], jerk=jerk)
        assert last.duration == pytest.approx(2 * free.duration)


def test_speeds_at_the_ends_with_limits_of_jerk():
    path = spline(5)
    rest = gw.time_joints(path, LIMITS, jerk=True)
    motion = gw.time_joints(path, LIMITS, jerk=True, start_speed=0.8, end_speed=0.4)
    assert motion.at(0.0)["speed"] == pytest.approx(0.8, abs=1e-9)
    assert motion.at(motion.duration)["speed"] == pytest.approx(0.4, abs=1e-9)
    assert worst(motion, LIMITS, jerk=True) <= 1 + 1e-6
    assert motion.duration < rest.duration
    with pytest.raises(gw.Infeasible, match=r"the path speed at the start can be at most .* under the limits of jerk") as refused:
        gw.time_joints(path, LIMITS, jerk=True, start_speed=30.0)
    most = float(str(refused.value).split("at most ")[1].split()[0])
    assert gw.time_joints(path, LIMITS, jerk=True, start_speed=0.999 * most).at(0.0)["speed"] == pytest.approx(0.999 * most)
    with pytest.raises(gw.BadParameter, match="from rest to rest"):
        gw.time_joints(path, LIMITS, jerk=True, start_speed=0.8, duration=2 * rest.duration)


@pytest.mark.parametrize("seed", [1, 3, 6])
def test_rates_that_gravity_and_inertia_share_are_kept_without_a_slower_motion(seed):
    """Slower, the two would not cancel where they do: slowing down as a whole would cost a quarter of the time."""
    path = gw.Path.through(np.random.default_rng(seed).uniform(-1.5, 1.5, (5, 5)))

    def rates(s):
        q, first, second = path.eval(s, 2)
        bound = np.full(q.shape, 100.0)
        return {"a": 3 * first, "b": 3 * second, "c": 54 * np.sin(q), "d": 2 * first, "low": -bound, "high": bound}

    motion = gw.time_joints(path, {"speed": np.pi, "acceleration": 14.0}, jerk=True, rates=rates)
    assert motion.report["jerk_slowed"] < 1.001
    worst = 0.0
    for piece in motion.pieces:
        times = piece["t"] + np.linspace(0.001, 0.999, 12) * piece["duration"]
        at = motion.sample(times=times)
        torque = 54 * np.sin(at["q"]) + 3 * at["qdd"] + 2 * at["qd"]
        worst = max(worst, np.abs(np.diff(torque, axis=0)).max() / (times[1] - times[0]))
    assert 99.0 < worst <= 100.0 * (1 + 1e-5)
