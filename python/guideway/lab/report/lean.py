"""A summary without what the page does not show, so that large experiments stay small."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

CLOCKS = ("plan_cpu", "cpu", "plan", "wall")
"""Times of a cell: the page shows the first that is there."""
SHOWN = ("n", "mean", "low", "high", "q1", "median", "q3", "best", "worst", "rate")
TIMED = ("n", "mean", "least", "q1", "median", "q3", "most")
DIGITS = 7


def lean(one: Mapping[str, Any], room: int) -> dict[str, Any]:
    """The summary of an experiment for the page: measures that it shows, numbers with seven digits, ``room`` characters of convergence curves."""
    names = {str(metric["name"]) for metric in one["metrics"] if metric["first"]} | {"gap"}
    names |= {str(entry["metric"]) for entry in one.get("published", ())}
    if names == {"gap"}:
        names |= {str(metric["name"]) for metric in one["metrics"][:3]}
    small = dict(one) | {
        "metrics": [metric for metric in one["metrics"] if metric["name"] in names],
        "cells": [trimmed(cell, names) for cell in one["cells"]],
        "overall": [trimmed(row, names) for row in one["overall"]],
        "curves": dict(one["curves"]) | {"convergence": bands(one["curves"]["convergence"], room)},
    }
    return rounded(small)


def trimmed(cell: Mapping[str, Any], names: set[str]) -> dict[str, Any]:
    """A cell with the measures of the page and one time."""
    clock = next((name for name in CLOCKS if name in cell["times"]), None)
    return dict(cell) | {
        "measures": {name: {key: v for key, v in found.items() if key in SHOWN} for name, found in cell["measures"].items() if name in names},
        "times": {} if clock is None else {clock: {key: v for key, v in cell["times"][clock].items() if key in TIMED}},
    }


def bands(curves: list[Mapping[str, Any]], left: int) -> list[dict[str, Any]]:
    """Convergence curves of all methods on as many of the first worlds as there is room for, at least on one."""
    places: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for curve in curves:
        places.setdefault((curve["world"], curve["query"]), []).append(rounded(dict(curve)))
    kept: list[dict[str, Any]] = []
    for group in places.values():
        left -= len(json.dumps(group, separators=(",", ":")))
        if left < 0 and kept:
            break
        kept += group
    return kept


def rounded(value: Any) -> Any:
    """Plain data with numbers of seven digits."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, Mapping):
        return {key: rounded(item) for key, item in value.items()}
    return [rounded(item) for item in value] if isinstance(value, list) else value
