"""The report: results and the map they live in as one HTML file that works offline."""

from __future__ import annotations

import html
import json
import math
import os
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from guideway.files import write_whole

from .geometry import listed
from .products import expand
from .profile import plan_profile, run_profile
from .scenery import Scenery, Snapshot, picture

SCRIPTS = (
    "kit.js",
    "motion.js",
    "raster.js",
    "layers.js",
    "map.js",
    "plots.js",
    "search.js",
    "loop.js",
    "replay.js",
    "panel.js",
    "alternatives.js",
    "report.js",
)
ROUNDED = {
    "polyline": 5,
    "raw_path": 5,
    "grid_path": 5,
    "driven": 5,
    "states": 4,
    "speed_ceiling": 5,
    "history": 6,
    "ranges": 2,
    "fan": 3,
    "chosen": 3,
}
"""Long tables and the decimals that a picture needs of them."""
MOST_HISTORY = 800
MOST_NUMBERS = 250_000
"""Most numbers of the steps of a drive; beyond, every second or third step is left out."""

Worlds = Scenery | Sequence[Scenery | None] | None


def report(results: Sequence[Mapping[str, Any]], path: str | os.PathLike[str], worlds: Worlds = None, title: str | None = None) -> Path:
    """Writes one self-contained HTML file for plans and runs, whole or not at all.

    ``results`` are dictionaries as in ``plan.json`` and ``run.json``; ``worlds`` is one world for all of them or one (or ``None``) per result.
    Raises ``TypeError`` or ``ValueError`` for results that are not dictionaries or worlds that do not match, ``OSError`` if writing fails.
    """
    target = Path(path)
    write_whole(target, page(results, worlds, title))
    return target


def page(results: Sequence[Mapping[str, Any]], worlds: Worlds = None, title: str | None = None) -> str:
    """The text of the report; see :func:`report`."""
    data = bundle(results, worlds)
    data["title"] = title or default_title(results)
    folder = files("guideway.view").joinpath("page")
    parts = {
        "title": html.escape(str(data["title"])).replace("://", ":&#47;&#47;"),
        "style": folder.joinpath("report.css").read_text("utf-8"),
        "script": "\n".join(folder.joinpath(name).read_text("utf-8") for name in SCRIPTS),
        "data": embed(data),
    }
    return fill(folder.joinpath("report.html").read_text("utf-8"), parts)


def fill(text: str, parts: Mapping[str, str]) -> str:
    """Replaces each ``{{name}}`` of the template once, never inside what was put in."""
    pieces = text.split("{{")
    return pieces[0] + "".join(parts[name] + rest for name, rest in (piece.split("}}", 1) for piece in pieces[1:]))


def embed(data: Any) -> str:
    """JSON that can stand in a script element: no markup, no address that a scanner takes for a link."""
    text = json.dumps(data, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026").replace("://", ":\\/\\/")


def bundle(results: Sequence[Mapping[str, Any]], worlds: Worlds = None) -> dict[str, Any]:
    """All data of the page: ``entries`` (one per result) and ``worlds`` (each once)."""
    results, each = expand(results, per_result(results, worlds))
    pictures: list[dict[str, Any]] = []
    known: dict[Any, tuple[int, Snapshot]] = {}
    entries: list[dict[str, Any]] = []
    for result, world in zip(results, each, strict=True):
        if world is not None and identity(world) not in known:
            known[identity(world)] = (len(pictures), Snapshot.of(world))
            pictures.append(clean(picture(known[identity(world)][1])))
        number, seen = (None, None) if world is None else known[identity(world)]
        run = is_run(result)
        entries.append(
            {
                "kind": "run" if run else "plan",
                "world": number,
                "data": clean(slim(result)),
                "profile": clean((run_profile if run else plan_profile)(result, seen)),
            }
        )
    for entry, label in zip(entries, labels(results), strict=True):
        entry["label"] = label
    return {"schema": 1, "entries": entries, "worlds": pictures}


def identity(world: Scenery) -> Any:
    """What tells worlds apart: the checksum of the file they were read from, where there is one."""
    checksum = getattr(world, "sha256", None)
    return (checksum, tuple(world.bounds)) if isinstance(checksum, str) and checksum else id(world)


def per_result(results: Sequence[Mapping[str, Any]], worlds: Worlds) -> list[Scenery | None]:
    """One world per result, checked."""
    for i, result in enumerate(results):
        if not isinstance(result, Mapping):
            raise TypeError(f"results[{i}] is a {type(result).__name__}; give dictionaries as in plan.json or run.json")
    if worlds is None:
        return [None] * len(results)
    if isinstance(worlds, Sequence):
        if len(worlds) != len(results):
            raise ValueError(f"{len(worlds)} worlds for {len(results)} results; give one world for all, or one per result")
        return list(worlds)
    return [worlds] * len(results)


def is_run(result: Mapping[str, Any]) -> bool:
    """Whether a result is a drive rather than a plan."""
    return "driven" in result or "outcome" in result


def slim(result: Mapping[str, Any]) -> dict[str, Any]:
    """A result without what the page does not draw: the spline's knots, long parts of the search history."""
    out = dict(result)
    path = out.get("path")
    if isinstance(path, Mapping):
        out["path"] = {"degree": path.get("degree"), "control_points": len(listed(path.get("control_points")))}
    search = out.get("search")
    if isinstance(search, Mapping) and isinstance(search.get("history"), list) and len(search["history"]) > MOST_HISTORY:
        step = -(-len(search["history"]) // MOST_HISTORY)
        out["search"] = dict(search) | {"history": search["history"][::step] + search["history"][-1:]}
    trace = out.get("trace")
    if isinstance(trace, Mapping) and isinstance(trace.get("steps"), list):
        step = max(1, -(-count(trace["steps"]) // MOST_NUMBERS))
        out["trace"] = dict(trace) | {"steps": trace["steps"][::step]}
    return out


def count(value: Any) -> int:
    """How many numbers and words there are in plain data."""
    if isinstance(value, Mapping):
        return sum(count(item) for item in value.values())
    return sum(count(item) for item in value) if isinstance(value, list | tuple) else 1


def clean(value: Any, digits: int | None = None) -> Any:
    """Plain JSON: numbers that are not finite become null, long tables are rounded, other objects become text."""
    if isinstance(value, Mapping):
        return {str(key): clean(item, ROUNDED.get(str(key), digits)) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [clean(item, digits) for item in value]
    if value is None or isinstance(value, str | bool | int):
        return value
    if hasattr(value, "tolist"):
        return clean(value.tolist(), digits)
    if isinstance(value, float):
        return (round(value, digits) if digits is not None else value) if math.isfinite(value) else None
    return str(value)


def labels(results: Sequence[Mapping[str, Any]]) -> list[str]:
    """A short name per result: the planner, and of material, seed and number what tells equal ones apart."""
    kinds = [str(r.get("label") or ("drive" if is_run(r) else r.get("planner") or "plan")) for r in results]
    names = [[kind] for kind in kinds]
    for key in ("material", "footprint", "controller", "seed"):
        values = [text_of(r, key) for r in results]
        same = [" ".join(name) for name in names]
        for i, value in enumerate(values):
            twins = [values[k] for k in range(len(values)) if same[k] == same[i]]
            if value and len(set(twins)) > 1:
                names[i].append(f"seed {value}" if key == "seed" else value)
    joined = [", ".join(name) for name in names]
    return [name if joined.count(name) == 1 else f"{name} #{joined[: i + 1].count(name)}" for i, name in enumerate(joined)]


def text_of(result: Mapping[str, Any], key: str) -> str:
    """A field of the result or of its query as short text."""
    query = result.get("query")
    value = result.get(key, query.get(key) if isinstance(query, Mapping) else None)
    if isinstance(value, Mapping):
        return " ".join(f"{k} {v}" for k, v in value.items())
    return "" if value is None else str(value)


def default_title(results: Sequence[Mapping[str, Any]]) -> str:
    """The map's name where there is one."""
    for result in results:
        world = result.get("world")
        source = world.get("source") if isinstance(world, Mapping) else None
        if isinstance(source, str) and source:
            return source.replace("\\", "/").rsplit("/", 1)[-1]
    return "Guideway report"
