"""Records in order: by world, query and method; what a measure is in each; which runs make a pair."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from .curves import Course, usable
from .experiment import Experiment, Metric

ALARM = -1e-9
"""A gap below this means that the checker or the reference is wrong."""
Record = Mapping[str, Any]
Instance = tuple[str, str]
"""Names of a world and a query."""


@dataclass
class Cell:
    """All records of one method on one world and query, in the order of their seeds."""

    world: str
    query: str
    method: str
    records: list[Record] = field(default_factory=list[Record])
    _known: dict[str, dict[int, float]] = field(default_factory=dict[str, dict[int, float]])

    @property
    def instance(self) -> Instance:
        """World and query."""
        return self.world, self.query

    @cached_property
    def sound(self) -> list[Record]:
        """Records of runs that succeeded with a certified result: only these are averaged."""
        return [record for record in self.records if is_sound(record)]

    @cached_property
    def courses(self) -> list[Course]:
        """Convergence of all runs, in the order of the records; empty for a run that did not succeed."""
        return [usable(record.get("curve") if is_sound(record) else None) for record in self.records]

    def by_seed(self, metric: str) -> dict[int, float]:
        """Seed -> value of a measure, of the sound runs that have one."""
        if metric not in self._known:
            sound = self.sound
            rows = [(r, succeeded(r)) for r in self.records] if metric == "success" else [(r, value_of(r, metric)) for r in sound]
            self._known[metric] = {seed_of(record): value for record, value in rows if value is not None}
        return self._known[metric]

    def values(self, metric: str) -> list[float]:
        """Values of a measure over the sound runs."""
        return list(self.by_seed(metric).values())

    def constant(self, metric: str) -> bool:
        """Whether every seed gives the same value: then seeds are no repetitions."""
        values = self.values(metric)
        return len(values) > 1 and max(values) - min(values) <= 1e-9 * max(abs(v) for v in values)


@dataclass
class Grid:
    """An experiment and its records: the cells, in the order of the file."""

    experiment: Experiment
    cells: dict[tuple[str, str, str], Cell]
    _optima: dict[int, float | None] = field(default_factory=dict[int, "float | None"])

    @property
    def instances(self) -> list[Instance]:
        """Worlds and queries that have records."""
        return list(dict.fromkeys(cell.instance for cell in self.cells.values()))

    @property
    def methods(self) -> list[str]:
        """Methods that have records."""
        return list(dict.fromkeys(cell.method for cell in self.cells.values()))

    def cell(self, instance: Instance, method: str) -> Cell | None:
        """The cell of a method, if there are records."""
        return self.cells.get((*instance, method))

    @cached_property
    def measured(self) -> list[str]:
        """All numeric measures in the records: those of the experiment first, then the others in order of their names."""
        seen = {name for cell in self.cells.values() for record in cell.records for name in numbers(record.get("measures"))}
        first = [metric.name for metric in self.experiment.metrics]
        timed = {name for cell in self.cells.values() for record in cell.records for name in numbers(record.get("times"))}
        return [*dict.fromkeys([*(name for name in first if name in seen | timed), *sorted(seen)])]

    @cached_property
    def rates(self) -> set[str]:
        """Measures that say yes or no: their intervals are Wilson's, not Student's."""
        kinds: dict[str, set[type]] = {}
        for cell in self.cells.values():
            for record in cell.records:
                measures = record.get("measures")
                for name, value in measures.items() if isinstance(measures, Mapping) else ():
                    if value is not None:
                        kinds.setdefault(name, set()).add(type(value))
        return {"success"} | {name for name, found in kinds.items() if found == {bool}}

    def metric(self, name: str) -> Metric:
        """What is known of a measure: from the experiment, else from its kind, else nothing."""
        for metric in self.experiment.metrics:
            if metric.name == name:
                return metric
        return known_metrics(self.experiment.kind).get(name) or Metric(name, better=None)

    @property
    def compared(self) -> list[Metric]:
        """Measures of the experiment that say which value is better."""
        return [metric for metric in self.experiment.metrics if metric.better in ("lower", "higher") and metric.name in self.measured]

    def optimum(self, cell: Cell) -> float | None:
        """The exact optimum in the model of a cell's method, on the scale of its curves; None where curves show something else than the
        reference measure.
        """
        if id(cell) not in self._optima:
            self._optima[id(cell)] = self._optimum(cell)
        return self._optima[id(cell)]

    def optimum_of(self, record: Record) -> float | None:
        """The exact optimum of the reference measure in the model of a record: as measured, else from its gap."""
        known, value, gap = value_of(record, "optimum"), value_of(record, str(self.experiment.reference)), self.gap_of(record)
        return known if known is not None or value is None or gap is None or gap <= -1 else value / (1 + gap)

    def gap_of(self, record: Record, name: str = "gap") -> float | None:
        """A gap of a record as a share, whatever the unit of its measure."""
        value = value_of(record, name)
        return value if value is None or self.metric(name).unit != "%" else value / 100

    def _optimum(self, cell: Cell) -> float | None:
        found: list[float] = []
        for record, curve in zip(cell.records, cell.courses, strict=True) if self.experiment.reference else ():
            value, optimum = value_of(record, str(self.experiment.reference)), self.optimum_of(record)
            if value is None or optimum is None or not curve:
                continue
            if not math.isclose(curve[-1][1], value, rel_tol=1e-6):
                return None
            found.append(optimum)
        return min(found) if found and max(found) - min(found) <= 1e-6 * abs(min(found)) else None

    def model(self, cell: Cell) -> float | None:
        """The exact optimum that a method's gaps refer to, whatever its curves show: methods with different ones do not solve the same problem."""
        known = [optimum for record in cell.sound if (optimum := self.optimum_of(record)) is not None]
        return min(known, default=None)

    def unlike(self, one: Cell | None, other: Cell | None, metric: str) -> bool:
        """Whether a reference measure is compared across models whose optima differ (such as paths on a lattice and at any angle)."""
        if metric != self.experiment.reference or one is None or other is None:
            return False
        first, second = self.model(one), self.model(other)
        return first is not None and second is not None and not math.isclose(first, second, rel_tol=1e-9)


def grid(experiment: Experiment, records: Iterable[Record]) -> Grid:
    """Sorts records into cells, in the order of the experiment; what the experiment does not name comes last, by name. The last record of a key
    counts.
    """
    kept = {(text(r, "world"), text(r, "query"), text(r, "method"), seed_of(r)): r for r in records}
    places = [{item["name"]: i for i, item in enumerate(items)} for items in (experiment.worlds, experiment.queries, experiment.methods)]
    order = sorted(kept, key=lambda key: (*((p.get(name, len(p)), name) for p, name in zip(places, key[:3], strict=True)), key[3]))
    cells: dict[tuple[str, str, str], Cell] = {}
    for key in order:
        cells.setdefault(key[:3], Cell(*key[:3])).records.append(kept[key])
    return Grid(experiment, cells)


def known_metrics(kind: str) -> Mapping[str, Metric]:
    """The measures that a kind declares; none where it cannot be loaded here."""
    from . import kinds

    try:
        return getattr(kinds.load(kind), "METRICS", {})
    except (ValueError, ImportError, AttributeError):
        return {}


def text(record: Record, name: str) -> str:
    """A name in a record."""
    value = record.get(name)
    return value if isinstance(value, str) else ""


def seed_of(record: Record) -> int:
    """The seed of a record."""
    value = record.get("seed")
    return value if isinstance(value, int) else 0


def is_sound(record: Record) -> bool:
    """Whether a run succeeded and the checker did not refuse its result."""
    return record.get("status") == "ok" and record.get("certified") is not False


def succeeded(record: Record) -> float:
    """1 where a run is sound and, if its kind says what success is, had it; else 0."""
    said = value_of(record, "success")
    return float(is_sound(record) and said != 0)


def numbers(values: Any) -> dict[str, float]:
    """The finite numbers and truth values of a table."""
    if not isinstance(values, Mapping):
        return {}
    return {name: float(v) for name, v in values.items() if isinstance(v, int | float) and math.isfinite(v)}


def value_of(record: Record, metric: str) -> float | None:
    """A measure of a record, or one of its times; None where it has none."""
    for table in ("measures", "times"):
        values = record.get(table)
        value = values.get(metric) if isinstance(values, Mapping) else None
        if isinstance(value, int | float) and math.isfinite(value):
            return float(value)
    return None


def spent(record: Record, budget: Mapping[str, Any]) -> float | None:
    """Evaluations that a run used: as measured, else its whole budget, else the end of its curve."""
    measured, allowed = value_of(record, "evaluations"), budget.get("evaluations")
    if measured is not None:
        return measured
    return float(allowed) if isinstance(allowed, int | float) else usable(record.get("curve")).end


def pairs(one: Sequence[Cell | None], other: Sequence[Cell | None], metric: str) -> list[tuple[float, float]]:
    """Values of two methods at the same world, query and seed, where both have one.

    Where both give the same value for every seed, seeds repeat nothing and the instance counts as a single pair.
    """
    found: list[tuple[float, float]] = []
    for a, b in zip(one, other, strict=True):
        if a is None or b is None:
            continue
        first, second = a.by_seed(metric), b.by_seed(metric)
        common = [seed for seed in first if seed in second]
        if a.constant(metric) and b.constant(metric):
            common = common[:1]
        found += [(first[seed], second[seed]) for seed in common]
    return found
