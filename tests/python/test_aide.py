"""The planner ``aide`` on the packaged worlds: via points without a stop, its bound on the command line, its trace."""

import json

import numpy as np
import pytest

import guideway as gw
from guideway import jobs
from guideway.cli import main
from guideway.commands.plan import job_of_scene
from guideway.io import load


@pytest.fixture(scope="module")
def hall():
    job = job_of_scene(load("scene:warehouse"))
    job.planner, job.via = "aide", [(-4.6, 1.0), (4.0, 13.5)]
    return job, jobs.run(job)


def test_via_points_in_the_warehouse_are_passed_without_a_stop(hall):
    job, outcome = hall
    record = outcome.record
    assert record["certificate"]["ok"]
    assert outcome.solution.trace["encoding"]["followed"] is None
    rows = outcome.trajectory.sample(1000.0)
    moving = rows[rows[:, 4] > 1e-6]
    for x, y in job.via:
        away = np.hypot(moving[:, 1] - x, moving[:, 2] - y)
        assert away.min() < 5e-3
        assert moving[away.argmin(), 4] > 0.05
    # One motion from rest to rest: it slows down nowhere to nothing in between.
    inside = moving[(moving[:, 0] > moving[0, 0] + 0.3) & (moving[:, 0] < moving[-1, 0] - 0.3)]
    assert inside[:, 4].min() > 0.01
    step = 1e-3
    assert np.abs(np.diff(rows[:, 4])).max() <= 1.01 * step * max(job.limits.acceleration, job.limits.deceleration)
    assert np.abs(np.diff(moving[:, 5])).max() <= 1.01 * step * job.limits.jerk


def test_the_trace_tells_the_loop_the_classes_and_the_bound(hall):
    trace = hall[1].record["trace"]
    assert trace["loop"][-1]["remaining"] == []
    assert trace["speed"]["regions_after"] == []
    assert 1 <= len(trace["classes"]) <= 8
    assert all(row["length"] > 40 for row in trace["classes"])
    assert 0 < trace["bound"]["lower"] <= trace["bound"]["value"] == trace["objective"]["value"]


def test_the_command_line_prints_objective_and_gap(tmp_path, capsys):
    out = tmp_path / "plan.json"
    assert main(["plan", "scene:w0", "--planner", "aide", "--seed", "3", "--out", str(out)]) == 0
    text = capsys.readouterr().out
    bound = json.loads(out.read_text(encoding="utf-8"))["trace"]["bound"]
    assert f"objective    {bound['value']:.4f}" in text
    assert f"{100 * bound['gap']:.2f} % above" in text


def test_goals_that_cannot_be_reached_are_errors():
    world = gw.World(np.array([[0, 0, 0, 0, 0], [0, 1, 1, 1, 0], [0, 1, 0, 1, 0], [0, 1, 1, 1, 0], [0, 0, 0, 0, 0]], dtype=bool), 1.0)
    with pytest.raises(gw.NoPath):
        gw.plan(gw.Query(world, (0.5, 0.5), (2.5, 2.5)), "aide")
    with pytest.raises(gw.GoalBlocked):
        gw.plan(gw.Query(world, (0.5, 0.5), (1.5, 1.5)), "aide")
