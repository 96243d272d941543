"""Runs: every misfortune costs one record, a stopped experiment goes on, and records do not depend on the number of workers."""

import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import guideway as gw
from guideway import lab
from guideway.lab import journal

HERE = Path(__file__).parent
VOLATILE = ("times", "peak_mib", "machine")

SEARCHES = """
schema = 1
name = "searches"
kind = "lab_trials.kind"
seeds = {seeds}
budget = {{ evaluations = 200 }}
limits = {{ seconds = 60, memory_mib = 1024 }}
[[worlds]]
name = "random {{size}}"
each = {{ size = [8, 10] }}
[[queries]]
name = "touch"
[[queries]]
name = "clear"
corners = "clear"
[[methods]]
name = "{{planner}}"
each = {{ planner = ["aco", "improved-aco", "pso-aco", "pso", "rrt-star"] }}
"""

MISCHIEF = """
schema = 1
name = "mischief"
kind = "lab_trials.kind"
seeds = 3
limits = { seconds = 1.5, memory_mib = 400 }
[[worlds]]
name = "one"
[[methods]]
name = "{how}"
each = { how = HOW }
"""

EXPECTED = {
    "segfault": "crashed",
    "hang": "timeout",
    "sleep": "timeout",
    "leave": "crashed",
    "exit": "crashed",
    "abort": "crashed",
    "close": "crashed",
    "large": "memory",
    "many": "memory",
    "none": "failed",
    "error": "failed",
    "killed": "crashed",
    "scribble": "crashed",
    "nan": "invalid",
    "infinite": "invalid",
    "colliding": "invalid",
    "nonsense": "invalid",
}


def experiment(folder, text):
    name = next(line for line in text.splitlines() if line.startswith("name")).split('"')[1]
    path = folder / f"{name}.toml"
    path.write_text(text)
    return path


def records(folder, name="searches"):
    """Records without what differs from machine to machine, by key."""
    found = [{key: value for key, value in record.items() if key not in VOLATILE} for record in journal.read(folder / f"{name}.jsonl")]
    return sorted(found, key=journal.key_of)


def environment():
    """One in which other programs find the kind of these tests."""
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(HERE), *filter(None, sys.path)])}


def command(*words):
    return subprocess.Popen([sys.executable, "-m", "guideway", "lab", *map(str, words)], stderr=subprocess.PIPE, text=True, env=environment())


def lines(path):
    return path.read_bytes().count(b"\n") if path.exists() else 0


def killed_again_and_again(path, out, times, total, more=("--workers", "2")):
    """Starts and kills it, each time after a random number of records more, then lets it end."""
    draw, kills = random.Random(7), 0
    while kills < times:
        goal = lines(out / "searches.jsonl") + draw.randrange(max(2, total // times - 1))
        process = command("run", path, "--out", out, "--resume", *more)
        while process.poll() is None and lines(out / "searches.jsonl") < goal:
            time.sleep(0.002)
        time.sleep(draw.random() * 0.02)
        assert process.poll() is None, process.stderr.read()
        process.send_signal(signal.SIGKILL)
        process.communicate()
        kills += 1
    assert lines(out / "searches.jsonl") < total
    process = command("run", path, "--out", out, "--resume", *more)
    assert process.wait() == 0, process.stderr.read()


def check_killed(folder, times, seeds):
    path, total = experiment(folder, SEARCHES.format(seeds=seeds)), 20 * seeds
    lab.run(lab.read(path), folder / "whole", workers=2)
    killed_again_and_again(path, folder / "broken", times, total)
    found = records(folder / "broken")
    assert len({journal.key_of(record) for record in found}) == len(found) == total
    assert found == records(folder / "whole")


def test_killed_and_resumed_it_loses_and_repeats_nothing(tmp_path):
    check_killed(tmp_path, 4, 10)


@pytest.mark.slow
def test_twenty_kills_in_two_thousand_runs(tmp_path):
    check_killed(tmp_path, 20, 100)


def test_the_number_of_workers_changes_nothing(tmp_path):
    trial = lab.read(experiment(tmp_path, SEARCHES.format(seeds=3)))
    for workers in (1, 2, 4):
        lab.run(trial, tmp_path / str(workers), workers=workers)
    first = records(tmp_path / "1")
    assert {record["status"] for record in first} == {"ok"}
    assert len(first) == 60
    assert first == records(tmp_path / "2") == records(tmp_path / "4")


def test_a_method_that_misbehaves_costs_one_record(tmp_path):
    trial = lab.read(experiment(tmp_path, MISCHIEF.replace("HOW", json.dumps(list(EXPECTED)))))
    lab.run(trial, tmp_path, workers=2)
    jsonschema = pytest.importorskip("jsonschema")
    for record in journal.read(tmp_path / "mischief.jsonl"):
        jsonschema.validate(record, gw.schemas.load("record"))
    found = records(tmp_path, "mischief")
    assert len(found) == 3 * len(EXPECTED)
    for record in found:
        bad = record["seed"] == 1
        assert record["status"] == (EXPECTED[record["method"]] if bad else "ok"), record
        assert (record["error"] is not None) == bad
        assert not bad or record["error"]["message"]


def test_a_method_that_becomes_two_processes_does_not_add_records(tmp_path):
    trial = lab.read(experiment(tmp_path, MISCHIEF.replace("1.5", "60").replace("HOW", '["fork"]').replace("seeds = 3", "seeds = 40")))
    assert lab.run(trial, tmp_path, workers=2) == {"ok": 40}
    assert [record["seed"] for record in records(tmp_path, "mischief")] == list(range(40))


def test_workers_end_with_a_coordinator_that_is_killed(tmp_path):
    text = MISCHIEF.replace("HOW", '["hang"]').replace("seconds = 1.5", "seconds = 1000").replace("seeds = 3", "seeds = [0, 1]")
    process = command("run", experiment(tmp_path, text), "--out", tmp_path, "--workers", "1")
    while not lines(tmp_path / "mischief.jsonl"):
        time.sleep(0.01)
        assert process.poll() is None
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    if not children.exists():
        pytest.skip("no /proc here")
    workers = children.read_text().split()
    process.kill()
    process.communicate()
    assert workers
    for _ in range(500):
        if not any(Path(f"/proc/{worker}").exists() for worker in workers):
            return
        time.sleep(0.01)
    pytest.fail("a worker lives on")


def test_interrupted_it_says_how_to_go_on(tmp_path):
    path = experiment(tmp_path, SEARCHES.format(seeds=100))
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)  # a job in the background of a script ignores it, and so would its children
    process = command("run", path, "--out", tmp_path, "--workers", "1")
    signal.signal(signal.SIGINT, before)
    while not lines(tmp_path / "searches.jsonl"):
        time.sleep(0.01)
        assert process.poll() is None
    process.send_signal(signal.SIGINT)
    _, told = process.communicate()
    assert process.returncode == 130
    assert "--resume" in told
    assert "Traceback" not in told
    assert len(journal.read(tmp_path / "searches.jsonl")) == lines(tmp_path / "searches.jsonl")


def test_records_are_not_added_to_by_accident(tmp_path):
    path = experiment(tmp_path, MISCHIEF.replace("HOW", '["none"]'))
    trial = lab.read(path)
    lab.run(trial, tmp_path, workers=1)
    with pytest.raises(gw.BadParameter, match="--resume"):
        lab.run(trial, tmp_path, workers=1)
    before = (tmp_path / "mischief.jsonl").read_bytes()
    assert lab.run(trial, tmp_path, workers=1, resume=True) == {"ok": 2, "failed": 1}
    assert (tmp_path / "mischief.jsonl").read_bytes() == before
    assert lab.run(lab.with_seeds(trial, 5), tmp_path, workers=1, resume=True) == {"ok": 4, "failed": 1}
    other = lab.read(experiment(tmp_path, MISCHIEF.replace("HOW", '["error"]')))
    with pytest.raises(gw.BadParameter, match="another version"):
        lab.run(other, tmp_path, workers=1, resume=True)


def test_the_copy_of_the_file_says_what_was_run(tmp_path):
    text = MISCHIEF.replace("HOW", '["none", "error"]') + '[quick]\nseeds = 1\nmethods = ["none"]\n'
    trial = lab.quick(lab.read(experiment(tmp_path, text)))
    lab.run(trial, tmp_path / "out", workers=1)
    again = lab.read(tmp_path / "out" / "mischief.toml")
    assert again.folder == str(tmp_path)
    assert [run.key for run in again.runs()] == [run.key for run in trial.runs()]
    assert again.digest == trial.digest


def test_one_coordinator_per_folder(tmp_path):
    from guideway.lab.folder import locked

    trial = lab.read(experiment(tmp_path, MISCHIEF.replace("HOW", '["none"]')))
    with locked(tmp_path), pytest.raises(gw.BadParameter, match="at work"):
        lab.run(trial, tmp_path, workers=1)


def test_a_full_disk_leaves_whole_records_and_says_how_to_go_on(tmp_path):
    trial = lab.read(experiment(tmp_path, SEARCHES.format(seeds=2)))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, before[1]))
    try:
        with pytest.raises(gw.GuidewayError, match="--resume"):
            lab.run(trial, tmp_path, workers=1)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    data = (tmp_path / "searches.jsonl").read_bytes()
    assert data.endswith(b"\n")
    assert 0 < data.count(b"\n") < 40
    assert lab.run(trial, tmp_path, workers=1, resume=True) == {"ok": 40}


RECORD = {"schema": 1, "status": "ok", "world": "w", "query": "", "method": "m"}


@pytest.mark.parametrize("line", ['{"hello": 1}', "[]", '{"schema": 2, "status": "ok", "world": "w", "query": "", "method": "m", "seed": 0}'])
def test_files_of_others_are_not_taken_for_torn_ones(tmp_path, line):
    path = tmp_path / "foreign.jsonl"
    path.write_text(line + "\n")
    for use in (journal.read, journal.Journal):
        with pytest.raises(gw.BadFile, match="line 1"):
            use(path)
    assert path.read_text() == line + "\n"


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 5), st.integers(0, 400), st.binary(max_size=20))
def test_a_torn_last_line_does_not_count(tmp_path_factory, whole, cut, junk):
    path = tmp_path_factory.mktemp("journal") / "a.jsonl"
    kept = b"".join(journal.line_of(RECORD | {"seed": seed}) for seed in range(whole))
    torn = journal.line_of(RECORD | {"seed": 99})[:-1][: cut % 60] + junk.replace(b"\n", b"")
    path.write_bytes(kept + torn)
    assert [record["seed"] for record in journal.read(path)] == list(range(whole))
    with journal.Journal(path) as opened:
        opened.append(RECORD | {"seed": 7})
    assert [record["seed"] for record in journal.read(path)] == [*range(whole), 7]


def test_a_bad_line_among_records_is_named(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_bytes(journal.line_of(RECORD | {"seed": 0}) + b"{}\n" + journal.line_of(RECORD | {"seed": 1}))
    with pytest.raises(gw.BadFile, match="line 2"):
        journal.read(path)


def test_workers_that_do_not_start_are_told_of(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    trial = lab.read(experiment(tmp_path, MISCHIEF.replace("HOW", '["none"]')))
    with pytest.raises(gw.GuidewayError, match="do not start"):
        lab.run(trial, tmp_path, workers=1)
