"""Learning on a simulated arm under a controller: what it feeds forward, how joints really moved, heavy loads."""

import dataclasses

import numpy as np
import pytest

pytest.importorskip("pinocchio")

import guideway as gw
from guideway.arm.learning import Task, make_learner
from guideway.arm.learning.loop import learn_task, run
from guideway.arm.learning.measured import measured
from guideway.arm.learning.oracle import optimum
from guideway.plants.arm import make_arm

OFF = (0.03, 0.02, 0.08)


@pytest.fixture(scope="module")
def task():
    arm = gw.arm.robot("ur5e")
    return Task(gw.arm.joint_path(arm, gw.arm.star()).path, arm, gw.arm.JointLimits(speed=np.pi, acceleration=10.0, torque=gw.arm.STAR_TORQUE))


@pytest.mark.parametrize("friction", ["reference", "full"])
def test_the_simulated_arm_is_learned(task, friction):
    pytest.importorskip("mujoco")
    plant = make_arm("mujoco", task, payload=3.0, payload_at=OFF, friction=friction, seed=1)
    found = learn_task(task, plant, trials=6)
    assert found.trials[-1].duration / found.oracle.duration <= 1.06
    tracked = found.logs[-1]
    assert np.abs(tracked.q - tracked.reference.q).max() < 0.03


def test_a_heavy_load_beside_the_axis_is_learned_in_six_trials(task):
    """Holding and rubbing take up to 95 % of a wrist's torque: the controller must know the load, and friction that warms up must be followed."""
    pytest.importorskip("mujoco")
    plant = make_arm("mujoco", task, payload=5.0, payload_at=OFF, friction="full", seed=2)
    best = [optimum(task, plant.rows).duration]  # of each trial: friction warms up
    found = run(task, make_learner("structured", task), plant, 6, observe=lambda _: best.append(optimum(task, plant.rows).duration))
    ratios = [trial.duration / own for trial, own in zip(found.trials, best[:-1], strict=True)]
    assert min(ratio for ratio, trial in zip(ratios, found.trials, strict=True) if trial.clean) <= 1.06
    assert max(trial.true for trial in found.trials[2:]) <= 0.01
    assert max(trial.lower_bound / own for trial, own in zip(found.trials, best[:-1], strict=True)) <= 1.01


def test_a_controller_that_knows_the_load_follows_better(task):
    pytest.importorskip("mujoco")
    away = {}
    for kind in ("learned", "nominal"):
        plant = make_arm("mujoco", task, payload=3.0, friction="full", seed=4, feedforward=kind)
        log = run(task, make_learner("structured", task), plant, 2).logs[1]
        away[kind] = float(np.sqrt(((log.q - log.reference.q) ** 2).mean()))
    assert away["learned"] < 0.3 * away["nominal"]


def test_what_a_motion_is_expected_to_take_is_what_it_takes(task):
    plant = make_arm("ideal", task, payload=3.0, payload_at=OFF, friction="full", seed=3)
    found = run(task, make_learner("structured", task), plant, 3)
    motion = found.motions[-1]
    assert found.motions[0].expected is None
    assert motion.slower(0.5).expected is motion.expected
    seen = motion.sample(500.0)
    plant.trials = 2
    away = motion.expected(seen) - plant.truth(seen)
    assert (np.sqrt((away**2).mean(0)) < 0.02 * task.torque).all()
    slow = motion.slower(0.02).sample(50.0)  # as slow as no trial was: friction stays what friction can be
    assert (np.abs(motion.expected(slow) - plant.truth(slow)) < 0.1 * task.torque).all()
    assert (np.abs(motion.expected(motion.at_rest())) < task.torque).all()


def test_how_joints_really_moved_is_found_from_their_angles(task):
    log = make_arm("ideal", task, seed=2).run(make_learner("structured", task).next([]))
    assert measured(log) is None
    wave = 0.004 * np.sin(20 * log.t)[:, None] * np.ones(6)
    noisy = wave + np.random.default_rng(4).normal(size=wave.shape) * 1e-6
    q, qd, qdd, ways = measured(dataclasses.replace(log, q=log.q + noisy))
    inside, seen = slice(10, -10), log.reference
    np.testing.assert_allclose((q - log.q)[inside], wave[inside], atol=1e-5)
    np.testing.assert_allclose((qd - seen.qd)[inside], 0.08 * np.cos(20 * log.t)[inside, None] * np.ones(6), atol=2e-3)
    np.testing.assert_allclose((qdd - seen.qdd)[inside], -400 * wave[inside], atol=0.1)
    fast = np.abs(qd) > 0.02
    assert (ways[fast] == np.sign(qd[fast])).all()
