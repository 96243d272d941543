"""The folder of an experiment's records: one coordinator at a time, and a copy of the file beside the records."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator
from pathlib import Path

from guideway.errors import BadFile, BadParameter
from guideway.files import write_whole
from guideway.io import files
from guideway.lab.experiment import Experiment
from guideway.lab.journal import Journal, key_of

_RAN = "ran = "


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Holds the folder; raises :class:`BadParameter` if another program does. The system lets go of it however this program ends."""
    import fcntl

    where = files.name(folder)
    with files.guard(where, "the folder of results"):
        folder.mkdir(parents=True, exist_ok=True)
        file = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise BadParameter(f"another 'guideway lab' is at work in {where}: wait for it, or choose another folder with --out") from None
        except OSError as error:
            raise BadFile(where, f"the folder cannot be locked ({error.strerror})", "", "Choose a folder on a local disk with --out") from error
        yield
    finally:
        os.close(file)


def opened(experiment: Experiment, folder: Path, resume: bool) -> Journal:
    """The journal of an experiment. Raises :class:`BadParameter` if it has records and they may not be added to."""
    path = folder / f"{experiment.name}.jsonl"
    journal = Journal(path)
    try:
        _agrees(experiment, journal, resume)
        _copy(experiment, folder)
    except BaseException:
        journal.close()
        raise
    return journal


def _agrees(experiment: Experiment, journal: Journal, resume: bool) -> None:
    where, records = files.name(journal.path), journal.records
    if records and not resume:
        raise BadParameter(f"{where} already holds {len(records)} records: go on with --resume, or choose another folder with --out")
    if any(record.get("digest") != experiment.digest for record in records):
        what = "its records are of another version of the experiment (other worlds, queries, methods, budget or limits"
        more = ", or one of them with --quick)"
        raise BadParameter(f"{where}: {what}{more}: choose another folder with --out, or put the file back as it was")
    if len({key_of(record) for record in records}) < len(records):
        raise BadFile(where, "a run has two records", "one record for each world, query, method and seed", "Remove one of them")


def _copy(experiment: Experiment, folder: Path) -> None:
    """The experiment's file beside its records, with what was run of it and where its files are."""
    text = files.load(experiment.path).text()
    if text.startswith(_RAN):  # a copy itself
        text = text.partition("\n")[2]
    quick = str(experiment.reduced).lower()
    ran = f"{_RAN}{{ folder = {json.dumps(experiment.folder, ensure_ascii=False)}, quick = {quick}, seeds = {list(experiment.seeds)} }}\n"
    with files.guard(files.name(folder), "the folder of results"):
        write_whole(folder / f"{experiment.name}.toml", ran + text)
