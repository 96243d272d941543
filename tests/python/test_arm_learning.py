"""Velocity self-learning: what the learner knows, what it learns, and that it never looks where it must not."""

import dataclasses
import json
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("pinocchio")
from scipy.interpolate import CubicSpline, PchipInterpolator

import guideway as gw
from guideway.arm.learning import LEARNERS, Log, Motion, Task, make_learner
from guideway.arm.learning.dynamics import Dynamics
from guideway.arm.learning.loop import Interrupted, learn_task, run
from guideway.arm.learning.oracle import optimum
from guideway.arm.learning.polytope import upper_end
from guideway.arm.learning.records import as_log, load_log
from guideway.arm.learning.regression import evidence, posterior, predicted
from guideway.arm.learning.residual import smoothed
from guideway.arm.learning.ripple import Spectrum
from guideway.arm.learning.spline import monotone_slopes, smooth_slopes
from guideway.arm.learning.unknown import END, SPEEDS, Unknown
from guideway.plants.arm import IdealArm, Sensors, make_arm, usual_friction
from guideway.plants.arm_friction import JointFriction


@pytest.fixture(scope="module")
def arm():
    return gw.arm.robot("ur5e")


@pytest.fixture(scope="module")
def star(arm):
    return gw.arm.joint_path(arm, gw.arm.star())


@pytest.fixture(scope="module")
def task(arm, star):
    return Task(star.path, arm, gw.arm.JointLimits(speed=np.pi, acceleration=10.0, torque=gw.arm.STAR_TORQUE))


def test_payload_friction_and_rotors_enter_linearly(arm, task):
    mass, at = 3.3, np.array([0.03, -0.02, 0.07])
    friction = gw.arm.Friction((8, 7, 6, 2, 1, 3), (7, 5, 6, 1, 2, 2))
    true = Dynamics(arm.with_payload(mass, at).with_friction(friction)).nominal(task.q, task.q1, task.q2)
    frame = arm.model.frames[arm.model.getFrameId(arm.tip)]
    lever = frame.placement.act(at)
    inertia = 0.0017 * mass * np.eye(3) + mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    turned = inertia  # the same in all directions about the centre
    six = [turned[0, 0], turned[0, 1], turned[1, 1], turned[0, 2], turned[1, 2], turned[2, 2]]
    numbers = np.concatenate([[mass], mass * lever, six, *friction.arrays(6), np.zeros(18)])
    found = task.nominal + task.dynamics.parameters(task.q, task.q1, task.q2).times(numbers)
    for name in "abdc":
        np.testing.assert_allclose(getattr(found, name), getattr(true, name), atol=1e-9)


def test_samples_of_a_motion_are_its_derivatives(task, star):
    motion = task.optimum().slower(0.7)
    t = np.linspace(0.1, motion.duration - 0.1, 200)
    h = 1e-6
    before, seen, after = (motion.sample(times=t + shift) for shift in (-h, 0.0, h))
    np.testing.assert_allclose((after.q - before.q) / (2 * h), seen.qd, atol=1e-5)
    np.testing.assert_allclose((after.speed - before.speed) / (2 * h), seen.u, atol=0.5 * np.abs(np.diff(motion.u)).max())
    assert motion.sample(500.0).t[-1] == pytest.approx(motion.duration)
    assert motion.slower(0.5).duration == pytest.approx(2 * motion.duration)
    timed = motion.timed(star, task.limits)
    assert timed.duration == pytest.approx(motion.duration)


def test_a_motion_that_stands_still_is_refused(task):
    with pytest.raises(gw.BadParameter, match="stands still"):
        Motion(task.path, task.s, np.zeros_like(task.s))


def test_the_kinematic_optimum_is_that_of_the_reference(task):
    assert task.optimum().duration == pytest.approx(1.912, rel=0.005)
    assert task.kinematic_ratio(task.optimum().dense(10)) <= 1 + 1e-6


@pytest.mark.parametrize(("payload", "best"), [(0.0, 2.0696), (3.0, 2.0708), (5.0, 2.2999)])
def test_the_oracle_is_that_of_the_reference(task, payload, best):
    assert optimum(task, make_arm("ideal", task, payload=payload).rows).duration == pytest.approx(best, rel=0.005)


@pytest.mark.parametrize("payload", [0.0, 3.0, 5.0])
def test_structured_meets_its_targets(task, payload):
    found = learn_task(task, make_arm("ideal", task, payload=payload, seed=11), trials=6)
    ratios = [trial.duration / found.oracle.duration for trial in found.trials]
    assert ratios[3] <= 1.05
    assert ratios[5] <= 1.03
    assert all(trial.true <= 0.01 for trial in found.trials[2:])
    assert all(task.kinematic_ratio(motion.dense()) <= 1 + 1e-6 for motion in found.motions)
    bounds = [trial.lower_bound / found.oracle.duration for trial in found.trials]
    assert max(bounds) <= 1.003
    assert bounds[-1] > 0.95
    assert found.best is not None


def test_structured_raises_speeds_again_when_the_load_is_gone(task):
    plant = make_arm("ideal", task, payload=5.0, seed=3)
    learner = make_learner("structured", task, {"forget": 0.2})
    logs = list(run(task, learner, plant, 3).logs)
    slow = learner.next(logs).duration
    light = make_arm("ideal", task, payload=0.0, seed=4)
    for _ in range(4):
        logs.append(light.run(learner.next(logs)))
    assert learner.next(logs).duration < 0.96 * slow


class Sealed:
    """A plant of which only ``run`` can be seen; logs are plain copies."""

    def __init__(self, plant):
        object.__setattr__(self, "_Sealed__plant", plant)
        object.__setattr__(self, "touched", [])

    def __getattribute__(self, name):
        if name in ("run", "touched", "_Sealed__plant", "__class__"):
            return object.__getattribute__(self, name)
        object.__getattribute__(self, "touched").append(name)
        raise AttributeError(name)

    def run(self, motion):
        log = object.__getattribute__(self, "_Sealed__plant").run(Motion(motion.path, motion.s.copy(), motion.x.copy()))
        return Log(motion, log.t.copy(), log.q.copy(), log.tau.copy(), log.stopped)


@pytest.mark.parametrize("learner", [name for name in LEARNERS if name not in ("guaranteed", "rl")])
def test_learners_see_nothing_but_logs(task, learner):
    """The same motions with the plant sealed, and with another plant behind the same logs."""
    open_run = run(task, make_learner(learner, task), make_arm("ideal", task, payload=3.0, seed=5), 4)
    sealed = Sealed(make_arm("ideal", task, payload=3.0, seed=5))
    again = run(task, make_learner(learner, task), sealed, 4)
    assert set(sealed.touched) <= {"true"}
    assert [m.x.tolist() for m in again.motions] == [m.x.tolist() for m in open_run.motions]

    class Recorded:
        """The logs of the first plant, with another one behind them: made last, lighter, with all effects of friction."""

        def __init__(self):
            self.logs = [dataclasses.replace(log) for log in open_run.logs]
            self.other = make_arm("ideal", task, payload=0.5, friction="full", seed=9)

        def __getattr__(self, name):
            return getattr(self.other, name)

        def run(self, motion):
            self.other.run(motion)
            return dataclasses.replace(self.logs.pop(0), motion=motion)

    swapped = run(task, make_learner(learner, task), Recorded(), len(open_run.logs))
    assert [m.x.tolist() for m in swapped.motions] == [m.x.tolist() for m in open_run.motions]


@pytest.mark.parametrize("reading", ["corrected", "literal"])
def test_source_becomes_feasible_and_only_ever_slows_down(task, reading):
    plant = make_arm("ideal", task, payload=5.0, seed=1)
    learner = make_learner("source", task, {"reading": reading})
    found = run(task, learner, plant, 40)
    assert learner.success
    assert found.finished
    assert len(found.trials) <= 40
    durations = [trial.duration for trial in found.trials]
    assert all(later >= before - 1e-9 for before, later in pairwise(durations))
    assert found.trials[-1].true <= 0.0
    assert all(task.kinematic_ratio(motion.dense(1)) <= 1.0 + 1e-3 for motion in found.motions)


def test_source_reports_a_static_overload_instead_of_lowering_for_ever(task):
    plant = make_arm("ideal", task, payload=5.0, noise=0.1)
    heavy = dataclasses.replace(plant, arm=task.arm.with_payload(7.0), stop=(9.0, 9.0))
    with pytest.raises(gw.Infeasible, match=r"static overload: (shoulder_lift|elbow|wrist_1)_joint"):
        run(task, make_learner("source", task, {"step": 0.3, "trials": 400}), heavy, 400)
    with pytest.raises(gw.Infeasible, match=r"static overload.*(shoulder_lift|elbow|wrist_1)_joint"):
        run(task, make_learner("structured", task), dataclasses.replace(heavy), 6)


def test_slopes_of_both_readings():
    values = np.array([0.0, 1.0, 3.0, 2.0, 2.5, 0.5, 0.0])
    at = np.arange(7) * 0.3
    np.testing.assert_allclose(smooth_slopes(values, 0.3), CubicSpline(at, values, bc_type="natural")(at, 1), atol=1e-12)
    np.testing.assert_allclose(monotone_slopes(values, 0.3)[1:-1], PchipInterpolator(at, values)(at[1:-1], 1), atol=1e-12)
    assert monotone_slopes(values, 0.3)[0] > 0 > monotone_slopes(values, 0.3)[-1]


def test_the_residual_is_that_of_the_full_gaussian_process():
    draw = np.random.default_rng(3)
    values, variances, size = draw.normal(size=(50, 2)), draw.uniform(0.1, 2.0, (50, 2)), np.array([0.7, 1.3])
    mean, spread = smoothed(values, variances, size, np.exp(-1 / 8))
    at = np.arange(50)
    for j in range(2):
        kernel = size[j] ** 2 * np.exp(-np.abs(at[:, None] - at) / 8)
        gain = kernel @ np.linalg.inv(kernel + np.diag(variances[:, j]))
        np.testing.assert_allclose(mean[:, j], gain @ values[:, j], atol=1e-9)
        np.testing.assert_allclose(spread[:, j] ** 2, np.diag(kernel - gain @ kernel), atol=1e-9)


def test_the_curve_of_friction_is_linear_between_its_speeds_and_each_way_apart(task):
    unknown = Unknown(task)
    qd = np.array([*SPEEDS, END, 1.0, 0.5 * (SPEEDS[1] + SPEEDS[2])])
    forwards, backwards = unknown.bends(qd, np.ones_like(qd)), unknown.bends(-qd, -np.ones_like(qd))
    count = len(SPEEDS)
    np.testing.assert_allclose(forwards[:count, :count], np.eye(count), atol=1e-12)
    np.testing.assert_allclose(backwards[:count, count:], -np.eye(count), atol=1e-12)
    assert not forwards[:, count:].any()
    assert not backwards[:, :count].any()
    np.testing.assert_allclose(forwards[count : count + 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(forwards[-1, 1:3], 0.5)


def test_ripple_is_found_where_there_is_one_and_not_in_noise():
    draw = np.random.default_rng(1)
    q = 0.4 * np.sin(np.linspace(0, 5, 3000))[:, None] * np.array([1.0, 0.8])
    tau = 15 + 10 * np.cos(np.linspace(0, 9, 3000))[:, None] * np.ones(2)
    sigma = np.array([0.5, 0.5])
    quiet, loud = Spectrum(2), Spectrum(2)
    noise = draw.normal(size=q.shape) * sigma
    assert not quiet.add(q, tau, noise, sigma)
    assert loud.add(q, tau, noise + 0.01 * tau * np.sin(202 * q + 0.7), sigma)
    np.testing.assert_allclose(loud.cycles, 202.0, rtol=0.005)
    assert not loud.add(q, tau, noise + 0.01 * tau * np.sin(202 * q + 0.7), sigma)


def test_full_friction_is_explained_after_one_slow_trial(task):
    """Stribeck, softened sign, asymmetry and ripple: what is left over of the next trial's true torque is a fraction of the noise."""
    plant = make_arm("ideal", task, payload=2.0, friction="full", seed=7)
    learner = make_learner("structured", task)
    log = plant.run(learner.next([]))
    learner.next([log])
    unknown = learner._along.unknown
    np.testing.assert_allclose(unknown.cycles[[0, 1, 2, 3, 5]], 202.0, rtol=0.01)
    motion = learner.next([log])
    quiet = dataclasses.replace(plant, sensors=Sensors((0.0,) * 6, quantum=0.0, delay=0))
    quiet.trials = 1
    true = quiet.run(motion)

    def left_over(unknown):
        """Root mean square of the error (N m, per joint) of the second trial's true torque, predicted from the first one."""
        seen = evidence(task, log, unknown, 1, 300)[0]
        belief = posterior([seen], unknown, 0.95, np.ones(6))
        samples = evidence(task, true, unknown, 0, 300)[1]
        return np.sqrt(((samples.left - predicted(unknown, samples.effects, belief.mean)) ** 2).mean(0))

    whole, plain = left_over(unknown), left_over(Unknown(task, curves=False))
    # wrist 2 stands still: it holds by its friction, of any size, so only the other joints' torques tell what it carries
    assert (np.abs(task.q1).max(0) < 1e-6).tolist() == [False, False, False, False, True, False]
    assert (whole < np.array([0.4, 0.4, 0.4, 0.4, 0.5, 0.4]) * np.array([0.5, 0.5, 0.5, 0.15, 0.15, 0.15])).all()
    assert whole.sum() < 0.5 * plain.sum()


@pytest.mark.parametrize("seed", [1, 2, pytest.param(3, marks=pytest.mark.slow), pytest.param(4, marks=pytest.mark.slow)])
def test_no_limit_is_exceeded_whatever_the_friction(task, seed):
    draw = np.random.default_rng([8, seed])
    viscous, coulomb = (tuple(np.asarray(part) * draw.uniform(0.5, 1.5, 6)) for part in usual_friction(task))
    arm = task.arm.with_payload(float(draw.uniform(0, 2)), (0.03, -0.02, 0.1))
    plant = IdealArm(arm, JointFriction.of("full", viscous, coulomb), Sensors.usual(0.8, 6), task.torque, seed=seed)
    found = learn_task(task, plant, trials=4)
    assert all(trial.true <= 0.0 for trial in found.trials[1:])
    assert found.trials[-1].duration <= 1.1 * found.oracle.duration
    assert all(trial.lower_bound <= 1.003 * found.oracle.duration for trial in found.trials)


def test_what_no_model_explains_is_kept_away_from_once_it_was_felt(task):
    """A torque that depends on the path alone, at one place: as if a cable were pulled tight there."""
    plain = make_arm("ideal", task, payload=3.0, seed=4)

    class Pulled:
        def __init__(self):
            self.worst = []

        def run(self, motion):
            log = plain.run(motion)
            pull = -6.0 * np.exp(-(((log.reference.s - 0.55 * task.s[-1]) / 0.03) ** 2))[:, None] * np.array([0, 1.0, 0, 0, 0, 0])
            quiet = np.abs(plain.truth(motion.sample(times=log.t)) + pull) / task.torque
            self.worst.append(float(quiet.max() - 1))
            return dataclasses.replace(log, tau=log.tau + pull)

    cell = Pulled()
    run(task, make_learner("structured", task), cell, 5)
    assert max(cell.worst[2:]) <= 0.01


def test_upper_ends_are_proven_and_tight():
    from scipy.optimize import linprog

    draw = np.random.default_rng(0)
    a, true, c = draw.normal(size=(60, 5)), draw.normal(size=5) * 0.3, draw.normal(size=5)
    y = a @ true + draw.uniform(-0.8, 0.8, 60)
    rows, ends = np.concatenate([a, -a]), np.concatenate([y + 1, 1 - y])
    exact = -linprog(-c, A_ub=rows, b_ub=ends, bounds=(-10, 10)).fun
    found = upper_end(c, rows, ends, np.full(5, 10.0))
    assert exact - 1e-9 <= found <= exact + 1e-5


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow)])
def test_guaranteed_never_exceeds_a_limit_and_never_slows_down(task, seed):
    draw = np.random.default_rng(seed)
    arm = task.arm.with_payload(float(draw.uniform(0, 4)), (0.02, 0.0, 0.08))
    plant = IdealArm(arm, JointFriction.of("reference", *usual_friction(task)), Sensors((0.1,) * 3 + (0.03,) * 3), task.torque, seed=seed)
    found = run(task, make_learner("guaranteed", task, {"bound": [0.7, 0.7, 0.7, 0.25, 0.25, 0.25]}), plant, 3)
    assert all(trial.true <= 0 for trial in found.trials)
    durations = [trial.duration for trial in found.trials]
    assert durations == sorted(durations, reverse=True)
    assert durations[-1] < 0.8 * durations[0]
    bounds, best = [trial.lower_bound for trial in found.trials], optimum(task, plant.rows).duration
    assert bounds == sorted(bounds)
    assert bounds[-1] <= best


def test_the_second_step_of_two_step_learning_comes_near_where_nothing_is_carried(task):
    found = learn_task(task, make_arm("ideal", task, seed=0), "ilc2", trials=16)
    assert not any(trial.stopped for trial in found.trials)
    assert found.trials[-1].duration / found.oracle.duration == pytest.approx(1.0, abs=0.06)
    assert max(trial.true for trial in found.trials) < 0.15


def test_interrupted_learning_keeps_what_was_found(task):
    plant = make_arm("ideal", task, payload=3.0, seed=5)

    def stop(trial):
        if trial.number == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        learn_task(task, plant, trials=6, observe=stop)
    assert isinstance(caught.value, Interrupted)
    found = caught.value.found
    assert len(found.trials) == len(found.motions) == len(found.logs) == len(found.true) == 2
    assert found.learner == "structured"
    assert found.motion.duration == found.trials[1].duration


def written(path, names, log, **changes):
    table = {"t": log.t, **{n: log.q[:, k] for k, n in enumerate(names)}, **{f"{n}_torque": log.tau[:, k] for k, n in enumerate(names)}} | changes
    rows = "\n".join(",".join(f"{v:.8g}" for v in row) for row in np.column_stack(list(table.values())))
    path.write_text(",".join(table) + "\n" + rows + "\n")
    return path


def test_a_log_from_a_file_is_as_good_as_the_plant_itself(task, tmp_path):
    plant = make_arm("ideal", task, payload=3.0, seed=2)
    learner = make_learner("structured", task)
    log = plant.run(learner.next([]))
    read, planned = as_log(task, load_log(written(tmp_path / "log.csv", task.arm.names, log), task.arm.names), log.motion)
    assert planned
    best = optimum(task, plant.rows).duration
    assert learner.next([read]).duration < 1.05 * best
    # a trial that was run at other speeds than planned: its angles tell where and how fast the arm was
    fresh = make_learner("structured", task)
    other = plant.run(fresh.next([]).slower(0.8))
    late = dataclasses.replace(other, t=other.t + 3.0)
    read, planned = as_log(task, load_log(written(tmp_path / "other.csv", task.arm.names, late), task.arm.names), fresh.next([]))
    assert not planned
    motion = fresh.next([read])
    assert motion.duration < 1.1 * best
    assert (np.abs(plant.truth(motion.dense())) / task.torque).max() < 1.02


def test_what_is_wrong_with_a_log_is_said(task, tmp_path):
    names = task.arm.names
    log = make_arm("ideal", task, seed=2).run(make_learner("structured", task).next([]))
    good = written(tmp_path / "good.csv", names, log)

    def complaint(path):
        with pytest.raises(gw.BadFile) as caught:
            as_log(task, load_log(path, names), log.motion)
        return str(caught.value)

    spoiled = tmp_path / "nan.csv"
    lines = good.read_text().splitlines()
    lines[100] = lines[100].replace(lines[100].split(",")[3], "nan", 1)
    spoiled.write_text("\n".join(lines))
    assert "line 101" in complaint(spoiled)
    assert "finite number" in complaint(spoiled)
    cut = tmp_path / "cut.csv"
    cut.write_text("\n".join(lines[:90] + good.read_text().splitlines()[90:600]))
    assert "it is cut" in complaint(cut)
    cut.write_text("\n".join(good.read_text().splitlines()[:400])[:-20])
    assert "line 400: the file ends in the middle of a row" in complaint(cut)
    assert "another path" in complaint(written(tmp_path / "path.csv", names, dataclasses.replace(log, q=log.q + 0.1)))
    assert "no column 'shoulder_pan_joint'" in complaint(written(tmp_path / "joints.csv", tuple("abcdef"), log))
    mixed = (names[1], names[0], *names[2:])
    assert "mixed up" in complaint(written(tmp_path / "mixed.csv", mixed, log))
    assert "does not increase" in complaint(written(tmp_path / "time.csv", names, dataclasses.replace(log, t=np.round(log.t, 2))))
    short = dataclasses.replace(log, t=log.t[:20], q=log.q[:20], tau=log.tau[:20])
    assert "at least 50" in complaint(written(tmp_path / "short.csv", names, short))
    with pytest.raises(gw.BadFile):
        load_log(tmp_path / "missing.csv", names)
    file = tmp_path / "odd.csv"
    for changes, words in (
        ({"t": 1000 * log.t}, "apart"),
        ({"q": np.degrees(log.q)}, "look like degrees"),
        ({"tau": -log.tau}, "wrong sign"),
        ({"tau": 1000 * log.tau}, "times those that the arm alone takes"),
        ({"tau": 0 * log.tau}, "never change"),
    ):
        assert words in complaint(written(file, names, dataclasses.replace(log, **changes)))
    kept = np.r_[:800, 1200 : len(log.t)]
    assert "a piece is missing" in complaint(written(file, names, dataclasses.replace(log, t=log.t[kept], q=log.q[kept], tau=log.tau[kept])))
    lines = good.read_text().splitlines()
    file.write_text("\n".join(lines[:2]))
    assert "at least 50" in complaint(file)


def test_whole_turns_of_a_joint_do_not_matter(task, tmp_path):
    log = make_arm("ideal", task, seed=2).run(make_learner("structured", task).next([]))
    turned = dataclasses.replace(log, q=log.q + 2 * np.pi * np.array([0, 0, 0, 1, 0, -1]))
    read, planned = as_log(task, load_log(written(tmp_path / "turned.csv", task.arm.names, turned), task.arm.names), log.motion)
    assert planned
    assert np.abs(read.q - read.reference.q).max() < 0.01


def test_safety_stop_ends_a_trial_and_learning_goes_on(task):
    plant = make_arm("ideal", task, payload=5.0, seed=1)
    log = plant.run(task.optimum())
    assert log.stopped
    assert len(log.t) < len(task.optimum().sample(500.0).t)
    found = run(task, make_learner("uniform", task), make_arm("ideal", task, payload=5.0, seed=1), 20)
    assert found.finished
    assert found.trials[-1].clean


def test_learners_and_their_settings_are_checked(task):
    with pytest.raises(gw.BadParameter, match="one of structured"):
        make_learner("magic", task)
    with pytest.raises(gw.BadParameter, match="no setting 'speed'"):
        make_learner("structured", task, {"speed": 1})
    with pytest.raises(gw.BadParameter, match="no setting"):
        make_learner("kinematic", task, {"speed": 1})
    wrong = ({"scale": "abc"}, {"scale": 0}, {"scale": 3}, {"sigmas": -3}, {"margin": True}, {"forget": float("nan")}, {"until": 0.5})
    for settings in wrong:
        with pytest.raises(gw.BadParameter, match=f"setting {next(iter(settings))} = .* is out of range"):
            make_learner("structured", task, settings)
    for name, settings in (("source", {"segments": 2.5}), ("rl", {"trials": 0}), ("guaranteed", {"bound": -1}), ("guaranteed", {"bound": [1, 2]})):
        with pytest.raises(gw.BadParameter, match="is out of range"):
            make_learner(name, task, settings)
    with pytest.raises(gw.BadParameter, match="trials 0"):
        learn_task(task, make_arm("ideal", task), trials=0)
    for wrong in ({"payload": -1.0}, {"friction": "some"}, {"noise": float("nan")}, {"feedforward": "some"}):
        with pytest.raises(gw.BadParameter):
            make_arm("ideal", task, **wrong)


def test_learning_needs_torque_limits(arm, star):
    with pytest.raises(gw.BadParameter, match="limit of torque"):
        Task(star.path, arm, gw.arm.JointLimits(speed=1.0, acceleration=1.0))
    other, path = gw.arm.robot("irb6700"), gw.Path.through(np.outer([0, 0.5], np.ones(6)))
    with pytest.raises(gw.BadParameter, match="inertias"):
        Task(path, other, gw.arm.JointLimits(speed=1.0, acceleration=1.0, torque=100.0))


def test_the_command_line_learns(tmp_path, capsys):
    from guideway.cli import main

    limits = tmp_path / "limits.toml"
    limits.write_text(f"speed = 3.14159265\nacceleration = 10.0\ntorque = {list(gw.arm.STAR_TORQUE)}\n")
    base = ["arm", "learn", "--nurbs", "star", "--robot", "ur5e", "--limits", str(limits)]
    out = tmp_path / "traj.json"
    assert main([*base, "--payload", "5", "--trials", "3", "--out", str(out), "--report", str(tmp_path / "learned.html")]) == 0
    assert capsys.readouterr().out.count("\ntrial ") == 2
    record = json.loads(out.read_text())
    assert record["duration"] < 1.05 * record["oracle_duration"]
    assert np.shape(record["tau"]) == np.shape(record["q"]) == (len(record["t"]), 6)
    assert len(record["trials"]) == 3
    for row, duration in [(trial["profile"], trial["duration"]) for trial in record["trials"]] + [(record["oracle"], record["oracle_duration"])]:
        v = np.sqrt(row["x"])
        assert (2 * np.diff(row["s"]) / (v[1:] + v[:-1])).sum() == pytest.approx(duration, rel=0.02)
    page = (tmp_path / "learned.html").read_text("utf-8")
    assert page.count('"profile":{"s":') == 3
    assert main([*base, "--learner", "magic"]) == 2
    assert "is not known" in capsys.readouterr().err
    assert main([*base, "--payload", "9"]) == 3
    assert "static overload" in capsys.readouterr().err
    # a real cell: the first motion, its log, the next motion
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    assert main([*base, "--next", "--csv", str(first)]) == 0
    assert first.read_text().startswith("t,shoulder_pan_joint,")
    arm = gw.arm.robot("ur5e")
    task = Task(gw.arm.joint_path(arm, gw.arm.star()).path, arm, gw.arm.load_limits(limits))
    log = make_arm("ideal", task, payload=3.0).run(make_learner("structured", task).next([]))
    assert main([*base, "--log", str(written(tmp_path / "log.csv", arm.names, log)), "--csv", str(second)]) == 0
    assert float(second.read_text().strip().split("\n")[-1].split(",")[0]) < 1.05 * 2.0708
    assert main([*base, "--log", str(first)]) == 2
    assert "the log has no column" in " ".join(capsys.readouterr().err.split())
