"""What several verbs share: reading values from words, and options for the robot, the limits and the budget."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import sys
from collections.abc import Iterator
from typing import Any

from guideway.errors import BadFile, BadParameter
from guideway.records import Progress, progress


def numbers(name: str, text: str, counts: tuple[int, ...], form: str) -> tuple[float, ...]:
    """Finite numbers separated by commas; ``counts`` says how many are allowed, ``form`` how it looks."""
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) not in counts or not all(math.isfinite(value) for value in values):
        raise BadParameter(f"{name} {text!r} cannot be read: write {form}, finite numbers in m and rad")
    return values


def cell(name: str, text: str) -> tuple[int, int]:
    """A cell: column, row, row 0 on top."""
    try:
        column, row = (int(part) for part in text.split(","))
    except ValueError:
        raise BadParameter(f"{name} {text!r} cannot be read: write COL,ROW, two whole numbers, row 0 on top") from None
    return column, row


def footprint(text: str) -> dict[str, Any]:
    """``disc:R``, ``box:L,W`` or ``polygon:x,y;x,y;...`` as a record."""
    kind, _, rest = text.partition(":")
    if kind == "disc":
        return {"disc": numbers("--footprint", rest, (1,), "disc:R")[0]}
    if kind == "box":
        return {"box": list(numbers("--footprint", rest, (2,), "box:L,W"))}
    if kind == "polygon":
        return {"polygon": [list(numbers("--footprint", part, (2,), "polygon:x,y;x,y;...")) for part in rest.split(";")]}
    raise BadParameter(f"--footprint {text!r} is not known: write disc:R, box:L,W or polygon:x,y;x,y;... in m")


def setting(text: str) -> tuple[str, Any]:
    """``key=value`` with a value in JSON, or a plain word."""
    key, equals, value = text.partition("=")
    if not key or not equals:
        raise BadParameter(f"--set {text!r} cannot be read: write key=value")
    try:
        return key, json.loads(value)
    except ValueError:
        return key, value


def positive(name: str, value: float | None) -> None:
    """Refuses what is not a positive, finite number."""
    if value is not None and not (math.isfinite(value) and value > 0):
        raise BadParameter(f"{name} {value:g} is out of range: it must be a finite number above 0")


def add_method(parser: argparse.ArgumentParser) -> None:
    """Planner, its parameters, seed and budget."""
    group = parser.add_argument_group("method")
    group.add_argument("--planner", metavar="NAME", help="planner (default visibility; --list names them all)")
    group.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="a parameter of the planner; may be repeated")
    group.add_argument("--seed", type=int, metavar="N", help="seed of random choices (default 0)")
    group.add_argument("--iterations", type=int, metavar="N", help="stop after N iterations of the method")
    group.add_argument("--evaluations", type=int, metavar="N", help="stop after N candidates costed")
    group.add_argument("--seconds", type=float, metavar="S", help="stop after S seconds; results then depend on the machine")
    group.add_argument("--threads", type=int, default=1, metavar="N", help="worker threads; they never change a result (default 1)")


def add_site(parser: argparse.ArgumentParser) -> None:
    """Masks of site rules."""
    group = parser.add_argument_group("site rules")
    group.add_argument(
        "--keep-out", metavar="FILE", action="append", default=[], help="a map_server mask: black areas are forbidden; may be repeated"
    )
    group.add_argument(
        "--speed-mask", metavar="FILE", help="a map_server mask as for Nav2's speed filter: the darker, the slower, in percent of the top speed"
    )


def count(name: str, value: int | None) -> None:
    """Refuses negative counts and those beyond 64 bits."""
    if value is not None and not 0 <= value < 1 << 63:
        raise BadParameter(f"{name} {value} is out of range: a whole number from 0 to 2^63 - 1")


def sealed_json(record: Any) -> str:
    """A record as JSON text; infinities are not allowed in it."""
    return json.dumps(record, allow_nan=False) + "\n"


def write(path: str, text: str | bytes) -> None:
    """Writes a file whole or not at all."""
    from guideway.io.write import write_atomic

    write_atomic(path, text)


def folder_of(path: str | None) -> str:
    """The folder a record will lie in."""
    return os.path.dirname(path) or "." if path else "."


def writable(*paths: str | None, inputs: tuple[str | None, ...] = ()) -> None:
    """Finds out before the work, not after it, that a result has nowhere to go, or would go over an input or another result."""
    taken = {os.path.realpath(path): "an input of this command" for path in inputs if path}
    for path in filter(None, paths):
        folder = folder_of(path)
        if not os.path.isdir(folder):
            raise BadFile(path, f"its folder {folder!r} does not exist", "", "Create it or choose another place")
        if os.path.isdir(path):
            raise BadFile(path, "it is a folder", "a file name")
        place = os.path.realpath(path)
        if (place in taken and os.path.isfile(place)) or taken.get(place) == "another result":
            raise BadFile(path, f"it is {taken[place]}", "", "Choose another name")
        taken[place] = "another result"


@contextlib.contextmanager
def progress_bar() -> Iterator[Progress | None]:
    """An observer that shows a progress bar, gone when the work is done; None where stderr is not a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    try:
        yield progress
    finally:
        progress.close()


def note(message: str) -> None:
    """A line for people, on stderr."""
    print(message, file=sys.stderr)
