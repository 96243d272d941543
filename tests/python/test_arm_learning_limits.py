"""No learner ignores a limit: all of them keep it, or it is refused when the task is made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pinocchio")

import guideway as gw
from guideway.arm.learning import LEARNERS, Task, make_learner
from guideway.arm.learning.kernel import solve
from guideway.arm.learning.loop import run
from guideway.cli import main
from guideway.plants.arm import make_arm

LIMITS = gw.arm.JointLimits(speed=np.pi, acceleration=10.0, torque=gw.arm.STAR_TORQUE)
STAR = ["arm", "learn", "--nurbs", "star", "--robot", "ur5e", "--limits", "limits.toml"]


@pytest.fixture(scope="module")
def arm():
    return gw.arm.robot("ur5e")


@pytest.fixture(scope="module")
def star(arm):
    return gw.arm.joint_path(arm, gw.arm.star())


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def limits_file(tmp_path, **more):
    words = {"speed": 3.14159265, "acceleration": 10.0, "torque": list(gw.arm.STAR_TORQUE)} | more
    (tmp_path / "limits.toml").write_text("".join(f"{key} = {value}\n" for key, value in words.items()))


@pytest.fixture(scope="module")
def slow(arm, star):
    """A task whose tip is limited."""
    return Task(star.path, arm, replace(LIMITS, tip_speed=0.4, tip_acceleration=2.0))


@pytest.mark.parametrize("learner", LEARNERS)
def test_every_learner_keeps_the_limits_of_the_tip(arm, star, slow, learner):
    plant = make_arm("ideal", slow, payload=2.0, noise=0.1, seed=1)
    found = run(slow, make_learner(learner, slow), plant, 2)
    kept = replace(slow.limits, torque=None)
    for motion in found.motions:
        certificate = motion.timed(star, kept, arm).certify(collisions=False)
        assert certificate["ok"], [check for check in certificate["checks"] if not check["ok"]]
        assert {"tip_speed", "tip_acceleration"} <= {check["limit"] for check in certificate["checks"]}


@pytest.mark.parametrize("learner", ["kinematic", "source"])
@pytest.mark.parametrize("deceleration", [5.0, 20.0])
def test_where_a_joint_turns_round_the_lower_limit_counts(arm, star, learner, deceleration):
    limits = replace(LIMITS, deceleration=deceleration)
    motion = make_learner(learner, Task(star.path, arm, limits)).next([])
    certificate = motion.timed(star, replace(limits, torque=None), arm).certify(collisions=False)
    assert certificate["ok"], [check for check in certificate["checks"] if not check["ok"]]


@pytest.mark.parametrize("limits", [{"tip_speed": 0.4}, {"tip_acceleration": 2.0}, {"tip_speed": 0.4, "tip_acceleration": 2.0}])
def test_the_limits_of_the_tip_cost_no_more_than_they_must(arm, star, limits):
    asked = replace(LIMITS, torque=None, **limits)
    best = gw.arm.time(star, asked, arm, check=False).duration
    assert Task(star.path, arm, replace(LIMITS, **limits)).optimum().duration == pytest.approx(best, rel=5e-3)


@pytest.mark.parametrize("name", ["jerk", "torque_rate"])
def test_a_limit_that_no_learner_keeps_is_refused(tmp_path, capsys, arm, star, name):
    with pytest.raises(gw.BadParameter, match=f"limit {name} cannot be kept while learning"):
        Task(star.path, arm, replace(LIMITS, **{name: 500.0}))
    limits_file(tmp_path, **{name: 500.0})
    assert main([*STAR, "--out", "out.json"]) == 2
    assert f"limit {name} cannot be kept while learning" in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "out.json").exists()


@pytest.mark.parametrize("slack", [0.02, 0.05, 0.0915, 0.15])
def test_where_friction_takes_the_last_of_a_torque_it_does_not_stop_for_good(slack):
    n, one = 41, np.ones((41, 1))
    s, low, c = np.linspace(0, 0.15, n), -10.7143 * one, -10.0 * one
    c[-2], c[-1] = slack - 10.7143, -8.5
    x = solve(s, np.full(n, 4.0), (0.036 * one, 0.2 * one, -0.556 * one, c), low, -low)
    assert (x[1:-1] > 0).all()
    u = np.diff(x) / (2 * np.diff(s))
    for side in (slice(0, -1), slice(1, None)):
        tau = 0.036 * u + 0.2 * x[side] - 0.556 * np.sqrt(x[side]) + c[side, 0]
        assert (tau >= low[side, 0] - 1e-3).all()
