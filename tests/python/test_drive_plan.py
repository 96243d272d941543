"""A plan that is driven later: what it keeps of its scene, and what of an edited one is refused."""

import copy
import json

import jsonschema
import pytest

import guideway as gw
from guideway.cli import main
from guideway.commands.drive import summary

SCENE = """
[world]
bounds = [0, 0, 6, 4]
mover_speed = 0.5
[[disc]]
center = [3, 2]
radius = 0.4
[[mover]]
shape = { disc = 0.2 }
path = [[4.5, 0.5], [4.5, 3.5]]
speed = 0.3
loop = "shuttle"
[robot]
footprint = { disc = 0.25 }
acceleration = 1.0
jerk = 5.0
turn_rate = 2.0
turn_acceleration = 0.7
[lidar]
beams = 90
range = 4.0
noise = 0.02
rate = 10.0
[query]
start = [0.6, 1.9]
goal = [5.4, 2.1]
clearance = 0.1
arrival = 0.4
time_limit = 45.0
stop = false
"""


@pytest.fixture
def room(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.toml").write_text(SCENE)
    assert main(["plan", "room.toml", "--out", "plan.json"]) == 0
    return tmp_path


def test_a_plan_is_driven_as_its_scene_is(room):
    plan = json.loads((room / "plan.json").read_text())
    jsonschema.validate(plan, gw.schemas.load("plan"))
    assert plan["trajectory"]["limits"]["turn_acceleration"] == 0.7
    runs = []
    for what in ("room.toml", "plan.json"):
        assert main(["drive", what, "--sense", "lidar", "--seed", "3", "--out", "run.json"]) == 0
        runs.append(json.loads((room / "run.json").read_text()))
    scene, later = runs
    assert later["robot"]["turn_acceleration"] == 0.7
    assert later["query"]["arrival"] == 0.4
    assert later["lidar"]["beams"] == 90
    assert later["mover_speed"] == 0.5
    for timed in ("step_seconds", "plan_seconds"):
        assert scene.pop(timed)
        assert later.pop(timed)
    assert {name for name in scene if scene[name] != later[name]} <= {"trace"}
    assert abs(scene["driven"][-1][4]) > 0.1, "it need not stop"


def edited(plan):
    """What an edit does to the pieces, the path or the settings of a plan."""
    pieces = plan["trajectory"]["pieces"]

    def negative():
        pieces[1]["duration"] *= -1

    def reversed_():
        pieces.reverse()

    def shifted():
        plan["path"]["control_points"] = [[x, y + 0.5] for x, y in plan["path"]["control_points"]]

    def longer():
        plan["trajectory"]["duration"] += 1

    def another_goal():
        plan["query"]["goal"][0] -= 1

    def words():
        plan["drive"]["arrival"] = "near"

    return [
        (negative, "pieces take"),
        (reversed_, "position"),
        (shifted, "path ends"),
        (longer, "pieces take"),
        (another_goal, "path ends"),
        (words, "drive.arrival"),
    ]


def test_edited_plans_are_refused(room, capsys):
    plan = json.loads((room / "plan.json").read_text())
    for k, (_, named) in enumerate(edited(plan)):
        changed = copy.deepcopy(plan)
        edited(changed)[k][0]()
        (room / "edited.json").write_text(json.dumps(changed))
        capsys.readouterr()
        assert main(["drive", "edited.json"]) == 2, named
        error = capsys.readouterr().err
        assert named in error
        assert "edited.json" in error


def test_the_summary_tells_how_long_plans_and_steps_took(room):
    main(["drive", "plan.json", "--controller", "tracker", "--time-limit", "1", "--out", "run.json"])
    run = json.loads((room / "run.json").read_text())
    steps = run["step_seconds"]
    assert steps["real_time_factor"] == pytest.approx(0.02 / steps["p99"])
    assert "(99 %: 0.500 ms, 40 x real time)" in summary(run | {"step_seconds": steps | {"p99": 5e-4, "real_time_factor": 40.0}})
    none, some = ({"mean": x, "p50": x, "p95": x, "p99": 2 * x} for x in (0.0, 0.04))
    assert "planning" not in summary(run | {"plan_seconds": none})
    assert "visibility, 40.0 ms a plan (99 %: 80.0 ms), for which the simulation stood still" in summary(run | {"plan_seconds": some})
    assert "each driven 0.3 s after it was asked for" in summary(run | {"plan_seconds": some, "plan_time": 0.3})


def test_plans_may_take_time(room):
    scene = SCENE.replace("[robot]", "[[mover]]\nshape = { disc = 0.3 }\npath = [[2, 3.2], [2, 3.2]]\nspeed = 1\nappears = { at = 1.0 }\n[robot]")
    (room / "parked.toml").write_text(scene.replace("goal = [5.4, 2.1]", "goal = [2, 3.1]").replace("stop = false", ""))
    runs = []
    for wait in ("0", "0.4"):
        main(["drive", "parked.toml", "--plan-time", wait, "--out", "run.json"])
        runs.append(json.loads((room / "run.json").read_text()))
        jsonschema.validate(runs[-1], gw.schemas.load("run"))
        assert runs[-1]["plan_time"] == float(wait)
    at_once, later = ([event for event in run["events"] if event["kind"] in ("asked", "no-plan", "replan")] for run in runs)
    assert at_once
    assert {event["kind"] for event in at_once} <= {"no-plan", "replan"}
    assert later[0]["kind"] == "asked"
    assert later[1]["t"] - later[0]["t"] == pytest.approx(0.4, abs=1e-6)
