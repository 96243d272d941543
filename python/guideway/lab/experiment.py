"""What an experiment is: plain, immutable data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from guideway.lab.space import Tune

Key = tuple[str, str, str, int]
"""Names of world, query and method, and the seed."""

SECONDS = 600.0
"""Time limit of a run where the experiment names none, s."""

MEMORY = 4096
"""Memory limit of a run where the experiment names none, MiB."""


@dataclass(frozen=True)
class Run:
    """One run of one method: everything a worker needs, in plain data."""

    experiment: str
    kind: str
    folder: str
    """Where relative files are."""
    world: Mapping[str, Any]
    """``name``, and ``source`` or ``make`` with its keywords."""
    query: Mapping[str, Any]
    """``name``, and keywords of the query."""
    method: Mapping[str, Any]
    """``name``, and what its kind asks for (``planner``, ``set`` ...)."""
    seed: int
    budget: Mapping[str, Any]
    """``evaluations``, ``iterations``, ``seconds``; those of the method win over those of the experiment."""
    limits: Mapping[str, Any]
    """``seconds`` and ``memory_mib``."""

    @property
    def key(self) -> Key:
        """What tells this run from all others of its experiment."""
        return self.world["name"], self.query["name"], self.method["name"], self.seed


@dataclass(frozen=True)
class Metric:
    """A measure: its unit, what is better, and the digits it is shown with."""

    name: str
    unit: str = ""
    better: Literal["lower", "higher"] | None = "lower"
    digits: int = 4


@dataclass(frozen=True)
class Published:
    """A figure in print."""

    table: str
    world: str
    query: str
    method: str
    metric: str
    statistic: str
    """mean, sd, median, best, worst, min, max or share; in the unit of the metric."""
    value: float


@dataclass(frozen=True)
class Claim:
    """What the source says, and how it is judged."""

    says: str
    table: str
    test: str
    """lower | higher (than each of ``than``), within (``tolerance`` of ``value``), share (at least ``value``), growth (with an exponent of at most
    ``value``) or none (``reason``)."""
    metric: str
    method: str
    than: tuple[str, ...]
    worlds: tuple[str, ...]
    """Names; all where empty."""
    value: float | None
    tolerance: float | None
    alpha: float
    reason: str
    possible: bool = False
    """Of ``share``: leave out what every method was refused in the same words, because no solution exists."""


@dataclass(frozen=True)
class Experiment:
    """An experiment, its grids expanded."""

    name: str
    title: str
    source: str
    table: str
    kind: str
    seeds: tuple[int, ...]
    budget: Mapping[str, Any]
    limits: Mapping[str, Any]
    metrics: tuple[Metric, ...]
    reference: str | None
    worlds: tuple[Mapping[str, Any], ...]
    queries: tuple[Mapping[str, Any], ...]
    methods: tuple[Mapping[str, Any], ...]
    published: tuple[Published, ...]
    claims: tuple[Claim, ...]
    path: str
    """The file it was read from."""
    folder: str
    """Where relative files are."""
    digest: str
    """sha256 of everything that decides the records of a seed: kind, worlds, queries, methods, budget, limits, named files."""
    quick: Mapping[str, Any]
    """What ``--quick`` changes."""
    tune: Tune | None
    """What ``guideway lab tune`` seeks."""
    reduced: bool = False
    """Is it the quick version?"""

    def runs(self) -> list[Run]:
        """All runs in a fixed order: worlds, queries, seeds, methods."""
        return [
            self.run(world, query, method, seed) for world in self.worlds for query in self.queries for seed in self.seeds for method in self.methods
        ]

    def run(self, world: Mapping[str, Any], query: Mapping[str, Any], method: Mapping[str, Any], seed: int) -> Run:
        """One run."""
        budget = {**self.budget, **method.get("budget", {})}
        limits = {**self.limits, **method.get("limits", {})}
        return Run(self.name, self.kind, self.folder, world, query, method, seed, budget, limits)
