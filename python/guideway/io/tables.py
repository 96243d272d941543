"""Checked access to the tables of a settings file: every complaint names file, table and field, the value and what is allowed."""

from __future__ import annotations

import difflib
import math
from typing import Any, cast

from guideway.errors import BadFile
from guideway.io.files import show, word
from guideway.io.types import Point

_MAX_DOTS = 200
_BREAKS = str.maketrans(dict.fromkeys("=[]{},", "\n"))

HUGE = 1e9
"""Largest coordinate that is accepted, m."""


class Table:
    """A table of a TOML or JSON file; fields are taken out one by one, and :meth:`done` refuses those that nobody asked for."""

    def __init__(self, where: str, path: str, data: object) -> None:
        """``path`` is the table's name as the file has it, for messages; ``data`` must be a mapping."""
        if not isinstance(data, dict):
            raise BadFile(f"{where}, {path}", f"{show(data)} is not a table", "a table of named fields", "Correct the field")
        self.where, self.path = where, path
        self._data = cast("dict[str, Any]", data)
        self._asked: list[str] = []

    def __contains__(self, key: str) -> bool:
        return key in self._data

    def at(self, key: str = "") -> str:
        """Where a field is, for messages."""
        table = f"{self.where}, {self.path}" if self.path else self.where
        return f"{table}, field {key if key.isidentifier() and len(key) < 60 else word(key)}" if key else table

    def bad(self, key: str, allowed: str, value: object = None) -> BadFile:
        """The complaint about a field."""
        if value is None and key not in self._data:
            others = [str(k)[:60] for k in self._data if k not in self._asked]
            near = difflib.get_close_matches(key, others[:100], 1)
            return BadFile(self.at(key), "the field is missing", allowed, f"Is {word(near[0])} meant to be it?" if near else "Add it")
        return BadFile(self.at(key), f"{show(self._data.get(key) if value is None else value)} cannot be used", allowed, "Correct the field")

    @property
    def keys(self) -> list[str]:
        """Names of the fields that are there."""
        return list(self._data)

    def raw(self, key: str) -> Any:
        """The value as parsed, or None."""
        self._asked.append(key)
        return self._data.get(key)

    def done(self) -> None:
        """Refuses fields that were not asked for."""
        unknown = [key for key in self._data if key not in self._asked]
        if unknown:
            known = list(dict.fromkeys(self._asked))
            near = difflib.get_close_matches(str(unknown[0])[:60], known, 1)
            todo = f"Did you mean {near[0]}?" if near else "Remove it or correct its name"
            raise BadFile(self.at(str(unknown[0])), "the field is not known", ", ".join(known), todo)

    def number(self, key: str, low: float, high: float, unit: str, default: float | None = None, *, above: bool = False) -> float:
        """A finite number in [low, high], or (low, high] with ``above``; required unless there is a default."""
        value = self.raw(key)
        if value is None and key not in self._data and default is not None:
            return default
        number = real(value)
        if number is None or not low <= number <= high or (above and number == low):
            raise self.bad(key, f"a number {'above' if above else 'from'} {low:g} {'and at most' if above else 'to'} {high:g} {unit}".rstrip())
        return number

    def optional(self, key: str, low: float, high: float, unit: str, *, above: bool = False) -> float | None:
        """Like :meth:`number`, None where the field is missing."""
        return self.number(key, low, high, unit, above=above) if key in self._data else self.raw(key)

    def integer(self, key: str, low: int, high: int, default: int | None = None) -> int | None:
        """A whole number in [low, high]; ``default`` where the field is missing."""
        value = self.raw(key)
        if key not in self._data:
            return default
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise self.bad(key, f"a whole number from {low} to {high}")
        return value

    def text(self, key: str, default: str | None = None) -> str | None:
        """A text of 1 to 4096 characters without NUL; ``default`` where the field is missing."""
        value = self.raw(key)
        if key not in self._data:
            return default
        if not isinstance(value, str) or not 1 <= len(value) <= 4096 or "\0" in value:
            raise self.bad(key, "a text in quotes")
        return value

    def flag(self, key: str, default: bool = False) -> bool:
        """True or false; ``default`` where the field is missing."""
        value = self.raw(key)
        if key not in self._data:
            return default
        if not isinstance(value, bool):
            raise self.bad(key, "true | false")
        return value

    def choice(self, key: str, allowed: tuple[str, ...], default: str) -> str:
        """One of ``allowed``."""
        value = self.raw(key)
        if key not in self._data:
            return default
        if not isinstance(value, str) or value not in allowed:
            raise self.bad(key, " | ".join(allowed))
        return value

    def numbers(self, key: str, counts: tuple[int, ...], shape: str) -> tuple[float, ...] | None:
        """Finite numbers of at most 1e9 in a list whose length is one of ``counts``; None where the field is missing."""
        value = self.raw(key)
        if key not in self._data:
            return None
        if not isinstance(value, list) or len(cast("list[object]", value)) not in counts:
            raise self.bad(key, shape)
        found = [real(item) for item in cast("list[object]", value)]
        if any(item is None or abs(item) > HUGE for item in found):
            raise self.bad(key, f"{shape}: finite numbers from -1e9 to 1e9")
        return tuple(item for item in found if item is not None)

    def points(self, key: str, least: int) -> tuple[Point, ...]:
        """At least ``least`` (at most 10^6) points [x, y] in m."""
        return tuple((row[0], row[1]) for row in self.rows(key, 2, "[x, y] in m", least))

    def rows(self, key: str, count: int, shape: str, least: int = 1) -> tuple[tuple[float, ...], ...]:
        """At least ``least`` (at most 10^6) lists of ``count`` finite numbers of at most 1e9."""
        value = self.raw(key)
        if not isinstance(value, list) or not least <= len(cast("list[object]", value)) <= 10**6:
            raise self.bad(key, f"a list of at least {least} entries {shape}")
        return tuple(self._row(f"{self.at(key)}, entry {i + 1}", item, count, shape) for i, item in enumerate(cast("list[object]", value)))

    def _row(self, at: str, item: object, count: int, shape: str) -> tuple[float, ...]:
        found = [real(v) for v in cast("list[object]", item)] if isinstance(item, list) else []
        kept = tuple(v for v in found if v is not None and abs(v) <= HUGE)
        if len(found) != count or len(kept) != count:
            raise BadFile(at, f"{show(item)} cannot be used", f"{shape}: finite numbers from -1e9 to 1e9", "Correct it")
        return kept

    def table(self, key: str) -> Table | None:
        """A table inside this one, None where missing."""
        value = self.raw(key)
        if key not in self._data:
            return None
        return Table(self.where, f"{self.path}.{key}" if self.path else f"[{key}]", value)

    def tables(self, key: str) -> list[Table]:
        """A list of tables (``[[key]]``), empty where missing; they are counted from 1 in messages."""
        value = self.raw(key)
        if key not in self._data:
            return []
        if not isinstance(value, list) or len(cast("list[object]", value)) > 10**6:
            raise self.bad(key, f"tables headed [[{key}]]")
        return [Table(self.where, f"[[{key}]] number {i + 1}", item) for i, item in enumerate(cast("list[object]", value))]


def real(value: object) -> float | None:
    """A finite number as float, else None; booleans are no numbers."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def parse_toml(where: str, text: str) -> dict[str, object]:
    """TOML text as nested plain data; raises :class:`BadFile` naming the line where the parser tells it."""
    import importlib
    import sys

    from guideway.io.files import guard

    tomllib: Any = importlib.import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")
    if max(part.count(".") for part in text.translate(_BREAKS).split("\n")) > _MAX_DOTS:
        # the parser takes time that grows with the square of the parts of a dotted key
        raise BadFile(where, "a key has too many parts", f"at most {_MAX_DOTS} dots", "Simplify the file")
    with guard(where):
        try:
            return tomllib.loads(text)
        except tomllib.TOMLDecodeError as e:
            raise BadFile(where, f"this is not valid TOML: {word(e, 100)}", todo="Correct the line") from e


def parse_csv(where: str, text: str, columns: tuple[str, ...], limit: int = 10**6) -> list[tuple[float, ...]]:
    """Rows of finite numbers under a header that names exactly ``columns`` in order; blank lines are skipped, at most ``limit`` rows."""
    rows: list[tuple[float, ...]] = []
    header: list[str] | None = None
    for number, line in enumerate(text.split("\n"), 1):
        words = [word.strip() for word in line.split(",")]
        if words == [""]:
            continue
        if header is None:
            header = words
            if tuple(words) != columns:
                raise BadFile(f"{where}, line {number}", f"the header is {show(','.join(words))}", ",".join(columns), "Correct the first line")
            continue
        rows.append(_csv_row(f"{where}, line {number}", words, columns))
        if len(rows) > limit:
            raise BadFile(where, f"there are more than {limit} rows", f"at most {limit}", "Use fewer rows")
    if header is None or not rows:
        raise BadFile(where, "there are no rows", f"the header {','.join(columns)} and at least one row of numbers", "Add them")
    return rows


def _csv_row(at: str, words: list[str], columns: tuple[str, ...]) -> tuple[float, ...]:
    if len(words) != len(columns):
        raise BadFile(at, f"the row has {len(words)} columns", f"{len(columns)}: {','.join(columns)}", "Correct the row")
    row: list[float] = []
    for column, cell in zip(columns, words, strict=True):
        try:
            value = float(cell) if "_" not in cell else math.nan
        except ValueError:
            value = math.nan
        if not abs(value) <= HUGE:
            raise BadFile(f"{at}, field {column}", f"{show(cell)} cannot be used", "a finite number from -1e9 to 1e9", "Correct the row")
        row.append(value)
    return tuple(row)
