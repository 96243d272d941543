"""Runs of timing: how long a motion takes, by how much it exceeds limits on a dense check, and how long a call takes."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any

import guideway as gw
from guideway.errors import BadParameter
from guideway.lab import peers
from guideway.lab.courses import MAKERS, Along, Between, Timed
from guideway.lab.experiment import Experiment, Metric, Run
from guideway.lab.kinds import Outcome

FIELDS = ("timing", "calls")
"""``timing``: ``reachability``, ``bisection`` or ``jerk`` along splines, ``point-to-point`` between states, or a peer; ``set``: for ours ``grid``
(number of points along a spline; chosen by error where left out); ``calls`` after one more are timed (1)."""
WORLD_FIELDS = ("make", *dict.fromkeys(name for arguments in MAKERS.values() for name in arguments))
QUERY_FIELDS = ("limits",)
"""``limits``: ``speed`` (rad/s), ``acceleration``, ``jerk`` of a spline's joints; between states they are drawn."""
OURS = {"reachability": "spline", "bisection": "spline", "jerk": "spline", "point-to-point": "axes"}
"""Our methods, and the worlds they are for."""
TOLERANCE = 1e-6
"""Excess (%) and miss that are rounding."""
RUN = "run"
LEAST, MOST = {"points": 2, "joints": 1, "axes": 1}, 10_000
"""Whole numbers a world may have."""

METRICS = {
    metric.name: metric
    for metric in (
        Metric("duration", "s", "lower", 4),
        Metric("excess", "%", "lower", 4),
        Metric("excess_speed", "%", "lower", 4),
        Metric("excess_acceleration", "%", "lower", 4),
        Metric("excess_jerk", "%", "lower", 4),
        Metric("kept", "", "higher", 3),
        Metric("miss", "", "lower", 9),
        Metric("call_cpu", "s", "lower", 7),
    )
}
"""Of a motion: its duration, the largest excess over any limit and over each, whether it kept all (rounding aside), how far it ends from its goal;
processor time of a call, which depends on the machine."""


def run(run: Run) -> Outcome:
    """Times a course. Raises what the method raises; a motion that exceeds limits is a result, and its excess a measure."""
    course = course_of(run.world, run.query, run.seed)
    call = method_of(run.method)
    calls, timed = int(run.method.get("calls", 1)), None
    seconds = []
    for _ in range(calls + (calls > 1)):
        timed = call(course)
        seconds.append(timed.seconds)
    assert timed is not None
    measures: dict[str, Any] = {"duration": timed.duration, "excess": timed.excess, "miss": timed.miss}
    measures |= {f"excess_{'speed' if name == 'velocity' else name}": value for name, value in timed.excesses.items()}
    measures["kept"] = timed.excess <= TOLERANCE and timed.miss <= TOLERANCE
    finite = all(math.isfinite(value) for value in measures.values())
    return Outcome(measures=measures, certified=finite, times={"call_cpu": statistics.median(seconds[-calls:])})


def course_of(world: Mapping[str, Any], query: Mapping[str, Any], seed: int) -> Along | Between:
    """The course of a world under a query."""
    arguments = {name: world.get(name, value) for name, value in MAKERS[world["make"]].items()}
    if arguments["seed"] == RUN:
        arguments["seed"] = seed
    if world["make"] == "axes":
        return Between(**arguments)
    return Along(limits=query.get("limits", {}), **arguments)


def method_of(method: Mapping[str, Any]) -> Callable[[Any], Timed]:
    """The method as a function of a course."""
    name, settings = method["timing"], method.get("set", {})
    if name.startswith(peers.PREFIX):
        peer = peers.find(name, "time")
        return lambda course: peer.run(course, set=settings)
    return _between if name == "point-to-point" else lambda course: _along(course, name, settings)


def _along(course: Along, name: str, settings: Mapping[str, Any]) -> Timed:
    words: dict[str, Any] = {"method": "reachability", "jerk": True} if name == "jerk" else {"method": name}
    begun = time.process_time()
    motion = gw.time_joints(course.path, course.limits, **words, **settings)
    return Timed.ours(course, motion, time.process_time() - begun)


def _between(course: Between) -> Timed:
    ends: dict[str, Any] = course.ends
    problem = gw.PointToPoint(course.start, course.goal, limits=course.limits, **ends)
    begun = time.process_time()
    motion = problem.plan()
    seconds = time.process_time() - begun
    rows = motion.sample(times=course.times(motion.duration))
    return Timed.between(course, motion.duration, (rows["q"], rows["qd"], rows["qdd"]), seconds)


def check(experiment: Experiment) -> None:
    """Raises :class:`guideway.BadParameter` for what is not known, before any run."""
    makes: set[Any] = {world.get("make") for world in experiment.worlds}
    for world in experiment.worlds:
        _check_world(world)
    for query in experiment.queries if "spline" in makes else ():
        limits = query.get("limits")
        if not isinstance(limits, Mapping) or not {"speed", "acceleration"} <= set(limits) <= {"speed", "acceleration", "jerk"}:
            raise BadParameter(f"query {query['name']!r}: limits {limits!r} must say speed (rad/s) and acceleration, and may say jerk")
        if not all(isinstance(value, (int, float)) and not isinstance(value, bool) and value > 0 for value in limits.values()):
            raise BadParameter(f"query {query['name']!r}: limits {dict(limits)!r} must be numbers above 0")
    for method in experiment.methods:
        _check_method(method, makes)


def _check_world(world: Mapping[str, Any]) -> None:
    where, make = f"world {world['name']!r}", world.get("make")
    if make not in MAKERS:
        raise BadParameter(f"{where}: make {make!r} is not known: one of {', '.join(MAKERS)}")
    for name, value in world.items():
        if name in ("name", "make"):
            continue
        usual = MAKERS[make].get(name)
        if usual is None:
            raise BadParameter(f"{where}: {name!r} is no argument of {make}: one of {', '.join(MAKERS[make])}")
        if not _fits(name, value, usual) and not (name == "seed" and value == RUN):
            raise BadParameter(f"{where}: {name} {value!r} cannot be used: such as {usual!r}" + (f' or "{RUN}"' if name == "seed" else ""))


def _fits(name: str, value: object, usual: object) -> bool:
    if isinstance(usual, bool) or isinstance(value, bool):
        return isinstance(usual, bool) and isinstance(value, bool)
    if name in LEAST or name == "seed":
        return isinstance(value, int) and LEAST.get(name, 0) <= value <= MOST
    return isinstance(value, (int, float)) and 0 <= value <= (1 if name == "share" else 12)


def _check_method(method: Mapping[str, Any], makes: set[Any]) -> None:
    where, name, calls = f"method {method['name']!r}", method.get("timing"), method.get("calls", 1)
    if isinstance(calls, bool) or not isinstance(calls, int) or not 1 <= calls <= 10_000:
        raise BadParameter(f"{where}: calls {calls!r} is not a whole number from 1 to 10000")
    if isinstance(name, str) and name.startswith(peers.PREFIX):
        try:
            peers.find(name, "time").settings(method.get("set"))
        except BadParameter as error:
            raise BadParameter(f"{where}: {error}") from None
        return
    if name not in OURS:
        raise BadParameter(f"{where}: timing {name!r} is not known: one of {', '.join(OURS)}, or {peers.PREFIX}NAME")
    if makes != {OURS[name]}:
        raise BadParameter(f"{where}: timing {name!r} is for worlds with make = {OURS[name]!r}")
    for key in method.get("set", {}):
        if key != "grid" or OURS[name] != "spline":
            raise BadParameter(f"{where}: set has no {key!r}: {'grid' if OURS[name] == 'spline' else 'nothing'} can be set")
