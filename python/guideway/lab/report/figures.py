"""Figures for papers as SVG, by matplotlib: equal records give equal bytes."""

from __future__ import annotations

import io
import math
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from guideway.files import write_whole
from guideway.view.figure import figure_sheet

from .loading import Loaded

COLOURS = ("#0072b2", "#007d59", "#a04a82", "#946200", "#7d4e2d", "#6b5fb5", "#b3392f", "#1f8296", "#5b6770", "#64751a")
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))
STYLE = {
    "svg.hashsalt": "guideway",
    "svg.fonttype": "none",
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e8ec",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "text.usetex": False,
    "text.parse_math": False,
    "svg.id": None,
}
MOST_FIGURES = 24
"""Figures of one kind per experiment: beyond, the first worlds are drawn."""
ALL = "all worlds"


def write_figures(summaries: Sequence[Mapping[str, Any]], found: Sequence[Loaded], folder: Path) -> list[Path]:
    """``NAME-convergence-WORLD.svg``, ``-boxes-``, ``-ecdf``, ``-time``, ``-profile``, ``-ranks-MEASURE`` and ``-growth-MEASURE`` as far as
    there is data.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for one, loaded in zip(summaries, found, strict=True):
        for stem, draw in figures_of(one, loaded):
            path = folder / f"{slug(str(one['name']))}-{stem}.svg"
            written.append(path)
            write_whole(path, svg(draw))
    return written


def figures_of(one: Mapping[str, Any], loaded: Loaded) -> list[tuple[str, Callable[[Any], None]]]:
    """Names and drawings of an experiment's figures."""
    methods, curves = colours(one), one["curves"]
    places = list(dict.fromkeys((cell["world"], cell["query"]) for cell in one["cells"]))
    out: list[tuple[str, Callable[[Any], None]]] = []
    for place in places[:MOST_FIGURES]:
        rows = [curve for curve in curves["convergence"] if (curve["world"], curve["query"]) == place]
        name = slug(" ".join(filter(None, place)))
        if rows:
            out.append((f"convergence-{name}", lambda axes, rows=rows, place=place: convergence(axes, rows, place, methods)))
        metric = next((m for m in one["metrics"] if m["first"]), None)
        if metric:
            out.append((f"boxes-{name}", lambda axes, place=place, metric=metric: boxes(axes, loaded, place, metric, methods)))
    if curves["ecdf_evaluations"]["methods"]:
        out.append(("ecdf", lambda axes: shares(axes, curves["ecdf_evaluations"]["methods"], "evaluations", methods)))
    if curves["ecdf_time"]:
        out.append(("time", lambda axes: shares(axes, curves["ecdf_time"], "processor time in s", methods)))
    if curves["profile"]:
        words = f"{curves['profile']['metric'].replace('_', ' ')} over the best method's"
        out.append(("profile", lambda axes: shares(axes, curves["profile"]["methods"], words, methods, log=False)))
    out += [(f"ranks-{slug(data['metric'])}", lambda axes, data=data: ranks(axes, data, methods)) for data in one["ranks"] if data["ranks"]]
    for metric in dict.fromkeys(fit["metric"] for fit in one["growth"]):
        fits = [fit for fit in one["growth"] if fit["metric"] == metric]
        out.append((f"growth-{slug(metric)}", lambda axes, fits=fits: growth(axes, fits, methods)))
    return unique(out)


def unique(named: Sequence[tuple[str, Any]]) -> list[tuple[str, Any]]:
    """Names with a number where another figure has the same."""
    seen: dict[str, int] = {}
    out = []
    for name, draw in named:
        seen[name] = seen.get(name, 0) + 1
        out.append((name if seen[name] == 1 else f"{name}-{seen[name]}", draw))
    return out


def slug(text: str) -> str:
    """A word for a file name."""
    return re.sub(r"[^A-Za-z0-9._]+", "-", text).strip("-.")[:80] or "x"


def colours(one: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Colour and dash of every method, as in the page."""
    names = dict.fromkeys(cell["method"] for cell in one["cells"])
    return {name: {"color": COLOURS[k % len(COLOURS)], "linestyle": DASHES[k // len(COLOURS) % len(DASHES)]} for k, name in enumerate(names)}


def svg(draw: Callable[[Any], None]) -> str:
    """A figure as text: no date, no ids that differ from run to run, letters as text."""
    import matplotlib as mpl

    buffer = io.BytesIO()
    style: Any = {key: value for key, value in STYLE.items() if key in mpl.rcParams}
    with mpl.rc_context(style):
        sheet = figure_sheet((4.6, 3.1))
        axes = sheet.add_subplot()
        draw(axes)
        handles, names = axes.get_legend_handles_labels()
        if handles:
            sheet.legend(handles, names, loc="outside lower center", ncols=3, fontsize=7)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Glyph .* missing")  # letters stay text, the viewer has them
            sheet.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return buffer.getvalue().decode()


def logarithmic(axes: Any, *names: str) -> None:
    """Logarithmic axes whose numbers are plain text: formulas are not parsed, for names are texts of anybody."""
    from matplotlib.ticker import FuncFormatter, NullFormatter

    for name in names:
        axis = getattr(axes, f"{name}axis")
        if not math.isfinite(axis.get_minpos()):  # nothing that has a logarithm
            continue
        axes.set(**{f"{name}scale": "log"})
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def convergence(axes: Any, rows: Sequence[Mapping[str, Any]], place: tuple[str, str], methods: Mapping[str, Any]) -> None:
    """Median and quartile band of the best value over evaluations."""
    end = max(row[0] for curve in rows for row in curve["rows"])
    for curve in rows:
        table = [*curve["rows"], [end, *curve["rows"][-1][1:]]]
        at, low, middle, high = ([math.nan if v is None else v for v in column] for column in zip(*table, strict=True))
        style = methods[curve["method"]]
        axes.fill_between(at, low, high, step="post", color=style["color"], alpha=0.13, linewidth=0)
        axes.step(at, middle, where="post", linewidth=1.2, label=curve["method"], **style)
    logarithmic(axes, "x")
    axes.set(xlabel="evaluations", ylabel="best", title=" · ".join(filter(None, place)))


def boxes(axes: Any, loaded: Loaded, place: tuple[str, str], metric: Mapping[str, Any], methods: Mapping[str, Any]) -> None:
    """Boxes of a measure over the seeds: quartiles, median, extremes."""
    rows = [(name, cell.values(metric["name"])) for name in methods if (cell := loaded.grid.cell(place, name)) and cell.values(metric["name"])]
    if rows:
        drawn = axes.boxplot([values for _, values in rows], orientation="horizontal", whis=(0, 100), widths=0.55, patch_artist=True)
        for (name, _), box, middle in zip(rows, drawn["boxes"], drawn["medians"], strict=True):
            box.set(facecolor="none", edgecolor=methods[name]["color"])
            middle.set(color=methods[name]["color"], linewidth=2)
        axes.set_yticks(range(1, len(rows) + 1), [name for name, _ in rows])
        axes.invert_yaxis()
    unit = f", {metric['unit']}" if metric["unit"] else ""
    axes.set(xlabel=f"{metric['name'].replace('_', ' ')}{unit}", title=" · ".join(filter(None, place)))


def shares(axes: Any, entries: Sequence[Mapping[str, Any]], words: str, methods: Mapping[str, Any], log: bool = True) -> None:
    """Shares of runs over an axis as steps."""
    end = max((row[0] for entry in entries for row in entry["rows"]), default=1.0)
    for entry in entries:
        if entry["rows"]:
            table = [[entry["rows"][0][0], 0.0], *entry["rows"], [end, entry["rows"][-1][1]]]
            axes.step(
                [row[0] for row in table], [row[1] for row in table], where="post", linewidth=1.2, label=entry["method"], **methods[entry["method"]]
            )
    if log:
        logarithmic(axes, "x")
    axes.set(xlabel=words, ylabel="share of runs", ylim=(0, 1.03))


def ranks(axes: Any, data: Mapping[str, Any], methods: Mapping[str, Any]) -> None:
    """Critical-difference diagram: mean ranks on an axis, names at both sides, bars over methods that are not told apart."""
    order = sorted(zip(data["methods"], data["ranks"], strict=True), key=lambda one: one[1])
    n, half = len(order), -(-len(order) // 2)
    groups = data["groups"]
    axes.set(xlim=(1 - 0.42 * n, n + 0.42 * n), ylim=(-(half + 0.6 + 0.4 * len(groups)), 2.2))
    axes.axis("off")
    axes.plot([1, n], [0, 0], color="#17212b", linewidth=0.9)
    for rank in range(1, n + 1):
        axes.plot([rank, rank], [0, 0.16], color="#17212b", linewidth=0.9)
        axes.text(rank, 0.28, str(rank), ha="center", fontsize=7)
    for i, (name, rank) in enumerate(order):
        near = i < half
        y, edge = -(0.8 + 0.4 * len(groups) + (i if near else n - 1 - i)), (1 - 0.08 * n if near else n + 0.08 * n)
        axes.plot([rank, rank, edge], [0, y, y], color=methods[name]["color"], linewidth=0.9)
        axes.text(edge + (-0.1 if near else 0.1), y, f"{name} ({rank:.2f})", ha="right" if near else "left", va="center", fontsize=7)
    known = dict(order)
    for i, names in enumerate(groups):
        axes.plot([known[names[0]] - 0.04, known[names[-1]] + 0.04], [-0.3 - 0.4 * i] * 2, color="#17212b", linewidth=2.6, solid_capstyle="round")
    if data["critical_difference"] is not None:
        axes.plot([1, 1 + data["critical_difference"]], [1.3, 1.3], color="#17212b", linewidth=1.4, marker="|")
        axes.text(1, 1.62, f"critical difference {data['critical_difference']:.2f}", fontsize=7)
    axes.set_title(f"Mean ranks of {data['metric'].replace('_', ' ')}")


def growth(axes: Any, fits: Sequence[Mapping[str, Any]], methods: Mapping[str, Any]) -> None:
    """Points and fits of c n^p over the size of the world; groups differ by their marks."""
    groups, marks = list(dict.fromkeys(fit["group"] for fit in fits)), "os^Dv<>P"
    for fit in fits:
        style, sizes = methods[fit["method"]], [point[0] for point in fit["points"]]
        words = " ".join(filter(None, (fit["method"], fit["group"], f"p = {fit['exponent']:.2f}")))
        mark = marks[groups.index(fit["group"]) % len(marks)]
        axes.plot(sizes, [point[1] for point in fit["points"]], mark, color=style["color"], markersize=3)
        ends = [min(sizes), max(sizes)]
        axes.plot(ends, [fit["factor"] * size ** fit["exponent"] for size in ends], linewidth=1, label=words, marker=mark, markersize=3, **style)
    logarithmic(axes, "x", "y")
    axes.set(xlabel="size of the world", ylabel=fits[0]["metric"].replace("_", " "))
