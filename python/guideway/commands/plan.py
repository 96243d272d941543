"""``guideway plan``: a map or scene in, a certified, timed path out."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from typing import Any

from guideway import _core, alternatives, jobs, products, records
from guideway.commands import options
from guideway.errors import BadParameter
from guideway.io.types import SOFT_WEIGHT, GridMap, Scene
from guideway.worlds import footprint_record, world_of

EXAMPLES = """examples:
  guideway plan warehouse.yaml --start=-5.4,-19 --goal 9.5,21.5 --footprint disc:0.35 --clearance 0.1 --out plan.json
  guideway plan room.toml --report room.html
  guideway plan maze.map --start-cell 3,4 --goal-cell 200,180 --planner jump-point --json
  guideway plan scene:pso-aco-1 --planner jump-point
  guideway plan scene:pso-aco-1 --planner aco --set preset=paper --iterations 1 --exact-fallback
  guideway plan scene:m30 --planner lexicographic --pareto --report choice.html
  guideway plan maze.map --scen maze.map.scen --planner jump-point --limit 100
  guideway plan --list jump-point"""

LIMITS = (
    ("speed", "V", "m/s (default 1)"),
    ("acceleration", "A", "m/s2 (default 0.5)"),
    ("deceleration", "D", "m/s2 (default: the acceleration)"),
    ("jerk", "J", "m/s3 (default 2)"),
)
"""Option, letter, unit and default of each limit."""


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the options."""
    parser.epilog = EXAMPLES
    parser.add_argument("map", nargs="?", metavar="MAP", help="map_server *.yaml, Moving AI *.map, text *.txt, scene or job *.toml, or scene:NAME")
    parser.add_argument("--list", nargs="?", const="", metavar="NAME", help="planners with a line each, or the parameters of one")
    parser.add_argument("--scen", metavar="FILE", help="every row of a Moving AI scenario, one JSON object per row")
    parser.add_argument("--limit", type=int, metavar="N", help="only the first N rows of the scenario")
    where = parser.add_argument_group("query")
    where.add_argument("--start", metavar="X,Y[,YAW]", help="start in m and rad, map frame")
    where.add_argument("--goal", metavar="X,Y[,YAW]", help="goal in m and rad, map frame")
    where.add_argument("--start-cell", metavar="COL,ROW", help="start as a cell of the image, row 0 on top")
    where.add_argument("--goal-cell", metavar="COL,ROW", help="goal as a cell of the image, row 0 on top")
    where.add_argument("--via", metavar="X,Y", action="append", help="a point to pass, in order; may be repeated")
    where.add_argument("--footprint", metavar="SHAPE", help="disc:R, box:L,W or polygon:x,y;x,y;... in m (default a point)")
    where.add_argument("--clearance", type=float, metavar="M", help="distance to keep from obstacles, m (default 0)")
    where.add_argument(
        "--soft-clearance", metavar="M[,W]", help="a metre nearer to obstacles than M beyond that costs up to 1 + W times (W: 2); plans with astar"
    )
    where.add_argument("--half-width", type=float, metavar="M", help="half the width of a long load, m (default 0; counts with --material long)")
    where.add_argument("--corners", metavar="RULE", help="touch, clear or squeeze: when a diagonal step on a grid is allowed (default by material)")
    where.add_argument("--material", metavar="KIND", help="standard (shortest, default), long (safest) or heavy (least energy)")
    where.add_argument("--compare-materials", action="store_true", help="all three products of the query beside the one asked for")
    where.add_argument("--unknown", choices=["blocked", "free"], default="blocked", help="cells that nobody has seen (default blocked)")
    where.add_argument("--thresholds", choices=["inclusive", "strict"], help="reading of map_server thresholds (default that of current Nav2)")
    where.add_argument("--order", choices=["given", "best"], help="of the via points (default given)")
    options.add_site(parser)
    options.add_method(parser)
    exact = parser.add_argument_group("exact lattice paths")
    exact.add_argument("--exact-fallback", action="store_true", help="where a lattice planner falls behind the exact path, return that")
    exact.add_argument("--pareto", action="store_true", help="add every lattice path worth choosing from, by length, turns, clearance and energy")
    shape = parser.add_argument_group("motion")
    shape.add_argument("--refine", metavar="HOW", help="none, simplify, smooth (default) or bspline")
    shape.add_argument("--max-curvature", type=float, metavar="K", help="largest curvature, 1/m; met where it can be, reported where not")
    for name, letter, about in LIMITS:
        shape.add_argument(f"--{name}", type=float, metavar=letter, help=f"largest {name}, {about}")
    shape.add_argument("--no-timing", action="store_true", help="a path only, no motion in time")
    out = parser.add_argument_group("output")
    out.add_argument("--out", metavar="FILE", help="the record as JSON")
    out.add_argument("--report", metavar="FILE", help="a self-contained HTML report")
    out.add_argument("--csv", metavar="FILE", help="the motion at 100 Hz")
    out.add_argument("--json", action="store_true", help="the record on stdout, and nothing else there")
    parser.set_defaults(handler=handle)


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    if arguments.list is not None:
        return _list(arguments.list, arguments.json)
    if arguments.map is None:
        raise BadParameter("guideway plan needs a MAP (*.yaml, *.map, *.txt or *.toml), or --list. See 'guideway plan --help'")
    _check(arguments)
    if arguments.scen is not None:
        from guideway.commands.scenario import run_scenario

        return run_scenario(arguments)
    job, out, report = job_of(arguments)
    if arguments.half_width and job.material != "long" and not arguments.compare_materials:
        options.note("guideway: --half-width counts with --material long only")
    options.writable(out, report, arguments.csv, inputs=(arguments.map,))
    try:
        with options.progress_bar() as job.observe:
            if arguments.compare_materials:
                outcome = products.compare(job, options.folder_of(out), own=arguments.refine is None and job.refine == "smooth")
            else:
                outcome = jobs.run(job, options.folder_of(out))
    except KeyboardInterrupt as interrupt:
        found = getattr(interrupt, "outcome", None)
        if found is not None:
            _deliver(arguments, found, out, report)
            options.note("guideway: interrupted; what was found so far is written")
            return 130
        raise
    _deliver(arguments, outcome, out, report)
    return 0


def _check(arguments: argparse.Namespace) -> None:
    for name in ("speed", "acceleration", "deceleration", "jerk", "max_curvature"):
        options.positive("--" + name.replace("_", "-"), getattr(arguments, name))
    for name in ("seed", "iterations", "evaluations", "limit", "threads"):
        options.count("--" + name, getattr(arguments, name))
    if arguments.compare_materials and arguments.scen is not None:
        raise BadParameter("--compare-materials is for one query: leave out --scen")
    if arguments.soft_clearance is not None and arguments.scen is not None:
        raise BadParameter("--soft-clearance is for one query: leave out --scen")
    if arguments.csv and arguments.no_timing:
        raise BadParameter("--csv needs a motion in time: leave out --no-timing")
    for first, second in (("start", "start_cell"), ("goal", "goal_cell")):
        if getattr(arguments, first) and getattr(arguments, second):
            raise BadParameter(f"--{first} and --{second.replace('_', '-')} are two ways to say one thing: give one of them")


def read(arguments: argparse.Namespace) -> GridMap | Scene:
    """The map or scene, as the readers found it."""
    from guideway.io import load

    given = {"unknown": arguments.unknown} | ({"thresholds": arguments.thresholds} if arguments.thresholds else {})
    return load(arguments.map, **given)


def job_of(arguments: argparse.Namespace) -> tuple[jobs.Job, str | None, str | None]:
    """The job: what the file says, overridden by the options; and where its results go."""
    found = read(arguments)
    job, table = (job_of_scene(found), found.plan) if isinstance(found, Scene) else (jobs.Job(world_of(found), (), ()), None)
    world = job.world
    for name in ("clearance", "half_width", "corners", "material", "planner", "seed", "refine", "max_curvature"):
        given = getattr(arguments, name)
        if given is not None:
            setattr(job, name, given)
    if arguments.footprint is not None:
        job.footprint = options.footprint(arguments.footprint)
    job.start, job.goal = _end(arguments, "start", job.start, world), _end(arguments, "goal", job.goal, world)
    if arguments.soft_clearance is not None:
        soft = options.numbers("--soft-clearance", arguments.soft_clearance, (1, 2), "M or M,WEIGHT")
        job.soft_clearance = (soft[0], soft[1] if len(soft) == 2 else SOFT_WEIGHT)
    if job.soft_clearance is not None and arguments.planner is None and (table is None or table.planner is None):
        job.planner = "astar"
    if arguments.via:
        job.via = [_pair(options.numbers("--via", text, (2,), "X,Y")) for text in arguments.via]
    job.order = arguments.order or job.order
    for mask in arguments.keep_out:
        job.world = job.world.with_keep_out(mask)
        job.keep_out.append(mask)
    job.speed_mask = arguments.speed_mask or job.speed_mask
    job.set = job.set | dict(options.setting(text) for text in arguments.set)
    job.limits = _limits(job.limits, arguments)
    given = {name: value for name in ("iterations", "evaluations", "seconds") if (value := getattr(arguments, name)) is not None}
    job.budget = replace(job.budget, **given)
    job.threads = arguments.threads
    job.exact_fallback |= arguments.exact_fallback
    job.pareto |= arguments.pareto
    job.timing = not arguments.no_timing
    if job.refine not in products.REFINEMENTS:
        raise BadParameter(f"--refine {job.refine!r} is not known: one of {', '.join(products.REFINEMENTS)}")
    return job, arguments.out or (table and table.out), arguments.report or (table and table.report)


def job_of_scene(scene: Scene) -> jobs.Job:
    """The job that a scene describes: its query, robot and ``[plan]`` table."""
    query, table, robot = scene.query, scene.plan, scene.robot
    job = jobs.Job(world_of(scene), (), (), footprint=footprint_record(robot.footprint))
    names = ("speed", "acceleration", "deceleration", "jerk", "turn_rate", "turn_acceleration", "lateral_acceleration")
    job.limits = records.Limits(**{name: getattr(robot, name) for name in names})
    if query is not None:
        job.start = () if query.start is None else (*query.start, *([] if query.start_yaw is None else [query.start_yaw]))
        job.goal = () if query.goal is None else (*query.goal, *([] if query.goal_yaw is None else [query.goal_yaw]))
        job.order = query.order
        job.soft_clearance = query.soft_clearance
        job.via, job.clearance, job.half_width, job.material = list(query.via), query.clearance, query.half_width, query.material
    job.drive = drive_of_scene(scene)
    job.speed_mask = None if scene.speed_mask is None else str(scene.speed_mask)
    if table is not None:
        job.planner, job.refine = table.planner or job.planner, table.refine or job.refine
        job.set, job.seed, job.corners = dict(table.set), table.seed or 0, table.corners
        job.budget = records.Budget(table.iterations, table.evaluations, table.seconds)
        job.exact_fallback, job.pareto = table.exact_fallback, table.pareto
    return job


def drive_of_scene(scene: Scene) -> dict[str, Any]:
    """What a scene says of the drive, for the record of its plan."""
    query = scene.query
    said = {} if query is None else {"arrival": query.arrival, "time_limit": query.time_limit, "stop": query.stop}
    return said | {"mover_speed": scene.mover_speed, "lidar": None if scene.lidar is None else scene.lidar.to_dict()}


def _end(arguments: argparse.Namespace, name: str, known: tuple[float, ...], world: _core.World) -> tuple[float, ...]:
    text, cell = getattr(arguments, name), getattr(arguments, f"{name}_cell")
    if text is not None:
        return options.numbers(f"--{name}", text, (2, 3), "X,Y or X,Y,YAW")
    if cell is not None:
        column, row = options.cell(f"--{name}-cell", cell)
        if not (0 <= column < world.width and 0 <= row < world.height):
            raise BadParameter(f"--{name}-cell {cell} is outside the map: columns 0 to {world.width - 1}, rows 0 to {world.height - 1}")
        return jobs.cell_to_point(world, (column, row))
    if not known:
        raise BadParameter(f"no {name} given: use --{name} X,Y (m) or --{name}-cell COL,ROW, or a scene with a [query] table")
    return known


def _pair(values: tuple[float, ...]) -> tuple[float, float]:
    return values[0], values[1]


def _limits(limits: records.Limits, arguments: argparse.Namespace) -> records.Limits:
    given = {n: v for n in (name for name, _, _ in LIMITS) if (v := getattr(arguments, n)) is not None}
    if "acceleration" in given and "deceleration" not in given:
        given["deceleration"] = given["acceleration"]  # a deceleration left out equals the acceleration
    return replace(limits, **given)


def _deliver(arguments: argparse.Namespace, outcome: jobs.Outcome, out: str | None, report: str | None) -> None:
    record = outcome.record
    if out:
        options.write(out, options.sealed_json(record))
    if arguments.csv and outcome.trajectory is not None:
        options.write(arguments.csv, csv_text(outcome.trajectory))
    if report:
        from guideway.view import report as write_report

        write_report([record], report, worlds=[outcome.query.world])
    if arguments.json:
        sys.stdout.write(options.sealed_json(record))
    else:
        print(summary(record))
        for path in filter(None, (out, arguments.csv, report)):
            print(f"wrote        {path}")


def csv_text(trajectory: _core.Trajectory) -> str:
    """The motion at 100 Hz as CSV."""
    rows = trajectory.sample(100.0).tolist()
    lines = (",".join(f"{value:.9g}" for value in row) for row in rows)
    return "t,x,y,yaw,speed,acceleration,jerk,curvature\n" + "\n".join(lines) + "\n"


def summary(record: dict[str, Any]) -> str:
    """A few lines for people."""
    search, metrics, reference = record["search"], record["metrics"], record["reference"]
    lines = [f"{record['planner']:<12} {search['raw_length']:.3f} m in {1e3 * search['seconds']:.2f} ms ({search['stop']})"]
    if reference["any_angle_gap"] is not None:
        lines.append(f"reference    {100 * reference['any_angle_gap']:.2f} % longer than the exact optimum of {reference['any_angle_optimum']:.3f} m")
    lines.extend(alternatives.gap_line(record))
    lines.extend(_objective(record.get("trace") or {}))
    curvature = "corners" if metrics["max_curvature"] is None else f"curvature up to {metrics['max_curvature']:.2f} 1/m"
    clearance = "no obstacle near" if metrics["min_clearance"] is None else f"{round(metrics['min_clearance'], 3) + 0.0:.3f} m clear"
    lines.append(f"path         {metrics['length']:.3f} m, {metrics['turns']} turns, {curvature}, {clearance}")
    if record["trajectory"]:
        lines.append(f"motion       {record['trajectory']['duration']:.2f} s in {len(record['trajectory']['pieces'])} pieces")
    lines.extend(_movers(record.get("trace") or {}))
    lines.append(f"certificate  {'ok' if record['certificate']['ok'] else 'FAILED'}: {len(record['certificate']['checks'])} checks")
    if "alternatives" in record:
        lines.extend(alternatives.table(record))
    lines.extend(f"not met      {text}" for text in record["unmet"])
    lines.extend(products.table(record["products"]) if "products" in record else [])
    return "\n".join(lines)


def _objective(trace: dict[str, Any]) -> list[str]:
    """The objective of a continuous planner, and how far above a proved lower bound it is."""
    objective, bound = trace.get("objective"), trace.get("bound") or {}
    if not isinstance(objective, dict):
        return []
    known = f", {100 * bound['gap']:.2f} % above a lower bound of {bound['lower']:.4f}" if bound.get("gap") is not None else ""
    return [f"objective    {objective['value']:.4f}{known}"]


def _movers(trace: dict[str, Any]) -> list[str]:
    """Which movers the motion keeps off, or why none, for planners that look at them."""
    told = (trace.get("speed") or {}).get("movers")
    if not isinstance(told, dict):
        return []
    count = f"{told['movers']} {'mover' if told['movers'] == 1 else 'movers'}"
    if not told["timed"]:
        return [f"movers       NOT KEPT OFF: the motion knows nothing of the {count}; {told['reason']}"]
    other = "" if not told["way"] else f", by way {told['way'] + 1} of {told['ways']} past the obstacles"
    brake = "a brake anywhere ends out of their reach" if told["passive"] else "no brake is sure to end out of their reach"
    return [f"movers       keeps off {count} at all times, {told['delay']:.2f} s later than alone ({told['waiting']:.2f} s waiting){other}; {brake}"]


def _list(name: str, as_json: bool) -> int:
    entries = _core.planners()
    if name:
        entries = [entry for entry in entries if entry["name"] == name]
        if not entries:
            known = ", ".join(entry["name"] for entry in _core.planners())
            raise BadParameter(f"planner {name!r} is not known: one of {known}")
    if as_json:
        print(json.dumps(entries))
    elif not name:
        _print_list(entries)
    else:
        _print_planner(entries[0])
    return 0


def _print_list(entries: list[dict[str, Any]]) -> None:
    """The planners with a line each, searches first."""
    groups = (
        ("Searches: no chance, nothing to tune", [entry for entry in entries if entry["paper"] is None]),
        (
            "Ant colonies, swarms and random trees: heuristics, the same for the same --seed; preset=paper for the settings of the source",
            [e for e in entries if e["paper"]],
        ),
    )
    for title, members in groups:
        print(title)
        for entry in members:
            print(f"  {entry['name']:<18} {entry['about']}")
    print("Parameters, defaults and source of one: guideway plan --list NAME")


def _print_planner(entry: dict[str, Any]) -> None:
    """What a planner is, and its parameters with defaults, and with those of the source where they differ."""
    print(f"{entry['name']}: {entry['about']}\nsource: {entry['source']}\n")
    paper = entry["paper"] or {}
    for parameter in entry["parameters"]:
        name, default = parameter["name"], parameter["default"]
        other = f"  (paper: {json.dumps(paper[name])})" if name in paper and paper[name] != default and name != "preset" else ""
        print(f"  {name} = {json.dumps(default)}{other}\n      {parameter['about']}")
    print("Set one with --set NAME=VALUE." if entry["parameters"] else "  no parameters")
