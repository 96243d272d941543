"""The page of results in Markdown: what of each source holds here, what does not, what cannot be judged, and how far beyond it we are."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from .verdicts import FAILS, HOLDS, OPEN

SOURCES = {
    "zhang2025": "A-I-DE: adaptive improved differential evolution with speed planning",
    "han2024": "PSO-ACO: particle swarm and ant colony for transfer robots",
    "lu2025": "Improved ant colony and improved dynamic window",
    "nan2025": "Velocity self-learning along a specified path",
    "ours": "Beyond the sources: our own experiments",
}
"""The sources by their keys in refs.bib, in the order of the page."""
MOST_FIGURES = 40
"""Figures in print that the page shows per experiment; the report has all."""
MOST_METHODS = 24
MOST_METRICS = 4
INTRO = """Made from the records of the experiments by `{command}`; nothing on it is written by hand. Each experiment names its command;
`guideway lab report` turns its records into a report with all tables, intervals, curves and paths. Every path went through the independent
checker: what it refused is a failure and in no mean. Comparisons: Wilcoxon's signed ranks on the same world, query and seed after Holm, with A12
of Vargha and Delaney; rates with Wilson's, means with Student's 95 % intervals. A claim *cannot be judged* where its source leaves out what it
would take, or where runs are too few.
"""


def results_page(summaries: Sequence[Mapping[str, Any]], command: str) -> str:
    """The text of the page from the experiments of ``summary.json``; ``command`` is what makes it."""
    keys = [*SOURCES, *sorted({str(one["source"]) for one in summaries} - set(SOURCES))]
    groups = [(key, [one for one in summaries if one["source"] == key]) for key in keys]
    known = [(key, group) for key, group in groups if group]
    parts = ["# Results\n", INTRO.format(command=command), *warning(summaries), overview(known)]
    return "\n".join([*parts, *(source(key, group) for key, group in known), about(summaries)])


def warning(summaries: Sequence[Mapping[str, Any]]) -> list[str]:
    """What makes the figures provisional, and alarms."""
    out = []
    if any(one["quick"] for one in summaries):
        out.append("**These are quick versions: fewer seeds, worlds or evaluations than the experiments ask for. The verdicts are provisional.**\n")
    lacking = sum(one["runs"]["missing"] for one in summaries)
    if lacking:
        out.append(f"**{lacking} runs are not done yet.**\n")
    wrong = sum(len(one["alarms"]) for one in summaries)
    if wrong:
        out.append(f"**Alarm: {wrong} certified runs are better than a proved optimum; the checker or a reference is wrong.**\n")
    return out


def overview(groups: Iterable[tuple[str, Sequence[Mapping[str, Any]]]]) -> str:
    """Claims and runs per source."""
    rows = []
    for key, group in groups:
        counts = Counter(claim["verdict"] for one in group for claim in one["claims"])
        runs, ok = sum(one["runs"]["recorded"] for one in group), sum(one["status"].get("ok", 0) for one in group)
        link = f"[{plain(SOURCES.get(key, key))}](#{anchor(SOURCES.get(key, key))})"
        rows.append([link, len(group), counts[HOLDS], counts[FAILS], counts[OPEN], runs, runs - ok])
    return table(["source", "experiments", HOLDS, FAILS, OPEN, "runs", "failed runs"], rows)


def source(key: str, group: Sequence[Mapping[str, Any]]) -> str:
    """A source: its claims with verdicts, then its experiments."""
    parts = [f"## {plain(SOURCES.get(key, key))}\n"]
    if key != "ours":
        parts.append(f"Source: `{key}` in [refs.bib](../refs.bib).\n")
    rows = [claim_row(one, claim) for verdict in (HOLDS, FAILS, OPEN) for one in group for claim in one["claims"] if claim["verdict"] == verdict]
    if rows:
        parts.append(table(["claim", "where", "verdict", "why", "experiment"], rows))
    return "\n".join([*parts, *(experiment(one) for one in group)])


def claim_row(one: Mapping[str, Any], claim: Mapping[str, Any]) -> list[str]:
    """A claim as a row."""
    marked = {HOLDS: "holds", FAILS: "**does not hold**", OPEN: "cannot be judged"}[claim["verdict"]]
    return [plain(claim["says"]), plain(claim["table"]), marked, plain(claim["reason"]), f"[{plain(one['name'])}](#{anchor(one['title'])})"]


def experiment(one: Mapping[str, Any]) -> str:
    """An experiment: its command, its methods over all worlds, the figures in print beside ours."""
    runs = one["runs"]["recorded"]
    counts = ", ".join(
        (many(runs, "run"), many(one["seeds"], "seed"), many(number_of(one, "world"), "world"), many(number_of(one, "method"), "method"))
    )
    parts = [f"### {plain(one['title'])}\n", f"`{one['command']}`{where(one)}. {counts}.\n", methods(one)]
    if one["published"]:
        parts.append(printed(one))
    return "\n".join(parts)


def many(count: int, word: str) -> str:
    """A number of things."""
    return f"{count} {word}" if count == 1 else f"{count} {word}s"


def where(one: Mapping[str, Any]) -> str:
    """The tables of the source."""
    return f" ({plain(one['table'])})" if one["table"] else ""


def number_of(one: Mapping[str, Any], what: str) -> int:
    """How many worlds and queries, or methods, have records."""
    return len({(cell["world"], cell["query"]) if what == "world" else cell["method"] for cell in one["cells"]})


def methods(one: Mapping[str, Any]) -> str:
    """Methods with success and the means over worlds of the first measures."""
    metrics = [metric for metric in one["metrics"] if metric["first"]][:MOST_METRICS]
    if not any(metric["name"] == "gap" for metric in metrics):
        metrics += [metric for metric in one["metrics"] if metric["name"] == "gap"]
    rows = []
    for row in one["overall"][:MOST_METHODS]:
        rate = row["success"]
        share = f"{100 * rate['share']:.1f} ({100 * rate['low']:.0f} to {100 * rate['high']:.0f})" if rate["share"] is not None else "-"
        values = [row["measures"].get(metric["name"]) or row["times"].get(metric["name"]) for metric in metrics]
        rows.append([plain(row["method"]), share, *(mean(row, found, metric) for found, metric in zip(values, metrics, strict=True))])
    left = len(one["overall"]) - len(rows)
    head = ["method", "success %", *(plain(", ".join(filter(None, (metric["name"].replace("_", " "), metric["unit"])))) for metric in metrics)]
    return table(head, rows) + (f"\n{left} more methods are in the report.\n" if left > 0 else "")


def mean(row: Mapping[str, Any], found: Mapping[str, Any] | None, metric: Mapping[str, Any]) -> str:
    """The mean over worlds, with their number where some have no value."""
    if not found:
        return "-"
    part = f" ({found['n']} of {row['instances']} worlds)" if metric["name"] in row["measures"] and found["n"] < row["instances"] else ""
    return digits(found["mean"], metric) + part


def printed(one: Mapping[str, Any]) -> str:
    """Figures in print beside ours."""
    known = {metric["name"]: metric for metric in one["metrics"]}
    rows = []
    for entry in one["published"][:MOST_FIGURES]:
        metric = known.get(entry["metric"], {"digits": 4, "unit": ""})
        place = ", ".join(filter(None, (entry["world"], entry["query"])))
        measure = f"{entry['metric'].replace('_', ' ')} ({entry['statistic']})"
        figures = [digits(entry["value"], metric), digits(entry["ours"], metric), change(entry["value"], entry["ours"])]
        rows.append([plain(entry["table"]), plain(place), plain(entry["method"]), plain(measure), *figures])
    left = len(one["published"]) - len(rows)
    more = f"\n{left} more figures in print are in the report.\n" if left > 0 else ""
    return table(["table", "world", "method", "measure", "in print", "here", "difference"], rows) + more


def digits(value: Any, metric: Mapping[str, Any]) -> str:
    """A value with the digits of its measure."""
    return f"{value:.{metric['digits']}f}" if isinstance(value, int | float) else "-"


def change(value: float, ours: float | None) -> str:
    """How far ours is from the figure in print."""
    return "-" if ours is None or value == 0 else f"{100 * (ours - value) / abs(value):+.1f} %"


def about(summaries: Sequence[Mapping[str, Any]]) -> str:
    """Versions; times are in the reports alone, with their machine."""
    versions = ", ".join(plain(version) for version in sorted({version for one in summaries for version in one["versions"]}))
    return f"## About these figures\n\nGuideway {versions or '-'}. Times depend on the machine and are in the report alone, beside its name.\n"


def table(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A Markdown table; its cells are Markdown already."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)]) + "\n"


def plain(text: Any) -> str:
    """Text that Markdown leaves as it is, on one line."""
    words = " ".join(str(text).split()).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([\\`*_\[\]|#])", r"\\\1", words)


def anchor(text: str) -> str:
    """The link to a heading."""
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
