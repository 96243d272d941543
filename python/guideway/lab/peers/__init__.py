"""Other people's planners, optimizers and timing, as methods beside ours: same worlds, same checker, same budget (``pip install 'guideway[peers]'``).

A method of an experiment names one as ``peer:NAME``, for example ``peer:ompl-rrt-star``. What they return is judged like anything else: a path goes
through :func:`guideway.certify`. Budgets count evaluations (checks of a state or a segment, or values of the objective) where a peer lets them be
counted; those that end on their own ignore budgets, which :attr:`Peer.budget` says.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from guideway._core import Path
from guideway.errors import BadParameter
from guideway.lab.extra import MissingExtra
from guideway.records import Budget

__all__ = ["PEERS", "Answer", "Peer", "find", "optimizer", "planner"]

PREFIX = "peer:"


@dataclass(frozen=True)
class Answer:
    """What a peer found.

    ``points``: way points of a path, m; ``x`` and ``value``: a minimum; ``evaluations``: how many were counted, None where they cannot be;
    ``history``: rows (evaluations, best so far); ``seconds``: of the search alone.
    """

    points: list[list[float]] | None = None
    x: list[float] | None = None
    value: float | None = None
    evaluations: int | None = None
    history: list[list[float]] = field(default_factory=list)
    seconds: float = field(default=0.0, compare=False)

    @property
    def path(self) -> Path | None:
        """The path through the points; None where there are none."""
        return None if self.points is None else Path.polyline(self.points)


@dataclass(frozen=True)
class Peer:
    """A peer: ``kind`` (plan, minimize or time), the ``package`` to install and the module it is imported as, where its call is (``home``,
    module:function, with ``words`` of its own), its parameters with their defaults, which ``budget`` it keeps (``evaluations or seconds`` or
    ``none``), and whether a seed repeats its result (``seeded``; None: it has nothing random)."""

    kind: str
    package: str
    module: str
    home: str
    words: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    budget: str = "none"
    seeded: bool | None = None

    def settings(self, given: Mapping[str, Any] | None) -> dict[str, Any]:
        """The parameters with those that are given; raises :class:`guideway.BadParameter` for unknown ones."""
        for name in given or {}:
            if name not in self.parameters:
                raise BadParameter(f"{self.package} has no parameter {name!r} here: one of {', '.join(self.parameters) or 'none'}")
        return {**self.parameters, **(given or {})}

    def need(self) -> None:
        """Raises :class:`guideway.lab.extra.MissingExtra` where its package cannot be imported."""
        if importlib.util.find_spec(self.module) is None:
            raise MissingExtra(f"{self.package} is not installed: pip install 'guideway[peers]'")

    def run(
        self,
        problem: Any,
        *,
        seed: int = 0,
        budget: Budget | Mapping[str, Any] | None = None,
        set: Mapping[str, Any] | None = None,
    ) -> Any:
        """Solves a problem (a :class:`guideway.Query`, an objective, a course of joints, by ``kind``).

        Raises :class:`guideway.lab.extra.MissingExtra`, and what the peer's answer means as an error of ours: ``NoPath``, ``Infeasible``.
        """
        self.need()
        place, name = self.home.split(":")
        call = getattr(importlib.import_module(f"guideway.lab.peers.{place}"), name)
        words = budget.to_dict() if isinstance(budget, Budget) else budget or {}
        given = {key: value for key, value in words.items() if value is not None}
        return call(problem, seed=seed, budget=given, **self.words, **self.settings(set))


def find(name: str, kind: str) -> Peer:
    """The peer that a method's name (with or without ``peer:``) means; raises :class:`guideway.BadParameter`."""
    short = name.removeprefix(PREFIX)
    known = [entry for entry, peer in PEERS.items() if peer.kind == kind]
    if short not in known:
        raise BadParameter(f"peer {short!r} is not known for {kind}: one of {', '.join(known)}")
    return PEERS[short]


def planner(name: str, settings: Mapping[str, Any] | None = None) -> Callable[..., Answer]:
    """The planner of that name as ``plan(query, seed, budget)``; raises :class:`guideway.BadParameter` for unknown names and settings."""
    peer = find(name, "plan")
    peer.settings(settings)
    return lambda query, seed=0, budget=None: peer.run(query, seed=seed, budget=budget, set=settings)


def optimizer(name: str, settings: Mapping[str, Any] | None = None) -> Callable[..., Answer]:
    """The optimizer of that name as ``minimize(f, bounds, seed, budget)`` with ``f(x)`` a number; raises :class:`guideway.BadParameter`."""
    peer = find(name, "minimize")
    peer.settings(settings)
    return lambda f, bounds, seed=0, budget=None: peer.run((f, bounds), seed=seed, budget=budget, set=settings)


_BOTH = "evaluations or seconds"


def _ompl(planner: str, **parameters: Any) -> Peer:
    return Peer("plan", "ompl", "ompl", "ompl:plan", {"planner": planner}, {"simplify": False, **parameters}, _BOTH, True)


def _motion_planning(planner: str, **parameters: Any) -> Peer:
    seeded = True if parameters else None
    module = "python_motion_planning"
    return Peer("plan", "python-motion-planning", module, "grids:motion_planning", {"planner": planner}, parameters, "none", seeded)


def _pygmo(algorithm: str) -> Peer:
    return Peer("minimize", "pygmo", "pygmo", "optimizers:pygmo", {"algorithm": algorithm}, {"population": 50}, "evaluations", True)


def _scipy(call: str, **parameters: Any) -> Peer:
    return Peer("minimize", "scipy", "scipy", f"optimizers:{call}", {}, parameters, "evaluations", True)


def _time(package: str, home: str, **words: Any) -> Peer:
    parameters = {} if package == "ruckig" else {"intervals": 1000}
    return Peer("time", package, package.replace("-", "_"), f"timing:{home}", words, parameters)


PEERS: dict[str, Peer] = {
    "ompl-rrt-connect": _ompl("RRTConnect", range=None),
    "ompl-rrt-star": _ompl("RRTstar", range=None),
    "ompl-informed-rrt-star": _ompl("InformedRRTstar", range=None),
    "ompl-bit-star": _ompl("BITstar"),
    "ompl-aorrtc": _ompl("AORRTC", range=None),
    "motion-planning-astar": _motion_planning("AStar"),
    "motion-planning-jps": _motion_planning("JPS"),
    "motion-planning-theta-star": _motion_planning("ThetaStar"),
    "motion-planning-lazy-theta-star": _motion_planning("LazyThetaStar"),
    "motion-planning-rrt-connect": _motion_planning("RRTConnect", samples=20_000),
    "motion-planning-rrt-star": _motion_planning("RRTStar", samples=1000),
    "nano-astar": Peer("plan", "nano-astar", "nano_astar", "grids:nano_astar"),
    "pygmo-de": _pygmo("de"),
    "pygmo-sade": _pygmo("sade"),
    "pygmo-de1220": _pygmo("de1220"),
    "pygmo-pso": _pygmo("pso"),
    "pygmo-sga": _pygmo("sga"),
    "pygmo-gaco": _pygmo("gaco"),
    "pygmo-cmaes": _pygmo("cmaes"),
    "scipy-de": _scipy("scipy_de", population=50, strategy="best1bin"),
    "scipy-dual-annealing": _scipy("scipy_dual_annealing"),
    "toppra": _time("toppra", "toppra"),
    "copp-py": _time("copp-py", "copp"),
    "copp-py-jerk": _time("copp-py", "copp", jerk=True),
    "ruckig": _time("ruckig", "ruckig"),
}
"""All peers by name."""
