"""Parameters of a method from trials: Optuna proposes, equal worlds and seeds judge, seeds that no trial has seen decide.

Every run of every trial is a record in ``NAME.tune.jsonl``. What Optuna proposes depends on the trials before alone, so a search that was stopped is
gone through again from its records, and goes on.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from guideway import _core
from guideway.errors import BadParameter, GuidewayError
from guideway.files import write_whole
from guideway.io import files
from guideway.io.export import toml_table
from guideway.lab.cells import value_of
from guideway.lab.coordinator import bar_of, crew_of
from guideway.lab.experiment import Experiment, Key, Run
from guideway.lab.extra import needed
from guideway.lab.folder import locked
from guideway.lab.journal import Journal, Record, key_of
from guideway.lab.space import Dimension, Tune

BATCH = 4
"""Trials that are proposed together; their number does not depend on that of the workers, so neither do the results."""

FAILURE = 1e9
"""What the share of failed runs weighs: any failure outweighs every measure."""


@dataclass(frozen=True)
class Trial:
    """Parameters, and what their runs gave."""

    set: Mapping[str, Any]
    name: str
    failed: int = 0
    value: float | None = None
    """Mean of the measure over the runs that succeeded."""
    score: float = math.inf
    """What is minimised."""


@dataclass
class Search:
    """The runs of a search: those that there are, and how others are made."""

    experiment: Experiment
    tune: Tune
    base: Mapping[str, Any]
    journal: Journal
    crew: Any
    update: Callable[[int], Any]
    digest: str
    have: dict[Key, Record] = field(default_factory=dict[Key, Record])

    def runs(self, method: Mapping[str, Any], worlds: Sequence[str], seeds: Sequence[int]) -> list[Run]:
        """The runs of a method on the worlds of a group."""
        found = [world for world in self.experiment.worlds if world["name"] in worlds]
        return [self.experiment.run(world, query, method, seed) for world in found for query in self.experiment.queries for seed in seeds]

    def done(self, runs: Sequence[Run]) -> None:
        """Runs what has no record yet."""
        todo = list({run.key: run for run in runs if run.key not in self.have}.values())
        self.update(len(runs) - len(todo))
        with closing(self.crew.records(todo, self.digest)) as records:
            for record in records:
                self.journal.append(record)
                self.have[key_of(record)] = record
                self.update(1)

    def judged(self, trials: Sequence[Trial], worlds: Sequence[str], seeds: Sequence[int]) -> list[tuple[Trial, list[Record]]]:
        """Trials with their values, and the records behind them."""
        runs = [self.runs({**self.base, "name": trial.name, "set": dict(trial.set)}, worlds, seeds) for trial in trials]
        self.done([run for some in runs for run in some])
        found = [[self.have[run.key] for run in some] for some in runs]
        return [(self._valued(trial, records), records) for trial, records in zip(trials, found, strict=True)]

    def _valued(self, trial: Trial, records: Sequence[Record]) -> Trial:
        values = [value for value in self.values(records) if value is not None]
        failed = len(records) - len(values)
        value = math.fsum(values) / len(values) if values else None
        sign = 1 if self.lower else -1
        return replace(trial, failed=failed, value=value, score=FAILURE * failed / len(records) + sign * (value or 0.0))

    def values(self, records: Sequence[Record]) -> list[float | None]:
        """The measure of each run, None for those that failed."""
        return [value_of(record, self.tune.metric) if record["status"] == "ok" else None for record in records]

    @property
    def lower(self) -> bool:
        """Is less better?"""
        metric = next((metric for metric in self.experiment.metrics if metric.name == self.tune.metric), None)
        if metric is None:
            from guideway.lab import kinds

            metric = kinds.load(self.experiment.kind).METRICS[self.tune.metric]
        return metric.better != "higher"


def tune(
    experiment: Experiment,
    out: str | os.PathLike[str],
    *,
    trials: int | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    resume: bool = False,
    progress: bool | None = None,
) -> dict[str, Any]:
    """Seeks the parameters that ``[tune]`` of an experiment asks for and returns what was found, with the evidence.

    It is written to ``out/NAME.tuned.json`` and ``.toml`` too. ``trials`` instead of those of the file; the others as for :func:`guideway.lab.run`.
    """
    asked = experiment.tune
    if asked is None:
        raise BadParameter(f"{files.name(experiment.path)} has no table [tune]: it says which parameters are sought, see docs/lab.md")
    asked = replace(asked, trials=trials or asked.trials)
    optuna = needed("optuna", "tune", "tuning needs Optuna")
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    folder = Path(out)
    digest = hashlib.sha256(json.dumps([experiment.digest, asked.method, asked.metric], default=str).encode()).hexdigest()
    base = next(method for method in experiment.methods if method["name"] == asked.method)
    with closing(crew_of(workers, cluster)) as crew, locked(folder), Journal(folder / f"{experiment.name}.tune.jsonl") as journal:
        _agrees(journal, digest, resume)
        instances = [len(worlds) * len(experiment.queries) for worlds in asked.groups.values()]
        total = sum(instances) * (asked.trials * asked.seeds + 2 * asked.check)
        with bar_of(f"{experiment.name}, tuning", total, 0, progress) as bar:
            have = {key_of(record): record for record in journal.records}
            search = Search(experiment, asked, base, journal, crew, bar.update, digest, have)
            groups = [_group(optuna, search, name, worlds) for name, worlds in asked.groups.items()]
    found = {
        "schema": 1,
        "experiment": experiment.name,
        "guideway": _core.__version__,
        "method": asked.method,
        "metric": asked.metric,
        "groups": groups,
    }
    _written(folder / f"{experiment.name}.tuned", found)
    return found


def _agrees(journal: Journal, digest: str, resume: bool) -> None:
    where = files.name(journal.path)
    if journal.records and not resume:
        raise BadParameter(f"{where} already holds {len(journal.records)} records: go on with --resume, or choose another folder with --out")
    if any(record.get("digest") != digest for record in journal.records):
        raise BadParameter(f"{where}: its records are of another version of the experiment: choose another folder with --out")


def _group(optuna: Any, search: Search, group: str, worlds: Sequence[str]) -> dict[str, Any]:
    """The search for one group of worlds, and its check."""
    asked, seeds = search.tune, range(search.tune.seeds)
    ranges = {dimension.name: _range(optuna, dimension) for dimension in asked.space}
    study = optuna.create_study(direction="minimize")
    first = _trial(group, 0, search.base.get("set", {}))
    trials = [search.judged([first], worlds, seeds)[0][0]]
    _tell_first(optuna, study, search.base, ranges, trials[0].score)
    while len(trials) < asked.trials:
        proposed: list[tuple[Any, Trial]] = []
        for number in range(len(trials), min(asked.trials, len(trials) + BATCH)):
            study.sampler = optuna.samplers.TPESampler(seed=number, constant_liar=True)
            ask = study.ask(fixed_distributions=ranges)
            proposed.append((ask, _trial(group, number, {**search.base.get("set", {}), **ask.params})))
        judged = search.judged([trial for _, trial in proposed], worlds, seeds)
        for (ask, _), (trial, _) in zip(proposed, judged, strict=True):
            study.tell(ask, trial.score)
            trials.append(trial)
    best = min(trials, key=lambda trial: trial.score)
    checked = _checked(search, trials[0], best, worlds)
    plain = [{"set": dict(t.set), "value": t.value, "failed": t.failed} for t in trials]
    chosen = best if checked["recommended"] == "tuned" else trials[0]
    return {"group": group, "worlds": list(worlds), "set": dict(chosen.set)} | checked | {"best": plain[trials.index(best)], "trials": plain}


def _trial(group: str, number: int, settings: Mapping[str, Any]) -> Trial:
    """Its name tells parameters apart, so that records of others are never taken for its own."""
    mark = hashlib.sha256(json.dumps(settings, sort_keys=True, default=str).encode()).hexdigest()[:8]
    return Trial(settings, f"{group} {number} {mark}")


def _range(optuna: Any, of: Dimension) -> Any:
    kinds = optuna.distributions
    if of.among:
        return kinds.CategoricalDistribution(of.among)
    if isinstance(of.low, int) and isinstance(of.high, int):
        return kinds.IntDistribution(of.low, of.high, log=of.log, step=int(of.step or 1))
    return kinds.FloatDistribution(of.low, of.high, log=of.log, step=of.step)


def _tell_first(optuna: Any, study: Any, base: Mapping[str, Any], ranges: Mapping[str, Any], score: float) -> None:
    """Lets Optuna know what the parameters as they are gave, where they lie in the space."""
    try:
        known: Mapping[str, Any] = _core.parameters(base["planner"], dict(base.get("set", {})) or None)
    except (GuidewayError, KeyError):
        known = base.get("set", {})
    if not all(name in known for name in ranges):
        return
    try:
        study.add_trial(optuna.trial.create_trial(params={name: known[name] for name in ranges}, distributions=dict(ranges), value=score))
    except (ValueError, TypeError):
        return  # outside of the space


def _checked(search: Search, first: Trial, best: Trial, worlds: Sequence[str]) -> dict[str, Any]:
    """The best against what was there, on seeds that no trial has seen."""
    from guideway.lab.statistics import paired

    asked = search.tune
    seeds = range(asked.seeds, asked.seeds + asked.check)
    (before, old), (after, new) = search.judged([first, best], worlds, seeds)
    test = paired(search.values(new), search.values(old), search.lower)
    better = after.failed < before.failed or (
        after.failed == before.failed and test.wins > test.losses and test.p is not None and test.p < 0.05  # the level of the claims
    )
    evidence = {"seeds": list(seeds), "runs": len(old), "before": before.value, "after": after.value}
    evidence |= {"failed_before": before.failed, "failed_after": after.failed}
    evidence |= {"better": test.wins, "worse": test.losses, "p": test.p, "a12": test.a12}
    return {"recommended": "tuned" if better else "as it was", "evidence": evidence}


def _written(path: Path, found: Mapping[str, Any]) -> None:
    head = {key: value for key, value in found.items() if key != "groups"}
    parts = [toml_table("# written by guideway lab tune", head)]
    for group in found["groups"]:
        kept = {key: value for key, value in group.items() if key not in ("trials", "best")}
        kept["evidence"] = {key: value for key, value in group["evidence"].items() if value is not None}
        parts.append(toml_table("[[tuned]]", kept))
    with files.guard(files.name(path), "the result of the tuning"):
        write_whole(f"{path}.json", json.dumps(found, indent=1, allow_nan=False) + "\n")
        write_whole(f"{path}.toml", "\n".join(parts))
