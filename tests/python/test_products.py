"""The three products of one query: shortest, safest, least energy."""

import json

import jsonschema
import numpy as np
import pytest

import guideway as gw
from guideway import jobs, products, schemas
from guideway.cli import main
from guideway.view.report import bundle


def run_json(words, capsys):
    assert main([*words, "--json"]) == 0
    plan = json.loads(capsys.readouterr()[0])
    jsonschema.validate(plan, schemas.load("plan"))
    assert plan["certificate"]["ok"]
    return plan


def plan(material, capsys, *more, scene="scene:pso-aco-1"):
    return run_json(["plan", scene, "--material", material, *more], capsys)


@pytest.mark.parametrize("planner", ["visibility", "theta-star", "jump-point"])
@pytest.mark.parametrize("refine", ["none", "simplify", "smooth"])
def test_a_long_load_never_touches(planner, refine, capsys):
    record = plan("long", capsys, "--planner", planner, "--refine", refine)
    assert record["query"]["corners"] == "clear"
    assert record["metrics"]["min_clearance"] > 0.5 - 1e-9
    marking = next(check for check in record["certificate"]["checks"] if check["name"] == "security marking")
    assert marking["ok"]
    assert marking["limit"] == 0.5


def test_the_half_width_comes_from_option_or_scene_and_blocks(tmp_path, capsys):
    room = "[world]\nbounds = [0, 0, 10, 6]\n[[disc]]\ncenter = [5, 3]\nradius = 1.0\n[query]\nstart = [1, 3]\ngoal = [9, 3]\nhalf_width = 0.6\n"
    (tmp_path / "room.toml").write_text(room + 'material = "long"\n')
    where = str(tmp_path / "room.toml")
    record = run_json(["plan", where], capsys)
    assert record["query"]["half_width"] == 0.6
    assert record["metrics"]["min_clearance"] >= 0.6 - 1e-9
    wider = run_json(["plan", where, "--half-width", "0.9"], capsys)
    assert wider["metrics"]["min_clearance"] >= 0.9 - 1e-9
    standard = run_json(["plan", where, "--material", "standard"], capsys)
    assert standard["metrics"]["min_clearance"] < 0.1
    assert main(["plan", where, "--half-width", "2.5"]) == 3
    assert main(["plan", where, "--half-width=-1"]) == 2
    assert "half_width" in capsys.readouterr().err


@pytest.mark.parametrize(("scene", "length"), [("scene:pso-aco-1", 15 * 2**0.5 + 8), ("scene:pso-aco-2", 10 * 2**0.5 + 18)])
def test_the_safest_product_stays_on_the_lattice(scene, length, capsys):
    record = plan("long", capsys, "--planner", "jump-point", "--refine", "simplify", scene=scene)
    assert record["metrics"]["length"] == pytest.approx(length, abs=1e-9)
    assert np.allclose(np.mod(record["polyline"], 1), 0.5)


@pytest.mark.parametrize(("scene", "energy"), [("scene:pso-aco-1", 30.1274), ("scene:pso-aco-2", 32.7990)])
def test_least_energy_is_chosen_among_splines_and_wide_bends(scene, energy, capsys):
    raw = plan("heavy", capsys, "--planner", "lexicographic", "--refine", "none", scene=scene)
    assert raw["metrics"]["energy"] == pytest.approx(energy, abs=5e-5)
    spline = plan("heavy", capsys, "--planner", "lexicographic", "--refine", "bspline", scene=scene)
    assert spline["metrics"]["length"] < raw["metrics"]["length"]
    assert len(spline["path"]["control_points"]) >= len(spline["grid_path"])
    least = plan("heavy", capsys, "--planner", "lexicographic", scene=scene)
    rows = least["candidates"]
    assert {row["refine"] for row in rows} == {"smooth", "bspline"}
    assert [row["drive_energy"] for row in rows if row["chosen"]] == [min(row["drive_energy"] for row in rows)]
    found = [record["metrics"]["drive_energy"] for record in (least, spline, raw)]
    assert found == sorted(found)
    assert found[0] == next(row["drive_energy"] for row in rows if row["chosen"])
    assert "candidates" not in raw


def test_energy_follows_the_motion(capsys):
    slow = plan("heavy", capsys, "--speed", "0.3")
    fast = plan("heavy", capsys, "--speed", "1.5")
    assert slow["metrics"]["drive_energy"] < fast["metrics"]["drive_energy"]
    assert plan("heavy", capsys, "--no-timing")["metrics"]["drive_energy"] is None


def test_a_curvature_limit_comes_before_energy(capsys):
    free = plan("heavy", capsys, "--planner", "lexicographic")
    tight = 0.6 * free["metrics"]["max_curvature"]
    bound = plan("heavy", capsys, "--planner", "lexicographic", "--max-curvature", str(tight))
    if bound["metrics"]["max_curvature"] > tight * (1 + 1e-6):
        assert bound["unmet"]
        assert all(row["max_curvature"] is None or row["max_curvature"] > tight for row in bound["candidates"])
    else:
        assert not bound["unmet"]


def compare(scene, capsys, *more):
    return run_json(["plan", scene, "--compare-materials", *more], capsys)


def distance(a, b):
    """Largest distance of the points of ``a`` from the segments of ``b``, m."""
    a, b = np.asarray(a), np.asarray(b)
    p, d = b[:-1], np.diff(b, axis=0)
    t = np.clip(((a[:, None] - p) * d).sum(2) / (d**2).sum(1), 0, 1)
    return float(np.hypot(*(a[:, None] - p - t[..., None] * d).T).min(axis=0).max())


@pytest.mark.parametrize(
    ("scene", "more", "apart"), [("scene:pso-aco-1", ["--planner", "lexicographic"], 0.4), ("scene:warehouse", ["--half-width", "0.8"], 0.4)]
)
def test_three_visibly_different_products_of_one_query(scene, more, apart, capsys):
    record = compare(scene, capsys, *more)
    found = record["products"]
    assert list(found) == ["standard", "long", "heavy"]
    assert found["standard"]["path"] == record["path"]
    for name, product in found.items():
        assert product["query"]["material"] == name
        assert product["certificate"]["ok"]
        jsonschema.validate({**record, **product}, schemas.load("plan"))
    lines = {name: product["polyline"] for name, product in found.items()}
    for first, second in (("standard", "long"), ("standard", "heavy"), ("long", "heavy")):
        assert distance(lines[first], lines[second]) > apart, (first, second)
    figures = {name: product["metrics"] for name, product in found.items()}
    assert figures["long"]["min_clearance"] == max(each["min_clearance"] for each in figures.values()) >= 0.45
    assert figures["heavy"]["drive_energy"] == min(each["drive_energy"] for each in figures.values())


def test_the_asked_product_is_the_plan_and_the_report_shows_all(tmp_path, capsys):
    (tmp_path / "plan.json").write_text(json.dumps(compare("scene:pso-aco-1", capsys, "--material", "long")))
    record = json.loads((tmp_path / "plan.json").read_text())
    assert record["query"]["material"] == "long"
    assert record["path"] == record["products"]["long"]["path"]
    entries = bundle([record])["entries"]
    assert [entry["label"] for entry in entries] == ["Shortest", "Safest", "Least energy"]
    assert [entry["data"]["asked"] for entry in entries] == [False, True, False]
    # Scene 1 has room for no bend that saves more than its way costs, and the report says so.
    assert record["products"]["heavy"]["path"] == record["products"]["standard"]["path"]
    assert "least energy" in entries[0]["data"]["warnings"][0]
    assert main(["view", str(tmp_path / "plan.json"), "--out", str(tmp_path / "view.html")]) == 0
    assert "Least energy" in (tmp_path / "view.html").read_text()


def test_a_product_that_cannot_be_had_is_told_and_spoils_nothing(capsys):
    record = compare("scene:pso-aco-1", capsys, "--half-width", "0.7")
    assert record["products"]["long"]["error"] == "StartBlocked"
    entries = bundle([record])["entries"]
    assert [entry["label"] for entry in entries] == ["Shortest", "Least energy"]
    assert any("Safest" in text for text in entries[0]["data"]["warnings"])
    assert main(["plan", "scene:pso-aco-1", "--compare-materials", "--material", "long", "--half-width", "0.7"]) == 3
    assert main(["plan", "scene:pso-aco-1", "--compare-materials", "--half-width", "0.7"]) == 0
    assert "StartBlocked" in capsys.readouterr().out


def test_refine_from_python():
    world = gw.World.load("scene:pso-aco-1")
    query = gw.Query(world, (0.5, 0.5), (19.5, 19.5), material="heavy")
    raw = gw.plan(query, "lexicographic").path
    every, gentle = gw.refine(raw, query, "bspline").path, gw.refine(raw, query, "bspline", spacing=2.0).path
    assert len(every.control_points) > len(gentle.control_points)
    assert gw.refine(raw, query, stretch=0.1).path.degree == 3
    with pytest.raises(gw.BadParameter, match="spacing"):
        gw.refine(raw, query, "bspline", spacing=-1)


def test_options_that_do_not_go_together_are_told(capsys):
    assert main(["plan", "scene:pso-aco-1", "--half-width", "0.3", "--no-timing"]) == 0
    assert "--material long" in capsys.readouterr().err
    assert main(["plan", "scene:pso-aco-1", "--compare-materials", "--scen", "x.scen"]) == 2
    assert "--scen" in capsys.readouterr().err


def test_interrupted_comparisons_keep_the_plan_that_was_asked_for(monkeypatch):
    world = gw.World.load("scene:pso-aco-1")
    job = jobs.Job(world, start=(0.5, 0.5), goal=(19.5, 19.5), material="long")
    real = jobs.run

    def stopped(each, folder):
        if each.material != "long":
            raise KeyboardInterrupt
        return real(each, folder)

    monkeypatch.setattr(jobs, "run", stopped)
    with pytest.raises(KeyboardInterrupt) as caught:
        products.compare(job, ".", own=True)
    assert caught.value.outcome.record["query"]["material"] == "long"  # type: ignore[attr-defined]
