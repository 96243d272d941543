"""Kinds of experiments: what one run does. Each kind is a module, loaded when it is first used.

A module has ``run(run) -> Outcome``, ``FIELDS`` (names of the method fields it knows beside name, set, budget, limits, each and ablate), ``METRICS``
(name -> :class:`guideway.lab.Metric`), and ``check(experiment)``, which raises :class:`guideway.GuidewayError` for what would fail in every run.
"""

from __future__ import annotations

import importlib
import re
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

from guideway.errors import BadParameter

KINDS: dict[str, str] = {
    "plan": "guideway.lab.kinds.plan",
    "minimize": "guideway.lab.kinds.minimize",
    "drive": "guideway.lab.kinds.drive",
    "learn": "guideway.lab.kinds.learn",
    "time": "guideway.lab.kinds.time",
}
"""Name -> module. A kind of your own is named by its module, ``package.module`` with at least one dot."""

_MODULE = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)+")


class NotAResult(Exception):
    """What a method returned is nothing that could be checked: the run is invalid."""


@dataclass
class Outcome:
    """What a run found. ``measures``, ``curve`` and ``path`` depend on the run alone; what depends on the machine is in ``times`` (s)."""

    measures: dict[str, float | int | bool | None] = field(default_factory=dict[str, Any])
    curve: list[list[float]] | None = None
    """[evaluations, best so far]."""
    path: list[list[float]] | None = None
    """[x, y] in m."""
    certified: bool | None = None
    """What the independent checker said; None where there is nothing to check."""
    times: dict[str, float] = field(default_factory=dict[str, float])


def load(kind: str) -> ModuleType:
    """The module of a kind. Raises :class:`BadParameter` for names that are not known."""
    module = KINDS.get(kind, kind)
    if kind not in KINDS and not _MODULE.fullmatch(kind):
        raise BadParameter(f"kind {kind!r} is not known: one of {', '.join(KINDS)}, or a module of yours as package.module")
    try:
        found = importlib.import_module(module)
    except ImportError as error:
        raise BadParameter(f"kind {kind!r} cannot be loaded ({error}): one of {', '.join(KINDS)}, or a module of yours as package.module") from error
    if not callable(getattr(found, "run", None)):
        raise BadParameter(f"kind {kind!r} cannot be used: its module {module} has no function run(run)")
    return found
