"""Driving a planned motion in a world that moves, and the record of ``run.json``."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway import _core, jobs, plants
from guideway.errors import BadFile, BadParameter, Infeasible
from guideway.records import Limits

if TYPE_CHECKING:
    from guideway.plants import Plant


TURN_RATE, TURN_ACCELERATION = 1.0, 2.0
"""What a unicycle without limits of its own can do, rad/s and rad/s2."""

SAME = 1e-6
"""Durations of a plan may differ by so much from the sum of their pieces, s."""


@dataclass
class Drive:
    """Everything that decides a run; ``arrival`` in m, ``time_limit`` and ``plan_time`` in s."""

    query: _core.Query
    trajectory: _core.Trajectory
    limits: Limits
    controller: str = "improved-dwa"
    planner: str = "visibility"
    set: dict[str, Any] = field(default_factory=dict)
    seed: int = 0
    arrival: float = 0.1
    stop_at_goal: bool = True
    time_limit: float | None = None
    sense: str = "truth"
    lidar: dict[str, Any] = field(default_factory=dict)
    map: str = "known"
    plant: str | Plant = "unicycle"
    observe: jobs.Observer | None = None
    trace: bool = False
    keep_out: list[str] = field(default_factory=list)
    speed_mask: str | None = None
    mover_speed: float | None = None
    plan_time: float = 0.0


def drive(
    query: _core.Query,
    trajectory: _core.Trajectory,
    controller: str = Drive.controller,
    *,
    planner: str = "visibility",
    set: dict[str, Any] | None = None,
    seed: int = 0,
    arrival: float = 0.1,
    stop_at_goal: bool = True,
    time_limit: float | None = None,
    sense: str = "truth",
    lidar: dict[str, Any] | None = None,
    map: str = "known",
    plant: str | Plant = "unicycle",
    observe: jobs.Observer | None = None,
    trace: bool = False,
    mover_speed: float | None = None,
    plan_time: float = 0.0,
) -> dict[str, Any]:
    """Drives ``trajectory`` among the movers of the query's world; returns the record of ``run.json``.

    ``controller`` is one of :func:`guideway.controllers`, ``set`` holds its parameters; ``planner`` plans anew when the way is blocked; ``arrival``
    (m) is how near the goal counts as arrived; ``time_limit`` is in s (default three times the planned duration and a minute). ``sense`` is
    "truth" or "lidar", a simulated one whose scans are all that is seen (``lidar``: ``beams``, ``field_of_view`` in rad, ``range`` and ``noise``
    in m, ``rate`` in Hz); with ``map`` "none" the robot knows the bounds of the world and what its lidar has seen (:func:`unseen` is the world to
    plan the first motion in). ``mover_speed`` is the top speed (m/s) of whatever moves on the site, which no scan can tell: by default it is guessed
    from each track. ``plan_time`` (s) is how long a new plan takes: it is made from what is known when it is asked for and driven so much later; with
    0 the world stands still while the planner works. ``plant`` is what is driven, one of
    :data:`guideway.plants.PLANTS` or an object of your own (:class:`guideway.plants.Plant`); what that raises is raised. With ``trace`` the record
    holds what reports show of single steps.
    """
    limits = Limits(**trajectory.limits)
    asked = Drive(query, trajectory, limits, controller, planner, dict(set or {}), seed, arrival, stop_at_goal, time_limit)
    asked.sense, asked.lidar, asked.map, asked.observe, asked.trace = sense, dict(lidar or {}), map, observe, trace
    asked.plant, asked.mover_speed, asked.plan_time = plant, mover_speed, plan_time
    return run(asked)


def run(drive: Drive, folder: str | os.PathLike[str] = ".") -> dict[str, Any]:
    """Drives and returns the record. On Ctrl-C the record is that of the run so far, with ``cancelled`` true."""
    plant = plants.make(drive.plant, drive.query, drive.trajectory, drive.seed)
    asked = drive.limits
    drive = _turnable(drive) if plant is None else _within(_embodied(drive, plant), plant)
    raw = _core.drive(
        drive.query,
        drive.trajectory,
        drive.controller,
        planner=drive.planner,
        seed=drive.seed,
        set=_settings(drive, plant) or None,
        arrival=drive.arrival,
        stop_at_goal=drive.stop_at_goal,
        time_limit=drive.time_limit,
        sense=drive.sense,
        lidar=drive.lidar or None,
        map=drive.map,
        plant=plant,
        observe=drive.observe,
        trace=drive.trace,
        speed_map=_speed_map(drive),
        mover_speed=drive.mover_speed,
        plan_time=drive.plan_time,
    )
    held = {} if plant is None or drive.limits == asked else {"limits": {"asked": asked.to_dict(), "held": drive.limits.to_dict()}}
    return record(drive, raw, folder) | {"plant": plants.report_of(plant) | held}


def _speed_map(drive: Drive) -> _core.SpeedMap | None:
    return None if drive.speed_mask is None else _core.SpeedMap.load(drive.speed_mask, drive.limits.speed)


def _turnable(drive: Drive) -> Drive:
    """A motion timed without a limit of the turn rate that asks for more than the unicycle can do is timed anew with what it can.

    Else the base would swing wide in every bend.
    """
    limits, motion = drive.limits, drive.trajectory
    if limits.turn_rate is not None or motion.limits["turn_rate"] is not None or motion.among is not None or motion.duration <= 0.0:
        return drive
    states = motion.sample()
    if float(np.abs(states[:, 4] * states[:, 7]).max()) <= TURN_RATE:
        return drive
    return _timed(drive, replace(limits, turn_rate=TURN_RATE, turn_acceleration=limits.turn_acceleration or TURN_ACCELERATION))


def _timed(drive: Drive, limits: Limits) -> Drive:
    """The same path timed anew within other limits; among the movers where it was before and that can be done."""
    query, slow = drive.query, _speed_map(drive)

    def motion(among: _core.Query | None) -> _core.Trajectory:
        return _core.time(drive.trajectory.path, limits, start_yaw=query.start_yaw, goal_yaw=query.goal_yaw, speed_map=slow, among=among)

    try:
        return replace(drive, trajectory=motion(None if drive.trajectory.among is None else query), limits=limits)
    except Infeasible:
        return replace(drive, trajectory=motion(None), limits=limits)


def _within(drive: Drive, plant: object) -> Drive:
    """A motion that asks for more than a plant says it can hold is timed anew within that, and the robot counts as one that can do no more."""
    held: Mapping[str, float] = getattr(plant, "limits", None) or {}
    asked = drive.limits.to_dict()
    usual = {"turn_rate": TURN_RATE, "turn_acceleration": TURN_ACCELERATION}
    less = {name: most for name, most in held.items() if most < (usual[name] if asked[name] is None else asked[name])}
    if not less or drive.trajectory.duration <= 0.0:
        return drive
    limits = replace(drive.limits, **less)
    query = drive.query
    return _timed(replace(drive, query=_with(query, query.footprint, query.clearance, limits)), limits)


def _embodied(drive: Drive, plant: object) -> Drive:
    """A robot that is a point becomes the body that the plant has in its place; that much of the clearance is then its own."""
    body: Mapping[str, Any] | None = getattr(plant, "footprint", None)
    query = drive.query
    if body is None or query.footprint != {"disc": 0.0} or body == query.footprint:
        return drive
    bare = _with(query, body, 0.0, drive.limits)
    return replace(drive, query=_with(query, body, max(0.0, query.radius - bare.radius), drive.limits))


def _with(query: _core.Query, footprint: Mapping[str, Any], clearance: float, limits: Limits) -> _core.Query:
    """The same query for another robot."""
    start, goal = ([*place, *([] if yaw is None else [yaw])] for place, yaw in ((query.start, query.start_yaw), (query.goal, query.goal_yaw)))
    return _core.Query(
        query.world,
        start,
        goal,
        via=query.via,
        footprint=footprint,
        clearance=clearance,
        half_width=query.half_width,
        soft_clearance=query.soft_clearance,
        corners=query.corners,
        material=query.material,
        limits=limits,
    )


def _settings(drive: Drive, plant: object) -> dict[str, Any]:
    """The parameters of the controller: where it has a bound of the error of its model and none is given, that of the plant, if it names one."""
    error = getattr(plant, "error", None)
    known = {p["name"] for entry in _core.controllers() if entry["name"] == drive.controller for p in entry["parameters"]}
    return drive.set if error is None or "error" not in known else {"error": error} | drive.set


def record(drive: Drive, raw: dict[str, Any], folder: str | os.PathLike[str]) -> dict[str, Any]:
    """The record of ``run.json`` from what the core returned."""
    world = drive.query.world
    known = [value for value in raw["min_separation"].values() if value is not None]
    slowest = raw["step_seconds"]["p99"]
    return {
        "guideway": _core.__version__,
        "schema": 1,
        "outcome": raw["outcome"],
        "time": raw["time"],
        "controller": drive.controller,
        "planner": drive.planner,
        "seed": drive.seed,
        "sense": drive.sense,
        "lidar": drive.lidar or None,
        "map": drive.map,
        "mover_speed": drive.mover_speed,
        "plan_time": drive.plan_time,
        "world": jobs.world_record(world, folder, drive.keep_out),
        "query": jobs.query_record(drive.query) | {"arrival": drive.arrival},
        "robot": {"footprint": drive.query.footprint} | drive.limits.to_dict(),
        "obstacles": {"shapes": world.shapes, "movers": world.movers, "map": {"source": world.source, "files": world.files}},
        "plan": {
            "polyline": _core.polyline(drive.trajectory.path, drive.query).tolist(),
            "duration": drive.trajectory.duration,
            "length": drive.trajectory.path.length,
        },
        "driven": raw["driven"],
        "movers": [mover_states(mover) for mover in raw["movers"]],
        "replans": raw["replans"],
        "min_separation": min(known) if known else None,
        "separation": raw["min_separation"],
        "forbidden": raw["forbidden"],
        "emergency_stops": raw["emergency_stops"],
        "step_seconds": raw["step_seconds"] | {"real_time_factor": raw["period"] / slowest if slowest > 0.0 else None},
        "plan_seconds": raw["plan_seconds"],
        "tracking": raw["tracking"],
        "energy": raw["energy"],
        "events": raw["events"],
        "collision": raw["collision"],
        "cancelled": raw["cancelled"],
    } | ({"trace": raw["trace"]} if raw["trace"] else {})


def unseen(world: _core.World) -> _core.World:
    """What a robot without a map knows of a world before it has seen anything: its bounds, and what is forbidden."""
    return world.emptied()


def mover_states(mover: dict[str, Any]) -> dict[str, Any]:
    """A mover over time: its shape and rows (t, x, y, visible 0 or 1)."""
    since, track = mover["since"], mover["track"]
    rows = [[t, x, y, int(since is not None and t >= since)] for t, x, y in track]
    if track and since is not None and 0 < since <= track[0][0]:
        rows = [[0.0, *track[0][1:], 0], *rows]  # not there before
    outline = mover["outline"]
    shape = {"polygon": outline["points"]} if len(outline["points"]) > 1 else {"disc": outline["radius"]}
    return {"shape": shape, "since": since, "states": rows}


def from_plan(plan: dict[str, Any], world: _core.World) -> tuple[_core.Query, _core.Trajectory, Limits]:
    """The query, the motion and the limits that a plan record holds; a plan without timing is timed now with the default limits."""
    asked = plan["query"]
    query = _core.Query(
        world,
        asked["start"],
        asked["goal"],
        via=asked["via"],
        footprint=asked["footprint"],
        clearance=asked["clearance"],
        half_width=asked.get("half_width", 0.0),
        soft_clearance=asked.get("soft_clearance"),
        corners=asked["corners"],
        material=asked["material"],
    )
    shape = plan["path"]
    path = _core.Path(shape["degree"], shape["knots"], shape["control_points"])
    timed = plan.get("trajectory")
    if timed is None:
        limits = Limits()
        return query, _core.time(path, limits, start_yaw=query.start_yaw, goal_yaw=query.goal_yaw), limits
    if not timed["pieces"]:
        raise BadParameter("the plan holds no motion: its start is its goal, so there is nothing to drive")
    limits = Limits(**timed["limits"])
    whole = math.fsum(piece["duration"] for piece in timed["pieces"])
    if not abs(whole - timed["duration"]) <= SAME:
        raise BadParameter(f"its pieces take {whole:.3f} s and its trajectory says {timed['duration']} s")
    return query, _core.Trajectory(path, limits, timed["pieces"]), limits


def check(drive: Drive, where: str) -> None:
    """Certifies the motion of a drive that was read from the file ``where`` anew, for its world, from its start to its goal.

    Raises :class:`BadFile` if it does not hold: the file was changed, or is another one than its query says.
    """
    certificate = _core.certify(drive.trajectory.path, drive.query, drive.trajectory)
    failed = [check["name"] for check in certificate["checks"] if not check["ok"]]
    if failed:
        what = f"its motion fails its certificate ({', '.join(failed)})"
        raise BadFile(where, what, "a plan.json as guideway plan writes it, unchanged", "Plan again")
