"""The same records from a Dask cluster, whatever becomes of its workers."""

import json
import random
import subprocess
import sys
import time

import pytest

import guideway as gw
from guideway import lab
from guideway.lab import journal
from test_lab_runs import EXPECTED, MISCHIEF, SEARCHES, command, experiment, lines, records

pytest.importorskip("distributed")


class Cluster:
    """A scheduler and workers as programs of their own."""

    def __init__(self, folder, environment):
        self.file, self.environment, self.workers = folder / "scheduler.json", environment, []
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        while not self.file.exists():
            time.sleep(0.05)
            assert self.scheduler.poll() is None
        self.address = json.loads(self.file.read_text())["address"].replace("tcp://", "dask://")

    def start(self, what, *words):
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", "--scheduler-file", str(self.file), *words]
        return subprocess.Popen(command, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def join(self):
        self.workers.append(self.start("worker", "--no-nanny", "--nthreads", "1", "--no-dashboard", "--host", "127.0.0.1", "--memory-limit", "0"))

    def kill(self, number):
        worker = self.workers.pop(number)
        worker.kill()
        worker.wait()

    def close(self):
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path):
    from test_lab_runs import environment

    found = Cluster(tmp_path, environment())
    yield found
    found.close()


def check_workers_die(cluster, folder, times, seeds):
    path, total, draw = experiment(folder, SEARCHES.format(seeds=seeds)), 20 * seeds, random.Random(3)
    lab.run(lab.read(path), folder / "whole", workers=2)
    for _ in range(2):
        cluster.join()
    process = command("run", path, "--out", folder / "there", "--cluster", cluster.address)
    kills, there = 0, folder / "there" / "searches.jsonl"
    while kills < times:
        goal = lines(there) + draw.randrange(max(2, total // times - 1))
        while process.poll() is None and lines(there) < goal:
            time.sleep(0.005)
        assert process.poll() is None, process.stderr.read()
        cluster.join()
        cluster.kill(0)
        kills += 1
    assert process.wait(300) == 0, process.stderr.read()
    assert len(journal.read(there)) == total
    assert records(folder / "there") == records(folder / "whole")


def test_workers_die_and_join(cluster, tmp_path):
    check_workers_die(cluster, tmp_path, 2, 6)


@pytest.mark.slow
def test_twenty_workers_die_in_two_thousand_runs(cluster, tmp_path):
    check_workers_die(cluster, tmp_path, 20, 100)


def test_a_method_that_misbehaves_costs_one_record_here_too(tmp_path):
    names = ["segfault", "hang", "many", "none", "nan", "killed"]
    trial = lab.read(experiment(tmp_path, MISCHIEF.replace("HOW", json.dumps(names))))
    lab.run(trial, tmp_path, cluster="local:1")
    found = records(tmp_path, "mischief")
    assert len(found) == 3 * len(names)
    assert all(record["status"] == (EXPECTED[record["method"]] if record["seed"] == 1 else "ok") for record in found)


def test_a_cluster_that_is_not_there(tmp_path, monkeypatch):
    monkeypatch.setattr("guideway.lab.cluster.CONNECT", 1)
    trial = lab.read(experiment(tmp_path, MISCHIEF.replace("HOW", '["none"]')))
    for cluster, told in (
        ("dask://", "cannot be read"),
        ("local:0", "1 to 1024"),
        ("local:x", "cannot be read"),
        ("dask://127.0.0.1:9", "cannot be reached"),
    ):
        with pytest.raises(gw.GuidewayError, match=told):
            lab.run(trial, tmp_path, cluster=cluster)
    with pytest.raises(gw.BadParameter, match="--workers"):
        lab.run(trial, tmp_path, cluster="local", workers=2)
