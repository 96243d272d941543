"""A whole experiment: what is left to do, done, and every record kept."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from typing import Any

from guideway.errors import BadParameter
from guideway.lab.cluster import Cluster
from guideway.lab.experiment import Experiment
from guideway.lab.folder import locked, opened
from guideway.lab.journal import Record, key_of
from guideway.lab.pool import Local


def run(
    experiment: Experiment,
    out: str | os.PathLike[str],
    *,
    workers: int | None = None,
    cluster: str | None = None,
    resume: bool = False,
    progress: bool | None = None,
) -> Counter[str]:
    """Runs an experiment into ``out/NAME.jsonl``; returns how many records of it have which status.

    ``workers``: processes on this machine, as many as it has cores where None. ``cluster``: ``dask://host:port``, or ``local`` or ``local:N`` for a
    small one here. ``resume`` goes on where an earlier call stopped. ``progress`` shows a bar on stderr; None: if that is a terminal.
    """
    folder = Path(out)
    with closing(crew_of(workers, cluster)) as crew, locked(folder), opened(experiment, folder, resume) as journal:
        have = {key_of(record) for record in journal.records}
        runs = experiment.runs()
        todo = [one for one in runs if one.key not in have]
        tally = Counter(record["status"] for record in journal.records)
        with (
            closing(crew.records(todo, experiment.digest)) as records,
            bar_of(experiment.name, len(runs), len(runs) - len(todo), progress) as bar,
        ):
            for record in records:
                journal.append(record)
                tally[record["status"]] += 1
                bar.update()
    return tally


def crew_of(workers: int | None, cluster: str | None) -> Local | Cluster:
    """Those who do the work: processes on this machine, or a cluster; to be closed."""
    if cluster is None:
        return Local(_workers(workers))
    if workers is not None:
        raise BadParameter("--workers is for this machine: leave it out with --cluster (local:N starts a cluster of N)")
    return Cluster(cluster)


def _workers(workers: int | None) -> int:
    if workers is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not 1 <= workers <= 1024:
        raise BadParameter(f"--workers {workers} is out of range: 1 to 1024")
    return workers


def bar_of(name: str, total: int, done: int, progress: bool | None) -> Any:
    """A progress bar on stderr with the time left; ``progress`` None: if that is a terminal."""
    from tqdm import tqdm

    return tqdm(total=total, initial=done, desc=name, unit="run", smoothing=0.05, disable=None if progress is None else not progress)


def told(tally: Counter[str]) -> str:
    """The tally in words."""
    rest = [f"{tally[status]} {status}" for status in sorted(tally) if status != "ok" and tally[status]]
    count = sum(tally.values())
    return f"{count} record{'s' * (count != 1)}, " + ", ".join([f"{tally['ok']} ok", *rest])


def troubles(records: Iterable[Record], most: int = 5) -> list[str]:
    """Why runs have no result: a line for each method and reason, the most frequent first."""
    found: Counter[tuple[str, str, str]] = Counter()
    for record in records:
        if record["status"] != "ok":
            error = record["error"] or {}
            found[record["method"], record["status"], f"{error.get('type', '')}: {error.get('message', '')}"[:300]] += 1
    lines = [f"{method}: {count} {status}, {said}" for (method, status, said), count in found.most_common(most)]
    return [*lines, *([f"and {len(found) - most} other reasons"] if len(found) > most else [])]
