"""Statistics of runs, by SciPy, statsmodels and scikit-posthocs; what those leave undefined is defined here.

Nothing returns NaN: what cannot be computed is ``None``. Two values that differ by less than 1e-9 of their size are a tie: lengths summed in another
order are the same length. Intervals are of 95 % unless ``level`` says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

TIE = 1e-9
"""Relative difference below which two values are equal."""
ENUMERATED = 13
"""Differences with ties up to which the signed-rank test is exact."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rate:
    """A share with its Wilson interval; ``share`` is None without runs, the interval then 0 to 1."""

    hits: int
    runs: int
    share: float | None
    low: float
    high: float

    def to_dict(self) -> dict[str, Any]:
        """As in summary.json."""
        return asdict(self)


@dataclass(frozen=True)
class Summary:
    """Location and spread of values. ``low``, ``high``: t interval of the mean, None for fewer than two values, as ``sd``."""

    n: int
    mean: float | None
    sd: float | None
    low: float | None
    high: float | None
    least: float | None
    q1: float | None
    median: float | None
    q3: float | None
    most: float | None

    def to_dict(self) -> dict[str, Any]:
        """As in summary.json."""
        return asdict(self)


@dataclass(frozen=True)
class Paired:
    """A paired comparison of one method with another: p of the signed-rank test and probability that the first is better.

    ``pairs`` counts the pairs where both have a value, ``ties`` the equal ones, ``wins`` and ``losses`` the others. ``p`` is None without pairs and
    1 where all pairs are equal.
    """

    pairs: int
    ties: int
    wins: int
    losses: int
    statistic: float | None
    p: float | None
    a12: float | None
    difference: float | None

    def to_dict(self) -> dict[str, Any]:
        """As in summary.json."""
        return asdict(self)


@dataclass(frozen=True)
class Ranks:
    """Friedman's test and what follows it. ``ranks``: mean rank per method, 1 is best; ``nemenyi``: p per pair; ``groups``: methods not told
    apart.
    """

    methods: tuple[str, ...]
    blocks: int
    statistic: float | None
    p: float | None
    ranks: tuple[float, ...]
    critical_difference: float | None
    nemenyi: tuple[tuple[float, ...], ...] | None
    groups: tuple[tuple[str, ...], ...]

    def to_dict(self) -> dict[str, Any]:
        """As in summary.json."""
        return asdict(self)


@dataclass(frozen=True)
class Growth:
    """t = c n^p fitted on logarithms; the interval of ``exponent`` is None for fewer than three sizes."""

    points: int
    exponent: float
    low: float | None
    high: float | None
    factor: float
    r2: float | None

    def to_dict(self) -> dict[str, Any]:
        """As in summary.json."""
        return asdict(self)


@dataclass(frozen=True)
class Area:
    """Area under a ROC curve with DeLong's interval; ``auc`` is None without positives or negatives."""

    auc: float | None
    low: float | None
    high: float | None
    positives: int
    negatives: int

    def to_dict(self) -> dict[str, Any]:
        """As in summary.json."""
        return asdict(self)


def success(hits: int, runs: int, level: float = 0.95) -> Rate:
    """Wilson score interval of a rate. Raises ``ValueError`` unless 0 <= hits <= runs."""
    from scipy.stats import binomtest

    if not 0 <= hits <= runs:
        raise ValueError(f"{hits} of {runs} is no rate")
    if runs == 0:
        return Rate(0, 0, None, 0.0, 1.0)
    found = binomtest(hits, runs).proportion_ci(level, method="wilson")
    return Rate(hits, runs, hits / runs, float(found.low), float(found.high))


def describe(values: Sequence[float], level: float = 0.95) -> Summary:
    """Mean with t interval, standard deviation, quartiles and extremes; equal values have a deviation of exactly 0."""
    array = finite(values)
    n = len(array)
    if n == 0:
        return Summary(0, *[None] * 9)
    ordered = np.sort(array).tolist()
    least, q1, median, q3, most = (quantile(ordered, q) for q in (0, 0.25, 0.5, 0.75, 1))
    if n == 1 or least == most:
        spread: tuple[float | None, ...] = (None, None, None) if n == 1 else (0.0, least, least)
        return Summary(n, least, *spread, least, q1, median, q3, most)
    mean = math.fsum(array) / n
    sd = math.sqrt(math.fsum((array - mean) ** 2) / (n - 1))
    half = student(level, n - 1) * sd / math.sqrt(n)
    return Summary(n, mean, sd, mean - half, mean + half, least, q1, median, q3, most)


def quantile(ordered: Sequence[float], share: float) -> float:
    """Linear quantile (as NumPy's default) of ordered values that may end in infinities; infinite as soon as it needs one of them."""
    at = share * (len(ordered) - 1)
    low, part = math.floor(at), at - math.floor(at)
    if part == 0:
        return ordered[low]
    return math.inf if math.isinf(ordered[low + 1]) else ordered[low] + part * (ordered[low + 1] - ordered[low])


@lru_cache(maxsize=256)
def student(level: float, freedom: int) -> float:
    """Two-sided quantile of Student's t."""
    from scipy.stats import t

    return float(t.ppf((1 + level) / 2, freedom))


def finite(values: Sequence[float | None]) -> Array:
    """The finite values among numbers and ``None``: ``(n,)``."""
    array = np.array([v for v in values if v is not None], dtype=np.float64)
    return array[np.isfinite(array)]


def paired(one: Sequence[float | None], other: Sequence[float | None], lower_is_better: bool = True) -> Paired:
    """Wilcoxon's signed-rank test, two sided, of values at the same place (same world, query and seed), and A12.

    Pairs in which one value is missing are left out. Raises ``ValueError`` for sequences of different length.
    """
    pairs = [(a, b) for a, b in zip(one, other, strict=True) if a is not None and b is not None and math.isfinite(a) and math.isfinite(b)]
    if not pairs:
        return Paired(0, 0, 0, 0, None, None, None, None)
    first, second = np.array(pairs, dtype=np.float64).T
    gaps = differences(first, second)
    better = int((gaps < 0).sum() if lower_is_better else (gaps > 0).sum())
    ties = int((gaps == 0).sum())
    statistic, p = signed_rank(gaps)
    chance = a12(second, first) if lower_is_better else a12(first, second)
    return Paired(len(pairs), ties, better, len(pairs) - ties - better, statistic, p, chance, float(np.median(gaps)))


def differences(one: Array, other: Array) -> Array:
    """``one - other`` with ties exactly 0, and with equal differences exactly equal: rounded at 1e-12 of the largest value."""
    gaps = one - other
    size = np.maximum(np.abs(one), np.abs(other))
    gaps[np.abs(gaps) <= TIE * size] = 0.0
    largest = float(size.max(initial=0.0))
    if largest == 0:
        return gaps
    return np.round(gaps, int(12 - math.floor(math.log10(largest)))) if 1e-200 < largest < 1e200 else gaps


def signed_rank(gaps: Sequence[float] | Array) -> tuple[float | None, float]:
    """Statistic and two-sided p of Wilcoxon's signed-rank test of differences; no statistic and p = 1 where all are 0.

    By SciPy: exact up to 50 differences without ties, the normal approximation with ties. Up to 13 differences with ties it goes through all signs,
    as SciPy does, one by one.
    """
    from scipy.stats import rankdata, wilcoxon

    array = np.asarray(gaps, dtype=np.float64)
    if not array.any():
        return None, 1.0
    kept = array[array != 0]
    if len(array) <= ENUMERATED and (len(kept) < len(array) or len(np.unique(np.abs(kept))) < len(kept)):
        ranks = rankdata(np.abs(kept))
        positive = float(ranks[kept > 0].sum())
        return min(positive, float(ranks.sum()) - positive), signs(ranks, positive)
    found: Any = wilcoxon(array)
    return float(found.statistic), float(found.pvalue)


def signs(ranks: Array, positive: float) -> float:
    """Two-sided p of a sum of positive ranks among all ways to set the signs."""
    sums = np.zeros(1)
    for rank in ranks:
        sums = np.concatenate([sums, sums + rank])
    below, above = float((sums <= positive + 1e-9).mean()), float((sums >= positive - 1e-9).mean())
    return min(1.0, 2 * min(below, above))


def a12(one: Sequence[float] | Array, other: Sequence[float] | Array) -> float | None:
    """Vargha and Delaney's effect size: how probably a value of the first exceeds one of the second, ties counting half."""
    from scipy.stats import mannwhitneyu

    if not len(one) or not len(other):
        return None
    first, second = tied(np.asarray(one, dtype=np.float64), np.asarray(other, dtype=np.float64))
    return float(mannwhitneyu(first, second, method="asymptotic").statistic) / (len(first) * len(second))


def tied(one: Array, other: Array) -> tuple[Array, Array]:
    """Both samples with values that are ties made equal: neighbours in order closer than ``TIE`` of their size get the lower one's value."""
    every = np.concatenate([one, other])
    order = np.argsort(every, kind="stable")
    ordered = every[order]
    apart = np.diff(ordered) > TIE * np.maximum(np.abs(ordered[1:]), np.abs(ordered[:-1]))
    starts = np.concatenate([[0], np.flatnonzero(apart) + 1])
    every[order] = np.repeat(ordered[starts], np.diff([*starts, len(ordered)]))
    return every[: len(one)], every[len(one) :]


def holm(ps: Sequence[float | None]) -> list[float | None]:
    """p-values corrected for their number by Holm's steps; ``None`` (no test was possible) stays and does not count.

    As ``statsmodels.stats.multitest.multipletests(method="holm")``, which takes a collection of all garbage for each family.
    """
    known = sorted((p, i) for i, p in enumerate(ps) if p is not None)
    out: list[float | None] = [None] * len(ps)
    largest = 0.0
    for place, (p, i) in enumerate(known):
        largest = max(largest, min(1.0, (len(known) - place) * p))
        out[i] = largest
    return out


def mcnemar(one: Sequence[bool], other: Sequence[bool]) -> tuple[int, int, float | None]:
    """Runs that only the first solved, runs that only the second solved, and the exact p; 1 where none differ, None without runs."""
    from statsmodels.stats.contingency_tables import mcnemar as exact

    pairs = list(zip(one, other, strict=True))
    only, lacking = sum(a and not b for a, b in pairs), sum(b and not a for a, b in pairs)
    if not pairs:
        return 0, 0, None
    both, neither = sum(a and b for a, b in pairs), sum(not a and not b for a, b in pairs)
    if only + lacking == 0:
        return 0, 0, 1.0
    found: Any = exact([[both, only], [lacking, neither]], exact=True)
    return only, lacking, min(1.0, float(found.pvalue))


def friedman(table: Mapping[str, Sequence[float | None]], lower_is_better: bool = True, alpha: float = 0.05) -> Ranks:
    """Friedman's test of methods over blocks (worlds, or seeds), Nemenyi's test and critical difference.

    ``table``: values per method, one per block. A missing value ranks last in its block (a failure is worse than any result); a block in which no
    method has one is left out. Friedman's test needs three methods and two blocks, Nemenyi's the same; else they are ``None`` and only the mean
    ranks are given.
    """
    methods = tuple(table)
    if not methods:
        return Ranks((), 0, None, None, (), None, None, ())
    blocks = block_ranks(table, lower_is_better)
    if not len(blocks):
        return Ranks(methods, 0, None, None, (), None, None, ())
    means = tuple(float(v) for v in blocks.mean(axis=0))
    if len(methods) < 3 or len(blocks) < 2:
        return Ranks(methods, len(blocks), None, None, means, None, None, ())
    statistic, p = friedman_test(blocks)
    distance = critical_difference(len(methods), len(blocks), alpha)
    return Ranks(methods, len(blocks), statistic, p, means, distance, nemenyi(blocks), groups(methods, means, distance))


def block_ranks(table: Mapping[str, Sequence[float | None]], lower_is_better: bool) -> Array:
    """Ranks of the methods in each block, 1 is best, ties share: ``(blocks, methods)``."""
    from scipy.stats import rankdata

    rows = []
    for block in zip(*table.values(), strict=True):
        values = [v if v is not None and math.isfinite(v) else None for v in block]
        if all(v is None for v in values):
            continue
        sign = 1.0 if lower_is_better else -1.0
        signed = np.array([math.inf if v is None else sign * v for v in values])
        known = np.isfinite(signed)
        signed[known] = tied(signed[known], np.empty(0))[0]
        rows.append(rankdata(signed))
    return np.array(rows, dtype=np.float64).reshape(-1, len(table))


def friedman_test(blocks: Array) -> tuple[float | None, float]:
    """Statistic and p of Friedman's test; p = 1 where all methods tie in every block."""
    from scipy.stats import friedmanchisquare

    if bool((blocks == blocks[:, :1]).all()):
        return None, 1.0
    found = friedmanchisquare(*blocks.T)
    return float(found.statistic), float(found.pvalue)


def nemenyi(blocks: Array) -> tuple[tuple[float, ...], ...]:
    """p of each pair of methods after Friedman's test: ``(methods, methods)``."""
    from scikit_posthocs import posthoc_nemenyi_friedman

    return tuple(tuple(float(p) for p in row) for row in posthoc_nemenyi_friedman(blocks).to_numpy())


def critical_difference(methods: int, blocks: int, alpha: float = 0.05) -> float:
    """Nemenyi's critical difference of mean ranks: ``q / sqrt(2) * sqrt(k (k + 1) / (6 n))`` with the studentised range ``q`` for infinite
    degrees of freedom.
    """
    from scipy.stats import studentized_range

    return float(studentized_range.ppf(1 - alpha, methods, np.inf)) / math.sqrt(2) * math.sqrt(methods * (methods + 1) / (6 * blocks))


def groups(methods: Sequence[str], ranks: Sequence[float], distance: float) -> tuple[tuple[str, ...], ...]:
    """Largest sets of methods, in order of rank, whose mean ranks lie within the critical difference; sets of one are left out."""
    order = sorted(range(len(methods)), key=lambda i: (ranks[i], i))
    spans: list[tuple[int, int]] = []
    for first in range(len(order)):
        last = max(k for k in range(first, len(order)) if ranks[order[k]] - ranks[order[first]] <= distance)
        if last > first and not (spans and spans[-1][1] >= last):
            spans.append((first, last))
    return tuple(tuple(methods[i] for i in order[first : last + 1]) for first, last in spans)


def growth(sizes: Sequence[float], values: Sequence[float], level: float = 0.95) -> Growth | None:
    """Exponent p of ``value = c size^p`` by least squares on logarithms. ``None`` for fewer than two sizes; what is not positive is left out."""
    from scipy.stats import linregress

    pairs = [(s, v) for s, v in zip(sizes, values, strict=True) if s > 0 and v > 0 and math.isfinite(s) and math.isfinite(v)]
    if len({s for s, _ in pairs}) < 2:
        return None
    x, y = np.log(np.array(pairs, dtype=np.float64)).T
    found: Any = linregress(x, y)
    exponent, half = float(found.slope), None
    if len(pairs) > 2:
        half = student(level, len(pairs) - 2) * float(found.stderr)
    r2 = float(found.rvalue) ** 2 if np.ptp(y) > 0 else None
    low, high = (None, None) if half is None else (exponent - half, exponent + half)
    return Growth(len(pairs), exponent, low, high, math.exp(float(found.intercept)), r2)


def auc(scores: Sequence[float], labels: Sequence[bool], level: float = 0.95) -> Area:
    """Area under the ROC curve (Mann-Whitney) with the interval of DeLong, DeLong and Clarke-Pearson (1988), cut to 0 ... 1.

    The interval is ``None`` with fewer than two positives or two negatives. Raises ``ValueError`` for sequences of different length.
    """
    from scipy.stats import norm, rankdata

    rows = list(zip(scores, labels, strict=True))
    good, poor = (np.array([s for s, label in rows if bool(label) is kind], dtype=np.float64) for kind in (True, False))
    m, n = len(good), len(poor)
    if not m or not n:
        return Area(None, None, None, m, n)
    every = rankdata(np.concatenate([good, poor]))
    above, below = (every[:m] - rankdata(good)) / n, 1 - (every[m:] - rankdata(poor)) / m
    area = float(above.mean())
    if m < 2 or n < 2:
        return Area(area, None, None, m, n)
    half = float(norm.ppf((1 + level) / 2)) * math.sqrt(float(above.var(ddof=1)) / m + float(below.var(ddof=1)) / n)
    return Area(area, max(0.0, area - half), min(1.0, area + half), m, n)


def roc(scores: Sequence[float], labels: Sequence[bool]) -> list[tuple[float, float]]:
    """Points (false positive rate, true positive rate) from (0, 0) to (1, 1), one per distinct score; empty without positives or negatives."""
    rows = sorted(zip(scores, labels, strict=True), key=lambda row: -row[0])
    positives = sum(bool(label) for _, label in rows)
    negatives = len(rows) - positives
    if not positives or not negatives:
        return []
    points, hits, alarms = [(0.0, 0.0)], 0, 0
    for i, (score, label) in enumerate(rows):
        hits, alarms = hits + bool(label), alarms + (not label)
        if i + 1 == len(rows) or rows[i + 1][0] != score:
            points.append((alarms / negatives, hits / positives))
    return points
