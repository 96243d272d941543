"""``guideway arm learn``: the fastest motion along a path, learned from measured torques, on a simulated plant or from logs of a real arm."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from guideway.commands import options
from guideway.errors import BadParameter

if TYPE_CHECKING:
    from guideway.arm.learning.loop import Learned, Trial
    from guideway.arm.learning.motion import Motion
    from guideway.arm.learning.task import Task
    from guideway.arm.paths import JointPath

EXAMPLES = """examples:
  guideway arm learn --nurbs star --robot ur5e --limits limits.toml --payload 5 --out traj.json
  guideway arm learn --nurbs star --robot ur5e --limits limits.toml --plant mujoco --friction full --payload 3 --payload-at 0.03,0.02,0.08
  guideway arm learn points.csv --urdf cell.urdf --limits limits.toml --next --csv first.csv
  guideway arm learn points.csv --urdf cell.urdf --limits limits.toml --log first_measured.csv --csv second.csv"""


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the options."""
    parser.epilog = EXAMPLES
    parser.add_argument("path", nargs="?", metavar="PATH.csv", help="joint way points: a header with the joints' names, a row each, rad")
    parser.add_argument(
        "--nurbs", metavar="FILE.toml", help="a path of the tool instead: degree, closed, points, weights, tool, posture; or the word star"
    )
    robot = parser.add_argument_group("robot, as it is known: without payload, without friction")
    robot.add_argument("--urdf", metavar="FILE", help="the robot's description")
    robot.add_argument("--robot", metavar="NAME", help="one that ships with the package instead: ur5e, irb6700, irb120")
    robot.add_argument("--estimated", action="store_true", help="with --robot irb6700: estimated masses, its description has none")
    robot.add_argument("--tip", metavar="LINK", help="the link that is moved (default tool0, else the end of the longest chain)")
    robot.add_argument(
        "--limits",
        metavar="FILE.toml",
        help="speed, acceleration, deceleration, torque, tip_speed, tip_acceleration (default: the robot's own, 10 rad/s2)",
    )
    learning = parser.add_argument_group("learning")
    learning.add_argument(
        "--learner", default="structured", metavar="NAME", help="structured (default), source, kinematic, nominal, uniform, ilc2, rl"
    )
    learning.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="a setting of the learner; may be repeated")
    learning.add_argument("--trials", type=int, default=6, metavar="N", help="at most N trials (default 6)")
    plant = parser.add_argument_group("simulated plant, unknown to the learner")
    plant.add_argument("--plant", default="ideal", metavar="NAME", help="ideal (default) or mujoco")
    plant.add_argument("--payload", type=float, default=0.0, metavar="KG", help="what it carries, kg (default 0)")
    plant.add_argument("--payload-at", default="0,0,0.08", metavar="X,Y,Z", help="its centre in the frame of the tip, m (default 0,0,0.08)")
    plant.add_argument("--friction", default="reference", metavar="KIND", help="none, reference (default) or full")
    plant.add_argument("--noise", type=float, default=0.5, metavar="NM", help="of torques, standard deviation in joints 1-3, 0.3 of it in the others")
    plant.add_argument(
        "--feedforward", default="learned", metavar="WHAT", help="torques the mujoco arm's controller adds: learned (default), or nominal"
    )
    plant.add_argument("--seed", type=int, default=0, metavar="N", help="of the noise (default 0)")
    real = parser.add_argument_group("real arm")
    real.add_argument(
        "--log", metavar="FILE.csv", action="append", default=[], help="a measured trial (t, angles, torques), in the order they were run"
    )
    real.add_argument("--next", action="store_true", help="write the motion to run next, simulate nothing; without --log that is the first one")
    out = parser.add_argument_group("output")
    out.add_argument("--out", metavar="FILE", help="the record as JSON")
    out.add_argument("--csv", metavar="FILE", help="the motion of the joints as a table")
    out.add_argument("--urscript", metavar="FILE", help="a program of servoj steps for arms of Universal Robots")
    out.add_argument("--report", metavar="FILE", help="a self-contained HTML report")
    out.add_argument("--rate", type=float, default=500.0, metavar="HZ", help="samples per second in files (default 500)")
    out.add_argument("--json", action="store_true", help="the record on stdout, and nothing else there")
    parser.set_defaults(handler=handle)


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    _check(arguments)
    outputs = (arguments.out, arguments.csv, arguments.urscript, arguments.report)
    options.writable(*outputs, inputs=(arguments.path, arguments.urdf, arguments.limits, *arguments.log))
    try:
        task, path = _task(arguments)
        if arguments.log or arguments.next:
            return _next(arguments, task, path)
        return _simulated(arguments, task, path)
    except ImportError as missing:
        raise BadParameter(str(missing)) from missing


def _check(arguments: argparse.Namespace) -> None:
    if (arguments.path is None) == (arguments.nurbs is None):
        raise BadParameter("guideway arm learn needs one of PATH.csv and --nurbs FILE.toml. See 'guideway arm learn --help'")
    if (arguments.urdf is None) == (arguments.robot is None):
        raise BadParameter("guideway arm learn needs one of --urdf FILE and --robot NAME")
    if arguments.estimated and arguments.robot is None:
        raise BadParameter("--estimated goes with --robot: give the masses in the URDF file")
    options.positive("--rate", arguments.rate)
    options.count("--seed", arguments.seed)
    if not 0 <= arguments.payload < 1e6:
        raise BadParameter(f"--payload {arguments.payload:g} is out of range: a number from 0")
    if not 0 <= arguments.noise < 1e6:
        raise BadParameter(f"--noise {arguments.noise:g} is out of range: a number from 0")
    if not 1 <= arguments.trials <= 10**6:
        raise BadParameter(f"--trials {arguments.trials} is out of range: a whole number from 1 to 1000000")


def _task(arguments: argparse.Namespace) -> tuple[Task, JointPath]:
    """The task, and its path."""
    from guideway import arm as arms
    from guideway.arm.learning.task import Task
    from guideway.arm.timing import complete

    if arguments.urdf is not None:
        arm = arms.Arm.load(arguments.urdf, tip=arguments.tip)
    else:
        arm = arms.robot(arguments.robot, estimated=arguments.estimated, tip=arguments.tip)
    if arguments.nurbs:
        nurbs = arms.star() if arguments.nurbs == "star" else arms.load_nurbs(arguments.nurbs)
        arm = arms.arm_for(arm, nurbs)
        path = arms.joint_path(arm, nurbs)
    else:
        path = arms.joint_path(arm, arguments.path)
    limits = arms.load_limits(arguments.limits) if arguments.limits else arms.JointLimits()
    return Task(path.path, arm, complete(limits, arm, True)), path


def _settings(arguments: argparse.Namespace) -> dict[str, Any]:
    return dict(options.setting(text) for text in arguments.set)


def _simulated(arguments: argparse.Namespace, task: Task, path: JointPath) -> int:
    from guideway.arm.learning.loop import Interrupted, learn_task
    from guideway.plants.arm import make_arm

    plant = make_arm(
        arguments.plant,
        task,
        payload=arguments.payload,
        payload_at=options.numbers("--payload-at", arguments.payload_at, (3,), "X,Y,Z"),
        friction=arguments.friction,
        noise=arguments.noise,
        seed=arguments.seed,
        feedforward=arguments.feedforward,
    )
    tell = options.note if arguments.json else print
    interrupted = False
    try:
        found = learn_task(
            task, plant, arguments.learner, trials=arguments.trials, settings=_settings(arguments), observe=lambda trial: tell(line(trial))
        )
    except Interrupted as stop:
        found, interrupted = stop.found, True
        if not found.trials:
            raise
    best = found.best if found.best is not None else min(range(len(found.trials)), key=lambda k: found.trials[k].measured)
    record = _record(arguments, task, path, found.motions[best])
    import numpy as np

    t, tau = found.true[best]
    record["tau"] = np.round(np.stack([np.interp(record["t"], t, column) for column in tau.T], 1), 9).tolist()
    record |= {"learner": found.learner, "plant": plant.report(), "trials": found.rows(), "best": best + 1}
    record["oracle_duration"] = found.oracle.duration if found.oracle else None
    record["oracle"] = found.oracle.profile() if found.oracle else None
    _deliver(arguments, task, path, found.motions[best], record)
    if not arguments.json:
        print(summary(found, best))
    if found.best is None:
        options.note(f"none of {len(found.trials)} trials was without a measured violation: the one nearest to it was kept")
    if interrupted:
        options.note(f"interrupted: {len(found.trials)} of {arguments.trials} trials are complete")
        return 130
    if found.best is None:
        return 3
    return 0


def _next(arguments: argparse.Namespace, task: Task, path: JointPath) -> int:
    """The motion to run next on a real arm, from the logs of the trials so far."""
    from guideway.arm.learning import make_learner
    from guideway.arm.learning.loop import judged, with_profiles
    from guideway.arm.learning.records import as_log, load_log

    learner = make_learner(arguments.learner, task, _settings(arguments))
    tell = options.note if arguments.json else print
    logs, trials = [], []
    motion = learner.next(logs)
    for number, name in enumerate(arguments.log, 1):
        log, planned = as_log(task, load_log(name, task.arm.names), motion)
        if not planned:
            if arguments.learner != "structured":
                raise BadParameter(
                    f"{name}: this is not a log of the motion that the learner {arguments.learner!r} asked for; only structured can use it"
                )
            options.note(f"{name}: not run at the planned times; places, speeds and accelerations are taken from its angles")
        logs.append(log)
        trials.append(judged(task, number, log, getattr(learner, "lower_bound", None), None))
        tell(line(trials[-1]))
        motion = learner.next(logs)
    if motion is None:
        tell("learning has ended: the last motion was fine, run it again")
        motion = logs[-1].motion
    record = _record(arguments, task, path, motion)
    from dataclasses import asdict

    rows = [asdict(trial) | {"clean": trial.clean} for trial in trials]
    record |= {"learner": arguments.learner, "plant": None, "trials": with_profiles(rows, [log.motion for log in logs])}
    record |= {"oracle_duration": None, "lower_bound": getattr(learner, "lower_bound", None)}
    _deliver(arguments, task, path, motion, record)
    if not arguments.json:
        bound = record["lower_bound"]
        print(f"next         {motion.duration:.4f} s" + (f", at most {100 * (motion.duration / bound - 1):.1f} % above the optimum" if bound else ""))
    return 0


def _record(arguments: argparse.Namespace, task: Task, path: JointPath, motion: Motion) -> dict[str, Any]:
    from guideway.arm import outputs

    record = outputs.record(motion.timed(path, task.limits, task.arm), arguments.rate)
    record.pop("tau_model", None)  # of the nominal arm: it misses what the arm carries
    if motion.expected:
        record["tau_model"] = motion.expected(motion.sample(times=record["t"])).round(9).tolist()
    return record


def _deliver(arguments: argparse.Namespace, task: Task, path: JointPath, motion: Motion, record: dict[str, Any]) -> None:
    from guideway.arm import outputs

    timed = motion.timed(path, task.limits, task.arm)
    for place, text in (
        (arguments.out, lambda: json.dumps(outputs.plain(record), allow_nan=False) + "\n"),
        (arguments.csv, lambda: outputs.csv_text(timed, arguments.rate)),
        (arguments.urscript, lambda: outputs.urscript(timed, min(arguments.rate, 500.0))),
    ):
        if place:
            options.write(place, text())
            if not arguments.json:
                print(f"wrote        {place}")
    if arguments.report:
        from guideway.view import arm_report

        arm_report(outputs.plain(record), arguments.report)
        if not arguments.json:
            print(f"wrote        {arguments.report}")
    if arguments.json:
        print(json.dumps(outputs.plain(record), allow_nan=False))


def line(trial: Trial) -> str:
    """A trial in a line."""
    text = f"trial {trial.number:<3} {trial.duration:8.4f} s"
    if trial.lower_bound:
        text += f"   at most {100 * (trial.duration / trial.lower_bound - 1):5.1f} % above the optimum"
    text += f"   torque {100 * (1 + trial.measured):6.1f} % of its limit measured"
    if trial.true is not None:
        text += f", {100 * (1 + trial.true):.1f} % true"
    return text + ("   stopped" if trial.stopped else f"   {trial.samples} samples over" if trial.samples else "")


def summary(found: Learned, best: int) -> str:
    """The outcome in two lines."""
    trial = found.trials[best]
    oracle = f", {trial.duration / found.oracle.duration:.4f} of the true optimum {found.oracle.duration:.4f} s" if found.oracle else ""
    return f"learner      {found.learner}\nbest         trial {trial.number}: {trial.duration:.4f} s{oracle}"
