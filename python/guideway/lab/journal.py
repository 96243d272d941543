"""The records of an experiment: one JSON object per line, whole after any crash."""

from __future__ import annotations

import contextlib
import json
import os
import time
from pathlib import Path
from types import TracebackType
from typing import Any

from guideway.errors import BadFile, GuidewayError
from guideway.io import files

SCHEMA = 1
"""Version of the record."""

STATUSES = ("ok", "failed", "invalid", "timeout", "memory", "crashed")

GROUP = 1.0
"""Records reach the disk at least this often, s; what a killed program wrote is there anyway."""

Record = dict[str, Any]


class DiskFull(GuidewayError):
    """The records cannot be written on; those before are whole."""


def key_of(record: Record) -> tuple[str, str, str, int]:
    """World, query, method and seed of a record."""
    return record["world"], record["query"], record["method"], record["seed"]


def read(path: str | os.PathLike[str]) -> list[Record]:
    """The records of a file, in the order they were written; a last line that was cut off does not count, a missing file has none.

    Raises :class:`BadFile` for any other line that is not a record.
    """
    return _read(path)[0]


def _read(path: str | os.PathLike[str]) -> tuple[list[Record], int]:
    """The records, and how many bytes they take."""
    where, records, size = files.name(path), [], 0
    if not os.path.exists(path):
        return [], 0
    with files.guard(where), open(path, "rb") as file:
        for number, line in enumerate(file, 1):
            record = _record(line)
            if record is None:
                if line.endswith(b"\n") and (_is_json(line) or file.read(1)):
                    raise BadFile(f"{where}, line {number}", "it is not a record of the lab", todo="Remove the line; --resume runs it again")
                break
            records.append(record)
            size += len(line)
    return records, size


def _is_json(line: bytes) -> bool:
    """Was it written whole, by whomever?"""
    try:
        json.loads(line)
    except (ValueError, RecursionError):
        return False
    return True


def _record(line: bytes) -> Record | None:
    if not line.endswith(b"\n"):
        return None
    try:
        record = json.loads(line)
        if record["schema"] != SCHEMA or record["status"] not in STATUSES:
            return None
        key_of(record)
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    return record


def line_of(record: Record) -> bytes:
    """A record as it stands in the file."""
    return json.dumps(record, allow_nan=False, separators=(",", ":")).encode() + b"\n"


class Journal:
    """Appends records to a file. What was there is in ``records``; a torn last line is dropped."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Opens the file. Raises :class:`BadFile` if it holds something else or cannot be written."""
        self.path = Path(path)
        self.records, self._size = _read(path)
        with files.guard(files.name(path), "the file of records"):
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0), 0o666)
            os.ftruncate(self._file, self._size)
            os.lseek(self._file, self._size, os.SEEK_SET)
        self._synced = time.monotonic()

    def append(self, record: Record) -> None:
        """Writes a record, whole or not at all. Raises :class:`DiskFull` where that does not work."""
        line, done = line_of(record), 0
        try:
            while done < len(line):
                done += os.write(self._file, line[done:])
            now = time.monotonic()
            if now - self._synced >= GROUP:
                self._synced = now
                os.fsync(self._file)
        except OSError as error:
            self._back(error)
        self._size += len(line)

    def _back(self, error: OSError) -> None:
        """Takes a half-written record off again."""
        with contextlib.suppress(OSError):
            os.ftruncate(self._file, self._size)
            os.lseek(self._file, self._size, os.SEEK_SET)
        what = f"the records cannot be written on ({(error.strerror or str(error)).lower()}); all that were written are whole"
        raise DiskFull(f"{files.name(self.path)}: {what}. Free space on the disk, then go on with --resume.") from error

    def close(self) -> None:
        """Brings all records to the disk."""
        if self._file >= 0:
            with contextlib.suppress(OSError):
                os.fsync(self._file)
            os.close(self._file)
            self._file = -1

    def __enter__(self) -> Journal:
        """Closes itself at the end of a ``with``."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Closes."""
        self.close()
