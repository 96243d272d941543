"""Planners of anybody as one call: registered ones, peers, and a user's own objects with ``plan``."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from guideway import _core
from guideway.errors import BadParameter, GuidewayError
from guideway.io.files import show
from guideway.lab import own, peers, worlds
from guideway.lab.experiment import Experiment
from guideway.records import Budget

_ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")
PEER = "peer:"
"""What the name of a peer begins with."""

Planned = Any
"""What a planner returns: :class:`guideway.Solution`, :class:`guideway.Path`, points of shape (n, 2) or more columns (m), or an object with ``path``
or ``points`` (and, if it likes, ``evaluations`` and ``history``, rows of evaluations and best so far)."""
TRIAL = Budget(iterations=1, evaluations=1, seconds=1.0)
Call = Callable[[_core.Query, int, Budget], Planned]


def planner(method: Mapping[str, Any], folder: str | os.PathLike[str] = ".") -> Call:
    """The planner of a method as a function of query, seed and budget.

    Raises :class:`guideway.errors.BadParameter` for names and parameters that are not known, and for peers that are not installed.
    """
    name, settings = method.get("planner"), dict(method.get("set", {}))
    where = f"method {method.get('name', '')!r}"
    if not isinstance(name, str) or not name:
        raise BadParameter(f"{where}: planner {name!r} is not a name: a registered planner, {PEER}NAME, file.py:Name or package.module:Name")
    if name.startswith(PEER):
        return _peer(name, settings, where)
    if own.is_own(name):
        return _own(name, settings, os.fspath(folder), where)
    known = [entry["name"] for entry in _core.planners()]
    if name not in known:
        raise BadParameter(f"{where}: planner {name!r} is not known: one of {', '.join(known)}, {PEER}NAME, file.py:Name or package.module:Name")
    try:
        _core.parameters(name, settings or None)
    except BadParameter as error:
        raise BadParameter(f"{where}: set: {error}") from None
    fallback = bool(method.get("exact_fallback", False))

    def registered(query: _core.Query, seed: int, budget: Budget) -> Planned:
        return _core.plan(query, name, seed=seed, budget=budget, set=settings or None, exact_fallback=fallback)

    return registered


def check(method: Mapping[str, Any], folder: str | os.PathLike[str] = ".") -> None:
    """Raises what :func:`planner` raises; and :class:`guideway.errors.BadParameter` for values of ``set`` that a registered planner refuses."""
    planner(method, folder)
    name, settings = method["planner"], dict(method.get("set", {}))
    if not settings or name.startswith(PEER) or own.is_own(name):
        return
    try:
        _core.plan(_trial(), name, seed=0, budget=TRIAL, set=settings)
    except BadParameter as error:
        if any(key in str(error) for key in settings):
            raise BadParameter(f"method {method.get('name', '')!r}: set: {error}") from None
    except GuidewayError:
        return


@lru_cache(maxsize=1)
def _trial() -> _core.Query:
    """A query that costs nothing."""
    return worlds.query({"name": "trial", "source": "scene:m20"}, {"start_cell": (0, 0), "goal_cell": (1, 0)})


def check_tune(experiment: Experiment) -> None:
    """Raises :class:`guideway.errors.BadParameter` for ends of ``[tune.space]`` that the method refuses."""
    if not experiment.tune:
        return
    method = next(method for method in experiment.methods if method["name"] == experiment.tune.method)
    for dimension in experiment.tune.space:
        for value in dimension.among or (dimension.low, dimension.high):
            try:
                check({**method, "set": {**method.get("set", {}), dimension.name: value}}, experiment.folder)
            except BadParameter as error:
                raise BadParameter(f"[tune.space]: {dimension.name}: {error}") from None


def _peer(name: str, settings: Mapping[str, Any], where: str) -> Call:
    try:
        peer = peers.find(name, "plan")
        peer.settings(settings)
    except BadParameter as error:
        raise BadParameter(f"{where}: {error}") from None

    def plan(query: _core.Query, seed: int, budget: Budget) -> Planned:
        return peer.run(query, seed=seed, budget=budget.to_dict(), set=settings)

    return plan


def _own(name: str, settings: dict[str, Any], folder: str, where: str) -> Call:
    """A user's object, new for every call, called with as much of (query, seed=, budget=) as it accepts."""

    def load() -> Any:
        return own.load(name, folder, settings).plan

    try:
        accepted = inspect.signature(load()).parameters.values()
    except GuidewayError as error:
        raise BadParameter(f"{where}: {error}") from None
    except Exception as error:
        raise BadParameter(f"{where}: planner {name!r} cannot be made: {type(error).__name__}: {error}") from error
    anything = any(p.kind is inspect.Parameter.VAR_KEYWORD for p in accepted)
    names = {p.name for p in accepted if p.kind in (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)}

    def plan(query: _core.Query, seed: int, budget: Budget) -> Planned:
        more = {"seed": seed, "budget": budget}
        return load()(query, **{name: value for name, value in more.items() if anything or name in names})

    return plan


def path_of(found: Planned) -> _core.Path | None:
    """The path of what a planner returned; None if it is not finite or no path at all."""
    held = getattr(found, "path", found)
    if isinstance(held, _core.Path):
        return held if np.isfinite(held.length) else None
    held = getattr(found, "points", held)
    try:
        points = np.asarray(held, float)
    except (TypeError, ValueError):
        return None
    if points.ndim != 2 or len(points) < 2 or points.shape[1] < 2 or not np.isfinite(points).all():
        return None
    try:
        return _core.Path.polyline(points[:, :2])
    except BadParameter:
        return None


def complaint(found: Planned) -> str:
    """What is wrong with a thing that :func:`path_of` takes for no path."""
    held = getattr(found, "path", found)
    if isinstance(held, _core.Path):
        return "the path it returned has no finite length"
    allowed = "points of shape (n, 2) in m, n at least 2, a gw.Path or a solution"
    try:
        points = np.asarray(getattr(found, "points", held), float)
    except (TypeError, ValueError):
        points = np.empty(())
    if points.ndim == 0:
        return f"it returned {_ADDRESS.sub('', show(found))}, which is no path: {allowed}"
    if points.ndim == 2 and not np.isfinite(points).all():
        return "the points it returned are not finite"
    return f"it returned an array of shape {points.shape}, which is no path: {allowed}"


def work_of(found: Planned) -> tuple[int | None, np.ndarray]:
    """Evaluations, and rows of evaluations and best so far, of what a planner of somebody else returned; None and no rows if it does not say."""
    evaluations = getattr(found, "evaluations", None)
    rows = getattr(found, "history", None)
    history = np.asarray([] if rows is None else rows, float)
    fits = history.ndim == 2 and history.shape[1] >= 2 and np.isfinite(history).all()
    return evaluations if isinstance(evaluations, int) else None, history[:, :2] if fits else np.empty((0, 2))
