"""The command line as users and scripts rely on it."""

import json
import os
import re
import signal
import subprocess
import sys
import time

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

import jsonschema
import numpy as np
import pytest

import guideway as gw
from guideway import schemas
from guideway.cli import main

ROOM = """[world]
bounds = [0, 0, 10, 6]
[[disc]]
center = [5, 3]
radius = 1.0
[[polygon]]
points = [[7, 0], [8, 0], [7.5, 2.6]]
[[mover]]
shape = { disc = 0.3 }
path = [[3, 1], [3, 5]]
speed = 0.5
loop = "shuttle"
[robot]
footprint = { disc = 0.2 }
speed = 1.2
acceleration = 1.0
deceleration = 0.8
jerk = 4.0
turn_rate = 2.0
turn_acceleration = 4.0
lateral_acceleration = 1.0
[query]
start = [1, 3, 0.5]
goal = [9, 2.5]
clearance = 0.1
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.toml").write_text(ROOM)
    (tmp_path / "a.map").write_text("type octile\nheight 4\nwidth 5\nmap\n.....\n.@@..\n..@..\n.....\n")


def timeless(record):
    record["search"]["seconds"] = 0.0
    return record


def run_json(words, capsys):
    assert main([*words, "--json"]) == 0
    out, _ = capsys.readouterr()
    return json.loads(out)


def test_plan_writes_what_it_promises(tmp_path, capsys):
    assert main(["plan", "room.toml", "--out", "plan.json", "--report", "plan.html", "--csv", "motion.csv"]) == 0
    plan = json.loads((tmp_path / "plan.json").read_text())
    jsonschema.validate(plan, schemas.load("plan"))
    assert plan["certificate"]["ok"]
    assert plan["reference"]["any_angle_gap"] >= -1e-9
    assert plan["world"]["source"] == "room.toml"
    assert plan["polyline"][0] == [1, 3]
    assert plan["polyline"][-1] == [9, 2.5]
    rows = (tmp_path / "motion.csv").read_text().splitlines()
    assert rows[0] == "t,x,y,yaw,speed,acceleration,jerk,curvature"
    table = np.array([[float(v) for v in row.split(",")] for row in rows[1:]])
    assert table[-1, 0] == pytest.approx(plan["trajectory"]["duration"], abs=1e-6)
    assert np.allclose(np.diff(table[:-1, 0]), 0.01)
    assert "<html" in (tmp_path / "plan.html").read_text()
    assert "wrote" in capsys.readouterr().out


def test_the_polyline_keeps_its_clearance(capsys):
    plan = run_json(["plan", "room.toml"], capsys)
    points = np.array(plan["polyline"])
    a, b = points[:-1], points[1:]
    center, edge = np.array([5.0, 3.0]), b - a
    t = np.clip(((center - a) * edge).sum(1) / np.maximum((edge**2).sum(1), 1e-300), 0, 1)
    distance = np.linalg.norm(a + t[:, None] * edge - center, axis=1) - 1.0
    assert distance.min() >= 0.3 - 1e-9


@pytest.mark.parametrize("planner", ["visibility", "jump-point", "astar", "dijkstra", "theta-star", "lazy-theta-star"])
def test_same_seed_same_bytes_with_any_number_of_threads(planner, capsys):
    words = ["plan", "room.toml", "--planner", planner, "--seed", "5"]
    one, two = (timeless(run_json([*words, "--threads", n], capsys)) for n in "12")
    assert json.dumps(one) == json.dumps(two)
    jsonschema.validate(one, schemas.load("plan"))


def test_scenario_rows(tmp_path, capsys):
    (tmp_path / "a.scen").write_text("version 1.0\n\n0\ta.map\t5\t4\t0\t0\t4\t3\t6.0\n0 a.map 5 4 1 1 4 3 1.0\n0 a.map 5 4 0 0 9 3 1.0\n")
    assert main(["plan", "a.map", "--scen", "a.scen", "--planner", "jump-point", "--out", "rows.jsonl"]) == 0
    rows = [json.loads(line) for line in (tmp_path / "rows.jsonl").read_text().splitlines()]
    for row in rows:
        jsonschema.validate(row, schemas.load("row"))
    assert [row["error"] for row in rows] == [None, "StartBlocked", "OutsideMap"]
    assert rows[0]["length"] == pytest.approx(7 - 2 + 2**0.5, abs=1e-9) or rows[0]["length"] == pytest.approx(7.0)
    assert [row["row"] for row in rows] == [0, 1, 2]


def test_drive_a_scene_and_view_it(tmp_path, capsys):
    assert main(["drive", "room.toml", "--out", "run.json", "--report", "run.html", "--seed", "2"]) == 0
    run = json.loads((tmp_path / "run.json").read_text())
    jsonschema.validate(run, schemas.load("run"))
    assert run["outcome"] == "arrived"
    assert run["min_separation"] > 0
    assert main(["plan", "room.toml", "--out", "plan.json"]) == 0
    assert main(["view", "plan.json", "run.json", "--out", "both.html"]) == 0
    text = (tmp_path / "both.html").read_text()
    assert not re.search(r"(src|href)\s*=\s*[\"']?(https?:)?//", text)


def test_a_plan_can_be_driven_from_its_file(tmp_path, capsys):
    assert main(["plan", "room.toml", "--out", "plan.json"]) == 0
    assert main(["drive", "plan.json", "--out", "run.json", "--controller", "tracker"]) == 0
    (tmp_path / "room.toml").write_text(ROOM + "# another file now\n")
    assert main(["drive", "plan.json"]) == 2
    assert "sha256" in capsys.readouterr().err


def test_a_drive_that_does_not_arrive_is_written_and_returns_3(tmp_path, capsys):
    assert main(["drive", "room.toml", "--time-limit", "0.5", "--out", "run.json"]) == 3
    assert json.loads((tmp_path / "run.json").read_text())["outcome"] == "timeout"


def test_maps(tmp_path, capsys):
    assert main(["maps", "info", "a.map"]) == 0
    assert "5, 4" in capsys.readouterr().out
    for name in ("b.yaml", "b.txt", "b.toml", "b.map"):
        assert main(["maps", "convert", "a.map", name]) == 0
    assert (tmp_path / "b.txt").read_text().split() == [".....", ".##..", "..#..", "....."]
    assert main(["maps", "view", "a.map", "--out", "a.png"]) == 0
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"


def test_list(capsys):
    assert main(["plan", "--list"]) == 0
    names = [line.split()[0] for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]
    assert {"dijkstra", "astar", "jump-point", "theta-star", "lazy-theta-star", "visibility"} <= set(names)
    assert sorted(names) == sorted(entry["name"] for entry in gw.planners())
    for name in names:
        assert main(["plan", "--list", name]) == 0
    capsys.readouterr()
    assert main(["plan", "--list", "aco"]) == 0
    assert "loop_cutting = true  (paper: false)" in capsys.readouterr().out


def test_ctrl_c(tmp_path):
    n = 3000
    rows = np.full((n, n), ".", dtype="U1")
    rows[np.random.default_rng(1).random((n, n)) < 0.3] = "@"
    rows[0, 0] = rows[-1, -1] = "."
    (tmp_path / "big.map").write_text(f"type octile\nheight {n}\nwidth {n}\nmap\n" + "\n".join("".join(row) for row in rows) + "\n")
    scenario = "version 1\n" + f"0\tbig.map\t{n}\t{n}\t0\t0\t{n - 1}\t{n - 1}\t1\n" * 200
    (tmp_path / "big.scen").write_text(scenario)
    words = [sys.executable, "-m", "guideway", "plan", "big.map", "--scen", "big.scen", "--planner", "dijkstra", "--out", "rows.jsonl", "--json"]

    def listen():
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # a job in the background of a script ignores it

    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment, preexec_fn=listen) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=10) == 130
        assert "Traceback" not in process.stderr.read()
    assert (tmp_path / "rows.jsonl").read_text().count("\n") >= 1


def test_demo(tmp_path, capsys):
    assert main(["demo", "--out", "d"]) == 0
    for name in ("plan.json", "run.json", "report.html"):
        assert (tmp_path / "d" / name).stat().st_size > 1000
    jsonschema.validate(json.loads((tmp_path / "d/plan.json").read_text()), schemas.load("plan"))
    jsonschema.validate(json.loads((tmp_path / "d/run.json").read_text()), schemas.load("run"))
    assert main(["drive", "d/plan.json"]) == 0


def test_scene_schema(tmp_path, data_files):
    schema = schemas.load("scene")
    for path in [tmp_path / "room.toml", *data_files]:
        jsonschema.validate(tomllib.loads(path.read_text()), schema)
    wrong = tomllib.loads(ROOM.replace("radius", "raduis"))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(wrong, schema)


@pytest.fixture
def data_files(tmp_path):
    assert main(["demo", "--out", "d"]) == 0
    assert main(["maps", "convert", "a.map", "b.toml"]) == 0
    return [tmp_path / "d/demo.toml", tmp_path / "b.toml"]
