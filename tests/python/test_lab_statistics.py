"""Statistics of the lab against SciPy, statsmodels and cases computed by hand, to 1e-9; edges where those have no answer."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("scipy")
pytest.importorskip("statsmodels")
pytest.importorskip("scikit_posthocs")

from guideway.lab import cells, curves, growing, statistics
from guideway.lab.reading import of_data
from guideway.lab.verdicts import judge

CLOSE = {"rel": 1e-9, "abs": 1e-9}
RNG = np.random.default_rng(7)
VALUES = st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=40)


def near(value: float) -> object:
    return pytest.approx(value, **CLOSE)


@pytest.mark.parametrize(("hits", "runs"), [(0, 1), (1, 1), (0, 30), (30, 30), (17, 30), (999, 1000)])
def test_wilson(hits: int, runs: int) -> None:
    from statsmodels.stats.proportion import proportion_confint

    found = statistics.success(hits, runs)
    low, high = proportion_confint(hits, runs, method="wilson")
    assert (found.low, found.high, found.share) == (near(max(0.0, low)), near(min(1.0, high)), near(hits / runs))


def test_wilson_by_hand_and_without_runs() -> None:
    z = 1.959963984540054
    middle, half = (0.5 + z * z / 20) / (1 + z * z / 10), z * math.sqrt(0.025 + z * z / 400) / (1 + z * z / 10)
    found = statistics.success(5, 10)
    assert (found.low, found.high) == (near(middle - half), near(middle + half))
    assert statistics.success(0, 0) == statistics.Rate(0, 0, None, 0.0, 1.0)
    with pytest.raises(ValueError, match="3 of 2"):
        statistics.success(3, 2)


@settings(deadline=None, max_examples=40)
@given(VALUES)
def test_means_and_quartiles(values: list[float]) -> None:
    from scipy import stats

    found = statistics.describe(values)
    assert found.n == len(values)
    assert found.mean == pytest.approx(np.mean(values), rel=1e-9, abs=1e-6)
    assert [found.least, found.q1, found.median, found.q3, found.most] == pytest.approx(
        np.quantile(values, [0, 0.25, 0.5, 0.75, 1]).tolist(), **CLOSE
    )
    if found.sd and found.sd > 1e-3:
        low, high = stats.t.interval(0.95, len(values) - 1, np.mean(values), stats.sem(values))
        assert (found.low, found.high) == (pytest.approx(low, rel=1e-9, abs=1e-6), pytest.approx(high, rel=1e-9, abs=1e-6))


def test_t_interval_by_hand() -> None:
    found = statistics.describe([1.0, 2.0, 3.0, 4.0])
    sd = math.sqrt(5 / 3)
    assert (found.mean, found.sd) == (2.5, near(sd))
    assert found.high == near(2.5 + 3.182446305283709 * sd / 2)


def test_summaries_of_nothing_one_value_and_equal_values() -> None:
    assert statistics.describe([]) == statistics.Summary(0, *[None] * 9)
    assert statistics.describe([math.nan, math.inf]).n == 0
    assert statistics.describe([3.5]).to_dict() | {"mean": 3.5, "sd": None, "low": None, "high": None} == statistics.describe([3.5]).to_dict()
    same = statistics.describe([0.1] * 30)
    assert (same.mean, same.sd, same.low, same.high) == (0.1, 0.0, 0.1, 0.1)


def test_signed_ranks_are_those_of_scipy() -> None:
    from scipy.stats import wilcoxon

    one, other = RNG.normal(size=30), RNG.normal(0.4, size=30)
    found = statistics.paired(one, other)
    assert found.p == near(wilcoxon(one, other).pvalue)
    assert found.statistic == near(wilcoxon(one, other).statistic)
    assert (found.pairs, found.ties, found.wins + found.losses) == (30, 0, 30)


@settings(deadline=None, max_examples=40)
@given(st.lists(st.integers(-4, 4), min_size=1, max_size=7))
def test_signed_ranks_with_ties_go_through_all_signs(gaps: list[int]) -> None:
    from scipy.stats import wilcoxon

    statistic, p = statistics.signed_rank(gaps)
    if any(gaps):
        assert (statistic, p) == (near(wilcoxon([float(v) for v in gaps]).statistic), near(wilcoxon([float(v) for v in gaps]).pvalue))
    else:
        assert (statistic, p) == (None, 1.0)


def test_signed_ranks_by_hand() -> None:
    found = statistics.paired([1, 1, 1, 1, 1, 1], [2, 3, 4, 5, 6, 7])
    assert (found.p, found.statistic, found.wins, found.a12, found.difference) == (near(2 / 2**6), 0, 6, 1.0, -3.5)
    assert statistics.paired([2, 3, 4, 5, 6, 7], [1, 1, 1, 1, 1, 1], lower_is_better=False).a12 == 1.0


def test_pairs_that_are_missing_equal_or_none() -> None:
    assert statistics.paired([1.0, None, math.nan, 2.0], [None, 1.0, 1.0, 2.0]) == statistics.Paired(1, 1, 0, 0, None, 1.0, 0.5, 0.0)
    assert statistics.paired([], []).p is None
    assert statistics.paired([None], [None]).a12 is None
    assert statistics.paired([3.0] * 30, [3.0] * 30).p == 1.0
    with pytest.raises(ValueError, match=r"zip\(\)"):
        statistics.paired([1.0], [1.0, 2.0])


def test_lengths_summed_in_another_order_are_ties() -> None:
    one = [28.627416997969522, 28.627416997969518, 1e-9]
    other = [28.62741699796952, 28.627416997969525, 1.0000000000001e-9]
    found = statistics.paired(one, other)
    assert (found.ties, found.p, found.a12) == (3, 1.0, 0.5)
    assert statistics.paired([1e-9] * 8, [2e-9] * 8).wins == 8, "small is not equal"


def test_a12_by_hand() -> None:
    assert statistics.a12([1, 2, 3], [2, 2, 9]) == near((0 + 0 + 0 + 0.5 + 0.5 + 0 + 1 + 1 + 0) / 9)
    assert statistics.a12([1], []) is None
    assert statistics.a12([2], [1]) == 1.0


@settings(deadline=None, max_examples=40)
@given(st.lists(st.integers(0, 9), min_size=1, max_size=15), st.lists(st.integers(0, 9), min_size=1, max_size=15))
def test_a12_counts_pairs(one: list[int], other: list[int]) -> None:
    wins = sum((a > b) + 0.5 * (a == b) for a in one for b in other)
    assert statistics.a12(one, other) == near(wins / len(one) / len(other))


@settings(deadline=None, max_examples=40)
@given(st.lists(st.floats(0, 1), min_size=1, max_size=20))
def test_holm_is_that_of_statsmodels(ps: list[float]) -> None:
    from statsmodels.stats.multitest import multipletests

    assert statistics.holm(ps) == pytest.approx(multipletests(ps, method="holm")[1].tolist(), **CLOSE)


def test_holm_by_hand_with_a_test_that_was_not_possible() -> None:
    assert statistics.holm([0.04, None, 0.01, 0.03]) == [pytest.approx(0.06), None, pytest.approx(0.03), pytest.approx(0.06)]
    assert statistics.holm([]) == []
    assert statistics.holm([None]) == [None]


def test_mcnemar() -> None:
    from statsmodels.stats.contingency_tables import mcnemar

    one = [True] * 10 + [False] * 5 + [True] * 9 + [False] * 2
    other = [True] * 10 + [False] * 5 + [False] * 9 + [True] * 2
    only, lacking, p = statistics.mcnemar(one, other)
    assert (only, lacking, p) == (9, 2, near(2 * sum(math.comb(11, k) for k in range(3)) / 2**11))
    assert p == near(mcnemar([[10, 9], [2, 5]], exact=True).pvalue)
    assert statistics.mcnemar([True] * 3, [True] * 3) == (0, 0, 1.0)
    assert statistics.mcnemar([False] * 3, [False] * 3) == (0, 0, 1.0)
    assert statistics.mcnemar([], []) == (0, 0, None)


def test_friedman_nemenyi_and_critical_difference() -> None:
    from scikit_posthocs import posthoc_nemenyi_friedman
    from scipy.stats import friedmanchisquare, studentized_range

    data = np.add(RNG.normal(size=(12, 4)), [0, 0.5, 1, 3])
    found = statistics.friedman({name: data[:, i].tolist() for i, name in enumerate("abcd")})
    assert found.statistic == near(friedmanchisquare(*data.T).statistic)
    assert found.p == near(friedmanchisquare(*data.T).pvalue)
    assert np.array(found.nemenyi) == pytest.approx(posthoc_nemenyi_friedman(data).to_numpy(), **CLOSE)
    assert found.critical_difference == near(studentized_range.ppf(0.95, 4, np.inf) / math.sqrt(2) * math.sqrt(20 / 72))
    assert found.critical_difference == pytest.approx(2.569 * math.sqrt(20 / 72), rel=2e-4), "the table of Demsar 2006"
    assert sum(found.ranks) == near(10)


def test_ranks_by_hand_with_ties_and_failures() -> None:
    found = statistics.friedman({"a": [1, 1, 1], "b": [2, 1, None], "c": [3, 2, None]})
    assert found.ranks == (near((1 + 1.5 + 1) / 3), near((2 + 1.5 + 2.5) / 3), near((3 + 3 + 2.5) / 3))
    assert statistics.friedman({"a": [1, 2], "b": [2, 1]}, lower_is_better=False).ranks == (1.5, 1.5)


def test_friedman_at_its_edges() -> None:
    tied = statistics.friedman({name: [1.0] * 5 for name in "abc"})
    assert (tied.statistic, tied.p, tied.ranks, tied.groups) == (None, 1.0, (2, 2, 2), (("a", "b", "c"),))
    two = statistics.friedman({"a": [1, 2], "b": [2, 3]})
    assert (two.p, two.critical_difference, two.ranks) == (None, None, (1, 2))
    assert statistics.friedman({}).blocks == 0
    failed = statistics.friedman({"a": [None, None], "b": [None, None], "c": [None, None]})
    assert (failed.blocks, failed.ranks) == (0, ())
    assert statistics.friedman({"a": [1], "b": [2], "c": [3]}).p is None


def test_groups_of_methods_that_are_not_told_apart() -> None:
    assert statistics.groups("abcd", [1.0, 1.5, 2.4, 4.0], 1.0) == (("a", "b"), ("b", "c"))
    assert statistics.groups("abcd", [4.0, 1.5, 2.4, 1.0], 9.0) == (("d", "b", "c", "a"),)
    assert statistics.groups("ab", [1.0, 2.0], 0.5) == ()


def test_growth() -> None:
    from scipy.stats import linregress, t

    sizes = np.array([20, 30, 50, 70, 100.0])
    exact = statistics.growth(sizes, 3 * sizes**1.7)
    assert exact is not None
    assert (exact.exponent, exact.factor, exact.r2) == (near(1.7), near(3), near(1))
    noisy = 0.1 * sizes**2 * np.exp(RNG.normal(0, 0.1, 5))
    found, line = statistics.growth(sizes, noisy), linregress(np.log(sizes), np.log(noisy))
    assert found is not None
    assert found.high == near(line.slope + t.ppf(0.975, 3) * line.stderr)


def test_growth_at_its_edges() -> None:
    assert statistics.growth([10, 10], [1, 2]) is None
    assert statistics.growth([], []) is None
    two = statistics.growth([10, 100, 0, 5], [1, 100, 4, -1])
    assert two is not None
    assert (two.points, two.exponent, two.low, two.high) == (2, near(2), None, None)
    flat = statistics.growth([10, 20, 40], [3, 3, 3])
    assert flat is not None
    assert (flat.exponent, flat.r2) == (near(0), None)


def test_auc_by_hand() -> None:
    scores, labels = [0.9, 0.8, 0.7, 0.6, 0.55, 0.4], [True, True, False, True, False, False]
    found = statistics.auc(scores, labels)
    assert (found.auc, found.positives, found.negatives) == (near(8 / 9), 3, 3)
    # placements: positives 1, 1, 2/3; negatives 2/3, 1, 1; variances 1/27 each, over 3 each
    half = 1.959963984540054 * math.sqrt(2 * (1 / 27) / 3)
    assert (found.low, found.high) == (near(8 / 9 - half), 1.0)


@settings(deadline=None, max_examples=40)
@given(st.lists(st.tuples(st.integers(0, 5), st.booleans()), min_size=2, max_size=30))
def test_auc_is_the_area_under_the_curve(rows: list[tuple[int, bool]]) -> None:
    scores, labels = zip(*rows, strict=True)
    found, points = statistics.auc(scores, labels), statistics.roc(scores, labels)
    if found.auc is None:
        assert points == []
        return
    area = sum((x1 - x0) * (y0 + y1) / 2 for (x0, y0), (x1, y1) in itertools.pairwise(points))
    assert area == near(found.auc)
    assert points[0] == (0, 0)
    assert points[-1] == (1, 1)


def test_auc_without_one_class() -> None:
    assert statistics.auc([1, 2], [True, True]) == statistics.Area(None, None, None, 2, 0)
    one = statistics.auc([1, 2, 3], [True, False, False])
    assert (one.auc, one.low) == (0.0, None)


CURVE = [[10, 5.0], [20, 4.0], [30, 4.0], [40, 3.000001], [60, 3.0], [100, 3.0]]


def test_convergence() -> None:
    assert curves.convergence(CURVE) == 40, "within 1e-6 of the final value"
    assert curves.convergence(CURVE, 1e-9) == 60
    assert curves.convergence([[7, 2.0]]) == 7
    assert curves.convergence([]) is None
    assert curves.convergence([[1, math.nan]]) is None
    assert curves.convergence([[1, -1.0], [2, -2.0]]) == 2


def test_expected_running_time_by_hand() -> None:
    runs = [([[10, 5.0], [40, 1.0]], 100.0), ([[20, 1.0]], 100.0), ([[10, 5.0]], 100.0), (None, 100.0)]
    found = curves.expected(runs, 1.0)
    assert found == curves.Expected((40 + 20 + 100 + 100) / 2, 2, 4, 260)
    assert curves.expected(runs, 0.5) == curves.Expected(None, 0, 4, 400)
    assert curves.expected([(None, None)], 1.0) is None
    assert curves.expected([], 1.0) is None


def test_bands() -> None:
    rows = curves.band([[[10, 5.0], [20, 3.0]], [[20, 4.0]], [[10, 1.0], [30, 1.0]]])
    assert rows == [[10, 3.0, 5.0, None], [20, 2.0, 3.0, 3.5], [30, 2.0, 3.0, 3.5]]
    assert curves.band([None, [], [[1, math.inf]]]) == []
    long = [[[k, 1e5 - k] for k in range(1, 50_000)]]
    assert len(curves.band(long)) <= 96
    assert curves.band(long)[-1][0] == 49_999


def test_distributions() -> None:
    assert curves.distribution([3.0, 1.0, None, 1.0]) == [[1.0, 0.5], [3.0, 0.75]]
    assert curves.distribution([None]) == []
    assert curves.distribution([float(k) for k in range(1000)], 50)[-1] == [999.0, 1.0]
    assert len(curves.distribution([float(k) for k in range(1000)], 50)) == 50


def test_performance_profiles_by_hand() -> None:
    found = curves.profile({"a": [1.0, 2.0, None, 3.0], "b": [2.0, 1.0, 5.0, None]})
    assert found == {"a": [[1.0, 0.5], [2.0, 0.75]], "b": [[1.0, 0.5], [2.0, 0.75]]}
    assert curves.profile({"a": [None], "b": [None]}) == {"a": [], "b": []}
    assert curves.profile({"a": [0.0], "b": [1.0]}) == {"a": [[1.0, 1.0]], "b": []}
    assert curves.profile({"a": [], "b": []}) == {"a": [], "b": []}


@pytest.mark.parametrize(
    ("value", "noise", "verdict"),
    [(2.2, 0.01, "holds"), (1.8, 0.01, "does not hold"), (2.0, 0.3, "cannot be judged")],
)
def test_growth_is_judged_by_the_interval_of_its_exponent(value: float, noise: float, verdict: str) -> None:
    text = {
        "schema": 1, "name": "t", "kind": "plan", "metrics": ["length"], "methods": [{"name": "m", "planner": "astar"}],
        "worlds": [{"name": "{size} {density}", "make": "complexity", "seed": 0, "each": {"size": [10, 20, 40, 80], "density": [0.1, 0.3]}}],
        "claims": [{"says": "it grows so", "test": "growth", "metric": "length", "method": "m", "value": value}],
    }  # fmt: skip
    experiment, rng, records = of_data("t.toml", "t.toml", text), np.random.default_rng(1), []
    for run in experiment.runs()[:: len(experiment.seeds)]:
        size, density = run.world["size"], run.world["density"]
        measures = {"length": 3 * size**2.0 * (1 + (density > 0.2)) * math.exp(noise * rng.standard_normal())}
        key = {"world": run.world["name"], "query": "", "method": "m", "seed": 0}
        records.append({**key, "status": "ok", "measures": measures, "certified": True})
    table = cells.grid(experiment, records)
    found = judge(table, experiment.claims[0])
    assert found["verdict"] == verdict, found["reason"]
    groups = found["numbers"]["groups"]
    assert [row["group"] for row in groups] == ["density 0.1", "density 0.3"]
    logs = np.log([[r["measures"]["length"], float(r["world"].split()[0])] for r in records if r["world"].endswith("0.1")])
    assert groups[0]["exponent"] == near(float(np.polyfit(logs[:, 1], logs[:, 0], 1)[0]))
    assert [(row["low"], row["high"]) for row in growing.growths(table, ())] == [(row["low"], row["high"]) for row in groups]
