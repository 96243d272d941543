"""Your planner against others, on your maps, in a few lines."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from guideway import jobs
from guideway._core import Query
from guideway.errors import BadParameter
from guideway.files import write_whole
from guideway.io import files
from guideway.io.export import toml_table
from guideway.io.files import show
from guideway.lab import journal
from guideway.lab.coordinator import run, told, troubles
from guideway.lab.extra import needed
from guideway.lab.own import PICKLED
from guideway.lab.reading import read
from guideway.records import Budget
from guideway.scenes import GridScene, RoomScene

if TYPE_CHECKING:
    from guideway.lab.experiment import Experiment

Place = str | os.PathLike[str] | Mapping[str, Any] | Query | GridScene | RoomScene
"""A scene or map file, ``scene:NAME``, ``[[worlds]]`` of an experiment file as a mapping, a query, or a scene of :mod:`guideway.scenes`."""

_ODD = re.compile(r"[^A-Za-z0-9._-]+")


@dataclass(frozen=True)
class Comparison:
    """What a comparison found; printed it is a table."""

    experiment: Experiment
    folder: Path
    records: list[journal.Record]

    def report(self, out: str | os.PathLike[str] | None = None) -> Path:
        """Writes the report with statistics, tables and figures; returns its path."""
        from guideway.lab.report import write_report

        return write_report(self.folder, out)

    def __str__(self) -> str:
        metrics = [metric.name for metric in self.experiment.metrics]
        rows = [["method", "ok", *metrics, "time"]]
        for method in self.experiment.methods:
            mine = [record for record in self.records if record["method"] == method["name"]]
            good = [record for record in mine if record["status"] == "ok"]
            means = [_mean([record["measures"].get(name) for record in good]) for name in metrics]
            rows.append([method["name"], f"{len(good)}/{len(mine)}", *means, _mean([record["times"]["plan"] for record in good], " s")])
        widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
        lines = ["  ".join([row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]) for row in rows]
        return "\n".join([*lines, told(Counter(record["status"] for record in self.records)), *troubles(self.records)])


def _mean(values: Sequence[float | None], unit: str = "") -> str:
    known = [value for value in values if value is not None]
    return f"{sum(known) / len(known):.4g}{unit}" if known else "-"


def compare(
    planners: Mapping[str, Any],
    worlds: Sequence[Place],
    *,
    seeds: int = 10,
    budget: Budget | None = None,
    metrics: Sequence[str] = ("length", "gap", "turns"),
    limits: Mapping[str, float] | None = None,
    out: str | os.PathLike[str] = "results",
    name: str = "compare",
    **how: Any,
) -> Comparison:
    """Runs planners on worlds, each with the same seeds and budget, every path checked, and returns the records.

    ``planners``: name -> a registered planner, ``peer:NAME``, ``file.py:Name``, or any object with ``plan(query)`` (it may take ``seed=`` and
    ``budget=``) that returns points of shape (n, 2) in m, a :class:`guideway.Path` or a solution; the object is copied anew for each run. ``limits``:
    ``seconds`` and ``memory_mib`` of a run. A map without a query of its own is given as a :class:`guideway.Query`. ``how`` goes to
    :func:`guideway.lab.run`: ``workers``, ``cluster``, ``resume``, ``progress``. The experiment is written to ``out/NAME.toml``; a later call goes on
    with ``resume=True`` (a planner that has changed since needs another ``name``). Raises :class:`guideway.GuidewayError`.
    """
    folder = Path(out)
    if not _ODD.sub("", name) == name or name != name.lower():
        raise BadParameter(f"name {show(name)}: small letters, digits, '.', '_' and '-'")
    if not planners or not worlds:
        raise BadParameter("compare needs at least one planner and one world")
    if not how.get("resume") and journal.read(folder / f"{name}.jsonl"):
        raise BadParameter(f"{files.name(folder)} already holds records of {name}: go on with resume=True, or choose another out or name")
    head = {"schema": 1, "name": name, "kind": "plan", "seeds": seeds, "metrics": list(metrics)}
    head |= {"budget": {key: value for key, value in (budget or Budget()).to_dict().items() if value is not None}, "limits": dict(limits or {})}
    path = _written(folder, f"{name}.toml", "")
    parts = [toml_table("# written by guideway.lab.compare", head)]
    parts += [toml_table("[[worlds]]", {"name": title, **_world(title, place, folder)}) for title, place in _named(worlds).items()]
    parts += [toml_table("[[methods]]", {"name": title, "planner": _planner(title, planner, folder)}) for title, planner in planners.items()]
    _written(folder, path.name, "\n".join(parts))
    experiment = read(path)
    run(experiment, folder, **how)
    records = {journal.key_of(record): record for record in journal.read(folder / f"{name}.jsonl")}
    return Comparison(experiment, folder, [records[one.key] for one in experiment.runs()])


def _written(folder: Path, name: str, data: bytes | str) -> Path:
    """Writes a file into the folder, which is made where it is not there."""
    path = folder / name
    with files.guard(files.name(path), "the file"):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, data)
    return path


def _named(worlds: Sequence[Place]) -> dict[str, Place]:
    """The worlds by name; the second of a name is numbered."""
    named: dict[str, Place] = {}
    for number, place in enumerate(worlds, 1):
        name = _name(place, number)
        unique = name if name not in named else f"{name} ({number})"
        named[unique] = place
    return named


def _name(place: Place, number: int) -> str:
    if isinstance(place, Mapping):
        return str(place.get("name", f"world {number}"))
    if isinstance(place, Query):
        return f"world {number}"
    return place.name if isinstance(place, GridScene | RoomScene) else os.fspath(place)


def _world(title: str, place: Place, folder: Path) -> dict[str, Any]:
    """What the experiment's file says of a world; what is no file yet is written beside it."""
    if isinstance(place, Mapping):
        return {key: value for key, value in place.items() if key != "name"}
    if isinstance(place, str | os.PathLike):
        text = os.fspath(place)
        return {"source": text if text.startswith("scene:") else os.path.abspath(text)}
    path = _written(folder, "worlds/" + _ODD.sub("-", title) + (".yaml" if isinstance(place, Query) else ".toml"), "")
    if not isinstance(place, Query):
        place.write(path)
        return {"source": f"worlds/{path.name}"}
    return {"source": f"worlds/{path.name}", "query": _asked(title, place, path)}


def _asked(title: str, query: Query, path: Path) -> dict[str, Any]:
    """Writes the map of a query; the rest of it."""
    from guideway.io import GridMap, write_map

    cells, world = query.world.occupancy(), query.world
    if cells is None or world.shapes or world.movers:
        raise BadParameter(f"{title}: this query has shapes or movers beside its map; give the scene file that they are in instead")
    x, y, yaw = world.origin
    write_map(GridMap(cells > 0, cells == 2, world.resolution, (x, y, yaw), path, "", {}, "map_server"), path)
    asked = {key: value for key, value in jobs.query_record(query).items() if value not in (None, [])}
    return asked | {"limits": {key: value for key, value in query.limits.items() if value is not None}}


def _planner(title: str, planner: Any, folder: Path) -> str:
    if isinstance(planner, str):
        return planner
    if not callable(getattr(planner, "plan", None)):
        raise BadParameter(f"planner {show(title)}: {show(planner)} is neither a name nor an object with a method plan(query)")
    cloudpickle = needed("cloudpickle", "lab", "a planner that is a Python object travels to the workers by cloudpickle")
    try:
        data = cloudpickle.dumps(planner)
    except Exception as error:
        raise BadParameter(f"planner {show(title)} cannot be copied to the workers ({type(error).__name__}: {error})") from error
    return f"{PICKLED}planners/{_written(folder, 'planners/' + _ODD.sub('-', title) + '.pkl', data).name}"
