"""Experiment files: what they say, and one clear error for each thing that can be wrong."""

import copy

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import guideway as gw
from guideway import lab
from guideway.lab import reading

TEXT = """
schema = 1
name = "trial"
title = "A trial"
source = "han2024"
table = "Table 2"
kind = "lab_trials.kind"
seeds = 4
budget = { evaluations = 100 }
limits = { seconds = 20, memory_mib = 1024 }
metrics = ["length", "own"]
reference = "length"
[metric.own]
unit = "m"
lower_is_better = false
digits = 2
[[worlds]]
name = "random {size} {corner}"
source = "file {corner}"
each = { size = [8, 9], corner = ["a", "b"] }
[[queries]]
name = "touch"
corners = "touch"
[[queries]]
name = "clear"
corners = "clear"
[[methods]]
name = "astar"
planner = "astar"
budget = { iterations = 5 }
[[methods]]
name = "improved-aco {rho} {off}"
planner = "improved-aco"
set = { preset = "paper" }
ablate = ["o1", "o2"]
each = { "set.rho" = [0.1, 0.2] }
[[published]]
table = "Table 2"
world = "random 8 a"
query = "clear"
method = "astar"
metric = "length"
statistic = "mean"
value = 28.6240
[[claims]]
says = "it is shorter"
table = "Table 2"
test = "lower"
metric = "length"
method = "astar"
than = ["improved-aco 0.1"]
worlds = ["random 8 a"]
[[claims]]
says = "it is better"
test = "none"
reason = "no measure is named"
[quick]
seeds = 2
worlds = ["random 8 a"]
queries = ["clear"]
methods = ["astar"]
budget = { evaluations = 10 }
"""
DATA = reading.parse_toml("trial.toml", TEXT)


def written(folder, text, name="trial.toml"):
    path = folder / name
    path.write_text(text)
    return path


@pytest.fixture
def trial(tmp_path):
    return lab.read(written(tmp_path, TEXT))


def test_grids_and_ablations_expand(trial):
    assert [world["name"] for world in trial.worlds] == ["random 8 a", "random 8 b", "random 9 a", "random 9 b"]
    assert trial.worlds[1] == {"name": "random 8 b", "size": 8, "source": "file b"}
    names = [method["name"] for method in trial.methods]
    assert names[:5] == ["astar", "improved-aco 0.1", "improved-aco 0.1 without o1", "improved-aco 0.1 without o2", "improved-aco 0.1 plain"]
    assert trial.methods[2]["set"] == {"preset": "paper", "rho": 0.1, "o1": False, "o2": True}
    assert trial.methods[8]["set"] == {"preset": "paper", "rho": 0.2, "o1": False, "o2": False}
    assert len(trial.runs()) == 4 * 2 * 9 * 4
    assert len({run.key for run in trial.runs()}) == 4 * 2 * 9 * 4


def test_methods_override_budget_and_limits(trial):
    astar, colony = trial.runs()[:2]
    assert astar.budget == {"evaluations": 100, "iterations": 5}
    assert colony.budget == {"evaluations": 100}
    assert astar.limits == {"seconds": 20, "memory_mib": 1024}


def test_measures_figures_and_claims(trial):
    assert trial.metrics == (lab.Metric("length", "m"), lab.Metric("own", "m", "higher", 2))
    assert trial.published == (lab.Published("Table 2", "random 8 a", "clear", "astar", "length", "mean", 28.624),)
    assert trial.claims[0].than == ("improved-aco 0.1",)
    assert trial.claims[1].reason == "no measure is named"


def test_the_quick_version(trial):
    small = lab.quick(trial)
    assert [len(getattr(small, name)) for name in ("seeds", "worlds", "queries", "methods")] == [2, 1, 1, 1]
    assert small.runs()[0].budget == {"evaluations": 10, "iterations": 5}
    assert small.digest != trial.digest
    assert lab.with_seeds(trial, 9).digest == trial.digest, "more seeds may be added to records that are there"


def test_without_a_quick_table_three_seeds_are_run(tmp_path):
    found = lab.read(written(tmp_path, TEXT.partition("[quick]")[0]))
    assert lab.quick(found).seeds == (0, 1, 2)
    assert lab.quick(found).digest == found.digest


WRONG = [
    ("schema = 1", "schema = 2", "field schema"),
    ("schema = 1", "", "field schema"),
    ('name = "trial"', 'name = "Trial/x"', "field name"),
    ('title = "A trial"', "title = 3", "field title"),
    ('title = "A trial"', 'titel = "A trial"', "Did you mean title"),
    ('source = "han2024"', 'source = "somebody"', "field source"),
    ('kind = "lab_trials.kind"', 'kind = "plans"', "plan | minimize | drive"),
    ('kind = "lab_trials.kind"', 'kind = "lab_trials.missing"', "field kind"),
    ("seeds = 4", "seeds = 0", "field seeds"),
    ("seeds = 4", "seeds = [1, 1]", "field seeds"),
    ("seeds = 4", "seeds = true", "field seeds"),
    ("seeds = 4", "seeds = 90000", "runs"),
    ("{ evaluations = 100 }", "{ evaluations = -1 }", "field evaluations"),
    ("{ evaluations = 100 }", "{ paths = 1 }", "evaluations, iterations, seconds"),
    ("{ evaluations = 100 }", "7", "[budget]"),
    ("seconds = 20", "seconds = nan", "field seconds"),
    ("memory_mib = 1024", "memory = 1024", "Did you mean memory_mib"),
    ('["length", "own"]', '["length", "unknown"]', "'unknown' is not known"),
    ('["length", "own"]', '"length"', "field metrics"),
    ('reference = "length"', 'reference = "weight"', "field reference"),
    ("digits = 2", "digits = 99", "field digits"),
    ("random {size} {corner}", "random", "the name 'random' is there twice"),
    ("random {size} {corner}", "random {sice}", "{sice}"),
    ("random {size} {corner}", "random\\u0000", "field name"),
    ("size = [8, 9]", "size = 8", "each, size"),
    ("size = [8, 9]", "size = []", "each, size"),
    ("size = [8, 9]", "size = [[1]]", "each, size"),
    ("size = [8, 9]", "length = [8, 9]", "the dimension length is no field"),
    ('ablate = ["o1", "o2"]', 'ablate = "o1"', "field ablate"),
    ('set = { preset = "paper" }', 'set = "paper"', "field set"),
    ('planner = "astar"', 'planer = "astar"', "Did you mean planner"),
    ('world = "random 8 a"', 'world = "random 7 a"', "[[published]] number 1, field world"),
    ('method = "astar"\nmetric = "length"\nstatistic', 'method = "x"\nmetric = "length"\nstatistic', "[[published]] number 1, field method"),
    ('statistic = "mean"', 'statistic = "average"', "mean | sd"),
    ("value = 28.6240", 'value = "28.6"', "field value"),
    ('test = "lower"', 'test = "best"', "lower | higher | within"),
    ('than = ["improved-aco 0.1"]', 'than = ["improved-aco"]', "field than"),
    ('than = ["improved-aco 0.1"]', "", "field than"),
    ('reason = "no measure is named"', "", "field reason"),
    ('worlds = ["random 8 a"]\nqueries', 'worlds = ["random"]\nqueries', "[quick], field worlds"),
    ("[quick]", "[quick]\nplanner = 3", "field planner"),
    ("schema = 1", "schema = = 1", "not valid TOML"),
    ("schema = 1", "schema = 1\ntune = 3", "[tune]"),
]


@pytest.mark.parametrize(("old", "new", "told"), WRONG, ids=lambda value: value[:24] if isinstance(value, str) else None)
def test_one_clear_error_names_the_field(tmp_path, old, new, told):
    assert old in TEXT
    with pytest.raises(gw.BadFile, match=r"trial\.toml") as error:
        lab.read(written(tmp_path, TEXT.replace(old, new, 1)))
    assert told in str(error.value)
    assert len(str(error.value)) < 700


def test_files_that_are_none(tmp_path):
    for make, told in (
        (lambda path: None, "No such file"),
        (lambda path: path.mkdir(), "folder"),
        (lambda path: path.write_bytes(b"\xff\xfe"), "UTF-8"),
        (lambda path: path.write_text(""), "empty"),
        (lambda path: path.write_text("a = [" + "[" * 5000), ""),
        (lambda path: path.write_bytes(b"# " + b"x" * (2 << 20)), "bytes"),
    ):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.toml"
        make(path)
        with pytest.raises(gw.BadFile) as error:
            lab.read(path)
        assert told.lower() in str(error.value).lower()


def test_a_grid_that_explodes_is_refused_before_it_is_made(tmp_path):
    lists = ", ".join(f'"set.p{number}" = {list(range(100))}' for number in range(20))
    text = TEXT.replace('each = { "set.rho" = [0.1, 0.2] }', f"each = {{ {lists} }}")
    with pytest.raises(gw.BadFile, match="the grid has"):
        lab.read(written(tmp_path, text))


PLACES = [
    (),
    ("worlds", 0),
    ("worlds", 0, "each"),
    ("methods", 1),
    ("methods", 1, "each"),
    ("published", 0),
    ("claims", 0),
    ("quick",),
    ("metric", "own"),
]
JUNK = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.dates() | st.sampled_from(["length", "astar", "{size}"]),
    lambda some: (
        st.lists(some, max_size=3) | st.dictionaries(st.text(max_size=6) | st.sampled_from(["name", "each", "set", "a.b"]), some, max_size=3)
    ),
    max_leaves=6,
)


def outcome(content, text=""):
    """What is wrong with it, or how many runs it has; any other exception fails the test."""
    try:
        content = reading.parse_toml("trial.toml", text) if content is None else content
        return "", len(reading.of_data("trial.toml", "trial.toml", content).runs())
    except gw.BadFile as error:
        return str(error), 0


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from(PLACES), st.data())
def test_mutated_tables_give_no_other_error(place, data):
    content = copy.deepcopy(DATA)
    table = content
    for part in place:
        table = table[part]
    key = data.draw(st.sampled_from(sorted(table)) | st.text(max_size=6))
    if data.draw(st.booleans()):
        table[key] = data.draw(JUNK)
    else:
        table.pop(key, None)
    told, runs = outcome(content)
    assert told.startswith("trial.toml") if told else 1 <= runs <= 100_000


@settings(max_examples=100, deadline=None)
@given(st.integers(0, len(TEXT)), st.integers(0, 30), st.text(max_size=5) | st.sampled_from(["[", "]]", '"', "\n", "=", "[[worlds]]\n", "\x00"]))
def test_mutated_files_give_no_other_error(at, cut, more):
    text = TEXT[:at] + more + TEXT[at + cut :]
    told, _ = outcome(None, text)
    assert not told or "trial.toml" in told
