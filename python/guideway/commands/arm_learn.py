"""``guideway arm learn``: the fastest motion along a path, learned from measured torques, on a simulated plant or from logs of a real arm."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from guideway.commands import arm_files, options
from guideway.errors import BadParameter, CertificateFailed, Infeasible

if TYPE_CHECKING:
    from guideway.arm.learning.loop import Learned, Trial
    from guideway.arm.learning.motion import Motion
    from guideway.arm.learning.task import Task
    from guideway.arm.motion import ArmMotion
    from guideway.arm.paths import JointPath

LEARNERS = "structured (default), guaranteed, source, kinematic, nominal, uniform, ilc2, rl"

SIMULATED: dict[str, Any] = {
    "plant": "ideal",
    "payload": 0.0,
    "payload_at": "0,0,0.08",
    "friction": "reference",
    "noise": 0.5,
    "feedforward": "learned",
    "seed": 0,
    "trials": 6,
}
"""What only a simulated plant can be told, with its defaults."""

BEYOND = 0.01
"""Share of a limit by which the true torque of a simulated plant may be beyond it without a word."""

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
    learning.add_argument("--learner", default="structured", metavar="NAME", help=LEARNERS)
    learning.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="a setting of the learner; may be repeated")
    learning.add_argument("--trials", type=int, metavar="N", help="at most N trials of the simulated plant (default 6)")
    plant = parser.add_argument_group("simulated plant, unknown to the learner")
    plant.add_argument("--plant", metavar="NAME", help="ideal (default) or mujoco")
    plant.add_argument("--payload", type=float, metavar="KG", help="what it carries, kg (default 0)")
    plant.add_argument("--payload-at", metavar="X,Y,Z", help="its centre in the frame of the tip, m (default 0,0,0.08)")
    plant.add_argument("--friction", metavar="KIND", help="none, reference (default) or full")
    plant.add_argument(
        "--noise", type=float, metavar="NM", help="of torques, standard deviation in joints 1-3 (default 0.5), 0.3 of it in the others"
    )
    plant.add_argument("--feedforward", metavar="WHAT", help="torques the mujoco arm's controller adds: learned (default), or nominal")
    plant.add_argument("--seed", type=int, metavar="N", help="of the noise (default 0)")
    real = parser.add_argument_group("real arm")
    real.add_argument(
        "--log", metavar="FILE.csv", action="append", default=[], help="a measured trial (t, angles, torques), in the order they were run"
    )
    real.add_argument("--next", action="store_true", help="write the motion to run next, simulate nothing; without --log that is the first one")
    arm_files.add_safety(parser)
    arm_files.add_output(parser)
    parser.set_defaults(handler=handle)


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    _check(arguments)
    given = (arguments.path, arguments.nurbs, arguments.urdf, arguments.limits, arguments.scene, *arguments.log)
    options.writable(*arm_files.places(arguments), inputs=given)
    try:
        task, path = _task(arguments)
        collision = _collision(arguments, task, path)
        if arguments.log or arguments.next:
            return _next(arguments, task, path, collision)
        return _simulated(arguments, task, path, collision)
    except ImportError as missing:
        raise BadParameter(str(missing)) from missing


def _check(arguments: argparse.Namespace) -> None:
    if (arguments.path is None) == (arguments.nurbs is None):
        raise BadParameter("guideway arm learn needs one of PATH.csv and --nurbs FILE.toml. See 'guideway arm learn --help'")
    if (arguments.urdf is None) == (arguments.robot is None):
        raise BadParameter("guideway arm learn needs one of --urdf FILE and --robot NAME")
    if arguments.estimated and arguments.robot is None:
        raise BadParameter("--estimated goes with --robot: give the masses in the URDF file")
    _plant(arguments)
    options.positive("--rate", arguments.rate)
    options.count("--seed", arguments.seed)
    for name in ("payload", "noise", "clearance"):
        value = getattr(arguments, name)
        if value is not None and not 0 <= value < 1e6:
            raise BadParameter(f"--{name} {value:g} is out of range: a number from 0")
    if not 1 <= arguments.trials <= 10**6:
        raise BadParameter(f"--trials {arguments.trials} is out of range: a whole number from 1 to 1000000")


def _plant(arguments: argparse.Namespace) -> None:
    """Fills in the defaults of the simulated plant; refuses what is said of it where there is none."""
    real = "--log" if arguments.log else "--next" if arguments.next else None
    for name, default in SIMULATED.items():
        if getattr(arguments, name) is None:
            setattr(arguments, name, default)
        elif real:
            word = f"--{name.replace('_', '-')}"
            raise BadParameter(
                f"{word} describes a simulated plant, and with {real} nothing is simulated: leave {word} out. "
                "What the real arm carries and how it rubs is learned from its logs"
            )


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


def _collision(arguments: argparse.Namespace, task: Task, path: JointPath) -> dict[str, Any] | None:
    """The proof that the path is free, before anything is learned on it; None where it is left out."""
    from guideway import arm as arms
    from guideway.arm.learning.certified import collisions_of

    scene = arms.load_scene(arguments.scene) if arguments.scene else None
    if arguments.no_collisions:
        return None
    found = collisions_of(path, arms.Surroundings(task.arm, scene), arguments.clearance)
    if not found["ok"]:
        raise CertificateFailed(arm_files.collided(found))
    return found


def _settings(arguments: argparse.Namespace) -> dict[str, Any]:
    return dict(options.setting(text) for text in arguments.set)


def _simulated(arguments: argparse.Namespace, task: Task, path: JointPath, collision: dict[str, Any] | None) -> int:
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
    timed, record = _certified(arguments, task, path, collision, found.motions[best], found.trials[best])
    import numpy as np

    t, tau = found.true[best]
    record["tau"] = np.round(np.stack([np.interp(record["t"], t, column) for column in tau.T], 1), 9).tolist()
    record |= {"learner": found.learner, "plant": plant.report(), "trials": found.rows(), "best": best + 1}
    record["oracle_duration"] = found.oracle.duration if found.oracle else None
    record["oracle"] = found.oracle.profile() if found.oracle else None
    _deliver(arguments, timed, record, summary(found, best))
    if found.best is None:
        options.note(f"none of {len(found.trials)} trials was without a measured violation: the one nearest to it was kept")
    elif (found.trials[best].true or 0.0) > BEYOND:
        options.note(f"the true torque of trial {best + 1} is beyond a limit, which noise hid from the measurement: allow more trials")
    if interrupted:
        options.note(f"interrupted: {len(found.trials)} of {arguments.trials} trials are complete")
        return 130
    if found.best is None:
        return 3
    return 0


def _next(arguments: argparse.Namespace, task: Task, path: JointPath, collision: dict[str, Any] | None) -> int:
    """The motion to run next on a real arm, from the logs of the trials so far."""
    from guideway.arm.learning import make_learner
    from guideway.arm.learning.loop import best_of, judged, with_profiles
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
        trials.append(judged(task, number, log, learner, None))
        tell(line(trials[-1]))
        motion = learner.next(logs)
    best, trial = best_of(trials), None
    if motion is None:
        if best is None:
            raise Infeasible(
                f"learning has ended, and in none of {len(trials)} trials was no violation measured: there is no motion to run next. "
                "Take another learner, or less payload"
            )
        tell(f"learning has ended: trial {best + 1} is the fastest without a measured violation, run it again")
        motion, trial = logs[best].motion, trials[best]
    timed, record = _certified(arguments, task, path, collision, motion, trial)
    from dataclasses import asdict

    rows = [asdict(trial) | {"clean": trial.clean} for trial in trials]
    bound = getattr(learner, "lower_bound", None)
    record |= {"learner": arguments.learner, "plant": None, "trials": with_profiles(rows, [log.motion for log in logs], best)}
    record |= {"oracle_duration": None, "lower_bound": bound}
    above = f", at most {100 * (motion.duration / bound - 1):.1f} % above the optimum" if bound else ""
    _deliver(arguments, timed, record, f"next         {motion.duration:.4f} s{above}")
    return 0


def _certified(
    arguments: argparse.Namespace, task: Task, path: JointPath, collision: dict[str, Any] | None, motion: Motion, trial: Trial | None
) -> tuple[ArmMotion, dict[str, Any]]:
    """The motion with its certificate, and its record; raises where a check fails."""
    from guideway.arm import outputs
    from guideway.arm.learning.certified import certified

    timed = certified(task, path, motion, collision, trial)
    if not timed.report["certificate"]["ok"]:
        raise CertificateFailed(arm_files.failure(timed, timed.report["certificate"]))
    record = outputs.record(timed, arguments.rate)
    record.pop("tau_model", None)  # of the nominal arm: it misses what the arm carries
    if motion.expected:
        record["tau_model"] = motion.expected(motion.sample(times=record["t"])).round(9).tolist()
    return timed, record


def _deliver(arguments: argparse.Namespace, timed: ArmMotion, record: dict[str, Any], outcome: str) -> None:
    from guideway.arm import outputs

    record = outputs.plain(record)
    written = arm_files.write(arguments, timed, record, record)
    if arguments.json:
        print(json.dumps(record, allow_nan=False))
        return
    print(outcome)
    print(kept(record))
    for place in written:
        print(f"wrote        {place}")


def kept(record: dict[str, Any]) -> str:
    """What the certificate says, and a step of speed where there is one."""
    certificate = record["certificate"]
    proved = [check for check in certificate["checks"] if check.get("certified", True)]
    lines = ["used         " + ", ".join(f"{check['name']} {100 * check['ratio']:.2f} %" for check in proved if "ratio" in check)]
    lines += [f"torque       not certified; {check['note']}" for check in certificate["checks"] if not check.get("certified", True)]
    margin = next((check["margin"] for check in proved if check["limit"] == "range"), None)
    range_ = f"joint ranges kept by {margin:.3f} rad" if margin is not None else "joints without ranges"
    collision = certificate["collision"]
    lines.append(f"safety       {range_}; {arm_files.near(collision) if collision else 'collisions were not checked'}")
    if step := record["report"].get("speed_step"):
        lines.append(f"step         the motion starts at {step[0]:.4g} and ends at {step[1]:.4g} rad/s along the path, not at rest")
    return "\n".join(lines)


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
    """The outcome: which trial, how far from the optimum, and what its torques were."""
    trial = found.trials[best]
    oracle = f", {trial.duration / found.oracle.duration:.4f} of the true optimum {found.oracle.duration:.4f} s" if found.oracle else ""
    title = "best " if found.best is not None else "kept "
    lines = [f"learner      {found.learner}", f"{title}        trial {trial.number}: {trial.duration:.4f} s{oracle}"]
    true = f", {100 * (1 + trial.true):.1f} % true" if trial.true is not None else ""
    lines.append(f"its torque   {100 * (1 + trial.measured):.1f} % of the limit measured, noise and all{true}")
    return "\n".join(lines)
