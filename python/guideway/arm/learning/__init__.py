"""Velocity self-learning: the fastest motion along a path that keeps torque limits nobody can compute, found from measured torques, trial by trial.

:func:`guideway.arm.learn` runs the loop against a plant. Each learner is a file here; all have one method, ``next(logs) -> motion | None``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.task import Task
from guideway.errors import BadParameter

__all__ = ["LEARNERS", "Learner", "Log", "Motion", "Task", "make_learner"]

LEARNERS = {
    "structured": "payload and friction from all torques, the rest over the path; exact optimum with a margin (the default)",
    "guaranteed": "as structured with a worst-case bound: no trial exceeds a limit while errors stay within a stated bound; slower",
    "source": "speed spline whose nodes are lowered where torques were over their limits",
    "kinematic": "no learning: speed and acceleration limits alone",
    "nominal": "no learning: torque limits by the nominal model",
    "uniform": "the kinematic optimum slowed as a whole, by bisection",
    "ilc2": "model corrected by a function of the path, solved again",
    "rl": "tabular Q(lambda), no model",
}
"""The learners that :func:`make_learner` makes, with a line each."""

_HOMES = {
    "structured": ("structured", "Structured"),
    "guaranteed": ("guaranteed", "Guaranteed"),
    "source": ("source", "Source"),
    "kinematic": ("kinematic", "Kinematic"),
    "nominal": ("nominal", "Nominal"),
    "uniform": ("uniform", "Uniform"),
    "ilc2": ("ilc2", "TwoStep"),
    "rl": ("rl", "Tabular"),
}


class Learner(Protocol):
    """What makes motions from logs."""

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The motion to try next, given the logs of all trials so far in their order; None where learning has ended."""
        ...


def make_learner(name: str, task: Task, settings: Mapping[str, Any] | None = None) -> Learner:
    """The learner of that name for a task; ``settings`` are its public fields. Raises :class:`guideway.errors.BadParameter`."""
    import dataclasses
    import importlib

    if name not in _HOMES:
        raise BadParameter(f"learner {name!r} is not known: one of {', '.join(LEARNERS)}")
    module, title = _HOMES[name]
    kind = getattr(importlib.import_module(f"guideway.arm.learning.{module}"), title)
    known = [field.name for field in dataclasses.fields(kind) if field.init and field.name != "task"]
    for key in settings or {}:
        if key not in known:
            raise BadParameter(f"the learner {name!r} has no setting {key!r}: one of {', '.join(known) or 'none'}")
        _check(key, (settings or {})[key])
    return kind(task, **(settings or {}))


_RANGES: dict[str, tuple[float, float, bool]] = {
    "scale": (0.01, 1.0, False),
    "sigmas": (0.0, 10.0, False),
    "margin": (0.0, 0.5, False),
    "forget": (0.01, 1.0, False),
    "until": (1.0, 100.0, False),
    "segments": (2, 500, True),
    "step": (1e-4, 1.0, False),
    "fine": (1e-4, 1.0, False),
    "trials": (1, 10**6, True),
    "closest": (1e-4, 0.5, False),
    "relaxation": (0.01, 1.0, False),
    "trust": (0.01, 0.9, False),
    "settled": (0.0, 1.0, False),
    "bins": (2, 1000, True),
    "alpha": (1e-3, 1.0, False),
    "trace": (0.0, 1.0, False),
    "explore": (0.0, 1.0, False),
    "seed": (0, 2**63 - 1, True),
}
"""Lowest and highest value of settings that are numbers, and whether they are whole."""


def _check(key: str, value: Any) -> None:
    if key not in _RANGES or (key == "until" and value is None):
        return
    low, high, whole = _RANGES[key]
    number = isinstance(value, int if whole else int | float) and not isinstance(value, bool)
    if not number or not low <= value <= high:
        raise BadParameter(f"setting {key} = {value!r} is out of range: a {'whole ' if whole else ''}number from {low:g} to {high:g}")
