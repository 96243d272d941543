"""``guideway arm time``: the fastest motion along a path under the limits of the joints."""

from __future__ import annotations

import argparse
from collections import Counter
from typing import TYPE_CHECKING, Any

from guideway.commands import arm_files, options
from guideway.errors import BadParameter, CertificateFailed

if TYPE_CHECKING:
    from guideway.arm import Arm, ArmMotion, JointLimits, JointPath, Nurbs

IN_TIME = 1e-4
"""By how much a window may be missed because of rounding, s: near rest a place is passed slowly."""

EXAMPLES = """examples:
  guideway arm time --nurbs star --robot ur5e --out traj.json
  guideway arm time --nurbs seam.toml --urdf robot.urdf --limits limits.toml --torque --payload 5 --urscript seam.script
  guideway arm time points.csv --urdf robot.urdf --limits limits.toml --jerk --ros trajectory.yaml --csv joint.csv"""


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the options."""
    parser.epilog = EXAMPLES
    parser.add_argument("path", nargs="?", metavar="PATH.csv", help="joint way points: a header with the joints' names, a row each, rad")
    parser.add_argument(
        "--nurbs", metavar="FILE.toml", help="a path of the tool instead: degree, closed, points, weights, tool, posture; or the word star"
    )
    add_robot(parser)
    shape = parser.add_argument_group("timing")
    shape.add_argument(
        "--limits", metavar="FILE.toml", help="speed, acceleration, deceleration, jerk, torque, torque_rate, tip_speed, tip_acceleration"
    )
    shape.add_argument("--method", default="reachability", metavar="NAME", help="reachability (default) or bisection")
    shape.add_argument("--torque", action="store_true", help="torques count; the robot's own limits where the limits file states none")
    shape.add_argument("--jerk", action="store_true", help="jerk and torque rate count; they do where the limits file states them")
    shape.add_argument("--grid", type=int, metavar="N", help="a fixed number of points (default: chosen by error)")
    shape.add_argument("--override", type=float, metavar="F", help="the motion slowed down to F of its speed, above 0, at most 1")
    shape.add_argument("--branches", action="store_true", help="time a tool path in every branch of the inverse kinematics, and take the fastest")
    shape.add_argument(
        "--window",
        metavar="S,EARLIEST[,LATEST]",
        action="append",
        default=[],
        help="when the place S (rad of joint arc length) may be passed, s; may be repeated; with limits of jerk only the end of the path",
    )
    for end, where in (("start", "at the start of the path"), ("end", "at its end")):
        shape.add_argument(f"--{end}-speed", type=float, default=0.0, metavar="V", help=f"speed along the path {where}, rad/s (default 0)")
    arm_files.add_safety(parser)
    arm_files.add_output(parser)
    parser.set_defaults(handler=handle)


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Which arm it is, and what it carries."""
    group = parser.add_argument_group("robot")
    group.add_argument("--urdf", metavar="FILE", help="the robot's description")
    group.add_argument("--robot", metavar="NAME", help="one that ships with the package instead: ur5e, irb6700, irb120")
    group.add_argument("--estimated", action="store_true", help="with --robot irb6700: estimated masses, its description has none")
    group.add_argument("--tip", metavar="LINK", help="the link that is moved (default tool0, else the end of the longest chain)")
    group.add_argument("--payload", type=float, default=0.0, metavar="KG", help="what the tip carries, kg (default 0)")
    group.add_argument("--payload-at", default="0,0,0.08", metavar="X,Y,Z", help="its centre in the frame of the tip, m (default 0,0,0.08)")
    group.add_argument("--friction", default="none", metavar="KIND", help="none (default), or reference: 8, 2 N m s/rad and 7, 2 N m of the UR5e")


def arm_of(arguments: argparse.Namespace) -> Arm:
    """The arm that the words ask for."""
    from guideway import arm as arms

    if (arguments.urdf is None) == (arguments.robot is None):
        raise BadParameter("guideway arm needs one of --urdf FILE and --robot NAME")
    if arguments.estimated and arguments.robot is None:
        raise BadParameter("--estimated goes with --robot: give the masses in the URDF file")
    settings: dict[str, Any] = {"tip": arguments.tip, "payload": arguments.payload}
    settings["payload_at"] = options.numbers("--payload-at", arguments.payload_at, (3,), "X,Y,Z")
    if arguments.friction not in ("none", "reference"):
        raise BadParameter(f"--friction {arguments.friction!r} is not known: use none or reference")
    settings["friction"] = arms.REFERENCE_FRICTION if arguments.friction == "reference" else None
    if arguments.urdf is not None:
        return arms.Arm.load(arguments.urdf, **settings)
    return arms.robot(arguments.robot, estimated=arguments.estimated, **settings)


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    _check(arguments)
    given = (arguments.path, arguments.nurbs, arguments.urdf, arguments.limits, arguments.scene)
    options.writable(*arm_files.places(arguments), inputs=given)
    try:
        motion = _timed(arguments)
    except ImportError as missing:
        raise BadParameter(str(missing)) from missing
    _deliver(arguments, motion)
    return 0


def _check(arguments: argparse.Namespace) -> None:
    if (arguments.path is None) == (arguments.nurbs is None):
        raise BadParameter("guideway arm time needs one of PATH.csv and --nurbs FILE.toml. See 'guideway arm time --help'")
    if arguments.branches and arguments.nurbs is None:
        raise BadParameter("--branches goes with --nurbs: way points of joints have one branch")
    options.positive("--rate", arguments.rate)
    for name in ("start_speed", "end_speed"):
        value = getattr(arguments, name)
        if not 0 <= value < 1e6:
            raise BadParameter(f"--{name.replace('_', '-')} {value:g} is out of range: a number from 0")
        if value and arguments.urscript:
            raise BadParameter(f"--urscript is for motions from rest to rest: leave --{name.replace('_', '-')} out, or write --csv or --ros")
    arguments.window = [_window(text) for text in arguments.window]
    if arguments.window and arguments.override is not None:
        raise BadParameter("--override slows the whole motion down, so windows would be missed: leave out --override or --window")
    for name in ("payload", "clearance"):
        value = getattr(arguments, name)
        if value is not None and not 0 <= value < 1e6:
            raise BadParameter(f"--{name} {value:g} is out of range: a number from 0")
    if arguments.grid is not None and not 2 <= arguments.grid <= 10**6:
        raise BadParameter(f"--grid {arguments.grid} is out of range: from 2 to 1000000 points")
    if arguments.override is not None and not 0 < arguments.override <= 1:
        raise BadParameter(f"--override {arguments.override:g} is out of range: above 0 and at most 1")


def _window(text: str) -> tuple[float, ...]:
    """A place and when it may be passed."""
    found = options.numbers("--window", text, (2, 3), "S,EARLIEST or S,EARLIEST,LATEST")
    if min(found) < 0 or (len(found) == 3 and found[2] < found[1]):
        raise BadParameter(f"--window {text!r} is out of range: numbers from 0, LATEST not before EARLIEST")
    return found


def _timed(arguments: argparse.Namespace) -> ArmMotion:
    """The motion, timed and certified."""
    from guideway import arm as arms

    arm = arm_of(arguments)
    limits = arms.load_limits(arguments.limits) if arguments.limits else arms.JointLimits()
    if arguments.jerk and limits.jerk is None and limits.torque_rate is None:
        raise BadParameter("--jerk needs jerk or torque_rate in the file of --limits: the robot's description states none")
    scene = arms.load_scene(arguments.scene) if arguments.scene else None
    if arguments.nurbs:
        given = nurbs_of(arguments.nurbs)
        arm = arms.arm_for(arm, given)
        path = _fastest(arguments, arm, given, limits) if arguments.branches else arms.joint_path(arm, given)
    else:
        path = arms.joint_path(arm, arguments.path)
    motion = _time(arguments, arm, path, limits)
    if arguments.override is not None:
        motion = motion.override(arguments.override)
    around = None if arguments.no_collisions else arms.Surroundings(arm, scene)
    certificate = motion.certify(collisions=around is not None, surroundings=around, clearance=arguments.clearance)
    for window in arguments.window:
        certificate["checks"].append(_passed(motion, window))
        certificate["ok"] = certificate["ok"] and certificate["checks"][-1]["ok"]
    motion.report["certificate"] = certificate
    if not certificate["ok"]:
        raise CertificateFailed(arm_files.failure(motion, certificate))
    return motion


def nurbs_of(text: str) -> Nurbs:
    """A tool path from its file, or the star."""
    from guideway import arm as arms

    return arms.star() if text == "star" else arms.load_nurbs(text)


def _time(arguments: argparse.Namespace, arm: Arm, path: JointPath, limits: JointLimits) -> ArmMotion:
    from guideway import arm as arms

    for window in arguments.window:
        if window[0] > path.path.length * (1 + 1e-4):
            raise BadParameter(f"--window: the place {window[0]:g} rad is beyond the end of the path, {path.path.length:.6g} rad")
    words: dict[str, Any] = {"method": arguments.method, "torque": True if arguments.torque else None, "grid": arguments.grid, "check": False}
    words |= {"start_speed": arguments.start_speed, "end_speed": arguments.end_speed}
    return arms.time(path, limits, arm, windows=[(min(s, path.path.length), *when) for s, *when in arguments.window], **words)


def _passed(motion: ArmMotion, window: tuple[float, ...]) -> dict[str, Any]:
    """Is a place passed in time? ``gap``: by how much it is not, s."""
    at, earliest, *latest = window
    t = motion.duration if at >= motion.path.path.length * (1 - 1e-9) else motion.time_at(at)
    gap = max(earliest - t, t - latest[0] if latest else 0.0, 0.0)
    return {"name": f"window at s = {at:g} rad", "limit": "window", "ok": gap <= IN_TIME, "gap": gap, "t": t, "s": at}


def _fastest(arguments: argparse.Namespace, arm: Arm, nurbs: Nurbs, limits: JointLimits) -> JointPath:
    """The branch of a tool path with the shortest motion; all of them are told on stderr."""
    from guideway import arm as arms

    timed = [(_time(arguments, arm, path, limits), path) for path in arms.all_branches(arm, nurbs)]
    for motion, path in timed:
        start = ", ".join(f"{value:.2f}" for value in path.path.eval([0.0])[0, 0])
        value = path.report["smallest_singular_value"]
        options.note(f"branch from ({start}) rad: {motion.duration:.4f} s, {path.path.length:.4f} rad, smallest singular value {value:.3f}")
    return min(timed, key=lambda entry: entry[0].duration)[1]


def _deliver(arguments: argparse.Namespace, motion: ArmMotion) -> None:
    import json

    from guideway.arm import outputs

    record = outputs.record(motion, arguments.rate)
    written = arm_files.write(arguments, motion, record, [record])
    if arguments.json:
        print(json.dumps(record, allow_nan=False))
        return
    print(summary(record))
    for place in written:
        print(f"wrote        {place}")


def summary(record: dict[str, Any]) -> str:
    """What a person wants to know of a record, a line each."""
    robot, path, certificate = record["robot"], record["report"]["path"], record["certificate"]
    load = f", payload {robot['payload']['mass']:g} kg" if robot["payload"]["mass"] else ""
    masses = ", inertials estimated" if robot["inertials"] == "estimated" else ""
    lines = [f"robot        {robot['name']}{load}{masses}"]
    detail = (
        f", smallest singular value {path['smallest_singular_value']:.3f}, spline within {path['deviation']:.1g} m" if "deviation" in path else ""
    )
    lines.append(f"path         {record['path']['length']:.4f} rad{detail}")
    lines.append("limits       " + "; ".join(f"{name} {_numbers(value)}" for name, value in record["limits"].items()))
    lines.append(f"duration     {record['duration']:.4f} s ({record['report']['method']})")
    measured = record["report"].get("measures") or {}
    if "energy" in measured:
        lines.append(f"energy       {measured['energy']:.1f} J; windings heated as by {measured['copper']:.3f} s of one joint at its limit")
    if prices := _prices(record):
        lines.append("price        " + ", ".join(f"{name} {value:+.4f} s" for name, value in prices[:6]))
    used = ", ".join(f"{check['name']} {100 * check['ratio']:.2f} %" for check in certificate["checks"] if "ratio" in check)
    lines.append(f"used         {used}")
    if record["grid"]["active"]:
        count = Counter(_named(name, record["joints"]) for name in record["grid"]["active"] if name)
        share = ", ".join(f"{name} {100 * n / len(record['grid']['active']):.0f} %" for name, n in count.most_common(4))
        lines.append(f"held by      {share}")
    for check in (check for check in certificate["checks"] if check["limit"] == "window"):
        lines.append(f"window       s = {check['s']:g} rad is passed at {check['t']:.4f} s")
    margin = next((check["margin"] for check in certificate["checks"] if check["limit"] == "range"), None)
    lines.append(f"safety       joint ranges kept by {margin:.3f} rad" if margin is not None else "safety       joints without ranges")
    if certificate["collision"] is not None:
        lines[-1] += f"; {arm_files.near(certificate['collision'])}"
    return "\n".join(lines)


def _named(constraint: str, joints: list[str]) -> str:
    """A constraint with the joint's name instead of its number."""
    what, _, number = constraint.partition(" of joint ")
    return f"{what} of {joints[int(number) - 1]}" if number.isdigit() and 0 < int(number) <= len(joints) else constraint


def _prices(record: dict[str, Any]) -> list[tuple[str, float]]:
    """What each bound of jerk or torque rate costs, the dearest first, s."""
    rows = [(_named(name, record["joints"]), value) for name, value in record["report"].get("price") or [] if value > 0]
    return sorted(rows, key=lambda row: -row[1])


def _numbers(value: float | list[float]) -> str:
    values = value if isinstance(value, list) else [value]
    return f"{values[0]:g}" if len(set(values)) == 1 else ", ".join(f"{item:g}" for item in values)
