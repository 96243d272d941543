"""Reading ``plan.json`` and ``run.json`` back: the record, and the world it was made in."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from guideway._core import World
from guideway.errors import BadFile
from guideway.io import files
from guideway.io.packaged import is_packaged


def load_record(path: str | os.PathLike[str]) -> dict[str, Any]:
    """A record from a JSON file. Raises :class:`BadFile` if it is missing, too large, not JSON, or not a record of Guideway."""
    where = files.name(path)
    try:
        record = json.loads(files.load(path).data(), parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise BadFile(where, f"it cannot be read as JSON ({error})", "a plan.json or run.json written by guideway") from None
    if not isinstance(record, dict) or "guideway" not in record or record.get("schema") != 1:
        raise BadFile(where, "it is not a record of guideway", 'an object with "guideway" and "schema": 1')
    return record


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is not a number")


def is_run(record: dict[str, Any]) -> bool:
    """Is it a drive rather than a plan?"""
    return "outcome" in record


def world_of_record(record: dict[str, Any], path: str | os.PathLike[str]) -> World:
    """The world of a record, found beside the file or in the working folder, and checked to be the same map.

    Raises :class:`BadFile` if the map is missing or another one.
    """
    from guideway.worlds import load

    named = record.get("world")
    source, digest = (named.get("source"), named.get("sha256")) if isinstance(named, dict) else (None, None)
    if not isinstance(source, str):
        raise BadFile(os.fspath(path), "it names no map (world.source)", "a record made from a map or scene file")
    found = source if is_packaged(source) else _found(source, path)
    world = load(found)
    files = named.get("files") if isinstance(named, dict) else None
    others = [name for name, known in files.items() if world.files.get(name) != known] if isinstance(files, dict) else []
    if others or (isinstance(digest, str) and world.sha256 != digest):
        what = f"it is not the map that {os.fspath(path)} was made with (another sha256{' of ' + others[0] if others else ''})"
        raise BadFile(found, what, "", "Plan again on this map")
    masks = named.get("keep_out") if isinstance(named, dict) else None
    for mask in masks or []:
        world = world.with_keep_out(mask_of_record(mask, path))
    return world


def mask_of_record(mask: dict[str, Any], path: str | os.PathLike[str]) -> str:
    """The file of a mask that the record ``path`` names, checked to be the same."""
    from guideway.io.masks import read_mask

    found = _found(str(mask.get("source")), path)
    if read_mask(found)[2] != mask.get("files"):
        raise BadFile(found, f"it is not the mask that {os.fspath(path)} was made with (another sha256)", "", "Plan again with this mask")
    return found


def _found(source: str, path: str | os.PathLike[str]) -> str:
    """Where the map of the record ``path`` is: beside it or in the working folder, with its number in a collection."""
    plain, mark, number = source.partition("#")
    places = [Path(path).parent / plain, Path(plain)]
    found = next((place for place in places if place.exists()), None)
    if found is None:
        tried = " and ".join(str(place) for place in dict.fromkeys(places))
        raise BadFile(os.fspath(path), f"its map {source!r} is not there (tried {tried})", "", "Put the map back, or plan again")
    return f"{found}{mark}{number}"
