"""Experiments and their records in a folder."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

from guideway.errors import BadFile
from guideway.lab import journal
from guideway.lab.cells import Grid, grid
from guideway.lab.experiment import Experiment
from guideway.lab.journal import Record
from guideway.lab.reading import read


@dataclass
class Loaded:
    """An experiment with its records and the text of its file."""

    experiment: Experiment
    records: list[Record]
    text: str = ""
    grid: Grid = field(init=False)

    def __post_init__(self) -> None:
        self.grid = grid(self.experiment, self.records)


def load(folder: str | os.PathLike[str]) -> list[Loaded]:
    """All experiments of a folder that have records, by name.

    Raises :class:`BadFile` where there are none, where records lack their experiment, or where a file cannot be read.
    """
    place = Path(folder)
    if not place.is_dir():
        raise BadFile(os.fspath(folder), "there is no such folder", "a folder with the records of guideway lab run", "Run an experiment first")
    found = []
    for path in sorted(place.glob("*.jsonl")):
        spec = path.with_suffix(".toml")
        if not spec.is_file():
            raise BadFile(
                str(path), f"its experiment {spec.name} is not beside it", "NAME.toml with NAME.jsonl", "Copy it there, or move the records away"
            )
        records = [_printable(record) for record in journal.read(path)]
        if records:
            found.append(Loaded(read(spec, check=False), records, spec.read_text("utf-8", errors="replace")))
    if not found:
        todo = "Run one first: guideway lab run NAME --out FOLDER"
        raise BadFile(os.fspath(folder), "there are no records of experiments in it", "NAME.toml with NAME.jsonl", todo)
    return found


def _printable(record: Record) -> Record:
    """A record whose error can be written as UTF-8, whatever the method said."""
    error = record.get("error")
    if not isinstance(error, dict):
        return record
    return record | {"error": {str(key): str(value).encode("utf-8", "replace").decode() for key, value in error.items()}}
