"""Tables of results as CSV, and as LaTeX with booktabs."""

from __future__ import annotations

import csv
import io
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from guideway.files import write_whole

CELL = ("world", "query", "method", "n", "ok", "success", "success_low", "success_high")
STATISTICS = ("n", "mean", "sd", "low", "high", "least", "q1", "median", "q3", "most")
ESCAPES = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': "''",
    "`": r"\textasciigrave{}",
    "\u2013": "--",
    "\u2014": "---",
    "\u2212": "$-$",
    "\u00b1": r"$\pm$",
    "\u00b7": r"$\cdot$",
    "\u00b0": r"$^\circ$",
    "\u00d7": r"$\times$",
    "\u2026": r"\ldots{}",
    "\u00b5": r"$\mu$",
    "\u00b2": r"$^2$",
    "\u00b3": r"$^3$",
    "[": "{[}",
    "]": "{]}",
    "'": "'",
}
"""Characters that LaTeX takes for something else; brackets would be an option after a line's end."""
FORMULAS = ("=", "+", "-", "@", "\t", "\r")
"""What a spreadsheet takes for the beginning of a formula."""


def write_tables(summaries: Sequence[Mapping[str, Any]], folder: Path) -> list[Path]:
    """``NAME.csv`` (a row per world, query and method), ``NAME-comparisons.csv``, ``NAME-published.csv``, ``claims.csv`` and ``NAME.tex``."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for one in summaries:
        name = str(one["name"])
        files = {f"{name}.csv": cells(one), f"{name}-comparisons.csv": list(one["comparisons"]), f"{name}-published.csv": list(one["published"])}
        for file, rows in files.items():
            if rows:
                write_whole(folder / file, csv_of(rows))
                written.append(folder / file)
        write_whole(folder / f"{name}.tex", latex(one))
        written.append(folder / f"{name}.tex")
    claims = [{"experiment": one["name"]} | plain_claim(claim) for one in summaries for claim in one["claims"]]
    if claims:
        write_whole(folder / "claims.csv", csv_of(claims))
        written.append(folder / "claims.csv")
    return written


def plain_claim(claim: Mapping[str, Any]) -> dict[str, Any]:
    """A claim without its nested numbers."""
    joined = {key: "; ".join(value) if isinstance(value, list) else value for key, value in claim.items() if key != "numbers"}
    return {"verdict": joined.pop("verdict"), **joined}


def cells(one: Mapping[str, Any]) -> list[dict[str, Any]]:
    """A row per world, query and method with every statistic of every measure and time."""
    rows = []
    for cell in one["cells"]:
        rate = cell["success"]
        head = (cell["world"], cell["query"], cell["method"], cell["n"], rate["hits"], rate["share"], rate["low"], rate["high"])
        row: dict[str, Any] = dict(zip(CELL, head, strict=True))
        ert, settled = cell["ert"] or {}, cell["convergence"] or {}
        row |= {"optimum": cell["optimum"], "ert_1_percent": ert.get("value"), "last_improvement": settled.get("evaluations")}
        for kind, table in (("", cell["measures"]), ("time_", cell["times"])):
            for name, values in table.items():
                row |= {f"{kind}{name}_{statistic}": values[statistic] for statistic in STATISTICS}
        rows.append(row)
    return rows


def csv_of(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as CSV; the first line names all columns, missing values are empty, text never begins like a formula."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([harmless(row.get(name)) for name in names] for row in rows)
    return buffer.getvalue()


def harmless(value: Any) -> Any:
    """A value for a cell of a spreadsheet: None is empty, text that begins like a formula gets an apostrophe."""
    if value is None:
        return ""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULAS) else value


def escape(text: str) -> str:
    """Text for LaTeX: its special characters as commands, control characters as spaces; letters of other scripts are left to the typesetter."""
    return "".join(ESCAPES.get(c, " " if unicodedata.category(c).startswith("C") else c) for c in text)


def latex(one: Mapping[str, Any]) -> str:
    """A table per measure of the experiment: methods in rows, worlds in columns, mean and half of the 95 % interval, the best in bold."""
    metrics = [metric for metric in one["metrics"] if metric["first"]] or list(one["metrics"])[:1]
    places = list(dict.fromkeys((cell["world"], cell["query"]) for cell in one["cells"]))
    methods = list(dict.fromkeys(cell["method"] for cell in one["cells"]))
    known = {(cell["world"], cell["query"], cell["method"]): cell for cell in one["cells"]}
    head = f"% {one['name']}: {one['command']}".replace("\n", " ")
    parts = [head, "% needs \\usepackage{booktabs}; with many worlds also \\usepackage{graphicx} for \\resizebox, or \\usepackage{lscape}"]
    for metric in metrics:
        body = [[escape(method), *(entry(known, place, method, metric, methods) for place in places)] for method in methods]
        parts.append(table_of([("Method", "l"), *((escape(" / ".join(filter(None, place))), "r") for place in places)], body, caption(one, metric)))
    parts.append(success_of(one, known, places, methods))
    return "\n".join(parts)


def caption(one: Mapping[str, Any], metric: Mapping[str, Any]) -> str:
    """What a table shows."""
    unit = f" in {escape(metric['unit'])}" if metric["unit"] else ""
    means = f"mean over {one['seeds']} seeds with half of its 95\\,\\% interval" if one["seeds"] > 1 else "one seed"
    return f"{escape(one['title'])}: {escape(metric['name'].replace('_', ' '))}{unit}, {means}, certified runs only."


def entry(known: Mapping[Any, Any], place: tuple[str, str], method: str, metric: Mapping[str, Any], methods: Sequence[str]) -> str:
    """Mean and half of the interval; bold where it is the best of its world."""
    values = measure(known, place, method, metric)
    if values is None:
        return "--"
    digits = metric["digits"]
    text = f"{values['mean']:.{digits}f}"
    means = [other["mean"] for name in methods if (other := measure(known, place, name, metric))]
    best = {"lower": min, "higher": max}.get(metric["better"])
    if best and len(set(means)) > 1 and values["mean"] == best(means):
        text = rf"\mathbf{{{text}}}"
    if values.get("rate"):
        return f"${text}\\;[{values['low']:.{digits}f}, {values['high']:.{digits}f}]$"
    spread = "" if values["high"] is None or values["high"] == values["mean"] else rf" \pm {values['high'] - values['mean']:.{digits}f}"
    return f"${text}{spread}$"


def measure(known: Mapping[Any, Any], place: tuple[str, str], method: str, metric: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """The statistics of a measure in a cell, or of a time."""
    cell = known.get((*place, method))
    return None if cell is None else cell["measures"].get(metric["name"]) or cell["times"].get(metric["name"])


def success_of(one: Mapping[str, Any], known: Mapping[Any, Any], places: Sequence[tuple[str, str]], methods: Sequence[str]) -> str:
    """Success rates with Wilson intervals."""

    def text(cell: Mapping[str, Any] | None) -> str:
        if cell is None or cell["success"]["share"] is None:
            return "--"
        rate = cell["success"]
        return f"${100 * rate['share']:.0f}\\;[{100 * rate['low']:.0f}, {100 * rate['high']:.0f}]$"

    body = [[escape(method), *(text(known.get((*place, method))) for place in places)] for method in methods]
    head = [("Method", "l"), *((escape(" / ".join(filter(None, place))), "r") for place in places)]
    return table_of(head, body, f"{escape(one['title'])}: success in \\% with its 95\\,\\% interval (Wilson).")


def table_of(head: Sequence[tuple[str, str]], body: Iterable[Sequence[str]], text: str) -> str:
    """A floating table with booktabs."""
    lines = [r"\begin{table}", r"\centering", rf"\caption{{{text}}}", rf"\begin{{tabular}}{{{''.join(side for _, side in head)}}}", r"\toprule"]
    lines += [" & ".join(name for name, _ in head) + r" \\", r"\midrule", *(" & ".join(row) + r" \\" for row in body)]
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", r"\end{table}", ""])
