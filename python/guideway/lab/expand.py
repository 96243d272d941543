"""Grids and ablations: one table of an experiment file becomes many."""

from __future__ import annotations

import copy
import itertools
import math
import re
from collections.abc import Collection, Iterator
from typing import Any, cast

from guideway.errors import BadFile
from guideway.io.files import show, word

MOST = 100_000
"""Most runs of an experiment, and most tables of a grid."""

_PLACE = re.compile(r"\{(\w*)\}")
_KEY = re.compile(r"\w+(\.\w+)?")


def expanded(at: str, table: dict[str, Any], fields: Collection[str] | None = None) -> list[dict[str, Any]]:
    """The tables that one with ``each`` and ``ablate`` stands for; ``at`` says where it is, for messages.

    Every list under ``each`` is a dimension; a value goes into the field of its name (``set.rho``: into ``set``) and, as ``{rho}``, into every text.
    A dimension that is not one of the ``fields`` must be in a text beside the name; where the fields are not known it goes into texts or a field.
    ``ablate`` names switches under ``set``: all on, each one off, all off; ``{off}`` is empty, "without NAME" and "plain".
    """
    plain = {key: value for key, value in table.items() if key not in ("each", "ablate")}
    dimensions = _dimensions(at, table["each"]) if "each" in table else {}
    switches = _switches(at, table["ablate"]) if "ablate" in table else []
    count = math.prod(len(values) for values in dimensions.values()) * max(1, len(switches))
    if count > MOST:
        raise BadFile(f"{at}, field each", f"the grid has {count} tables", f"at most {MOST}", "Use fewer values or dimensions")
    if not dimensions and not switches:
        return [plain]
    told = set(_PLACE.findall(repr({key: value for key, value in plain.items() if key != "name"})))
    into = [key for key in dimensions if "." in key or (key not in plain and (key not in told if fields is None else key in fields))]
    lost = next((key for key in dimensions if key not in into and key not in told), None)
    if lost is not None:
        allowed = ", ".join(fields or ())
        raise BadFile(
            f"{at}, field each", f"the dimension {word(lost)} is no field", allowed, f"Correct its name, or put {{{word(lost)}}} into a text"
        )
    return [_one(at, plain, (cell, into), off) for cell in _cells(dimensions) for off in switches or [None]]


def _dimensions(at: str, each: object) -> dict[str, list[Any]]:
    at = f"{at}, field each"
    if not isinstance(each, dict) or not each:
        raise BadFile(at, f"{show(each)} cannot be used", "a table of lists, such as { size = [20, 30] }", "Correct the field")
    found: dict[str, list[Any]] = {}
    for key, values in cast("dict[str, Any]", each).items():
        if not _KEY.fullmatch(key) or key in ("name", "each", "ablate"):
            raise BadFile(at, f"{word(key)} cannot be a dimension", "the name of a field, or set.NAME", "Correct its name")
        if not isinstance(values, list) or not values or not all(isinstance(v, (str, bool, int, float)) for v in cast("list[Any]", values)):
            raise BadFile(f"{at}, {word(key)}", f"{show(values)} cannot be used", "a list of numbers, texts or true and false", "Correct the list")
        found[key] = cast("list[Any]", values)
    names = [key.split(".")[-1] for key in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise BadFile(at, f"two dimensions end in {word(twice)}", "one of a name", "Leave one out")
    return found


def _cells(dimensions: dict[str, list[Any]]) -> Iterator[dict[str, Any]]:
    for values in itertools.product(*dimensions.values()):
        yield dict(zip(dimensions, values, strict=True))


def _switches(at: str, ablate: object) -> list[tuple[str, dict[str, bool]]]:
    """What ``{off}`` says and the switches, for every version."""
    names = cast("list[str]", ablate) if isinstance(ablate, list) else []
    if not 1 <= len(names) <= 64 or not all(isinstance(name, str) and name for name in names) or len(set(names)) < len(names):
        allowed = "a list of different switches of the method, such as ['o1', 'o2']"
        raise BadFile(f"{at}, field ablate", f"{show(ablate)} cannot be used", allowed, "Correct the list")
    on = dict.fromkeys(names, True)
    versions = [("", on)] + [(f"without {name}", on | {name: False}) for name in names]
    return versions + ([("plain", dict.fromkeys(names, False))] if len(names) > 1 else [])


def _one(at: str, plain: dict[str, Any], at_cell: tuple[dict[str, Any], list[str]], off: tuple[str, dict[str, bool]] | None) -> dict[str, Any]:
    cell, into = at_cell
    words = {key.split(".")[-1]: _shown(value) for key, value in cell.items()}
    table = copy.deepcopy(plain)
    for key in into:
        _put(at, table, key.split("."), cell[key])
    if off is not None:
        words["off"] = off[0]
        for name, on in off[1].items():
            _put(at, table, ["set", name], on)
    return {key: _filled(at, value, words) for key, value in table.items()}


def _put(at: str, table: dict[str, Any], parts: list[str], value: Any) -> None:
    for part in parts[:-1]:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise BadFile(f"{at}, field {part}", f"{show(table)} is not a table", "a table", "Correct the field")
    table[parts[-1]] = value


def _filled(at: str, value: Any, words: dict[str, str]) -> Any:
    if isinstance(value, str):
        unknown = next((name for name in _PLACE.findall(value) if name not in words), None)
        if unknown is not None:
            known = ", ".join(f"{{{name}}}" for name in words)
            raise BadFile(at, f"{word('{' + unknown + '}')} in {show(value)} is no dimension of it", known, "Correct it or add the dimension to each")
        return _PLACE.sub(lambda place: words[place[1]], value).strip()
    if isinstance(value, dict):
        return {key: _filled(at, item, words) for key, item in cast("dict[str, Any]", value).items()}
    if isinstance(value, list):
        return [_filled(at, item, words) for item in cast("list[Any]", value)]
    return value


def _shown(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
