"""Maps and scenarios made of lines: Moving AI ``.map`` and ``.scen``, text grids.

Moving AI [sturtevant2012]: ``.``, ``G`` and ``S`` (ground, swamp) are free for a
ground robot; ``@``, ``O``, ``T`` and ``W`` (outside, trees, water) block. Resolution 1 m, origin (0, 0) at the lower-left corner of the lower-left
cell.
"""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from guideway.errors import BadFile
from guideway.io.files import MAX_TEXT, Blob, load, name, show
from guideway.io.types import MAX_CELLS, GridMap

if TYPE_CHECKING:
    from guideway.io.types import BoolGrid

_OCTILE = {".": False, "G": False, "S": False, "@": True, "O": True, "T": True, "W": True}
_TEXT = {".": False, "#": True}
_HEAD = 4096
_MAX_ROWS = 1 << 22


@dataclass(frozen=True)
class ScenarioRow:
    """A query of a Moving AI scenario: cells ``(column, row)`` with row 0 at the top, ``length`` the published optimum in cells, ``line`` from 1.

    The cells may lie outside the map or be blocked: that is for the planner to say, row by row.
    """

    map: str
    width: int
    height: int
    start: tuple[int, int]
    goal: tuple[int, int]
    length: float
    bucket: int
    line: int


def load_moving_ai(path: str | os.PathLike[str]) -> GridMap:
    """Loads a Moving AI ``.map`` (or ``.map.gz``); raises :class:`BadFile` naming file and line."""
    blob = load(path)
    where = name(blob.path)
    width, height, start = _octile_header(blob, where)
    # every row may end in two characters, and a few blank lines may follow
    limit = start + height * (width + 2) + 4096
    rows = _lines(where, blob.data(limit)[start:])
    return _grid(blob, rows, (width, height), _OCTILE, "moving_ai", 5)


def load_text(path: str | os.PathLike[str]) -> GridMap:
    """Loads rows of ``.`` (free) and ``#`` (blocked), top row first; resolution 1 m, origin (0, 0); blank lines at the ends are dropped."""
    blob = load(path)
    rows = _lines(name(blob.path), blob.data(2 * MAX_CELLS))
    skipped = next((i for i, row in enumerate(rows) if row.strip()), len(rows))
    rows = rows[skipped:]
    if not rows:
        raise BadFile(name(blob.path), "there are no rows", "rows of . (free) and # (blocked)", "Write at least one")
    return _grid(blob, rows, (len(rows[0]), len(rows)), _TEXT, "text", skipped + 1)


def _lines(where: str, data: bytes) -> list[bytes]:
    """Lines without their ends; blank lines at the end are dropped."""
    if data.count(b"\n") > _MAX_ROWS:
        raise BadFile(where, f"there are more than {_MAX_ROWS} lines", f"at most {_MAX_ROWS}", "Use a smaller map")
    rows = [row[:-1] if row.endswith(b"\r") else row for row in data.split(b"\n")]
    while rows and not rows[-1].strip():
        rows.pop()
    return rows


def _octile_header(blob: Blob, where: str) -> tuple[int, int, int]:
    """Width, height, and where the rows start, in bytes."""
    head = blob.head(_HEAD)
    head = head[3:] if (mark := head.startswith(b"\xef\xbb\xbf")) else head
    sizes: dict[bytes, int] = {}
    position = 0
    for number in range(1, 9):
        end = head.find(b"\n", position)
        end = len(head) if end < 0 else end
        words = head[position:end].split()
        position = end + 1
        if words == [b"map"]:
            break
        at = f"{where}, line {number}"
        if words[:1] == [b"type"] and number == 1:
            if words[1:] != [b"octile"]:
                raise BadFile(at, f"the type is {show(b' '.join(words[1:]).decode('latin-1'))}", "type octile", "Use a grid map")
        elif len(words) == 2 and words[0] in (b"height", b"width") and words[0] not in sizes and number > 1:
            sizes[words[0]] = _size(at, words[0].decode(), words[1])
        else:
            raise BadFile(at, f"{show(b' '.join(words).decode('latin-1'))} is not a header line", "type octile, height H, width W, map", "Correct it")
    if len(sizes) < 2 or position > len(head):
        raise BadFile(where, "the header is incomplete", "the lines type octile, height H, width W, map", "Copy the file again")
    width, height = sizes[b"width"], sizes[b"height"]
    if width * height > MAX_CELLS:
        raise BadFile(where, f"the header says {width} x {height} cells", f"1 to {MAX_CELLS} cells in all", "Use a smaller map")
    return width, height, position + (3 if mark else 0)


def _size(at: str, field: str, word: bytes) -> int:
    allowed = f"a whole number from 1 to {MAX_CELLS}"
    if not word.isdigit() or len(word) > 12 or not 1 <= int(word) <= MAX_CELLS:
        raise BadFile(f"{at}, field {field}", f"{show(word.decode('latin-1'))} cannot be used", allowed, "Correct the line")
    return int(word)


def _grid(blob: Blob, rows: list[bytes], size: tuple[int, int], kinds: dict[str, bool], kind: str, first: int) -> GridMap:
    """Rows of characters as a map; ``first`` is the line number of the first row, for messages."""
    width, height = size
    where = name(blob.path)
    if len(rows) != height:
        raise BadFile(where, f"there are {len(rows)} rows", f"{height} rows, as the header says", "Copy the file again")
    if width < 1 or width * height > MAX_CELLS:
        raise BadFile(where, f"there are {width} x {height} cells", f"1 to {MAX_CELLS} cells in all", "Use a smaller map")
    for i, row in enumerate(rows):
        if len(row) != width:
            raise BadFile(f"{where}, line {first + i}", f"the row has {len(row)} characters", f"{width}, as the other rows", "Correct the row")
    return GridMap(
        blocked=_cells(b"".join(rows), size, kinds, (where, first)),
        unknown=None,
        resolution=1.0,
        origin=(0.0, 0.0, 0.0),
        source=blob.path,
        sha256=blob.sha256,
        files={blob.path.name: blob.sha256},
        kind=kind,
    )


def _cells(data: bytes, size: tuple[int, int], kinds: dict[str, bool], place: tuple[str, int]) -> BoolGrid:
    import numpy as np

    table = bytearray(b"\x02" * 256)
    for character, blocks in kinds.items():
        table[ord(character)] = blocks
    mapped = bytearray(data).translate(bytes(table))
    bad = mapped.find(2)
    if bad >= 0:
        (where, first), (width, _) = place, size
        at = f"{where}, line {first + bad // width}, column {bad % width + 1}"
        raise BadFile(at, f"the character {show(chr(data[bad]))} is not a kind of cell", f"one of {' '.join(kinds)}", "Correct the row")
    return np.frombuffer(mapped, np.bool_).reshape(size[1], size[0])


def load_scenario(path: str | os.PathLike[str]) -> list[ScenarioRow]:
    """Loads a Moving AI ``.scen`` (or ``.scen.gz``): words separated by tabs or spaces, ``version 1`` or ``1.0``, blank lines skipped.

    Raises :class:`BadFile` naming file and line.
    """
    blob = load(path)
    where = name(blob.path)
    rows: list[ScenarioRow] = []
    seen_version = False
    for number, line in enumerate(blob.text(8 * MAX_TEXT).split("\n"), 1):
        words = line.split()
        if not words:
            continue
        if not seen_version:
            if len(words) != 2 or words[0] != "version" or words[1] not in ("1", "1.0"):
                raise BadFile(f"{where}, line {number}", f"{show(line)} is not the version", "version 1 or version 1.0", "Name a scenario file")
            seen_version = True
            continue
        rows.append(_row(f"{where}, line {number}", number, line))
    if not seen_version:
        raise BadFile(where, "the file has no lines", "version 1 and a query a line", "Copy the file again")
    return rows


_TABBED = re.compile(r"\t+ *")


def _row(at: str, number: int, line: str) -> ScenarioRow:
    # a map name may hold spaces where the columns are separated by tabs
    words = _TABBED.split(line.strip()) if line.count("\t") >= 8 else line.split()
    if len(words) != 9:
        columns = "9: bucket, map, width, height, start x, start y, goal x, goal y, length"
        raise BadFile(at, f"the row has {len(words)} columns", columns, "Correct the row")
    names = ["bucket", "width", "height", "start x", "start y", "goal x", "goal y"]
    bucket, width, height, *cells = (_whole(at, field, word) for field, word in zip(names, [words[0], *words[2:8]], strict=True))
    try:
        length = float(words[8])
    except ValueError:
        length = math.nan
    if not 0 <= length < 1e12:
        raise BadFile(f"{at}, field length", f"{show(words[8])} cannot be used", "a finite number from 0", "Correct the row")
    return ScenarioRow(words[1], width, height, (cells[0], cells[1]), (cells[2], cells[3]), length, bucket, number)


def _whole(at: str, field: str, word: str) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 10):
        raise BadFile(f"{at}, field {field}", f"{show(word)} cannot be used", "a whole number from 0 to 999999999", "Correct the row")
    return int(word)
