"""Alternatives and the exact fallback, as scripts and people use them."""

import json

import jsonschema
import pytest

import guideway as gw
from guideway import schemas
from guideway.cli import main
from guideway.io import load


def run(*words, capsys, status=0):
    assert main([*words]) == status
    return capsys.readouterr().out


@pytest.fixture(scope="module")
def scene():
    return gw.World.load("scene:pso-aco-1")


def query_of(world, **words):
    return gw.Query(world, (0.5, 0.5), (19.5, 19.5), **words)


def test_plan_with_alternatives(tmp_path, capsys):
    out, report = tmp_path / "plan.json", tmp_path / "plan.html"
    text = run("plan", "scene:pso-aco-1", "--planner", "lexicographic", "--pareto", "--out", str(out), "--report", str(report), capsys=capsys)
    record = json.loads(out.read_text())
    jsonschema.validate(record, schemas.load("plan"))
    rows = record["alternatives"]
    assert record["pareto"]["complete"] is True
    assert record["pareto"]["stop"] == "converged"
    assert f"alternatives {len(rows)} (all of them)" in text
    assert "alternatives" in report.read_text()
    shortest = rows[0]
    assert (shortest["length"], shortest["turns"]) == (pytest.approx(28.62741699796952), 3)
    assert record["reference"]["grid_turns"] == 3
    assert record["reference"]["grid_gap"] == 0
    for i, row in enumerate(rows):
        assert row["energy"] == pytest.approx(row["length"] + 0.5 * row["turns"])
        assert row["grid_path"][0] == [0.5, 0.5]
        assert row["grid_path"][-1] == [19.5, 19.5]
        for other in rows[:i] + rows[i + 1 :]:
            better = other["length"] <= row["length"], other["turns"] <= row["turns"], other["min_clearance"] >= row["min_clearance"]
            assert not all(better)


def test_without_the_option_nothing_is_added(capsys):
    record = json.loads(run("plan", "scene:m20", "--planner", "astar", "--json", capsys=capsys))
    assert "alternatives" not in record
    assert record["search"]["fallback"] is False
    assert record["reference"]["grid_turns"] == 2


def test_the_set_through_the_interface(scene):
    found = gw.pareto(query_of(scene))
    assert found["complete"]
    few = gw.pareto(query_of(scene), searches=1)
    assert not few["complete"]
    assert few["stop"] == "budget"
    assert 0 < len(few["alternatives"]) <= len(found["alternatives"])
    with pytest.raises(gw.BadParameter):
        gw.pareto(query_of(scene, via=[(0.5, 2.5)]))
    with pytest.raises(gw.NoPath):
        gw.pareto(query_of(scene), seconds=0.0)


def test_least_energy_is_one_of_the_alternatives(scene):
    best = gw.lattice_optimum(scene, (0, 19), (19, 0), aim="energy")
    assert best is not None
    found = gw.pareto(query_of(scene, material="heavy"))
    assert min(row["energy"] for row in found["alternatives"]) == pytest.approx(best["energy"])


def test_the_exact_path_stands_in_for_a_poor_one(capsys):
    words = ("plan", "scene:pso-aco-1", "--planner", "aco", "--set", "preset=paper", "--iterations", "1", "--seed", "3")
    poor = json.loads(run(*words, "--json", capsys=capsys))
    assert poor["reference"]["grid_gap"] > 0
    good = json.loads(run(*words, "--exact-fallback", "--json", capsys=capsys))
    jsonschema.validate(good, schemas.load("plan"))
    assert good["reference"]["grid_gap"] == 0
    assert good["search"]["fallback"] is True
    assert good["search"]["heuristic"]["raw_length"] == poor["search"]["raw_length"]
    assert "fallback     the exact path; aco found" in run(*words, "--exact-fallback", capsys=capsys)


def test_an_optimum_is_not_replaced(scene):
    found = gw.plan(query_of(scene), "astar", exact_fallback=True)
    assert (found.fallback, found.heuristic) == (False, None)
    with pytest.raises(gw.BadParameter):
        gw.plan(query_of(scene), "visibility", exact_fallback=True)
    heavy = gw.plan(query_of(scene, material="heavy"), "dijkstra", exact_fallback=True)
    reference = gw.reference(query_of(scene, material="heavy"), heavy)
    assert reference["grid_energy_gap"] == 0


def test_a_job_may_ask_for_both(tmp_path, capsys):
    job = tmp_path / "job.toml"
    job.write_text(
        "[world]\nbounds = [0, 0, 6, 4]\nresolution = 0.25\n[[disc]]\ncenter = [3, 2.1]\nradius = 0.4\n[query]\nstart = [0.5, 2]\ngoal = [5.5, 2]\n"
        '[plan]\nplanner = "astar"\npareto = true\nexact_fallback = true\n'
    )
    record = json.loads(run("plan", str(job), "--json", capsys=capsys))
    assert record["pareto"]["complete"]
    assert len(record["alternatives"]) > 1
    job.write_text(job.read_text().replace("pareto = true", "pareto = 1"))
    with pytest.raises(gw.BadFile):
        load(job)
    assert main(["plan", "scene:m20", "--pareto", "--via", "3.5,3.5"]) == 2


def test_figures(scene, tmp_path):
    pytest.importorskip("matplotlib")
    from guideway.view import alternatives_figure

    record = {"query": {"start": [0.5, 0.5], "goal": [19.5, 19.5]}} | gw.pareto(query_of(scene))
    assert all(path.stat().st_size > 1000 for path in alternatives_figure(record, scene, tmp_path / "front"))
    with pytest.raises(ValueError, match="--pareto"):
        alternatives_figure({}, scene, tmp_path / "front")
