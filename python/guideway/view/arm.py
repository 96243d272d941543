"""The report of an arm's motion: phase plane, joints over time, learning and the arm itself on its path, as one HTML file that works offline."""

from __future__ import annotations

import html
import os
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from guideway.files import write_whole

from .arm_bodies import around, bodies
from .arm_course import course, phase, stretches
from .geometry import listed
from .report import clean, embed, fill

SCRIPTS = (
    "kit.js",
    "arm-chain.js",
    "arm-mesh.js",
    "arm-gl.js",
    "arm-scene.js",
    "arm-phase.js",
    "arm-curves.js",
    "arm-trials.js",
    "arm-panel.js",
    "arm.js",
)

ROUNDED = 6
"""Decimals of long tables."""

MOST_TRIALS = 60
"""Most profiles of trials that are drawn; the table has all of them."""

Records = Mapping[str, Any] | Sequence[Mapping[str, Any]]


def is_arm(record: Mapping[str, Any]) -> bool:
    """Is it the motion of an arm (``traj.json``)?"""
    return record.get("kind") == "arm"


def report(records: Records, path: str | os.PathLike[str], title: str | None = None) -> Path:
    """Writes one self-contained HTML file for one or several motions of arms, whole or not at all.

    ``records`` are dictionaries as in ``traj.json``. Raises ``TypeError`` where one is not a dictionary, ``OSError`` if writing fails.
    """
    target = Path(path)
    write_whole(target, page(records, title))
    return target


def page(records: Records, title: str | None = None) -> str:
    """The text of the report; see :func:`report`."""
    data = bundle([records] if isinstance(records, Mapping) else list(records))
    data["title"] = title or data["title"]
    folder = files("guideway.view").joinpath("page")
    parts = {
        "title": html.escape(str(data["title"])).replace("://", ":&#47;&#47;"),
        "style": "\n".join(folder.joinpath(name).read_text("utf-8") for name in ("report.css", "arm.css")),
        "script": "\n".join(folder.joinpath(name).read_text("utf-8") for name in SCRIPTS),
        "data": embed(data),
    }
    return fill(folder.joinpath("arm.html").read_text("utf-8"), parts)


def bundle(records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """What the page draws, plain JSON: a motion per record, the surfaces of each robot once."""
    surfaces: list[Any] = []
    motions: list[dict[str, Any]] = []
    for i, record in enumerate(records):
        if not isinstance(record, Mapping):
            raise TypeError(f"records[{i}] is a {type(record).__name__}; give dictionaries as in traj.json")
        found = bodies(record.get("robot"))
        if found is not None and found not in surfaces:
            surfaces.append(found)
        motions.append(motion_of(record, len(records)) | {"bodies": None if found is None else surfaces.index(found)})
    for entry, label in zip(motions, labels(records), strict=True):
        entry["label"] = label
    return {"schema": 1, "title": default_title(records), "motions": motions, "surfaces": surfaces}


def motion_of(record: Mapping[str, Any], among: int = 1) -> dict[str, Any]:
    """What the page needs of one record; ``among`` how many there are, for the share of samples of each."""
    found = course(record, among)
    kept = {
        key: record.get(key) for key in ("joints", "duration", "limits", "certificate", "learner", "plant", "best", "oracle_duration", "lower_bound")
    }
    robot, path = mapped(record.get("robot")), mapped(record.get("path"))
    shape = phase(record, found)
    return clean(kept) | {
        "robot": clean({key: robot.get(key) for key in ("name", "tip", "frame", "inertials", "payload", "friction", "range")}) if robot else None,
        "chain": clean(robot.get("chain"), 9),
        "path": clean({"length": path.get("length"), "source": file_name(path.get("source")), "degree": path.get("degree")}),
        "report": clean(mapped(record.get("report"))),
        "points": len(listed(mapped(record.get("grid")).get("s"))),
        "course": clean(found, ROUNDED),
        "phase": clean(shape, ROUNDED),
        "stretches": clean(stretches(record, found), ROUNDED),
        "trials": clean(trials_of(record), ROUNDED),
        "oracle": clean(profile(record.get("oracle")), ROUNDED),
        "around": around(record),
    }


def mapped(value: Any) -> Mapping[str, Any]:
    """A record, or an empty one."""
    return value if isinstance(value, Mapping) else {}


def trials_of(record: Mapping[str, Any]) -> list[dict[str, Any]]:
    """All trials; their profiles thinned, and of very many trials only those of some."""
    rows = [row for row in listed(record.get("trials")) if isinstance(row, Mapping)]
    step = max(1, -(-len(rows) // MOST_TRIALS))
    found = []
    for i, row in enumerate(rows):
        plain = {str(key): value for key, value in row.items() if not isinstance(value, Mapping | list | tuple)}
        drawn = i % step == 0 or i in (0, len(rows) - 1) or row.get("number") == record.get("best")
        found.append(plain | ({"profile": shape} if drawn and (shape := profile(row.get("profile"))) else {}))
    return found


def profile(value: Any, most: int = 400) -> dict[str, Any] | None:
    """Path speed ``v`` over the place ``s`` from a record of ``s`` and squared speed ``x``; None where there is none."""
    given = mapped(value)
    s, x = column(given.get("s")), column(given.get("x"))
    if len(s) < 2 or len(s) != len(x):
        return None
    kept = np.unique(np.linspace(0, len(s) - 1, min(most, len(s))).round().astype(int))
    return {"s": s[kept].tolist(), "v": np.sqrt(np.maximum(x[kept], 0.0)).tolist()}


def column(value: Any) -> np.ndarray:
    """Numbers of a list, missing ones as NaN; empty where it is no list of numbers."""
    try:
        found = np.array([np.nan if item is None else item for item in listed(value)], float)
    except (TypeError, ValueError):
        return np.zeros(0)
    return found if found.ndim == 1 else np.zeros(0)


def file_name(value: Any) -> str | None:
    """The last part of a file name."""
    return value.replace("\\", "/").rsplit("/", 1)[-1] if isinstance(value, str) and value else None


def labels(records: Sequence[Mapping[str, Any]]) -> list[str]:
    """A short name per motion, told apart by method, payload and number."""
    names = [str(r.get("label") or r.get("learner") or mapped(r.get("report")).get("method") or "motion") for r in records]
    loads = [mapped(mapped(r.get("robot")).get("payload")).get("mass") for r in records]
    if len(set(map(str, loads))) > 1:
        names = [f"{name}, {load:g} kg" if isinstance(load, float | int) else name for name, load in zip(names, loads, strict=True)]
    if len(set(names)) < len(names):
        names = [f"{name}, {'jerk' if 'jerk' in mapped(r.get('limits')) else 'no jerk limit'}" for name, r in zip(names, records, strict=True)]
    return [name if names.count(name) == 1 else f"{name} #{names[: i + 1].count(name)}" for i, name in enumerate(names)]


def default_title(records: Sequence[Mapping[str, Any]]) -> str:
    """Robot and path, where they are named."""
    for record in records:
        robot, source = mapped(record.get("robot")).get("name"), file_name(mapped(record.get("path")).get("source"))
        if robot or source:
            return " \N{EN DASH} ".join(str(part) for part in (robot, source) if part)
    return "Motion of an arm"
