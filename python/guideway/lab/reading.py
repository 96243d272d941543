"""Experiment files: read and checked; every complaint names the file and the field, what is allowed and what to do."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from guideway.errors import BadFile, BadParameter, GuidewayError
from guideway.io import files
from guideway.io.files import show, word
from guideway.io.packaged import is_packaged
from guideway.io.tables import Table, parse_toml
from guideway.lab import kinds
from guideway.lab.expand import MOST, expanded
from guideway.lab.experiment import MEMORY, SECONDS, Experiment, Metric
from guideway.lab.judging import read_claims, read_published
from guideway.lab.space import read_tune

LIMIT = 1 << 20
"""Largest experiment file, bytes."""

_NAME = re.compile(r"[a-z0-9][a-z0-9._-]{0,79}")
_SOURCE = re.compile(r"ours|[a-z]+(19|20)\d{2}[a-z]*")


def read(path: str | os.PathLike[str], *, check: bool = True) -> Experiment:
    """Reads an experiment; ``check`` asks its kind too whether planners, parameters and worlds are known.

    Raises :class:`guideway.errors.BadFile`, one error that names file and field, for whatever is wrong with it.
    """
    where = files.name(path)
    data = parse_toml(where, files.load(path, LIMIT).text(LIMIT))
    with files.guard(where):
        found = of_data(where, path, data)
    return _checked(where, found) if check else found


def quick(experiment: Experiment) -> Experiment:
    """The version of ``--quick``: fewer seeds (3, where the file says nothing), worlds, queries and methods, a smaller budget."""
    small = experiment.quick
    seeds = small.get("seeds", experiment.seeds[:3])
    budget = small.get("budget", {})
    methods = [
        method | {"budget": method["budget"] | budget} if budget and "budget" in method else method for method in _kept(small, experiment, "methods")
    ]
    changed = replace(
        experiment,
        seeds=seeds,
        worlds=tuple(_kept(small, experiment, "worlds")),
        queries=tuple(_kept(small, experiment, "queries")),
        methods=tuple(methods),
        budget={**experiment.budget, **budget},
        limits={**experiment.limits, **small.get("limits", {})},
        reduced=True,
    )
    return replace(changed, digest=digest(changed))


def with_seeds(experiment: Experiment, count: int) -> Experiment:
    """The experiment with seeds 0 to ``count`` - 1. Raises :class:`guideway.errors.BadParameter` for more runs than an experiment may have."""
    runs = count * len(experiment.worlds) * len(experiment.queries) * len(experiment.methods)
    if runs > MOST:
        raise BadParameter(f"--seeds {count} makes {runs} runs of {experiment.name}: at most {MOST}")
    return replace(experiment, seeds=tuple(range(count)))


def digest(experiment: Experiment) -> str:
    """sha256 of what decides the records, seeds left out: more seeds may be added to what is there. The maps and planners' files that are named count
    with what is in them."""
    parts: list[Any] = [experiment.kind, experiment.worlds, experiment.queries, experiment.methods, experiment.budget, experiment.limits]
    parts += [[name, _content(experiment, name)] for name in files_of(experiment)]
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()


def files_of(experiment: Experiment, missing: bool = False) -> list[str]:
    """The files of maps and planners that are named, as far as they are there; or those that are ``missing``."""
    sources = {str(world["source"]).partition("#")[0] for world in experiment.worlds if "source" in world and not is_packaged(world["source"])}
    planners = (str(method.get("planner", "")).rpartition(":")[0] for method in experiment.methods)
    named = sorted(sources | {planner for planner in planners if planner.endswith(".py")})
    return [name for name in named if (_content(experiment, name) is None) == missing]


def _content(experiment: Experiment, name: str) -> str | None:
    """sha256 of a file; None where there is none."""
    try:
        return hashlib.sha256(Path(experiment.folder, name).read_bytes()).hexdigest()
    except (OSError, ValueError):
        return None


def _kept(small: Mapping[str, Any], experiment: Experiment, what: str) -> Iterable[Any]:
    names = small.get(what)
    return [item for item in getattr(experiment, what) if names is None or item["name"] in names]


def of_data(where: str, path: str | os.PathLike[str], data: dict[str, object]) -> Experiment:
    """The experiment that the parsed file says; ``where`` is its name in messages."""
    top = Table(where, "", data)
    if top.integer("schema", 1, 1) is None:
        raise top.bad("schema", "1")
    name = top.text("name") or _missing(top, "name", "the file's name without .toml")
    if not _NAME.fullmatch(name):
        raise top.bad("name", "small letters, digits, '.', '_' and '-', at most 80")
    source = top.text("source", "ours") or "ours"
    if not _SOURCE.fullmatch(source):
        raise top.bad("source", "ours, or the key of a source such as han2024")
    kind = top.text("kind") or _missing(top, "kind", ", ".join(kinds.KINDS))
    module = _kind(top, kind)
    seeds = _seeds(top) or tuple(range(30))
    worlds, methods = (_items(top, what, module) for what in ("worlds", "methods"))
    queries = _items(top, "queries", module) if "queries" in top else ({"name": ""},)
    runs = len(seeds) * len(worlds) * len(queries) * len(methods)
    if runs > MOST:
        raise BadFile(where, f"the experiment has {runs} runs", f"at most {MOST}", "Use fewer seeds, worlds, queries or methods, or several files")
    names = {what: [item["name"] for item in items] for what, items in (("worlds", worlds), ("queries", queries), ("methods", methods))}
    metrics = _metrics(top, module)
    known = sorted({"success"} | {metric.name for metric in metrics} | set(getattr(module, "METRICS", {})))
    found = Experiment(
        name=name,
        title=top.text("title", name) or name,
        source=source,
        table=_free(top, "table"),
        kind=kind,
        seeds=seeds,
        budget=_budget(top),
        limits={"seconds": SECONDS, "memory_mib": MEMORY} | _limits(top),
        metrics=metrics,
        reference=_reference(top, known),
        worlds=worlds,
        queries=queries,
        methods=methods,
        published=read_published(top, names, known),
        claims=read_claims(top, names, known),
        path=os.fspath(path),
        folder=str(Path(path).absolute().parent),
        digest="",
        quick=_quick(top, names),
        tune=read_tune(top, names, known),
    )
    ran = top.table("ran")
    top.done()
    return replace(found, digest=digest(found)) if ran is None else _as_run(ran, found)


def _as_run(ran: Table, found: Experiment) -> Experiment:
    """The copy beside the records: what was really run, and from where."""
    found = replace(found, folder=ran.text("folder", found.folder) or found.folder)
    found = replace(found, digest=digest(found))
    small = ran.flag("quick")
    seeds = _seeds(ran) or found.seeds
    ran.done()
    found = quick(found) if small else found
    return replace(found, seeds=seeds)


def _checked(where: str, found: Experiment) -> Experiment:
    check = getattr(kinds.load(found.kind), "check", None)
    if check is not None:
        try:
            check(found)
        except BadFile:
            raise
        except GuidewayError as error:
            raise BadFile(where, str(error)) from error
        except Exception as error:
            raise BadFile(
                where, f"kind {found.kind} cannot make sense of it ({type(error).__name__}: {word(error, 100)})", todo="Correct it"
            ) from error
    return found


def _missing(table: Table, key: str, allowed: str) -> str:
    raise table.bad(key, allowed)


def _free(table: Table, key: str) -> str:
    """A text that may be empty."""
    value = table.raw(key)
    if key not in table:
        return ""
    if not isinstance(value, str) or len(value) > 4096:
        raise table.bad(key, "a text in quotes")
    return value


def _kind(top: Table, kind: str) -> ModuleType:
    try:
        return kinds.load(kind)
    except GuidewayError:
        raise top.bad("kind", f"{' | '.join(kinds.KINDS)}, or a module of yours as package.module") from None


def _seeds(table: Table) -> tuple[int, ...] | None:
    """A count, or a list of different seeds."""
    value = table.raw("seeds")
    if "seeds" not in table:
        return None
    allowed = f"how many (1 to {MOST}), or a list of different whole numbers from 0 to 2^63 - 1"
    if isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= MOST:
        return tuple(range(value))
    found = cast("list[Any]", value) if isinstance(value, list) else []
    if not 1 <= len(found) <= MOST or not all(isinstance(seed, int) and not isinstance(seed, bool) and 0 <= seed < 1 << 63 for seed in found):
        raise table.bad("seeds", allowed)
    if len(set(found)) < len(found):
        raise table.bad("seeds", allowed)
    return tuple(found)


def _budget(table: Table) -> dict[str, Any]:
    """``budget = { evaluations, iterations, seconds }``."""
    budget = table.table("budget")
    if budget is None:
        return {}
    found: dict[str, Any] = {key: budget.integer(key, 1, (1 << 63) - 1) for key in ("evaluations", "iterations")}
    found["seconds"] = budget.optional("seconds", 0, 1e9, "s", above=True)
    budget.done()
    return {key: value for key, value in found.items() if value is not None}


def _limits(table: Table) -> dict[str, Any]:
    limits = table.table("limits")
    if limits is None:
        return {}
    seconds = limits.optional("seconds", 0, 1e6, "s", above=True)
    memory = limits.optional("memory_mib", 64, 1 << 24, "MiB")
    limits.done()
    return {key: value for key, value in (("seconds", seconds), ("memory_mib", memory)) if value is not None}


def _items(top: Table, what: str, module: ModuleType) -> tuple[dict[str, Any], ...]:
    """Worlds, queries or methods, grids expanded, names different."""
    raw = top.tables(what)
    if not raw:
        raise top.bad(what, f"at least one table headed [[{what}]]")
    found: list[dict[str, Any]] = []
    fields = getattr(module, _FIELDS[what], None)
    known = None if fields is None else [*fields, *(("set", "budget", "limits") if what == "methods" else ())]
    for table in raw:
        items = expanded(table.at(), {key: table.raw(key) for key in table.keys}, known)
        found += [_item(Table(table.where, table.path, item), what, module) for item in items]
        if len(found) > MOST:
            raise BadFile(table.at(), f"there are more than {MOST} of them", f"at most {MOST}", "Use smaller grids")
    seen: set[str] = set()
    for item in found:
        if item["name"] in seen:
            todo = "Give each its own; those of a grid hold its dimensions in braces, such as 'random {size}'"
            raise BadFile(f"{top.where}, {what}", f"the name {show(item['name'])} is there twice", "different names", todo)
        seen.add(item["name"])
    return tuple(found)


_FIELDS = {"worlds": "WORLD_FIELDS", "queries": "QUERY_FIELDS", "methods": "FIELDS"}


def _item(table: Table, what: str, module: ModuleType) -> dict[str, Any]:
    name = table.text("name")
    if name is None or len(name) > 200 or not name.isprintable():
        raise table.bad("name", "a text of at most 200 printable characters")
    found: dict[str, Any] = {"name": name}
    if what == "methods":
        for key, value in (("budget", _budget(table)), ("limits", _limits(table)), ("set", table.raw("set"))):
            if key in table:
                found[key] = value
        if not isinstance(found.get("set", {}), dict):
            raise table.bad("set", "a table of parameters, such as { preset = 'paper' }")
    fields = getattr(module, _FIELDS[what], None)
    allowed = table.keys if fields is None else fields
    for key in allowed:
        value = table.raw(key)
        if key in table and key not in found:
            found[key] = value
    table.done()
    return found


def _metrics(top: Table, module: ModuleType) -> tuple[Metric, ...]:
    """The measures shown first, with what ``[metric.NAME]`` says of them."""
    known: Mapping[str, Metric] = getattr(module, "METRICS", {})
    tables, names = top.table("metric"), top.raw("metrics")
    if "metrics" not in top:
        names = list(known)[:1]
    if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in cast("list[Any]", names)):
        raise top.bad("metrics", "a list of names of measures, such as ['length']")
    found: list[Metric] = []
    for name in dict.fromkeys(cast("list[str]", names)):
        table = tables.table(name) if tables is not None else None
        if name not in known and table is None:
            raise BadFile(top.at("metrics"), f"{show(name)} is not known", ", ".join(known), f"Correct it, or describe it in [metric.{word(name)}]")
        metric = known.get(name, Metric(name))
        found.append(metric if table is None else _metric(table, metric))
    if tables is not None:
        tables.done()
    return tuple(found)


def _metric(table: Table, metric: Metric) -> Metric:
    unit = _free(table, "unit") if "unit" in table else metric.unit
    lower = table.flag("lower_is_better", metric.better == "lower")
    better = metric.better if "lower_is_better" not in table else ("lower" if lower else "higher")
    digits = table.integer("digits", 0, 12, metric.digits)
    table.done()
    return Metric(metric.name, unit, better, metric.digits if digits is None else digits)


def _reference(top: Table, known: list[str]) -> str | None:
    reference = top.text("reference")
    if reference is not None and reference not in known:
        raise top.bad("reference", ", ".join(known))
    return reference


def _quick(top: Table, names: Mapping[str, list[str]]) -> dict[str, Any]:
    table = top.table("quick")
    if table is None:
        return {}
    seeds, budget, limits = _seeds(table), _budget(table), _limits(table)
    found: dict[str, Any] = {key: value for key, value in (("seeds", seeds), ("budget", budget), ("limits", limits)) if value}
    for what, known in names.items():
        kept = table.raw(what)
        if what not in table:
            continue
        if not isinstance(kept, list) or not kept or not all(isinstance(name, str) and name in known for name in cast("list[Any]", kept)):
            raise table.bad(what, f"a list of names of {what}: {show(known)[1:-1]}")
        found[what] = tuple(cast("list[str]", kept))
    table.done()
    return found
