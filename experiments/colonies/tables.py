"""Statistics of runs, Markdown and CSV of them."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

DOCS = Path(__file__).resolve().parents[2] / "docs/experiments.md"


def wilson(hits: int, runs: int, z: float = 1.959964) -> tuple[float, float]:
    """95 % interval of a rate."""
    if runs == 0:
        return 0.0, 1.0
    rate, square = hits / runs, z * z / runs
    middle, half = rate + square / 2, z * math.sqrt(rate * (1 - rate) / runs + square / (4 * runs))
    return max(0.0, (middle - half) / (1 + square)), min(1.0, (middle + half) / (1 + square))


def interval(values: Sequence[float]) -> tuple[float, float]:
    """Mean and half-width of its 95 % interval."""
    array = np.asarray(values, float)
    if len(array) < 2:
        return float(array.mean()) if len(array) else math.nan, math.nan
    return float(array.mean()), float(stats.t.ppf(0.975, len(array) - 1) * array.std(ddof=1) / math.sqrt(len(array)))


def a12(smaller: Sequence[float], larger: Sequence[float]) -> float:
    """Vargha and Delaney: how probably a value of the second is above one of the first, ties half."""
    m, n = len(smaller), len(larger)
    if not m or not n:
        return math.nan
    ranks = stats.rankdata(np.round(np.concatenate([larger, smaller]), 9))
    return float((ranks[:n].sum() / n - (n + 1) / 2) / m)


def signed_rank(one: Sequence[float], other: Sequence[float]) -> float:
    """p of the two-sided Wilcoxon signed-rank test; 1 where all pairs are equal."""
    differences = np.round(np.asarray(one) - np.asarray(other), 9)
    return 1.0 if not differences.any() else float(stats.wilcoxon(differences).pvalue)


def holm(ps: Sequence[float]) -> list[float]:
    """p-values corrected for their number."""
    out, worst = [0.0] * len(ps), 0.0
    for place, index in enumerate(sorted(range(len(ps)), key=lambda i: ps[i])):
        worst = max(worst, min(1.0, (len(ps) - place) * ps[index]))
        out[index] = worst
    return out


def markdown(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)]) + "\n"


def write_csv(path: Path, rows: list[dict[str, Any]]) -> None:
    names = list(dict.fromkeys(name for row in rows for name in row))
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)


def publish(name: str, command: str, text: str, out: Path, docs: bool) -> None:
    """Prints the text, writes it to ``out/NAME.md`` and, if asked, between its marks in docs/experiments.md."""
    print(text)
    (out / f"{name}.md").write_text(text)
    if docs:
        begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
        page = DOCS.read_text()
        before, after = page[: page.index(begin)], page[page.index(end) :]
        DOCS.write_text(f"{before}{begin}\nMade by `{command}`.\n\n{text}\n{after}")


def percent(share: float, digits: int = 1) -> str:
    return f"{100 * share:.{digits}f}"
