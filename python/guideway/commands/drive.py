"""``guideway drive``: a planned motion in a world that moves."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from guideway import _core, driving, jobs
from guideway.commands import options
from guideway.errors import BadFile, BadParameter
from guideway.io.types import Scene

EXAMPLES = """examples:
  guideway drive plan.json --out run.json --report run.html
  guideway drive room.toml --planner visibility --seed 3
  guideway drive plan.json --movers people.toml --controller tracker"""


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the options."""
    parser.epilog = EXAMPLES
    parser.add_argument("plan", metavar="PLAN.json|SCENE.toml", help="a plan, or a scene with a query to plan first")
    parser.add_argument("--planner", metavar="NAME", help="plans a scene, and again when the way is blocked (default visibility)")
    parser.add_argument("--controller", metavar="NAME", help=f"what steers (default {driving.Drive.controller}; 'list' names them all)")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="a parameter of the controller; may be repeated")
    parser.add_argument("--movers", metavar="FILE", help="moving obstacles instead of the scene's own: TOML with [[mover]] tables")
    parser.add_argument("--sense", default="truth", metavar="HOW", help="how movers are seen: truth (default), with the noise of the plant")
    parser.add_argument("--map", default="known", metavar="HOW", help="what the robot knows of the map: known (default), all of it")
    parser.add_argument("--plant", default="unicycle", metavar="NAME", help="what is driven: unicycle (default), with lags and noise")
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
    options.writable(arguments.out, arguments.report, inputs=(arguments.plan, arguments.movers))
    drive, plan = drive_of(arguments)
    with options.progress_bar() as drive.observe:
        record = driving.run(drive, options.folder_of(arguments.out))
    _deliver(arguments, record, plan, drive.query.world)
    if record["cancelled"]:
        return 130
    return 0 if record["outcome"] == "arrived" else 3


def _check(arguments: argparse.Namespace) -> None:
    for name, known in (("sense", "truth"), ("map", "known"), ("plant", "unicycle")):
        if getattr(arguments, name) != known:
            raise BadParameter(f"--{name} {getattr(arguments, name)!r} is not available in this version: use {known}")
    options.positive("--time-limit", arguments.time_limit)
    options.count("--seed", arguments.seed)


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
    return drive, plan


def _from_plan(arguments: argparse.Namespace) -> tuple[driving.Drive, dict[str, Any]]:
    from guideway.results import is_run, load_record, world_of_record

    plan = load_record(arguments.plan)
    if is_run(plan):
        raise BadFile(arguments.plan, "it is a run", "a plan.json or a scene TOML")
    world = _with_movers(world_of_record(plan, arguments.plan), arguments.movers)
    try:
        query, trajectory, limits = driving.from_plan(plan, world)
    except (KeyError, TypeError, ValueError) as error:
        raise BadFile(arguments.plan, f"a field is missing or wrong ({error})", "a plan.json as guideway plan writes it") from None
    return driving.Drive(query, trajectory, limits, planner=plan.get("planner", "visibility")), plan


def _from_scene(arguments: argparse.Namespace) -> tuple[driving.Drive, dict[str, Any]]:
    from guideway.commands.plan import job_of_scene
    from guideway.io import load

    scene = load(arguments.plan)
    if not isinstance(scene, Scene):
        raise BadFile(arguments.plan, "it is a map without a query", "a plan.json, or a scene TOML with a [query] table", "Plan on it first")
    job = job_of_scene(scene)
    job.world = _with_movers(job.world, arguments.movers)
    job.planner = arguments.planner or job.planner
    outcome = jobs.run(job, options.folder_of(arguments.out))
    if outcome.trajectory is None:
        raise BadParameter("the scene's job asks for no timing; a drive needs a motion in time")
    drive = driving.Drive(outcome.query, outcome.trajectory, job.limits, planner=job.planner)
    if scene.query is not None:
        drive.arrival, drive.time_limit = scene.query.arrival, scene.query.time_limit
    return drive, outcome.record


def _with_movers(world: _core.World, path: str | None) -> _core.World:
    if path is None:
        return world
    from guideway.io import load_movers

    return world.with_movers([mover.to_dict() for mover in load_movers(path)])


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


def summary(record: dict[str, Any]) -> str:
    """A few lines for people."""
    tracking, steps = record["tracking"], record["step_seconds"]
    nearest = "nothing near" if record["min_separation"] is None else f"{record['min_separation']:.3f} m to the nearest obstacle"
    lines = [
        f"outcome      {record['outcome']} after {record['time']:.2f} s (planned {record['plan']['duration']:.2f} s)",
        f"safety       {nearest}, {record['emergency_stops']} emergency stops, {record['replans']} new plans",
        f"tracking     {100 * tracking['tte']:.2f} cm from the path (RMS), {100 * tracking['tpe']:.1f} cm from the goal at the end",
        f"controller   {record['controller']}, {1e3 * steps['mean']:.3f} ms a step (99 %: {1e3 * steps['p99']:.3f} ms)",
    ]
    if record["collision"]:
        hit = record["collision"]
        lines.append(f"collision    with {hit['with']} at {hit['t']:.2f} s{' (it drove into the parked robot)' if hit['unavoidable'] else ''}")
    return "\n".join(lines)
