"""The HTML report: summaries and what is drawn of them in one file that works offline."""

from __future__ import annotations

import html
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

from guideway.lab.results_page import SOURCES
from guideway.view.report import clean, embed, fill

from .drawing import Budget, drawings
from .lean import lean
from .loading import Loaded

SHARED = ("kit.js", "raster.js")
SCRIPTS = ("words.js", "charts.js", "plots.js", "ranks.js", "results.js", "paths.js", "experiment.js", "overview.js", "lab.js")
MOST_BANDS = 2_500_000
"""Characters of convergence curves of a report."""
MOST_TEXT = 40_000
"""Characters of an experiment's file that the page shows."""


def page(summaries: Sequence[dict[str, Any]], found: Sequence[Loaded], title: str = "Guideway lab") -> str:
    """The text of the report."""
    budget = Budget()
    names = dict.fromkeys([*SOURCES, *sorted(str(one["source"]) for one in summaries)])
    named = [[key, SOURCES.get(key, key)] for key in names if any(one["source"] == key for one in summaries)]
    room = MOST_BANDS // max(len(found), 1)
    entries = [
        lean(one, room) | {"drawing": drawn, "text": loaded.text[:MOST_TEXT]}
        for one, loaded, drawn in zip(summaries, found, drawings([loaded.grid for loaded in found], budget), strict=True)
    ]
    data = clean({"schema": 1, "title": title, "sources": named, "experiments": entries, "worlds": budget.worlds})
    shared, own = files("guideway.view").joinpath("page"), files("guideway.lab.report").joinpath("page")
    scripts = [shared.joinpath(name) for name in SHARED] + [own.joinpath(name) for name in SCRIPTS]
    parts = {
        "title": html.escape(title),
        "style": shared.joinpath("report.css").read_text("utf-8") + own.joinpath("lab.css").read_text("utf-8"),
        "script": "\n".join(script.read_text("utf-8") for script in scripts),
        "data": embed(data),
    }
    return fill(own.joinpath("lab.html").read_text("utf-8"), parts)
