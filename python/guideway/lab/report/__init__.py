"""The report of experiments: one HTML file that works offline, tables, figures for papers, benchmark logs, and ``summary.json``."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from guideway._core import __version__
from guideway.files import write_whole
from guideway.lab.extra import needed
from guideway.lab.results_page import results_page
from guideway.lab.summary import SCHEMA, summary

from .loading import Loaded, load
from .ompl import write_logs
from .page import page
from .tables import write_tables

__all__ = ["Loaded", "load", "page", "write_report"]


def write_report(
    folder: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    figures: bool = True,
    markdown: str | os.PathLike[str] | None = None,
) -> Path:
    """Writes the report of all experiments in a folder (``NAME.toml`` with ``NAME.jsonl`` beside it); returns the HTML file.

    ``out`` is the HTML file or the folder to write to; left out, it is ``report.html`` in the folder of the records. Beside it stand
    ``summary.json``, ``tables/*.csv``, ``tables/*.tex``, ``ompl/*.log`` and, with ``figures``, ``figures/*.svg`` (these need matplotlib);
    ``markdown`` is a page of what holds besides (:func:`guideway.lab.results_page.results_page`). Equal records give equal files. Raises
    :class:`guideway.errors.BadFile` for a folder without experiments or a file that cannot be read, ``OSError`` if writing fails.
    """
    for module in ("scipy.stats", "statsmodels.stats", "scikit_posthocs", *(["matplotlib"] if figures else [])):
        needed(module, "lab", f"the report needs {module.split('.')[0]}")
    found = load(folder)
    html = Path(folder if out is None else out)
    if html.suffix.lower() not in (".html", ".htm"):
        html /= "report.html"
    html.parent.mkdir(parents=True, exist_ok=True)
    summaries = [summary(one.experiment, one.records) for one in found]
    write_whole(html, page(summaries, found))
    if markdown is not None:
        quick = any(one["quick"] for one in summaries)
        write_whole(markdown, results_page(summaries, "make results-quick" if quick else "make results"))
    _write_beside(html.parent, summaries, found, figures)
    return html


def _write_beside(target: Path, summaries: list[dict[str, Any]], found: list[Loaded], figures: bool) -> None:
    whole = {"schema": SCHEMA, "guideway": __version__, "experiments": summaries}
    write_whole(target / "summary.json", json.dumps(whole, ensure_ascii=False, allow_nan=False, indent=1, sort_keys=True) + "\n")
    write_tables(summaries, target / "tables")
    write_logs(found, target / "ompl")
    if figures:
        from .figures import write_figures

        write_figures(summaries, found, target / "figures")
