"""What the records of an experiment say: ``summary.json``, versioned, without NaN."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import Any

from guideway._core import __version__
from guideway.view.report import clean

from .cells import ALARM, Cell, Grid, Instance, Record, grid, is_sound, pairs, seed_of, spent, value_of
from .curves import TARGETS, band, convergence, distribution, expected, profile, reached
from .experiment import Experiment, Metric
from .growing import growths
from .reading import files_of
from .statistics import describe, friedman, holm, mcnemar, paired, success
from .verdicts import judge

SCHEMA = 1
TARGET = 0.01
"""Gap of the expected running time."""
MOST_INSTANCES = 64
"""With more worlds and queries than this, methods are compared over all of them only."""
MOST_METHODS = 16
"""With more methods than this they are compared with the first one only."""
LEAST_BLOCKS = 5
"""With fewer worlds and queries than this the blocks of Friedman's test are the seeds on each of them."""
MOST_ERRORS = 20
CLOCKS = ("plan_cpu", "cpu", "plan", "wall")
"""Times of a record, the one that says most of the method first."""


def summarise(experiments: Iterable[tuple[Experiment, Sequence[Record]]]) -> dict[str, Any]:
    """The content of ``summary.json``: every experiment with its records."""
    found = [summary(experiment, records) for experiment, records in experiments]
    return {"schema": SCHEMA, "guideway": __version__, "experiments": found}


def summary(experiment: Experiment, records: Sequence[Record]) -> dict[str, Any]:
    """One experiment: cells, comparisons, curves, published figures, claims, alarms; plain JSON without NaN."""
    table = grid(experiment, records)
    return clean(
        about(experiment, table)
        | {
            "cells": [cell_summary(table, cell) for cell in table.cells.values()],
            "overall": [overall(table, method) for method in table.methods],
            "comparisons": comparisons(table),
            "paired_success": paired_success(table),
            "ranks": [found for metric in table.compared if (found := ranks(table, metric))],
            "curves": {"convergence": bands(table), **distributions(table), "profile": profiles(table)},
            "growth": growths(table, CLOCKS),
            "published": published(table),
            "claims": [judge(table, claim) for claim in experiment.claims],
            "alarms": alarms(table),
        }
    )


def about(experiment: Experiment, table: Grid) -> dict[str, Any]:
    """What was run, where, and how much of it is there."""
    records = [record for cell in table.cells.values() for record in cell.records]
    wanted = {run.key for run in experiment.runs()}
    done = {(*key, seed_of(record)) for key, cell in table.cells.items() for record in cell.records}
    metrics = [table.metric(name) for name in table.measured]
    stale = sum(record.get("digest") != experiment.digest for record in records) if files_of(experiment, missing=True) == [] else 0
    runs = {"recorded": len(records), "expected": len(wanted), "missing": len(wanted - done), "unknown": len(done - wanted), "stale": stale}
    return {
        "name": experiment.name,
        "title": experiment.title,
        "source": experiment.source,
        "table": experiment.table,
        "kind": experiment.kind,
        "quick": experiment.reduced,
        "reference": experiment.reference,
        "budget": dict(experiment.budget),
        "limits": dict(experiment.limits),
        "seeds": len({seed_of(record) for record in records}),
        "runs": runs,
        "status": dict(Counter(str(record.get("status")) for record in records)),
        "worlds": [str(world["name"]) for world in experiment.worlds],
        "queries": [str(query["name"]) for query in experiment.queries],
        "methods": [str(method["name"]) for method in experiment.methods],
        "metrics": [{"name": m.name, "unit": m.unit, "better": m.better, "digits": m.digits, "first": m in experiment.metrics} for m in metrics],
        "digests": sorted({str(record.get("digest", "")) for record in records}),
        "versions": sorted({str(record.get("version", "")) for record in records}),
        "machines": distinct(record.get("machine") for record in records),
        "command": f"guideway lab run {experiment.name}" + (" --quick" if experiment.reduced else ""),
    }


def distinct(values: Iterable[Any]) -> list[Any]:
    """Each different value once, in order."""
    return [json.loads(text) for text in sorted({json.dumps(value, sort_keys=True, default=str) for value in values if value})]


def cell_summary(table: Grid, cell: Cell) -> dict[str, Any]:
    """Success, measures and times of one method on one world and query."""
    runs, budget = len(cell.records), budget_of(table.experiment, cell.method)
    optimum = table.optimum(cell)
    curves = [(course, spent(record, budget)) for course, record in zip(cell.courses, cell.records, strict=True)]
    found = None if optimum is None else expected(curves, optimum + TARGET * abs(optimum))
    gaps = [gap for record in cell.sound if (gap := table.gap_of(record)) is not None]
    settled = [at for course in cell.courses if (at := convergence(course)) is not None]
    return {
        "world": cell.world,
        "query": cell.query,
        "method": cell.method,
        "n": runs,
        "status": dict(Counter(str(record.get("status")) for record in cell.records)),
        "failed": runs - len(cell.sound),
        "success": success(int(sum(cell.values("success"))), runs).to_dict(),
        "measures": {name: measure(table.metric(name), cell.values(name), name in table.rates) for name in table.measured if cell.values(name)},
        "times": {name: describe(cell.values(name)).to_dict() for name in timed(cell)},
        "peak_mib": max((float(m) for r in cell.records if isinstance(m := r.get("peak_mib"), int | float)), default=None),
        "ert": None if found is None else {"gap": TARGET, "optimum": optimum, **found.to_dict()},
        "optimum": table.model(cell),
        "convergence": {"evaluations": describe(settled).median, "gap": describe(gaps).median} if settled else None,
        "errors": errors(cell),
    }


def budget_of(experiment: Experiment, method: str) -> Mapping[str, Any]:
    """The budget of a method: its own wins over the experiment's."""
    own = next((item.get("budget", {}) for item in experiment.methods if item["name"] == method), {})
    return {**experiment.budget, **own}


def measure(metric: Metric, values: Sequence[float], rate: bool = False) -> dict[str, Any]:
    """Statistics of a measure, with best and worst where it says what is better; of a ``rate`` (yes or no) the interval is Wilson's."""
    found = describe(values).to_dict()
    if rate and values:
        wilson = success(int(sum(values)), len(values))
        found |= {"rate": True, "low": wilson.low, "high": wilson.high}
    if metric.better is not None:
        ends = ("least", "most") if metric.better == "lower" else ("most", "least")
        found |= {"best": found[ends[0]], "worst": found[ends[1]]}
    return found


def timed(cell: Cell) -> list[str]:
    """Names of the times of a cell's records."""
    return sorted({name for record in cell.sound for name in record.get("times") or {} if value_of({"times": record["times"]}, name) is not None})


def errors(cell: Cell) -> list[dict[str, Any]]:
    """Errors of the runs that did not succeed: each different one with its seeds."""
    found: dict[tuple[str, str, str], list[int]] = {}
    for record in cell.records:
        if is_sound(record):
            continue
        error = record.get("error")
        said = error if isinstance(error, Mapping) else {}
        found.setdefault((str(record.get("status")), str(said.get("type", "")), str(said.get("message", ""))), []).append(seed_of(record))
    rows = [{"status": s, "type": t, "message": m, "seeds": seeds} for (s, t, m), seeds in found.items()]
    return sorted(rows, key=lambda row: (-len(row["seeds"]), row["status"], row["type"], row["message"]))[:MOST_ERRORS]


def overall(table: Grid, method: str) -> dict[str, Any]:
    """A method over all worlds and queries: success of all runs, and measures with every instance weighing the same (means of the means)."""
    cells = [cell for instance in table.instances if (cell := table.cell(instance, method))]
    means = {name: [m for cell in cells if (m := describe(cell.values(name)).mean) is not None] for name in table.measured}
    return {
        "method": method,
        "instances": len(cells),
        "n": sum(len(cell.records) for cell in cells),
        "failed": sum(len(cell.records) - len(cell.sound) for cell in cells),
        "success": success(int(sum(sum(cell.values("success")) for cell in cells)), sum(len(cell.records) for cell in cells)).to_dict(),
        "measures": {name: measure(table.metric(name), values) for name, values in means.items() if values},
        "times": {
            name: describe([v for cell in cells for v in cell.values(name)]).to_dict() for name in sorted({n for c in cells for n in timed(c)})
        },
    }


def comparisons(table: Grid) -> list[dict[str, Any]]:
    """Paired comparisons per measure: with the first method on each world and query, and of all pairs over all of them; Holm within each family."""
    rows: list[dict[str, Any]] = []
    for metric in table.compared:
        if 1 < len(table.instances) <= MOST_INSTANCES:
            for instance in table.instances:
                place = {"world": instance[0], "query": instance[1]}
                rows += [place | row for row in family(table, metric, [instance], against_first(table.methods))]
        every = against_first(table.methods) if len(table.methods) > MOST_METHODS else list(combinations(table.methods, 2))
        rows += [{"world": None, "query": None} | row for row in family(table, metric, table.instances, every)]
    return rows


def against_first(methods: Sequence[str]) -> list[tuple[str, str]]:
    """The first method with each of the others."""
    return [(methods[0], other) for other in methods[1:]]


def family(table: Grid, metric: Metric, instances: Sequence[Instance], couples: Sequence[tuple[str, str]]) -> list[dict[str, Any]]:
    """Comparisons that are corrected together."""
    rows = []
    for one, other in couples:
        mine, theirs = ([table.cell(instance, method) for instance in instances] for method in (one, other))
        both = pairs(mine, theirs, metric.name)
        found = paired([a for a, _ in both], [b for _, b in both], metric.better == "lower")
        alike = not any(table.unlike(a, b, metric.name) for a, b in zip(mine, theirs, strict=True))
        rows.append({"metric": metric.name, "method": one, "other": other, "same_model": alike, **found.to_dict()})
    return [row | {"p_holm": p} for row, p in zip(rows, holm([row["p"] for row in rows]), strict=True)]


def paired_success(table: Grid) -> list[dict[str, Any]]:
    """McNemar's test of success on the same world, query and seed, of the first method with each other, where any run failed."""
    rows = []
    for one, other in against_first(table.methods) if table.methods else []:
        both: list[tuple[float, float]] = []
        for instance in table.instances:
            first, second = table.cell(instance, one), table.cell(instance, other)
            solved = second.by_seed("success") if second else {}
            both += [(value, solved[seed]) for seed, value in (first.by_seed("success") if first else {}).items() if seed in solved]
        if all(a == b == 1 for a, b in both):
            continue
        only, lacking, p = mcnemar([a > 0 for a, _ in both], [b > 0 for _, b in both])
        rows.append({"method": one, "other": other, "pairs": len(both), "only_method": only, "only_other": lacking, "p": p})
    return [row | {"p_holm": p} for row, p in zip(rows, holm([row["p"] for row in rows]), strict=True)]


def ranks(table: Grid, metric: Metric) -> dict[str, Any] | None:
    """Friedman and Nemenyi over instances (medians over seeds), or over seeds where there are few instances.

    A failure ranks last. A block in which some method succeeded without having the measure is left out, and so is a method that never has it.
    """
    methods = [method for method in table.methods if not silent(table, method, metric.name)]
    if len(methods) < 2:
        return None
    many = len(table.instances) >= LEAST_BLOCKS
    blocks: list[list[float | None]] = []
    for instance in table.instances:
        cells = [table.cell(instance, method) for method in methods]
        seeds = sorted({seed_of(record) for cell in cells if cell for record in cell.records})
        known = [cell.by_seed(metric.name) if cell else {} for cell in cells]
        solved = [{seed_of(record) for record in cell.sound} if cell else set[int]() for cell in cells]
        if many:
            blocks += (
                [[describe(list(row.values())).median for row in known]]
                if all(row or not done for row, done in zip(known, solved, strict=True))
                else []
            )
        else:
            fair = [seed for seed in seeds if all(seed in row or seed not in done for row, done in zip(known, solved, strict=True))]
            blocks += [[row.get(seed) for row in known] for seed in fair]
    found = friedman({method: [block[i] for block in blocks] for i, method in enumerate(methods)}, metric.better == "lower")
    return {"metric": metric.name, "blocks_are": "worlds and queries" if many else "seeds on each world and query", **found.to_dict()}


def silent(table: Grid, method: str, metric: str) -> bool:
    """Whether a method succeeds without ever having a measure."""
    cells = [cell for instance in table.instances if (cell := table.cell(instance, method))]
    return any(cell.sound for cell in cells) and not any(cell.by_seed(metric) for cell in cells)


def bands(table: Grid) -> list[dict[str, Any]]:
    """Convergence: median and quartiles of the best value over evaluations, per cell whose records have curves."""
    rows = []
    for cell in table.cells.values():
        rows_of = band(cell.courses)
        if rows_of:
            rows.append({"world": cell.world, "query": cell.query, "method": cell.method, "rows": rows_of})
    return rows


def distributions(table: Grid) -> dict[str, Any]:
    """Empirical distributions per method: over evaluations (share of runs and targets reached) and over time (share of runs solved)."""
    best = {key: value for key, cell in table.cells.items() if (value := best_known(table, cell)) is not None}
    over_evaluations, over_time = [], []
    for method in table.methods:
        cells = [cell for instance in table.instances if (cell := table.cell(instance, method))]
        hits = [
            reached(course, (1 + gap) * best[key_of(cell)])
            for cell in cells if key_of(cell) in best for course in cell.courses for gap in TARGETS
        ]  # fmt: skip
        if any(hit is not None for hit in hits):
            over_evaluations.append({"method": method, "rows": distribution(hits)})
        ends = [duration(record) if is_sound(record) else None for cell in cells for record in cell.records]
        if any(end is not None for end in ends):
            over_time.append({"method": method, "rows": distribution(ends)})
    proved = bool(best) and all(table.optimum(table.cells[key]) is not None for key in best)
    return {
        "ecdf_evaluations": {"targets": list(TARGETS), "reference": "exact" if proved else "best found", "methods": over_evaluations},
        "ecdf_time": over_time,
    }


def key_of(cell: Cell) -> tuple[str, str, str]:
    """World, query and method."""
    return cell.world, cell.query, cell.method


def best_known(table: Grid, cell: Cell) -> float | None:
    """The positive exact optimum on the scale of a cell's curves, else the best value that any run of any method without one found."""
    exact = table.optimum(cell)
    if exact is not None:
        return exact if exact > 0 else None
    cells = [other for method in table.methods if (other := table.cell(cell.instance, method)) and table.optimum(other) is None]
    best = min((course[-1][1] for other in cells for course in other.courses if course), default=0.0)
    return best if best > 0 else None


def duration(record: Record) -> float | None:
    """Processor time of the method's own work, else of the whole run, else wall time, s."""
    return next((value for name in CLOCKS if (value := value_of({"times": record.get("times")}, name)) is not None), None)


def profiles(table: Grid) -> dict[str, Any] | None:
    """Performance profile of the reference measure, else of the first of which less is better, over all worlds, queries and seeds; None unless all
    its values are positive.
    """
    known = [metric for metric in table.compared if metric.better == "lower" and metric.name != "gap" and metric.name not in table.rates]
    metric = next((metric for metric in known if metric.name == table.experiment.reference), next(iter(known), None))
    if metric is None or len(table.methods) < 2:
        return None
    columns: dict[str, list[float | None]] = {method: [] for method in table.methods}
    for instance in table.instances:
        known = {method: cell.by_seed(metric.name) if (cell := table.cell(instance, method)) else {} for method in table.methods}
        seeds = sorted({seed_of(r) for method in table.methods if (cell := table.cell(instance, method)) for r in cell.records})
        for method in table.methods:
            columns[method] += [known[method].get(seed) for seed in seeds]
    if any(value is not None and value <= 0 for column in columns.values() for value in column):
        return None
    return {
        "metric": metric.name,
        "problems": len(next(iter(columns.values()))),
        "methods": [{"method": m, "rows": r} for m, r in profile(columns).items()],
    }


def published(table: Grid) -> list[dict[str, Any]]:
    """The figures in print beside ours; ``ours`` is None where we have no certified run."""
    return [row | {"ours": ours(table, row)} for row in ({name: getattr(p, name) for name in FIELDS} for p in table.experiment.published)]


FIELDS = ("table", "world", "query", "method", "metric", "statistic", "value")
STATISTICS = {"min": "least", "max": "most"}


def ours(table: Grid, row: Mapping[str, Any]) -> float | None:
    """The statistic of a published figure, from our records; a share counts failed runs, too."""
    cell = table.cell((row["world"], row["query"]), row["method"])
    if cell is None:
        return None
    if row["statistic"] == "share":
        return sum(value > 0 for value in cell.values(row["metric"])) / len(cell.records)
    return measure(table.metric(row["metric"]), cell.values(row["metric"])).get(STATISTICS.get(str(row["statistic"]), str(row["statistic"])))


def alarms(table: Grid) -> list[dict[str, Any]]:
    """Certified results better than a proved optimum (any measure that is a gap, as a share): then the checker or the reference is wrong."""
    names = [name for name in table.measured if name == "gap" or name.endswith("_gap")]
    return [
        {"world": cell.world, "query": cell.query, "method": cell.method, "seed": seed_of(record), "metric": name, "gap": gap}
        for cell in table.cells.values() for record in cell.sound for name in names if (gap := table.gap_of(record, name)) is not None and gap < ALARM
    ]  # fmt: skip
