"""``guideway drive``: a planned motion in a world that moves."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from guideway import _core, driving, jobs, plants
from guideway.commands import options
from guideway.errors import BadFile, BadParameter
from guideway.io.types import Scene

EXAMPLES = """examples:
  guideway drive plan.json --out run.json --report run.html
  guideway drive room.toml --planner visibility --seed 3
  guideway drive plan.json --movers people.toml --controller tracker
  guideway drive plan.json --movers people.csv --mover-radius 0.3 --sense lidar
  guideway drive --barn 7 --sense lidar --map none --report run.html
  guideway drive dynabarn_worlds.json#3 --sense lidar
  guideway drive room.toml --plant mujoco --plant-set height=0.5 --video room.gif"""

WORDS = {"acceleration": "m/s2 ahead", "deceleration": "m/s2 braking", "turn_rate": "rad/s turning", "turn_acceleration": "rad/s2 turning"}
"""Limits that a plant may lower, as people read them."""

LONGEST_PLAN = 1000.0
"""Most that ``--plan-time`` may be, s."""


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the options."""
    parser.epilog = EXAMPLES
    what = "a plan, or a scene with a query to plan first; world N of a collection: FILE#N"
    parser.add_argument("plan", nargs="?", metavar="PLAN.json|SCENE.toml|FILE#N", help=what)
    parser.add_argument("--barn", type=int, metavar="N", help="world N of BARN, found in GUIDEWAY_DATA or named by --worlds")
    parser.add_argument("--dynabarn", type=int, metavar="N", help="world N of DynaBARN, found in the same way")
    parser.add_argument("--worlds", metavar="FILE", help="the file of the collection")
    parser.add_argument("--planner", metavar="NAME", help="plans a scene, and again when the way is blocked (default visibility)")
    parser.add_argument("--controller", metavar="NAME", help=f"what steers (default {driving.Drive.controller}; 'list' names them all)")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="a parameter of the controller; may be repeated")
    parser.add_argument("--movers", metavar="FILE", help="moving obstacles instead of the scene's own: TOML with [[mover]], CSV t,id,x,y")
    parser.add_argument("--mover-radius", type=float, default=0.25, metavar="M", help="radius of the discs of a CSV, m (default 0.25)")
    options.add_site(parser)
    parser.add_argument("--sense", default="truth", metavar="HOW", help="how movers are seen: truth (default), or lidar: simulated, and tracked")
    about = "top speed of whatever moves on the site, m/s, which no lidar can tell (default: the scene's; else guessed from each track)"
    parser.add_argument("--mover-speed", type=float, metavar="V", help=about)
    parser.add_argument("--map", default="known", metavar="HOW", help="what the robot knows of the map: known (default), or none but its bounds")
    parser.add_argument(
        "--plant", default="unicycle", metavar="NAME", help="what is driven: unicycle (default), with lags and noise, or mujoco, simulated"
    )
    parser.add_argument("--plant-set", metavar="KEY=VALUE", action="append", default=[], help="a setting of the plant mujoco; may be repeated")
    parser.add_argument("--video", metavar="FILE", help="a film (.gif) or a still picture (.png) of the plant mujoco in its room")
    about = "how long a new plan takes, s: it is driven so much later than it is asked for (default 0: the world stands still meanwhile)"
    parser.add_argument("--plan-time", type=float, default=0.0, metavar="S", help=about)
    parser.add_argument("--time-limit", type=float, metavar="S", help="longest run, s (default three times the planned duration and a minute)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the noise (default 0)")
    parser.add_argument("--out", metavar="FILE", help="the record as JSON")
    parser.add_argument("--report", metavar="FILE", help="a self-contained HTML report")
    parser.add_argument("--json", action="store_true", help="the record on stdout, and nothing else there")
    parser.set_defaults(handler=handle)


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    if arguments.controller == "list":
        for entry in _core.controllers():
            print(f"{entry['name']:<16} {entry['about']}")
        return 0
    _check(arguments)
    arguments.plan = _named(arguments)
    options.writable(arguments.out, arguments.report, arguments.video, inputs=(arguments.plan, arguments.movers))
    drive, plan = drive_of(arguments)
    drive.plant = _plant(arguments, drive)
    with options.progress_bar() as drive.observe:
        record = driving.run(drive, options.folder_of(arguments.out))
    _deliver(arguments, record, plan, drive.query.world)
    _film(arguments, drive.plant)
    if record["cancelled"]:
        return 130
    return 0 if record["outcome"] == "arrived" else 3


def _check(arguments: argparse.Namespace) -> None:
    for name, known in (("sense", ("truth", "lidar")), ("map", ("known", "none"))):
        if getattr(arguments, name) not in known:
            raise BadParameter(f"--{name} {getattr(arguments, name)!r} is not available in this version: use {' or '.join(known)}")
    if arguments.map == "none" and arguments.sense != "lidar":
        raise BadParameter("--map none needs --sense lidar: a robot without a map must see what is there")
    if arguments.plant not in plants.PLANTS:
        raise BadParameter(f"--plant {arguments.plant!r} is not known: use {' or '.join(plants.PLANTS)}")
    if arguments.video is not None:
        if arguments.plant != "mujoco":
            raise BadParameter("--video shows the plant mujoco: add --plant mujoco")
        if not arguments.video.lower().endswith((".gif", ".png")):
            raise BadParameter(f"--video {arguments.video!r} has no ending that is known: use .gif for a film, .png for a picture")
    options.positive("--time-limit", arguments.time_limit)
    options.positive("--mover-radius", arguments.mover_radius)
    options.positive("--mover-speed", arguments.mover_speed)
    if not 0 <= arguments.plan_time <= LONGEST_PLAN:
        raise BadParameter(f"--plan-time {arguments.plan_time:g} is out of range: it must be 0 to {LONGEST_PLAN:g} s")
    options.count("--seed", arguments.seed)


def _named(arguments: argparse.Namespace) -> str:
    """What is to be driven, by name: the file, or a world of a collection."""
    from guideway.io.collections import find_collection

    given = [kind for kind in ("plan", "barn", "dynabarn") if getattr(arguments, kind) is not None]
    if len(given) != 1:
        raise BadParameter("guideway drive needs one of PLAN.json, SCENE.toml, FILE#N, --barn N and --dynabarn N. See 'guideway drive --help'")
    if given == ["plan"]:
        if arguments.worlds is not None:
            raise BadParameter("--worlds names the file of --barn N or --dynabarn N: add one of them, or write FILE#N")
        return arguments.plan
    number = getattr(arguments, given[0])
    options.count(f"--{given[0]}", number)
    return f"{find_collection(given[0], arguments.worlds)}#{number}"


def _plant(arguments: argparse.Namespace, drive: driving.Drive) -> str | plants.Plant:
    """The plant that the words ask for."""
    settings = dict(options.setting(text) for text in arguments.plant_set)
    try:
        return plants.make(arguments.plant, drive.query, drive.trajectory, drive.seed, settings) or arguments.plant
    except ImportError as error:
        raise BadParameter(str(error)) from error


def _film(arguments: argparse.Namespace, plant: str | plants.Plant) -> None:
    """Writes the film, or says why there is none: the run counts all the same."""
    if arguments.video is None:
        return
    from guideway.plants import film

    assert isinstance(plant, plants.MobileBase)
    try:
        film.save(plant, arguments.video)
    except film.NoPicture as error:
        options.note(f"no film: {error}")
    else:
        (options.note if arguments.json else print)(f"wrote        {os.fspath(arguments.video)}")


def drive_of(arguments: argparse.Namespace) -> tuple[driving.Drive, dict[str, Any] | None]:
    """The drive that the words ask for, and the plan it starts from."""
    if arguments.plan.endswith(".json"):
        drive, plan = _from_plan(arguments)
    else:
        drive, plan = _from_scene(arguments)
    drive.planner = arguments.planner or drive.planner
    drive.controller = arguments.controller or drive.controller
    drive.set = dict(options.setting(text) for text in arguments.set)
    drive.seed = arguments.seed
    drive.time_limit = arguments.time_limit or drive.time_limit
    drive.trace = bool(arguments.out or arguments.report)
    drive.sense, drive.map = arguments.sense, arguments.map
    drive.plan_time = arguments.plan_time
    drive.mover_speed = arguments.mover_speed if arguments.mover_speed is not None else drive.mover_speed
    return drive, plan


def _from_plan(arguments: argparse.Namespace) -> tuple[driving.Drive, dict[str, Any]]:
    from guideway.results import is_run, load_record, mask_of_record, world_of_record

    plan = load_record(arguments.plan)
    if is_run(plan):
        raise BadFile(arguments.plan, "it is a run", "a plan.json or a scene TOML")
    world = _with_movers(world_of_record(plan, arguments.plan), arguments)
    _same_site(arguments, plan)
    masks = [mask_of_record(mask, arguments.plan) for mask in plan["world"].get("keep_out", [])]
    slow = None if "speed_mask" not in plan else mask_of_record(plan["speed_mask"], arguments.plan)
    try:
        query, trajectory, limits = driving.from_plan(plan, world)
        drive = driving.Drive(query, trajectory, limits, planner=plan.get("planner", "visibility"))
        _said(drive, plan.get("drive") or {}, arguments)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BadFile(arguments.plan, f"a field is missing or wrong ({error})", "a plan.json as guideway plan writes it") from None
    driving.check(drive, arguments.plan)
    drive.keep_out, drive.speed_mask = masks, slow
    return drive, plan


def _same_site(arguments: argparse.Namespace, plan: dict[str, Any]) -> None:
    """Refuses masks that the plan was not made with: its path and its speeds know nothing of them."""
    from guideway.io.masks import read_mask

    slow = [plan["speed_mask"]] if "speed_mask" in plan else []
    given = [] if arguments.speed_mask is None else [arguments.speed_mask]
    for option, paths, kept in (("--keep-out", arguments.keep_out, plan["world"].get("keep_out", [])), ("--speed-mask", given, slow)):
        known = [sorted(mask["files"].values()) for mask in kept]
        for path in paths:
            if sorted(read_mask(path)[2].values()) not in known:
                what = f"{option} {path!r} is not a mask that {arguments.plan} was made with"
                raise BadParameter(f"{what}: leave it out (a plan brings its masks), or plan again with it")


def _said(drive: driving.Drive, said: dict[str, Any], arguments: argparse.Namespace) -> None:
    """What a scene says of the drive; :mod:`guideway.commands.plan` keeps it in the plan."""
    for name in ("arrival", "time_limit", "mover_speed"):
        value = said.get(name)
        if value is not None:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise TypeError(f"drive.{name} {value!r} is no number")
            setattr(drive, name, float(value))
    stop, lidar = said.get("stop", True), said.get("lidar")
    if not isinstance(stop, bool) or not isinstance(lidar, dict | None):
        raise TypeError(f"drive.stop is {stop!r} and drive.lidar {lidar!r}: true or false, and a table or null")
    drive.stop_at_goal = stop
    if lidar is not None and arguments.sense == "lidar":
        drive.lidar = lidar


def _from_scene(arguments: argparse.Namespace) -> tuple[driving.Drive, dict[str, Any]]:
    from guideway.commands.plan import job_of_scene
    from guideway.io import load

    scene = load(arguments.plan)
    if not isinstance(scene, Scene):
        raise BadFile(arguments.plan, "it is a map without a query", "a plan.json, or a scene TOML with a [query] table", "Plan on it first")
    job = job_of_scene(scene)
    job.world = _with_site(_with_movers(job.world, arguments), arguments)
    job.keep_out, job.speed_mask = list(arguments.keep_out), arguments.speed_mask or job.speed_mask
    job.planner = arguments.planner or job.planner
    world = job.world
    if arguments.map == "none":
        job.world = driving.unseen(job.world)  # the first plan knows no better
    outcome = jobs.run(job, options.folder_of(arguments.out))
    if outcome.trajectory is None:
        raise BadParameter("the scene's job asks for no timing; a drive needs a motion in time")
    job.world = world
    drive = driving.Drive(job.query(), outcome.trajectory, job.limits, planner=job.planner)
    drive.keep_out, drive.speed_mask = job.keep_out, job.speed_mask
    _said(drive, job.drive, arguments)
    return drive, outcome.record


def _with_site(world: _core.World, arguments: argparse.Namespace) -> _core.World:
    for mask in arguments.keep_out:
        world = world.with_keep_out(mask)
    return world


def _with_movers(world: _core.World, arguments: argparse.Namespace) -> _core.World:
    if arguments.movers is None:
        return world
    from guideway.io import load_movers

    return world.with_movers([mover.to_dict() for mover in load_movers(arguments.movers, arguments.mover_radius)])


def _deliver(arguments: argparse.Namespace, record: dict[str, Any], plan: dict[str, Any] | None, world: _core.World) -> None:
    if arguments.out:
        options.write(arguments.out, options.sealed_json(record))
    if arguments.report:
        from guideway.view import report

        records = [record] if plan is None else [plan, record]
        report(records, arguments.report, worlds=[world] * len(records))
    if arguments.json:
        sys.stdout.write(options.sealed_json(record))
        return
    print(summary(record))
    for path in filter(None, (arguments.out, arguments.report)):
        print(f"wrote        {os.fspath(path)}")


def _fast(steps: dict[str, Any]) -> str:
    """How many of the slowest steps fit in a control period."""
    factor = steps["real_time_factor"]
    return "" if factor is None else f", {factor:.3g} x real time"


def summary(record: dict[str, Any]) -> str:
    """A few lines for people."""
    tracking, steps = record["tracking"], record["step_seconds"]
    nearest = "nothing near" if record["min_separation"] is None else f"{record['min_separation']:.3f} m to the nearest obstacle"
    ended = "interrupted" if record["cancelled"] else record["outcome"]
    lines = [
        f"outcome      {ended} after {record['time']:.2f} s (planned {record['plan']['duration']:.2f} s)",
        f"safety       {nearest}, {record['emergency_stops']} emergency stops, {record['replans']} new plans",
        f"tracking     {100 * tracking['tte']:.2f} cm from the path (RMS), {100 * tracking['tpe']:.1f} cm from the goal at the end",
        f"controller   {record['controller']}, {1e3 * steps['mean']:.3f} ms a step (99 %: {1e3 * steps['p99']:.3f} ms{_fast(steps)})",
    ]
    if record["plan_seconds"]["mean"] > 0.0:
        plans = record["plan_seconds"]
        times = f"{1e3 * plans['p50']:.1f} ms a plan (99 %: {1e3 * plans['p99']:.1f} ms)"
        when = f"each driven {record['plan_time']:g} s after it was asked for" if record["plan_time"] else "for which the simulation stood still"
        lines.append(f"planning     {record['planner']}, {times}, {when}")
    plant = record["plant"]
    if "limits" in plant:
        asked, held = plant["limits"]["asked"], plant["limits"]["held"]
        less = ", ".join(
            f"{held[name]:.3g} {words} ({'no limit' if asked[name] is None else format(asked[name], '.3g')} asked)"
            for name, words in WORDS.items()
            if asked[name] != held[name]
        )
        lines.append(f"limits       {less}: all that {plant['name']} can hold")
    if "tilt" in plant:
        tilt, slip = plant["tilt"], plant["slip"]
        lines.append(
            f"plant        {plant['name']}: tilt at most {tilt['max']:.1f} degrees (posture stability {tilt['psi']:.1f} %), "
            f"slip at most {slip['max']:.2f} m/s, {plant['contacts']} contacts, {plant['energy']['work']:.0f} J into the wheels"
        )
    if record["collision"]:
        hit = record["collision"]
        lines.append(f"collision    with {hit['with']} at {hit['t']:.2f} s{' (it drove into the parked robot)' if hit['unavoidable'] else ''}")
    return "\n".join(lines)
