"""What ``[tune]`` of an experiment file says: whose parameters are sought where, and by what they are judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any, cast

from guideway.errors import BadFile
from guideway.io.files import show
from guideway.io.tables import Table, real

Names = Mapping[str, list[str]]


@dataclass(frozen=True)
class Dimension:
    """The values of a parameter: those ``among``, or numbers from ``low`` to ``high`` (whole ones if both are); ``log``: even in their logarithm."""

    name: str
    among: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 0.0
    step: float | None = None
    log: bool = False


@dataclass(frozen=True)
class Tune:
    """How the parameters of a method are sought."""

    method: str
    metric: str
    trials: int
    seeds: int
    """Each trial runs seeds 0 to ``seeds`` - 1 on every world and query of its group."""
    check: int
    """So many seeds that no trial has seen decide whether the best is better than what was there."""
    groups: Mapping[str, tuple[str, ...]]
    """Names of the worlds that are tuned for together."""
    space: tuple[Dimension, ...]


def read_tune(top: Table, names: Names, metrics: list[str]) -> Tune | None:
    """The table ``[tune]``, None where there is none."""
    table = top.table("tune")
    if table is None:
        return None
    method, metric = table.text("method"), table.text("metric")
    if method not in names["methods"]:
        raise table.bad("method", f"one of {show(names['methods'])[1:-1]}")
    if metric not in metrics:
        raise table.bad("metric", f"one of {show(metrics)[1:-1]}")
    counts = [table.integer(key, 1, most, default) for key, most, default in (("trials", 100_000, 60), ("seeds", 1000, 5), ("check", 1000, 10))]
    trials, seeds, check = (count or 1 for count in counts)
    groups = _groups(table, names["worlds"])
    space = _space(table)
    table.done()
    return Tune(method or "", metric or "", trials, seeds, check, groups, space)


def _groups(table: Table, worlds: list[str]) -> dict[str, tuple[str, ...]]:
    """Group -> worlds whose names match one of its patterns; one group of all where none are named."""
    given = table.table("groups")
    if given is None:
        return {"all": tuple(worlds)}
    found: dict[str, tuple[str, ...]] = {}
    for key in given.keys:
        patterns: Any = given.raw(key)
        if not isinstance(patterns, list) or not all(isinstance(pattern, str) for pattern in cast("list[Any]", patterns)):
            raise given.bad(key, "a list of names of worlds, '*' for any text")
        found[key] = tuple(world for world in worlds if any(fnmatchcase(world, pattern) for pattern in cast("list[str]", patterns)))
        if not found[key]:
            raise given.bad(key, f"names that are among those of the worlds, '*' for any text: {show(worlds)[1:-1]}")
    return found


def _space(table: Table) -> tuple[Dimension, ...]:
    space = table.table("space")
    if space is None or not space.keys:
        raise BadFile(table.at("space"), "there are no parameters", "[tune.space] with, for example, ants = { low = 10, high = 100 }", "Add some")
    found: list[Dimension] = []
    for key in space.keys:
        of = space.table(key)
        assert of is not None
        found.append(_dimension(key, of))
        of.done()
    return tuple(found)


def _dimension(name: str, table: Table) -> Dimension:
    if "among" in table:
        among: Any = table.raw("among")
        plain = isinstance(among, list) and among and all(isinstance(value, (str, bool, int, float)) for value in cast("list[Any]", among))
        if not plain:
            raise table.bad("among", "a list of numbers, texts or true and false")
        return Dimension(name, tuple(cast("list[Any]", among)))
    low, high, step = (table.raw(key) for key in ("low", "high", "step"))
    log = table.flag("log")
    for key, value in (("low", low), ("high", high)):
        if real(value) is None or abs(value) > 1e12:
            raise table.bad(key, "a number from -1e12 to 1e12; or among = [...]")
    if not low < high or (log and low <= 0):
        raise table.bad("high", f"above low ({show(low)})" + (", and low above 0 with log" if log else ""))
    if "step" in table and (log or real(step) is None or not 0 < step <= high - low or (isinstance(low, int) and not isinstance(step, int))):
        raise table.bad("step", "a number above 0 and at most high - low, whole if they are; none with log")
    return Dimension(name, (), low, high, step, log)
