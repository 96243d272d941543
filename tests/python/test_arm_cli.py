"""``guideway arm time`` as users and scripts rely on it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import jsonschema
import pytest
import yaml

pytest.importorskip("pinocchio")

import guideway as gw
from guideway import schemas
from guideway.cli import main

UR5E = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")
STAR = ["arm", "time", "--nurbs", "star", "--robot", "ur5e"]
WAY = ",".join(UR5E) + "\n0,-1,1,0,0,0\n0.5,-1.2,1.2,0.1,0.3,0\n1,-1,1,0,0.5,0.5\n"
TOOL = """degree = 2
points = [[0.3, 0.3, 0.3], [0.4, 0.3, 0.35], [0.5, 0.2, 0.3]]
tool = [0, 1, 0, 0]
posture = [0.5, -1.2, 1.5, -1.8, -1.57, 0]
frame = "base"
"""
SIDEWAYS = """degree = 1
points = [[0.4, -0.3, 0.3], [0.4, 0.3, 0.3]]
tool = [0.7071, -0.7071, 0, 0]
frame = "base"
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "way.csv").write_text(WAY)
    (tmp_path / "tool.toml").write_text(TOOL)
    (tmp_path / "limits.toml").write_text("speed = 2.0\nacceleration = 5.0\ntorque = [28, 42, 40, 11, 5, 5]\n")
    (tmp_path / "jerk.toml").write_text("acceleration = 5.0\njerk = 100.0\n")


def run(capsys, *words):
    code = main([str(word) for word in words])
    out, err = capsys.readouterr()
    return code, out, err


def test_the_star_with_everything(tmp_path, capsys):
    words = ["--payload", 5, "--friction", "reference", "--limits", "limits.toml", "--out", "traj.json"]
    words += ["--csv", "joint.csv", "--urscript", "star.script", "--ros", "star.yaml"]
    code, out, err = run(capsys, *STAR, *words)
    assert (code, err) == (0, "")
    record = json.loads((tmp_path / "traj.json").read_text())
    jsonschema.validate(record, schemas.load("arm"))
    assert record["joints"] == list(UR5E)
    assert record["certificate"]["ok"]
    assert record["certificate"]["collision"]["ok"]
    assert record["robot"]["payload"]["mass"] == 5
    assert f"{record['duration']:.4f} s" in out
    assert "wrote        traj.json" in out
    assert len((tmp_path / "joint.csv").read_text().splitlines()) == len(record["t"]) + 1
    assert "servoj" in (tmp_path / "star.script").read_text()
    assert yaml.safe_load((tmp_path / "star.yaml").read_text())["joint_names"] == list(UR5E)
    assert gw.arm.load_motion(record).duration == pytest.approx(record["duration"])


def test_json_alone_on_stdout(capsys):
    code, out, _ = run(capsys, *STAR, "--json")
    assert code == 0
    assert json.loads(out)["duration"] == pytest.approx(1.9097, rel=0.005)


def test_way_points_tool_paths_and_files_of_robots(tmp_path, capsys):
    urdf = gw.arm.robot("ur5e").source
    for path in (["way.csv"], ["--nurbs", "tool.toml"]):
        code, out, err = run(capsys, "arm", "time", *path, "--urdf", urdf, "--limits", "limits.toml", "--method", "bisection")
        assert code == 0, err
        assert "duration" in out
    code, out, err = run(capsys, "arm", "time", "way.csv", "--urdf", urdf, "--limits", "jerk.toml", "--jerk", "--override", "0.5")
    assert code == 0, err


def test_a_scene_in_the_way(tmp_path, capsys):
    (tmp_path / "cell.toml").write_text("[[sphere]]\nradius = 0.05\nat = [0.0, -0.25, 0.3]\n")
    code, out, err = run(capsys, *STAR, "--scene", "cell.toml", "--out", "traj.json")
    assert (code, out) == (3, "")
    assert "collision" in err
    assert "scene sphere 1" in err
    assert not (tmp_path / "traj.json").exists()
    assert run(capsys, *STAR, "--scene", "cell.toml", "--no-collisions")[0] == 0
    code, _, err = run(capsys, *STAR, "--clearance", "0.05")
    assert code == 3
    assert "base_link_inertia and upper_arm_link" in " ".join(err.split())


def test_urscript_is_for_arms_of_universal_robots(tmp_path, capsys):
    (tmp_path / "abb.csv").write_text("joint_1,joint_2,joint_3,joint_4,joint_5,joint_6\n0,0,0,0,0.5,0\n0.5,0,0.1,0,0.7,0\n")
    code, out, err = run(capsys, "arm", "time", "abb.csv", "--robot", "irb120", "--no-collisions", "--out", "out.json", "--urscript", "out.script")
    assert (code, out) == (2, "")
    assert "URScript is for arms of Universal Robots, not for abb_irb120_3_58" in " ".join(err.split())
    assert not (tmp_path / "out.json").exists()
    given = Path(gw.arm.robot("ur5e").source).read_text("utf-8")
    (tmp_path / "cell.urdf").write_text(given.replace('<robot name="ur5e"', '<robot name="cell_7"', 1))
    (tmp_path / "ur5e.urdf").write_text(given)
    for name, warned in (("cell", True), ("ur5e", False)):
        words = ["way.csv", "--urdf", f"{name}.urdf", "--no-collisions", "--urscript", f"{name}.script"]
        assert run(capsys, "arm", "time", *words)[0] == 0
        assert ("# WARNING: this motion is for cell_7" in (tmp_path / f"{name}.script").read_text()) == warned


def test_all_branches(capsys):
    code, out, err = run(capsys, *STAR, "--branches", "--no-collisions")
    assert code == 0
    assert err.count("branch from") == 8
    best = min(float(line.split("rad: ")[1].split(" s")[0]) for line in err.splitlines() if "rad: " in line)
    assert f"{best:.4f} s" in out


def test_help(capsys):
    code, out, _ = run(capsys, "arm")
    assert code == 2
    assert "guideway arm time --nurbs star" in out
    code, out, _ = run(capsys, "arm", "time", "--help")
    assert code == 0
    assert "--urscript" in out


def test_windows_and_speeds_at_the_ends(tmp_path, capsys):
    words = ["--window", "1.0,0.9,1.2", "--window", "3,2.0", "--no-collisions", "--out", "traj.json"]
    code, out, err = run(capsys, *STAR, *words)
    assert code == 0, err
    assert "window       s = 1 rad is passed at 0.9000 s" in out
    record = json.loads((tmp_path / "traj.json").read_text())
    jsonschema.validate(record, schemas.load("arm"))
    motion = gw.arm.load_motion(record)
    assert 0.9 - 1e-4 <= motion.time_at(1.0) <= 1.2
    assert motion.time_at(3.0) >= 2.0 - 1e-4
    code, out, err = run(capsys, *STAR, "--start-speed", "0.5", "--end-speed", "0.3", "--no-collisions", "--out", "traj.json")
    assert code == 0, err
    motion = gw.arm.load_motion(json.loads((tmp_path / "traj.json").read_text()))
    assert motion.along([0.0])[0, 1] == pytest.approx(0.5)
    assert motion.along([motion.duration])[0, 1] == pytest.approx(0.3)
    (tmp_path / "jerk.toml").write_text("jerk = 150.0\n")
    words = ["--limits", "jerk.toml", "--start-speed", "0.5", "--end-speed", "0.3", "--no-collisions", "--out", "traj.json"]
    code, out, err = run(capsys, *STAR, *words)
    assert code == 0, err
    record = json.loads((tmp_path / "traj.json").read_text())
    assert next(check for check in record["certificate"]["checks"] if check["name"].startswith("jerk"))["ok"]
    motion = gw.arm.load_motion(record)
    assert motion.along([0.0, motion.duration])[:, 1] == pytest.approx([0.5, 0.3])
    code, out, err = run(capsys, *STAR, "--limits", "jerk.toml", "--end-speed", "9", "--no-collisions")
    assert code == 3
    assert "the path speed at the end can be at most" in err


BAD = [
    ([*STAR, "--window", "1,0.1,0.2"], 3, "cannot be reached before"),
    ([*STAR, "--window", "9,1"], 2, "beyond the end of the path"),
    ([*STAR, "--window", "1"], 2, "S,EARLIEST"),
    ([*STAR, "--window", "1,2,1"], 2, "LATEST not before EARLIEST"),
    ([*STAR, "--window", "1,1", "--override", "0.5"], 2, "windows would be missed"),
    ([*STAR, "--window", "1,0.9", "--limits", "smooth.toml"], 2, "the end of the path"),
    ([*STAR, "--start-speed", "nan"], 2, "--start-speed"),
    ([*STAR, "--start-speed", "50"], 3, "the path speed at the start can be at most"),
    ([*STAR, "--end-speed", "0.1", "--urscript", "a.script"], 2, "from rest to rest"),
    (["arm", "fly"], 2, "fly"),
    (["arm", "time", "way.csv"], 2, "--urdf FILE and --robot NAME"),
    (["arm", "time", "--robot", "ur5e"], 2, "PATH.csv and --nurbs"),
    (["arm", "time", "way.csv", "--robot", "r2d2"], 2, "ur5e, irb6700, irb120"),
    (["arm", "time", "way.csv", "--urdf", "nowhere.urdf"], 2, "nowhere.urdf"),
    (["arm", "time", "nowhere.csv", "--robot", "ur5e"], 2, "nowhere.csv"),
    (["arm", "time", "way.csv", "--robot", "irb120"], 2, "is not of this robot"),
    ([*STAR, "--method", "magic"], 2, "reachability, bisection"),
    ([*STAR, "--payload", "nan"], 2, "--payload"),
    ([*STAR, "--payload-at", "1,2"], 2, "--payload-at"),
    ([*STAR, "--friction", "ice"], 2, "--friction"),
    ([*STAR, "--jerk"], 2, "jerk or torque_rate"),
    ([*STAR, "--override", "2"], 2, "--override"),
    ([*STAR, "--grid", "1"], 2, "--grid"),
    ([*STAR, "--rate", "-5"], 2, "--rate"),
    ([*STAR, "--tip", "hand"], 2, "hand"),
    ([*STAR, "--limits", "none.toml"], 2, "none.toml"),
    ([*STAR, "--limits", "nan.toml"], 2, "acceleration"),
    ([*STAR, "--out", "no/such/traj.json"], 2, "no/such"),
    (["arm", "time", "nan.csv", "--robot", "ur5e"], 2, "nan.csv, line 3"),
    (["arm", "time", "--nurbs", "weights.toml", "--robot", "ur5e"], 2, "weights"),
    (["arm", "time", "--nurbs", "far.toml", "--robot", "ur5e"], 3, "cannot be reached"),
    (["arm", "time", "--nurbs", "singular.toml", "--robot", "ur5e"], 3, "singular"),
    (["arm", "time", "--nurbs", "corner.toml", "--robot", "ur5e"], 3, "corner"),
    (["arm", "time", "abb.csv", "--robot", "irb6700", "--torque"], 2, "no torque limit is given"),
    (["arm", "time", "abb.csv", "--robot", "irb6700", "--limits", "torque.toml"], 2, "no masses and inertias"),
    (["arm", "time", "abb.csv", "--robot", "irb120", "--torque"], 2, "effort 0 or missing"),
    ([*STAR, "--limits", "weak.toml"], 3, "static overload"),
]


@pytest.mark.parametrize(("words", "status", "named"), BAD, ids=lambda value: " ".join(value) if isinstance(value, list) else None)
def test_bad_input_is_one_paragraph(tmp_path, capsys, words, status, named):
    (tmp_path / "nan.toml").write_text("acceleration = nan\n")
    (tmp_path / "nan.csv").write_text(WAY.replace("0.5,-1.2", "0.5,nan"))
    (tmp_path / "weights.toml").write_text(TOOL + "weights = [1, 0, 1]\n")
    (tmp_path / "far.toml").write_text(TOOL.replace("[0.5, 0.2, 0.3]", "[1.5, 0.2, 0.3]"))
    (tmp_path / "singular.toml").write_text(SIDEWAYS)
    (tmp_path / "corner.toml").write_text(TOOL.replace("degree = 2", "degree = 1"))
    (tmp_path / "abb.csv").write_text("joint_1,joint_2,joint_3,joint_4,joint_5,joint_6\n0,0,0,0,0.5,0\n0.5,0,0.1,0,0.7,0\n")
    (tmp_path / "torque.toml").write_text("torque = 5000.0\nacceleration = 5.0\n")
    (tmp_path / "smooth.toml").write_text("jerk = 100.0\n")
    (tmp_path / "weak.toml").write_text("torque = 1.0\n")
    code, out, err = run(capsys, *words)
    assert code == status, err
    assert out == ""
    assert named in " ".join(err.split())
    assert "Traceback" not in err
    assert err.count("\n\n") == 0
    assert len(err) < 900


def test_without_pinocchio(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    code, _, err = run(capsys, *STAR)
    assert code == 2
    assert "pip install 'guideway[arm]'" in " ".join(err.split())
