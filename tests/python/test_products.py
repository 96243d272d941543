"""The three products of one query: shortest, safest, least energy."""

import json
from pathlib import Path

import jsonschema
import pytest

from guideway import schemas
from guideway.cli import main

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "crates/guideway/tests/scenes/pso-aco-1.txt"
ENDS = ["--start", "0.5,0.5", "--goal", "19.5,19.5"]


def run_json(words, capsys):
    assert main([*words, "--json"]) == 0
    plan = json.loads(capsys.readouterr()[0])
    jsonschema.validate(plan, schemas.load("plan"))
    assert plan["certificate"]["ok"]
    return plan


def plan(material, capsys, *more, scene=SCENE):
    return run_json(["plan", str(scene), *ENDS, "--material", material, *more], capsys)


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
