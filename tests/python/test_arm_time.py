"""Time-optimal motion of arms against the reference values, the two methods against each other, tip limits, jerk."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pinocchio")

import guideway as gw
from guideway.arm.measures import measures
from guideway.arm.model import STILL
from guideway.arm.paths import arm_for
from guideway.arm.rows import torque_coefficients

KINEMATIC = {5: 2.7007, 10: 1.9097, 20: 1.3554}
LIMITED = {
    (5, 0): 2.7214,
    (5, 3): 2.7214,
    (5, 5): 2.7811,
    (10, 0): 2.0696,
    (10, 3): 2.0708,
    (10, 5): 2.2999,
    (20, 0): 1.7358,
    (20, 3): 1.8116,
    (20, 5): 2.1074,  # the reference says 2.1612: see the test of the joint that stands still
}


@pytest.fixture(scope="module")
def arm():
    return arm_for(gw.arm.robot("ur5e", friction=gw.arm.REFERENCE_FRICTION), gw.arm.star())


@pytest.fixture(scope="module")
def star_path(arm):
    return gw.arm.joint_path(arm, gw.arm.star())


def limits(acceleration, **others):
    return gw.arm.JointLimits(speed=np.pi, acceleration=acceleration, **others)


@pytest.mark.parametrize("method", ["reachability", "bisection"])
@pytest.mark.parametrize("acceleration", [5, 10, 20])
def test_kinematic_reference_values(star_path, acceleration, method):
    motion = gw.arm.time(star_path, limits(acceleration), method=method)
    assert motion.duration == pytest.approx(KINEMATIC[acceleration], rel=0.005)
    assert motion.report["certificate"]["ok"]


def test_one_more_kinematic_value(star_path):
    assert gw.arm.time(star_path, limits(np.pi)).duration == pytest.approx(3.4071, rel=0.005)


def test_rated_torques_are_never_reached_on_the_star(arm, star_path):
    loaded = arm.with_payload(5.0)
    free = gw.arm.time(star_path, limits(20))
    held = gw.arm.time(star_path, limits(20), loaded, torque=True)
    assert held.duration == pytest.approx(free.duration, rel=1e-4)
    torque = next(check for check in held.report["certificate"]["checks"] if check["limit"] == "torque")
    assert torque["ratio"] < 0.75


def test_the_active_constraint_is_named(arm, star_path):
    motion = gw.arm.time(star_path, limits(10, torque=gw.arm.STAR_TORQUE), arm.with_payload(5.0))
    named = {name for name in motion.grid["active"] if name}
    assert any(name.startswith("torque of ") for name in named)
    assert any("acceleration" in name for name in named)
    assert len(motion.grid["active"]) == len(motion.grid["s"]) == len(motion.grid["x"])


def test_limits_of_the_tip(arm, star_path):
    motion = gw.arm.time(star_path, limits(10, tip_speed=0.35, tip_acceleration=1.5), arm)
    checks = {check["limit"]: check["ratio"] for check in motion.report["certificate"]["checks"] if "ratio" in check}
    assert 0.99 < checks["tip_acceleration"] <= 1 + 1e-6
    assert checks["tip_speed"] <= 1 + 1e-6
    free = gw.arm.time(star_path, limits(10), arm)
    assert motion.duration > 1.2 * free.duration
    slow = gw.arm.time(star_path, limits(10, tip_speed=0.1), arm)
    assert slow.duration > 0.72725 / 0.1


def test_the_branch_decides(arm):
    motions = [gw.arm.time(path, limits(10)) for path in gw.arm.all_branches(arm, gw.arm.star())]
    durations = sorted(motion.duration for motion in motions)
    assert len(durations) == 8
    assert durations[0] == pytest.approx(1.779, rel=0.005)
    assert durations[-1] == pytest.approx(1.969, rel=0.005)
    assert any(duration == pytest.approx(1.9097, rel=0.005) for duration in durations)


def test_deceleration_counts_against_the_motion(arm, star_path):
    motion = gw.arm.time(star_path, limits(10, deceleration=4.0), arm)
    checks = {check["limit"]: check["ratio"] for check in motion.report["certificate"]["checks"] if "ratio" in check}
    # what exceeds a limit by less than 2e-5 is removed by slowing the whole down: up to so much may stay unused
    assert 1 - 2e-5 <= checks["deceleration"] <= 1 + 1e-6
    assert checks["acceleration"] > 0.9


def test_limits_come_from_the_description(arm, star_path):
    motion = gw.arm.time(star_path, None, arm)
    assert motion.limits.to_dict() == {"speed": [np.pi] * 6, "acceleration": 10.0}
    with pytest.raises(gw.BadParameter, match="no limits were given"):
        gw.arm.time(star_path)
    with pytest.raises(gw.BadParameter, match="no torque limit is given"):
        gw.arm.time([[0, 0, 0, 0, 0.5, 0], [0.5, 0.2, 0, 0, 0.5, 0]], None, gw.arm.robot("irb120"), torque=True)
    with pytest.raises(gw.BadParameter, match="no masses"):
        gw.arm.time([[0, 0, 0, 0, 0.5, 0], [0.5, 0.2, 0, 0, 0.5, 0]], {"torque": 1e4}, gw.arm.robot("irb6700"))
    with pytest.raises(gw.Infeasible, match="static overload"):
        gw.arm.time(star_path, limits(10, torque=gw.arm.STAR_TORQUE), arm.with_payload(12.0))


@pytest.mark.parametrize("name", ["ur5e", "irb120", "irb6700"])
def test_way_points_of_every_robot(name):
    robot = gw.arm.robot(name)
    low, high = np.maximum(robot.lower, -1.0), np.minimum(robot.upper, 1.0)
    points = np.random.default_rng(3).uniform(low, high, (6, robot.joints))
    motion = gw.arm.time(points, None, robot)
    assert motion.report["certificate"]["ok"]
    assert np.allclose(motion.at(0.0)["q"], points[0])
    assert np.allclose(motion.at(motion.duration)["q"], points[-1])


def test_coulomb_friction_and_payload_cost_time(arm, star_path):
    asked = limits(10, torque=gw.arm.STAR_TORQUE)
    free, held = (arm.with_friction(friction).with_payload(5.0) for friction in (None, {"coulomb": (7, 7, 7, 2, 2, 2)}))
    fast, slow = (gw.arm.time(star_path, asked, robot) for robot in (free, held))
    assert 1.9 < fast.duration < slow.duration < 2.2999
    assert slow.report["certificate"]["ok"]
    torque = next(check["ratio"] for check in slow.report["certificate"]["checks"] if check["limit"] == "torque")
    assert torque == pytest.approx(1.0, abs=1e-4)
    assert any(name.startswith("torque of ") for name in slow.grid["active"])
    assert gw.arm.time(star_path, asked, held, torque=False).duration == pytest.approx(1.9097, rel=0.005)
    for share in (0.155, 0.2, 0.343, 0.6):
        stopped = slow.stop_from(share * slow.duration)
        assert stopped.report["brake"]["worst"] < 1e-6
        assert all(check["ratio"] < 1 + 5e-6 for check in stopped.certify(collisions=False)["checks"] if "ratio" in check)
        assert stopped.at(stopped.duration)["speed"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("jerk", [60.0, 200.0])
def test_jerk_costs_time(star_path, jerk):
    rough, smooth = gw.arm.time(star_path, limits(10)), gw.arm.time(star_path, limits(10, jerk=jerk))
    assert rough.duration < smooth.duration < 2 * rough.duration
    ratio = next(check["ratio"] for check in smooth.report["certificate"]["checks"] if check["limit"] == "jerk")
    assert ratio <= 1 + 1e-6


def ratio_of(motion, name):
    return next(check["ratio"] for check in motion.report["certificate"]["checks"] if check["limit"] == name)


@pytest.mark.parametrize(("rate", "friction", "others"), [(400.0, False, {}), (250.0, True, {"jerk": 500.0}), (250.0, True, {"torque": 150.0})])
def test_torque_rate_is_kept_and_used(arm, star_path, rate, friction, others):
    motion = gw.arm.time(star_path, limits(10, torque_rate=rate, **others), arm if friction else arm.with_friction(None))
    assert motion.report["certificate"]["ok"]
    assert 0.95 < ratio_of(motion, "torque_rate") <= 1 + 1e-6
    assert motion.report["rate_slowed"] == 1.0
    assert any(name.startswith("torque rate of ") for name in motion.grid["active"])
    price = dict(map(tuple, motion.report["price"]))
    assert max(value for name, value in price.items() if name.startswith("torque rate of ")) > 0
    assert any(name.startswith("jerk of ") for name in price) == ("jerk" in others)


def test_torque_rate_costs_less_than_a_slower_motion(arm, star_path):
    """Without limits of rates in the solver: a motion with some limit of jerk, slowed down as a whole until the rates are kept."""
    from guideway.arm.timing import _within_rate

    rate = limits(10, torque_rate=250.0)
    motion, free = gw.arm.time(star_path, rate, arm), gw.arm.time(star_path, limits(10), arm)
    assert motion.duration < 1.04 * free.duration
    jerks = (100.0, 140.0, 180.0, 220.0, 300.0, 500.0)
    slowed = [_within_rate(replace(gw.arm.time(star_path, limits(10, jerk=jerk), arm), limits=rate)) for jerk in jerks]
    assert slowed[-1].report["rate_slowed"] > 1.2
    assert min(other.duration for other in slowed) > 1.05 * motion.duration


@pytest.mark.parametrize("seed", [1, 7])
def test_torque_rate_on_paths_through_random_points(seed):
    arm = gw.arm.robot("ur5e", friction=gw.arm.REFERENCE_FRICTION)
    path = gw.arm.joint_path(arm, np.random.default_rng(seed).uniform(-1.5, 1.5, (6, 6)))
    own = (150.0, 150.0, 150.0, 28.0, 28.0, 28.0)
    motion = gw.arm.time(path, limits(10, torque=own, torque_rate=400.0), arm, windows=[(path.path.length, 5.5)] if seed == 7 else ())
    assert motion.report["certificate"]["ok"]
    assert motion.report["rate_slowed"] == 1.0
    assert ratio_of(motion, "torque_rate") <= 1 + 1e-6
    if seed == 1:
        assert ratio_of(motion, "torque_rate") > 0.95
        assert motion.duration < 1.04 * gw.arm.time(path, limits(10, torque=own), arm).duration


@pytest.mark.parametrize(("acceleration", "payload"), list(LIMITED))
def test_torque_limits_with_friction_give_the_reference_values(arm, star_path, acceleration, payload):
    asked, loaded = limits(acceleration, torque=gw.arm.STAR_TORQUE), arm.with_payload(float(payload))
    motion, other = (gw.arm.time(star_path, asked, loaded, method=method) for method in ("reachability", "bisection"))
    assert motion.duration == pytest.approx(LIMITED[acceleration, payload], rel=0.005)
    assert other.duration == pytest.approx(motion.duration, rel=0.002)
    for found, method in ((motion, "reachability"), (other, "bisection")):
        assert found.report["method"] == method
        assert found.report["certificate"]["ok"]


def collocated(arm, path, acceleration, at_rest, intervals=1000):
    """Duration (s) with speed, acceleration and torque kept at the grid points alone, as the reference has it: controllable sets backwards, the
    greatest acceleration forwards, each by plain search; shares nothing with the solver. ``at_rest``: the way (-1, 0, 1), grid points x joints,
    that Coulomb friction takes where a joint does not move."""
    places, step = np.linspace(0.0, path.length, intervals + 1, retstep=True)
    _, first, second = path.eval(places, 2)
    torques, none = torque_coefficients(arm, path, places), np.zeros_like(first)
    still = torques["c"] + np.where(np.abs(first) > STILL, 0.0, at_rest) * arm.friction.arrays(arm.joints)[1]
    a, b, d, c = (np.hstack(pair) for pair in ((first, torques["a"]), (second, torques["b"]), (none, torques["d"]), (none, still)))
    bound = np.r_[np.full(arm.joints, acceleration), gw.arm.STAR_TORQUE]
    fastest = (np.pi / np.abs(first).max(axis=1)) ** 2

    def accelerations(k, x):
        rest, moving = b[k] * x + d[k] * np.sqrt(x) + c[k], np.abs(a[k]) > STILL
        if (np.abs(rest) > bound)[~moving].any():
            return np.inf, -np.inf
        ends = np.sort([(sign * bound - rest)[moving] / a[k][moving] for sign in (-1, 1)], axis=0)
        return ends[0].max(), ends[1].min()

    reach = np.zeros(intervals + 1)
    for k in reversed(range(intervals)):

        def short(x, k=k):
            low, high = accelerations(k, x)
            return min(high - low, reach[k + 1] - x - 2 * step * low, x + 2 * step * high)

        low, high = fastest[k] if short(fastest[k]) >= 0 else 0.0, fastest[k]
        while high - low > 1e-12 * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if short(middle) >= 0 else (low, middle)
        reach[k] = low
    x = np.zeros(intervals + 1)
    for k in range(intervals):
        x[k + 1] = np.clip(x[k] + 2 * step * accelerations(k, x[k])[1], 0.0, reach[k + 1])
    speed = np.sqrt(x)
    return float(np.sum(2 * step / (speed[:-1] + speed[1:])))


def test_the_last_reference_value_charges_a_joint_that_stands_still_with_friction_by_the_sign_of_noise(arm, star_path):
    """Joint 5 does not move along the star: its speed is rounding noise. The reference's 2.1612 s charges it with 2 N m of Coulomb friction by
    the sign of that noise. With signs drawn at random the reference's own way of computing gives its value in the mean; with none, ours."""
    loaded, path = arm.with_payload(5.0), star_path.path
    shape = (1001, arm.joints)
    assert np.abs(path.eval(np.linspace(0.0, path.length, 2001), 1)[1][:, 4]).max() < 1e-12
    noisy = [collocated(loaded, path, 20.0, np.random.default_rng(seed).choice([-1.0, 1.0], shape)) for seed in range(8)]
    assert min(noisy) < 2.1612 < max(noisy)
    assert np.mean(noisy) == pytest.approx(2.1612, rel=0.005)
    assert collocated(loaded, path, 20.0, np.zeros(shape)) == pytest.approx(LIMITED[20, 5], rel=0.002)


@pytest.mark.parametrize(("acceleration", "payload"), [(5, 5), (10, 5), (20, 0), (20, 3)])
def test_the_other_reference_values_by_the_same_plain_search(arm, star_path, acceleration, payload):
    none = np.zeros((1001, arm.joints))
    assert collocated(arm.with_payload(float(payload)), star_path.path, float(acceleration), none) == pytest.approx(
        LIMITED[acceleration, payload], rel=0.002
    )


def test_windows_say_when_places_are_passed(star_path):
    middle = 0.5 * star_path.path.length
    free, late = (gw.arm.time(star_path, limits(10), windows=rows) for rows in ((), [(middle, 3.0)]))
    assert late.grid["s"][-1] == free.grid["s"][-1]
    times = np.linspace(0.0, late.duration, 4001)
    passed = np.interp(middle, late.sample(times=times)["s"], times)
    assert 3.0 - 1e-3 <= passed <= 3.01
    assert late.report["certificate"]["ok"]
    assert late.duration > free.duration


def test_measures_of_a_motion_are_those_of_its_torques():
    arm = gw.arm.robot("ur5e", friction={"coulomb": (7, 7, 7, 2, 2, 2)})
    limits = {"speed": 1.0, "acceleration": 4.0, "torque": gw.arm.STAR_TORQUE}
    motion = gw.arm.time(np.array([[0.0, -1.2, 1.0, 0.0, 0.5, 0.0], [0.4, -0.9, 1.3, 0.3, 0.2, 0.1]]), limits, arm)
    found = measures(motion)
    t = np.linspace(0.0, motion.duration, 20001)
    sample = motion.sample(times=t)
    tau = motion.torques(sample)
    assert found["energy"] == pytest.approx(np.trapezoid(np.maximum(tau * sample["qd"], 0).sum(1), t), rel=2e-3)
    assert found["copper"] == pytest.approx(np.trapezoid(((tau / np.array(gw.arm.STAR_TORQUE)) ** 2).sum(1), t), rel=2e-3)
    assert found["energy"] > 7 * 0.4  # friction of the first joint alone: no weight helps it
    smooth = gw.arm.time(motion.path, {**limits, "jerk": 20.0}, arm)
    assert measures(smooth)["jerk_peak"] <= 20.0 * (1 + 1e-6) < found["jerk_peak"]
