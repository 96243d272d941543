"""Whether a claim holds: the test that the experiment names, the numbers that decided it, and the reason in a sentence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from .cells import Cell, Grid, pairs, seed_of
from .experiment import Claim, Metric
from .growing import fits
from .statistics import describe, holm, paired, success

HOLDS, FAILS, OPEN = "holds", "does not hold", "cannot be judged"
LEAST_PAIRS = 6
"""With fewer pairs that differ no two-sided signed-rank test reaches 5 %."""
UNMADE = ("ImportError", "ModuleNotFoundError", "MissingExtra", "TypeError", "AttributeError", "NameError", "SyntaxError", "BadParameter", "BadFile")
"""Errors that say nothing of a method: its library is missing, or it was called in a way that it does not know."""

REFUSED = ("Infeasible", "NoPath")
"""Errors of tasks that have no solution."""


def judge(grid: Grid, claim: Claim) -> dict[str, Any]:
    """Verdict, reason and numbers of one claim, as in summary.json."""
    tests = {"lower": ordering, "higher": ordering, "within": within, "share": share, "growth": grows}
    verdict, reason, found = (OPEN, claim.reason or "no test is named", {}) if claim.test not in tests else tests[claim.test](grid, claim)
    head = {name: getattr(claim, name) for name in ("says", "table", "test", "metric", "method", "value", "tolerance", "alpha")}
    return head | {"than": list(claim.than), "worlds": list(claim.worlds), "verdict": verdict, "reason": reason, "numbers": found}


def chosen(grid: Grid, claim: Claim, method: str) -> list[Cell | None]:
    """The cells of a method on the worlds that a claim names."""
    return [grid.cell(instance, method) for instance in grid.instances if not claim.worlds or instance[0] in claim.worlds]


def unmade(method: str, cells: Sequence[Cell]) -> str | None:
    """Why a method was never run, if so: there are no records, or all failed by what is not its fault."""
    records = [record for cell in cells for record in cell.records]
    if not records:
        return f"there are no runs of {method}"
    errors = [record.get("error") for record in records]
    said = [error for error in errors if isinstance(error, Mapping) and error.get("type") in UNMADE]
    if len(said) < len(records):
        return None
    return f"{method} could not be run here: {said[0].get('type')}: {said[0].get('message')}"


def missing(grid: Grid, claim: Claim) -> str | None:
    """Why there is nothing to judge, if so."""
    for method in (claim.method, *claim.than):
        cells = [cell for cell in chosen(grid, claim, method) if cell]
        if lack := unmade(method, cells):
            return lack
        if claim.metric != "success" and not any(cell.values(claim.metric) for cell in cells):
            return f"no certified run of {method} has a value of {claim.metric}"
    return None


def ordering(grid: Grid, claim: Claim) -> tuple[str, str, dict[str, Any]]:
    """Lower or higher than each of the others: signed ranks of paired runs, corrected by Holm, and no world that says the opposite."""
    lack = missing(grid, claim) or ("it names no method to compare with" if not claim.than else None)
    if lack:
        return OPEN, lack, {}
    rows = [against(grid, claim, other) for other in claim.than]
    for row, p in zip(rows, holm([row["p"] for row in rows]), strict=True):
        row["p_holm"] = p
        row["verdict"], row["reason"] = verdict_of(row, claim)
        if not row["same_model"]:
            row["reason"] += " (their models differ, and so do the optima)"
    found = {"comparisons": rows}
    poor = [row for row in rows if row["verdict"] == FAILS]
    unknown = [row for row in rows if row["verdict"] == OPEN]
    decisive = poor or unknown or rows
    words = "; ".join(f"{row['than']}: {row['reason']}" for row in decisive)
    return (FAILS if poor else OPEN if unknown else HOLDS), words, found


def against(grid: Grid, claim: Claim, other: str) -> dict[str, Any]:
    """One comparison over all worlds of a claim, and the worlds where it goes the other way."""
    mine, theirs = chosen(grid, claim, claim.method), chosen(grid, claim, other)
    both = pairs(mine, theirs, claim.metric)
    found = paired([a for a, _ in both], [b for _, b in both], claim.test == "lower")
    exact = bool(both) and all(
        a and b and a.constant(claim.metric) and b.constant(claim.metric) for a, b in zip(mine, theirs, strict=True) if a and b
    )
    reversed_on = [a.world for a, b in zip(mine, theirs, strict=True) if a and b and opposite(a, b, claim)]
    alike = not any(grid.unlike(a, b, claim.metric) for a, b in zip(mine, theirs, strict=True))
    return {"than": other, **found.to_dict(), "deterministic": exact, "reversed_on": reversed_on, "same_model": alike}


def opposite(mine: Cell, theirs: Cell, claim: Claim) -> bool:
    """Whether the opposite of a claim is significant on one world (or certain, where nothing depends on the seed)."""
    both = pairs([mine], [theirs], claim.metric)
    found = paired([a for a, _ in both], [b for _, b in both], claim.test == "lower")
    if mine.constant(claim.metric) and theirs.constant(claim.metric):
        return found.losses > 0
    return found.p is not None and found.p < claim.alpha and found.losses > found.wins


def verdict_of(row: Mapping[str, Any], claim: Claim) -> tuple[str, str]:
    """Verdict and reason of one comparison."""
    pairs_, ties, wins, losses = (row[name] for name in ("pairs", "ties", "wins", "losses"))
    count = f"{claim.test} in {wins} of {pairs_} pairs, equal in {ties}"
    if not pairs_:
        return OPEN, "no seed on which both succeed"
    if row["deterministic"]:
        if wins == pairs_:
            return HOLDS, f"{claim.test} on every world; nothing depends on the seed"
        return FAILS, f"{count}; nothing depends on the seed"
    if ties == pairs_ and pairs_ >= LEAST_PAIRS:
        return FAILS, f"equal in all {pairs_} pairs"
    if wins + losses < LEAST_PAIRS:
        return (FAILS, f"{count}: it makes hardly a difference") if ties >= 4 * LEAST_PAIRS else (OPEN, f"{count}: too few for a test")
    if wins > losses and len(claim.than) * 2.0 ** (1 - wins - losses) >= claim.alpha:
        return OPEN, f"{count}: too few for a test"
    statistics = f"p = {short(row['p_holm'])} (Holm), A12 = {row['a12']:.3f}"
    if row["p_holm"] < claim.alpha and wins > losses:
        if row["reversed_on"]:
            return FAILS, f"{count}, {statistics}, but the other way on {', '.join(row['reversed_on'][:3])}"
        return HOLDS, f"{count}, {statistics}"
    return FAILS, f"{count}, {statistics}"


def short(p: float) -> str:
    """A p-value with two digits."""
    return "< 1e-12" if p < 1e-12 else f"{p:.2g}"


def within(grid: Grid, claim: Claim) -> tuple[str, str, dict[str, Any]]:
    """The mean on every world no further from a value than the tolerance."""
    lack = missing(grid, claim) or ("it names no value" if claim.value is None else None)
    if lack or claim.value is None:
        return OPEN, str(lack), {}
    tolerance, metric = claim.tolerance or 0.0, grid.metric(claim.metric)
    rows = []
    for cell in chosen(grid, claim, claim.method):
        values = cell.values(claim.metric) if cell else []
        found = describe(values)
        if cell is None or found.mean is None:
            rows.append({"world": cell.world if cell else "", "verdict": OPEN, "mean": None, "low": None, "high": None, "n": 0})
            continue
        rate = success(int(sum(values)), len(values)) if values and claim.metric in grid.rates else found
        low, high = (found.mean if v is None else v for v in (rate.low, rate.high))
        inside = abs(found.mean - claim.value) <= tolerance * (1 + 1e-12)
        near = low <= claim.value + tolerance and high >= claim.value - tolerance
        verdict = HOLDS if inside else OPEN if near else FAILS
        rows.append({"world": cell.world, "verdict": verdict, "mean": found.mean, "low": rate.low, "high": rate.high, "n": found.n})
    reason = "; ".join(f"{row['world']}: {mean_words(row, metric)}" for row in decisive_rows(rows)[:4])
    bound = f"(asked: {number(claim.value, metric)} ± {number(tolerance, metric)})"
    return worst(rows), f"{reason} {bound}", {"worlds": rows}


def decisive_rows(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows that have the verdict of all."""
    return [row for row in rows if row["verdict"] == worst(rows)]


def worst(rows: Sequence[Mapping[str, Any]]) -> str:
    """The verdict of several: one that fails fails all, one that is open leaves all open."""
    verdicts = {row["verdict"] for row in rows}
    return FAILS if FAILS in verdicts else OPEN if OPEN in verdicts or not rows else HOLDS


def mean_words(row: Mapping[str, Any], metric: Metric) -> str:
    """Mean and interval of a row in words."""
    if row["mean"] is None:
        return "no certified run"
    spread = "" if row["low"] is None else f" [{number(row['low'], metric)}, {number(row['high'], metric)}]"
    return f"mean {number(row['mean'], metric)}{spread} of {row['n']}"


def number(value: float, metric: Metric) -> str:
    """A value with the digits and the unit of its measure."""
    return f"{value:.{metric.digits}f}" + (f" {metric.unit}" if metric.unit else "")


def grows(grid: Grid, claim: Claim) -> tuple[str, str, dict[str, Any]]:
    """The exponent of growth with the size of the world at most a value, for every kind of world: judged by its interval."""
    lack = missing(grid, claim) or ("it names no exponent" if claim.value is None else None)
    if lack or claim.value is None:
        return OPEN, str(lack), {}
    rows = []
    for label, (fit, _) in fits(grid, [cell for cell in chosen(grid, claim, claim.method) if cell], claim.metric).items():
        low, high = (-math.inf, math.inf) if fit.low is None or fit.high is None else (fit.low, fit.high)
        verdict = HOLDS if high <= claim.value else FAILS if low > claim.value else OPEN
        rows.append({"group": label, "verdict": verdict, "exponent": fit.exponent, "low": fit.low, "high": fit.high, "points": fit.points})
    if not rows:
        return OPEN, "there are no worlds of two sizes", {}
    words = "; ".join(
        f"{row['group'] or 'all worlds'}: {row['exponent']:.2f}"
        + (" of two points" if row["low"] is None else f" [{row['low']:.2f}, {row['high']:.2f}]")
        for row in decisive_rows(rows)[:4]
    )
    return worst(rows), f"exponent {words} (asked: at most {claim.value:g})", {"groups": rows}


def share(grid: Grid, claim: Claim) -> tuple[str, str, dict[str, Any]]:
    """At least a share of all runs succeed, or have a measure that is true; a run that failed counts against it. Of ``possible`` runs alone those
    do not count that every method was refused in the same words because nothing is there to be found: that is the task's doing, nobody's failure."""
    cells = [cell for cell in chosen(grid, claim, claim.method) if cell]
    lack = unmade(claim.method, cells)
    if lack or claim.value is None:
        return OPEN, lack or "it names no share", {}
    out = sum(len(impossible(grid, cell)) for cell in cells) if claim.possible else 0
    runs = sum(len(cell.records) for cell in cells) - out
    if not runs:
        return OPEN, f"none of {out} runs was possible", {}
    hits = sum(value > 0 for cell in cells for value in cell.values(claim.metric))
    rate = success(hits, runs)
    words = f"{hits} of {runs} runs, {100 * hits / runs:.1f} % [{100 * rate.low:.1f}, {100 * rate.high:.1f}], asked: {100 * claim.value:.1f} %"
    verdict = HOLDS if hits / runs >= claim.value - 1e-12 else OPEN if rate.high >= claim.value else FAILS
    words += f"; {out} runs left out: no solution exists, every method was told so" if out else ""
    return verdict, words + ("; too few runs to refute it" if verdict == OPEN else ""), rate.to_dict()


def impossible(grid: Grid, cell: Cell) -> set[int]:
    """Seeds of a cell on which every method of the experiment, two or more, was refused in the same words as there is no solution."""
    cells = [grid.cell(cell.instance, method) for method in grid.methods]
    if len(cells) < 2 or any(other is None for other in cells):
        return set()
    said = [{seed_of(record): _refusal(record) for record in other.records} for other in cells if other is not None]
    first = said[0]
    return {seed for seed, words in first.items() if words is not None and all(other.get(seed) == words for other in said)}


def _refusal(record: Mapping[str, Any]) -> str | None:
    """What a run was told where no solution exists."""
    error = record.get("error")
    return str(error.get("message")) if isinstance(error, Mapping) and error.get("type") in REFUSED else None
