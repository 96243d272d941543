"""The report of experiments: summary, page, tables, figures, logs; from records of any kind, hostile ones too."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest

pytest.importorskip("scipy")
pytest.importorskip("statsmodels")
pytest.importorskip("scikit_posthocs")

from guideway import schemas
from guideway.errors import BadFile
from guideway.lab.report import load, write_report
from guideway.lab.report.tables import escape
from guideway.lab.summary import summary
from pages import drawn

HOSTILE = "<script>alert(1)</script> & \"x\" 'y' $\\frac{1}{2}$ _%#~^ {ü} 路径 |a\\b"
SPEC = """
schema = 1
name = "fixture"
title = {title}
source = "han2024"
table = "Table 2"
kind = "plan"
seeds = 8
budget = {{ evaluations = 100 }}
metrics = ["length", "turns", "gap"]
reference = "length"
{worlds}
{methods}
{rest}
"""
CLAIMS = """
[[published]]
table = "Table 2"
world = "one"
method = "good"
metric = "length"
statistic = "mean"
value = 10.1
[[claims]]
says = "good is shorter than poor"
test = "lower"
metric = "length"
method = "good"
than = ["poor"]
[[claims]]
says = "poor is shorter than good"
test = "lower"
metric = "length"
method = "poor"
than = ["good"]
[[claims]]
says = "good takes ten"
test = "within"
metric = "length"
method = "good"
value = 10.5
tolerance = 1
[[claims]]
says = "poor always succeeds"
test = "share"
metric = "success"
method = "poor"
value = 1
[[claims]]
says = "nobody can say"
test = "none"
reason = "no formula is given"
"""


def spec(worlds: list[str], methods: list[str], title: str = "A fixture", rest: str = "") -> str:
    places = "\n".join(f"[[worlds]]\nname = {json.dumps(name)}\nsource = 'scene:pso-aco-1'" for name in worlds)
    ways = "\n".join(f"[[methods]]\nname = {json.dumps(name)}\nplanner = 'aco'" for name in methods)
    return SPEC.format(title=json.dumps(title), worlds=places, methods=ways, rest=rest)


def record(world: str, method: str, seed: int, length: float, **more: Any) -> dict[str, Any]:
    measures = {"length": length, "turns": seed % 3, "gap": 100 * (length / 10 - 1), "optimum": 10.0}
    base = {"schema": 1, "experiment": "fixture", "digest": "d" * 64, "world": world, "query": "", "method": method, "seed": seed, "status": "ok"}
    base |= {"error": None, "measures": measures, "curve": [[10, 2 * length], [50 + seed, length]], "path": [[0.5, 0.5], [3, 3 + seed / 10], [9, 9]]}
    return (
        base
        | {"certified": True, "times": {"wall": 0.1 + seed / 100, "cpu": 0.1}, "peak_mib": 50.0, "version": "0.1.0", "machine": {"cpu": "x"}}
        | more
    )


def failed(world: str, method: str, seed: int, status: str = "failed") -> dict[str, Any]:
    error = {"type": "NoPath", "message": "there is no path"}
    return record(world, method, seed, 0, status=status, error=error, measures={}, curve=None, path=None, certified=None)


def put(folder: Path, text: str, records: list[dict[str, Any]], name: str = "fixture") -> Path:
    folder.mkdir(exist_ok=True)
    (folder / f"{name}.toml").write_text(text, "utf-8")
    (folder / f"{name}.jsonl").write_text("".join(json.dumps(row) + "\n" for row in records), "utf-8")
    return folder


def usual(folder: Path) -> Path:
    rows = [record(world, "good", seed, 10 + 0.1 * seed) for world in ("one", "two") for seed in range(8)]
    rows += [record(world, "poor", seed, 12 + 0.2 * seed) for world in ("one", "two") for seed in range(7)]
    rows += [failed("one", "poor", 7), failed("two", "poor", 7, "timeout")]
    rows += [record(world, "third", seed, 11 + 0.01 * seed) for world in ("one", "two") for seed in range(8)]
    return put(folder, spec(["one", "two"], ["good", "poor", "third"], rest=CLAIMS), rows)


def summaries(folder: Path) -> dict[str, Any]:
    found = load(folder)[0]
    return summary(found.experiment, found.records)


def test_summary_says_what_the_records_say(tmp_path: Path) -> None:
    one = summaries(usual(tmp_path / "runs"))
    cell = next(c for c in one["cells"] if (c["world"], c["method"]) == ("one", "poor"))
    assert cell["success"]["hits"] == 7
    assert cell["measures"]["length"]["mean"] == pytest.approx(12.6)
    assert cell["measures"]["length"]["best"] == 12
    assert cell["errors"] == [{"status": "failed", "type": "NoPath", "message": "there is no path", "seeds": [7]}]
    good = one["cells"][0]
    assert (good["ert"]["successes"], good["ert"]["runs"]) == (2, 8), "gap 0 and 1 % with 0.1 m a seed"
    assert good["ert"]["value"] == (50 + 51 + 6 * 100) / 2, "runs that never got there used their whole budget"
    assert [claim["verdict"] for claim in one["claims"]] == ["holds", "does not hold", "holds", "does not hold", "cannot be judged"]
    assert one["published"][0]["ours"] == pytest.approx(10.35)
    assert one["runs"] == {"recorded": 48, "expected": 48, "missing": 0, "unknown": 0, "stale": 48}
    assert one["ranks"][0]["ranks"][0] == 1
    assert {row["p_holm"] < 0.05 for row in one["comparisons"] if row["metric"] == "length" and row["world"] is None} == {True}
    assert one["alarms"] == []


def test_an_invalid_path_is_a_failure_and_never_averaged(tmp_path: Path) -> None:
    rows = [record("one", "good", seed, 10.0) for seed in range(4)]
    rows += [record("one", "good", 4, 1.0, status="invalid", certified=False), record("one", "good", 5, 1.0, certified=False)]
    one = summaries(put(tmp_path / "runs", spec(["one"], ["good"]), rows))
    assert one["cells"][0]["success"] == {"hits": 4, "runs": 6} | {k: one["cells"][0]["success"][k] for k in ("share", "low", "high")}
    assert one["cells"][0]["measures"]["length"]["mean"] == 10
    assert one["alarms"] == [], "what is not certified is no result"


def test_a_path_better_than_the_optimum_is_an_alarm(tmp_path: Path) -> None:
    folder = put(tmp_path / "runs", spec(["one"], ["good"]), [record("one", "good", 0, 9.99), record("one", "good", 1, 10.0 * (1 - 1e-12))])
    assert [alarm["seed"] for alarm in summaries(folder)["alarms"]] == [0]
    assert '"alarms":[{' in write_report(folder, figures=False).read_text("utf-8")


def test_seeds_that_repeat_nothing_count_once(tmp_path: Path) -> None:
    rows = [
        record(world, method, seed, length) for world in ("one", "two") for method, length in (("good", 10.0), ("poor", 11.0)) for seed in range(8)
    ]
    one = summaries(put(tmp_path / "runs", spec(["one", "two"], ["good", "poor"], rest=CLAIMS), rows))
    assert one["claims"][0]["numbers"]["comparisons"][0]["pairs"] == 2
    assert [claim["verdict"] for claim in one["claims"][:2]] == ["holds", "does not hold"]


def test_worlds_that_say_the_opposite_refute_a_claim(tmp_path: Path) -> None:
    rows = [record("one", "good", seed, 10 + 0.01 * seed) for seed in range(20)] + [
        record("one", "poor", seed, 12 + 0.1 * seed) for seed in range(20)
    ]
    rows += [record("two", "good", seed, 11 + 0.01 * seed) for seed in range(8)] + [record("two", "poor", seed, 10 + 0.1 * seed) for seed in range(8)]
    claim = summaries(put(tmp_path / "runs", spec(["one", "two"], ["good", "poor"], rest=CLAIMS), rows))["claims"][0]
    assert claim["verdict"] == "does not hold"
    assert claim["numbers"]["comparisons"][0]["reversed_on"] == ["two"]


@pytest.mark.parametrize(
    "rows", [[failed("one", "good", 0)], [record("one", "good", 0, 10.0)], [record("one", "good", 0, 10.0, measures={}, times={})]]
)
def test_few_poor_or_empty_records(tmp_path: Path, rows: list[dict[str, Any]]) -> None:
    folder = put(tmp_path / "runs", spec(["one", "two"], ["good", "poor"], rest=CLAIMS), rows)
    write_report(folder, tmp_path / "out")
    found = json.loads((tmp_path / "out/summary.json").read_text("utf-8"), parse_constant=pytest.fail)
    jsonschema.Draft202012Validator(schemas.load("summary")).validate(found)
    assert found["experiments"][0]["runs"]["missing"] == 31
    assert {claim["verdict"] for claim in found["experiments"][0]["claims"][:2]} == {"cannot be judged"}


def test_the_page_of_results(tmp_path: Path) -> None:
    write_report(usual(tmp_path / "runs"), tmp_path / "out", figures=False, markdown=tmp_path / "results.md")
    text = (tmp_path / "results.md").read_text("utf-8")
    assert "| 1 | 2 | 2 | 1 | 48 | 2 |" in text, "experiments, holds, does not hold, cannot be judged, runs, failed"
    assert "| poor always succeeds |  | **does not hold** | 14 of 16 runs, 87.5 %" in text
    assert "| Table 2 | one | good | length (mean) | 10.1000 | 10.3500 | +2.5 % |" in text
    assert "`guideway lab run fixture`" in text
    assert "[A fixture]" not in text
    widths = {len(re.findall(r"(?<!\\)\|", line)) for line in text.splitlines() if line.startswith("| good")}
    assert widths == {6}, "claims and methods have five columns each"


def test_hostile_names_do_not_break_the_page_of_results(tmp_path: Path) -> None:
    write_report(hostile(tmp_path / "runs"), tmp_path / "out", figures=False, markdown=tmp_path / "results.md")
    text = (tmp_path / "results.md").read_text("utf-8")
    assert "<script>" not in text
    assert "<!--" not in text


def test_folders_without_experiments_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadFile, match="no records of experiments"):
        write_report(tmp_path)
    with pytest.raises(BadFile, match="no such folder"):
        write_report(tmp_path / "nowhere")
    (tmp_path / "stray.jsonl").write_text(json.dumps(record("one", "good", 0, 1.0)) + "\n")
    with pytest.raises(BadFile, match=r"stray\.toml is not beside it"):
        write_report(tmp_path)


def test_everything_is_written_and_equal_the_second_time(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    folder = usual(tmp_path / "runs")
    for out in ("a", "b"):
        write_report(folder, tmp_path / out)
    files = sorted(path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*") if path.is_file())
    names = [str(file) for file in files]
    assert {"report.html", "summary.json", "tables/fixture.csv", "tables/fixture.tex", "tables/claims.csv", "ompl/fixture-one.log"} <= set(names)
    kinds = ["boxes-one", "boxes-two", "convergence-one", "convergence-two", "ecdf", "profile", "ranks-gap", "ranks-length", "ranks-turns", "time"]
    assert sorted(name for name in names if name.endswith(".svg")) == [f"figures/fixture-{kind}.svg" for kind in kinds]
    assert all((tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes() for file in files)
    assert write_report(folder, tmp_path / "c/mine.html", figures=False) == tmp_path / "c/mine.html"


def test_summary_fits_its_schema(tmp_path: Path) -> None:
    write_report(usual(tmp_path / "runs"), tmp_path / "out", figures=False)
    found = json.loads((tmp_path / "out/summary.json").read_text("utf-8"), parse_constant=pytest.fail)
    validator = jsonschema.Draft202012Validator(schemas.load("summary"))
    validator.validate(found)
    found["experiments"][0]["claims"][0]["verdict"] = "perhaps"
    assert not validator.is_valid(found)


def hostile(folder: Path) -> Path:
    error = {"type": HOSTILE, "message": HOSTILE + "\nhttps://example.org"}
    rows = [record(HOSTILE, HOSTILE, seed, 10.0 + seed) for seed in range(3)] + [record(HOSTILE, "=1+1", seed, 11.0) for seed in range(3)]
    rows.append(failed(HOSTILE, HOSTILE, 3) | {"error": error, "version": HOSTILE, "machine": {"name": HOSTILE, "cpu": "http://x"}})
    rest = f"[[claims]]\nsays = {json.dumps(HOSTILE)}\ntest = 'none'\nreason = {json.dumps(HOSTILE)}"
    return put(folder, spec([HOSTILE], [HOSTILE, "=1+1"], HOSTILE, rest), rows)


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    page = write_report(hostile(tmp_path / "runs"), tmp_path / "out").read_text("utf-8")
    assert "<script>alert" not in page
    assert len(re.findall(r"<script", page)) == 2
    assert not re.search(r"https?://", page.replace('"http:" + "//www.w3.org/2000/svg"', ""))
    assert "default-src 'none'" in page
    assert not re.search(
        r"""\b(?:src|href)\s*=\s*["']?(?!#)\w|@import|url\((?!#)""", re.sub(r'<script type="application/json".*?</script>', "", page, flags=re.S)
    )
    rows = list(csv.reader((tmp_path / "out/tables/fixture.csv").open(encoding="utf-8")))
    assert {row[0] for row in rows[1:]} == {HOSTILE}
    assert {row[2] for row in rows[1:]} == {HOSTILE, "'=1+1"}
    for figure in (tmp_path / "out/figures").glob("*.svg"):
        assert "<script" not in figure.read_text("utf-8")


def test_latex_is_escaped() -> None:
    plain = re.sub(r"\\text\w+\{\}|\\ldots\{\}|\\[{}$&#%_]|\{\[\}|\{\]\}|\$[-\\a-z^0-9]+\$", "", escape(HOSTILE))
    assert not re.search(r"[\\{}$&#%_^~<>|]", plain), plain
    assert escape("a\nb\x00c") == "a b c"
    assert escape("50 % of a_b") == r"50 \% of a\_b"


def test_latex_tables_have_the_cells_they_announce(tmp_path: Path) -> None:
    write_report(usual(tmp_path / "runs"), tmp_path / "out", figures=False)
    text = (tmp_path / "out/tables/fixture.tex").read_text("utf-8")
    assert text.count(r"\begin{table}") == text.count(r"\end{table}") == 4
    assert all(line.count("&") == 2 for line in text.splitlines() if line.endswith(r"\\"))
    assert r"good & $\mathbf{10.3500} \pm 0.2048$ & $\mathbf{10.3500} \pm 0.2048$ \\" in text


def ompl_log(path: Path) -> dict[str, Any]:
    """A benchmark log as its readers take it apart."""
    lines = iter(path.read_text("utf-8").splitlines())
    head = {"version": next(lines).split(), "experiment": next(lines).split(), "host": next(lines).split(), "start": next(lines)}
    for _ in range(2):
        assert next(lines) == "<<<|"
        while next(lines) != "|>>>":
            pass
    assert next(lines).endswith("is the random seed")
    assert next(lines).endswith("seconds per run")
    assert next(lines).endswith("MB per run")
    head["runs"] = int(next(lines).removesuffix(" runs per planner"))
    assert next(lines).endswith("seconds spent to collect the data")
    assert next(lines) == "1 enum type"
    head["status"] = next(lines).split("|")[1:]
    planners = {}
    for _ in range(int(next(lines).removesuffix(" planners"))):
        name = next(lines)
        settings = [next(lines) for _ in range(int(next(lines).split()[0]))]
        columns = [next(lines).rsplit(" ", 1)[0] for _ in range(int(next(lines).split()[0]))]
        rows = [dict(zip(columns, next(lines).split("; ")[:-1], strict=True)) for _ in range(int(next(lines).split()[0]))]
        courses: list[list[list[str]]] = []
        if (line := next(lines)) != ".":
            assert [next(lines) for _ in range(int(line.split()[0]))] == ["time REAL", "evaluations INTEGER", "best_cost REAL"]
            count = int(next(lines).split()[0])
            courses = [[step.split(",")[:-1] for step in next(lines).split(";")[:-1]] for _ in range(count)]
            assert next(lines) == "."
        planners[name] = {"settings": settings, "rows": rows, "courses": courses}
    assert next(lines, None) is None
    return head | {"planners": planners}


def test_benchmark_logs(tmp_path: Path) -> None:
    write_report(usual(tmp_path / "runs"), tmp_path / "out", figures=False)
    found = ompl_log(tmp_path / "out/ompl/fixture-one.log")
    assert found["version"] == ["Guideway", "version", "0.1.0"]
    assert found["experiment"] == ["Experiment", "fixture-one"]
    assert list(found["planners"]) == ["good", "poor", "third"]
    poor = found["planners"]["poor"]
    assert poor["settings"] == ["planner = aco"]
    assert [row["solved"] for row in poor["rows"]] == ["1"] * 7 + ["0"]
    assert (poor["rows"][7]["solution_length"], poor["rows"][7]["length"]) == ("", "")
    assert float(poor["rows"][2]["solution_length"]) == pytest.approx(12.4)
    assert found["status"][int(poor["rows"][0]["status"])] == "Exact solution"
    assert [float(v) for v in poor["courses"][0][-1]] == pytest.approx([0.05, 50, 12])
    timeout = ompl_log(tmp_path / "out/ompl/fixture-two.log")
    assert timeout["status"][int(timeout["planners"]["poor"]["rows"][7]["status"])] == "Timeout"


def test_benchmark_logs_of_hostile_names_keep_their_form(tmp_path: Path) -> None:
    write_report(hostile(tmp_path / "runs"), tmp_path / "out", figures=False)
    (path,) = (tmp_path / "out/ompl").iterdir()
    found = ompl_log(path)
    assert (len(found["experiment"]), len(found["host"]), len(found["planners"])) == (2, 3, 2)


def test_ompl_reads_the_logs(tmp_path: Path) -> None:
    tools = pytest.importorskip("ompl.tools")
    import sqlite3

    write_report(usual(tmp_path / "runs"), tmp_path / "out", figures=False)
    write_report(hostile(tmp_path / "odd"), tmp_path / "out2", figures=False)
    logs = [str(path) for out in ("out", "out2") for path in sorted((tmp_path / out / "ompl").iterdir())]
    tools.readBenchmarkLog(str(tmp_path / "b.db"), logs, False)
    tools.computeViews(str(tmp_path / "b.db"), False)
    base = sqlite3.connect(tmp_path / "b.db")
    assert base.execute("SELECT count(*), sum(solved), round(sum(solution_length), 6) FROM runs WHERE experimentid = 1").fetchall()[0][:2] == (24, 23)


@pytest.mark.slow
def test_a_large_experiment_stays_small(tmp_path: Path) -> None:
    worlds, methods = [f"world {k}" for k in range(100)], [f"method {k}" for k in range(10)]
    line = [[0.1 * k, 5 + 4 * math.sin(0.07 * k)] for k in range(300)]
    curve = [[10 * k, 30 - 0.05 * k] for k in range(1, 200)]
    rows = [record(w, m, s, 10 + s + 0.1 * k, path=line, curve=curve) for w in worlds for k, m in enumerate(methods) for s in range(10)]
    found = load(put(tmp_path / "runs", spec(worlds, methods, rest="").replace("seeds = 8", "seeds = 10"), rows))
    from guideway.lab.report import page

    text = page([summary(one.experiment, one.records) for one in found], found)
    assert len(rows) == 10_000
    assert len(text) < 10_000_000


@pytest.mark.usefixtures("browser")
def test_the_page_draws_itself(tmp_path: Path) -> None:
    page = write_report(usual(tmp_path / "runs"), tmp_path / "out", figures=False)
    text, complaints = drawn(page.as_uri(), tmp_path)
    assert not complaints
    assert text.count('class="cell"') == 6
    for title in ("Claims", "Convergence", "Targets reached over evaluations", "Spread over the seeds", "Ranks", "Performance profile"):
        assert title in text
    assert "does not hold" in text
    assert "1 of 8 failed" in text


@pytest.mark.usefixtures("browser")
def test_a_cell_shows_its_runs_and_hostile_text_stays_text(tmp_path: Path) -> None:
    page = write_report(hostile(tmp_path / "runs"), tmp_path / "out", figures=False)
    text = page.read_text("utf-8").replace("</body>", "<script>document.querySelector('.cell').click()</script></body>")
    page.write_text(text, "utf-8")
    shown, complaints = drawn(page.as_uri(), tmp_path)
    assert not complaints
    assert "1 run failed" in shown
    assert "there is no path" not in shown
    assert "&lt;script&gt;alert(1)" in shown
    assert '<canvas role="img"' in shown


@pytest.mark.usefixtures("browser")
def test_several_experiments_have_an_overview(tmp_path: Path) -> None:
    folder = usual(tmp_path / "runs")
    other = (folder / "fixture.toml").read_text("utf-8").replace('"fixture"', '"second"').replace("A fixture", "Another")
    put(folder, other, [record("one", "good", 0, 10.0)], "second")
    shown, complaints = drawn(write_report(folder, figures=False).as_uri(), tmp_path)
    assert not complaints
    assert shown.count('class="row"') == 2
    assert "All experiments" in shown


def test_a_method_that_could_not_be_run_is_not_judged(tmp_path: Path) -> None:
    error = {"type": "MissingExtra", "message": "it needs a library"}
    rows = [record("one", "good", seed, 10.0 + seed) for seed in range(8)] + [failed("one", "poor", seed) | {"error": error} for seed in range(8)]
    claims = summaries(put(tmp_path / "runs", spec(["one"], ["good", "poor"], rest=CLAIMS), rows))["claims"]
    assert {claims[k]["verdict"] for k in (0, 1, 3)} == {"cannot be judged"}
    assert claims[3]["reason"] == "poor could not be run here: MissingExtra: it needs a library"


def test_what_nobody_could_do_is_left_out_only_where_the_claim_says_so(tmp_path: Path) -> None:
    def refused(method: str, seed: int, words: str, kind: str = "Infeasible") -> dict[str, Any]:
        return record("one", method, seed, 1.0, status="failed", certified=None, measures={}, error={"type": kind, "message": words})

    rows = [record("one", method, seed, 10.0) for method in ("good", "poor") for seed in range(10)]
    rows += [refused(method, 10, "static overload: 41 N m") for method in ("good", "poor")]
    claim = '[[claims]]\nsays = "it succeeds"\ntest = "share"\nmetric = "success"\nmethod = "good"\nvalue = 1\n'

    def verdict(name: str, more: list[dict[str, Any]], possible: str) -> dict[str, Any]:
        return summaries(put(tmp_path / name, spec(["one"], ["good", "poor"], rest=claim + possible), rows + more))["claims"][0]

    plain, fair = verdict("plain", [], ""), verdict("fair", [], "possible = true\n")
    assert plain["verdict"] != "holds"
    assert "10 of 11 runs" in plain["reason"]
    assert fair["verdict"] == "holds"
    assert "10 of 10 runs" in fair["reason"]
    assert "1 runs left out" in fair["reason"]
    # refused alone, in other words, or for another reason: that is the method's failure
    own = verdict("own", [refused("good", 11, "static overload: 40 N m"), record("one", "poor", 11, 10.0)], "possible = true\n")
    assert "10 of 11 runs" in own["reason"]
    other = verdict("other", [refused("good", 11, "no way"), refused("poor", 11, "gave up")], "possible = true\n")
    assert "10 of 11 runs" in other["reason"]
    broken = verdict("broken", [refused(method, 11, "a bug", "ValueError") for method in ("good", "poor")], "possible = true\n")
    assert "10 of 11 runs" in broken["reason"]


def test_yes_and_no_have_the_interval_of_a_rate(tmp_path: Path) -> None:
    rows = [record("one", "good", seed, 10.0, measures={"turns": seed > 1}) for seed in range(6)]
    found = summaries(put(tmp_path / "runs", spec(["one"], ["good"]), rows))["cells"][0]["measures"]["turns"]
    assert (found["mean"], found["rate"]) == (pytest.approx(2 / 3), True)
    z = 1.959963984540054
    middle, half = (2 / 3 + z * z / 12) / (1 + z * z / 6), z * math.sqrt(2 / 9 / 6 + z * z / 144) / (1 + z * z / 6)
    assert (found["low"], found["high"]) == (pytest.approx(middle - half), pytest.approx(middle + half))


def test_ranks_leave_out_what_has_no_value_and_put_failures_last(tmp_path: Path) -> None:
    rows = [record("one", "good", seed, 10.0 + seed) for seed in range(6)] + [failed("one", "poor", seed) for seed in range(6)]
    rows += [record("one", "third", seed, 5.0 if seed else 0, measures={"length": 5.0 + seed} if seed else {}) for seed in range(6)]
    rows += [record("one", "mute", seed, 0, measures={"turns": 1}) for seed in range(6)]
    one = summaries(put(tmp_path / "runs", spec(["one"], ["good", "poor", "third", "mute"]), rows))
    found = next(row for row in one["ranks"] if row["metric"] == "length")
    assert (found["methods"], found["blocks"], found["ranks"]) == (["good", "poor", "third"], 5, [2, 3, 1])
    assert {(row["world"], row["query"]) for row in one["comparisons"]} == {(None, None)}


def test_success_is_what_the_kind_says_it_is(tmp_path: Path) -> None:
    rows = [record("one", "good", seed, 10.0, measures={"length": 10.0, "success": seed > 0}) for seed in range(4)] + [failed("one", "good", 4)]
    cell = summaries(put(tmp_path / "runs", spec(["one"], ["good"]), rows))["cells"][0]
    assert (cell["success"]["hits"], cell["success"]["runs"], cell["failed"], cell["measures"]["length"]["n"]) == (3, 5, 1, 4)


def test_the_page_leaves_out_what_it_does_not_show() -> None:
    from guideway.lab.report.lean import lean

    stats = {"n": 3, "mean": 1 / 3, "sd": 1.0, "low": 0.1, "high": 0.5, "least": 0.0, "q1": 0.1, "median": 0.2, "q3": 0.3, "most": 1.0}
    cell = {"measures": {"length": stats, "other": stats}, "times": {"cpu": stats, "wall": stats}}
    curve = [{"world": str(k), "query": "", "method": m, "rows": [[j / 7, 1 / 3, 1 / 3, 1 / 3] for j in range(96)]} for k in range(300) for m in "ab"]
    metrics = [{"name": "length", "first": True}, {"name": "other", "first": False}]
    small = lean({"metrics": metrics, "cells": [cell], "overall": [cell], "curves": {"convergence": curve}}, 500_000)
    assert set(small["cells"][0]["measures"]) == {"length"}
    assert small["cells"][0]["measures"]["length"]["mean"] == 0.3333333
    assert set(small["cells"][0]["times"]) == {"cpu"}
    kept = small["curves"]["convergence"]
    assert 0 < len(json.dumps(kept, separators=(",", ":"))) <= 500_000
    assert len(kept) % 2 == 0, "all methods of a world or none"
