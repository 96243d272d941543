"""``guideway arm learn`` in the hands of somebody who gives it the wrong things, or stops it half way."""

from __future__ import annotations

import json
import re
from importlib.resources import files

import numpy as np
import pytest

pytest.importorskip("pinocchio")

import guideway as gw
from guideway.arm.learning import Task, make_learner
from guideway.cli import main
from guideway.plants.arm import IdealArm, make_arm

LIMITS = f"speed = 3.14159265\nacceleration = 10.0\ntorque = {list(gw.arm.STAR_TORQUE)}\n"
TOOL = 'degree = 3\nclosed = true\ntool = "down"\nframe = "base"\nposture = [2.469, -1.5457, -2.095, 2.07, -1.5708, -2.243]\npoints = '
STAR = ["--nurbs", "star", "--robot", "ur5e", "--limits", "limits.toml"]


@pytest.fixture(scope="module")
def task(tmp_path_factory):
    file = tmp_path_factory.mktemp("task") / "limits.toml"
    file.write_text(LIMITS)
    arm = gw.arm.robot("ur5e")
    return Task(gw.arm.joint_path(arm, gw.arm.star()).path, arm, gw.arm.load_limits(file))


@pytest.fixture(scope="module")
def log(task):
    return make_arm("ideal", task, payload=3.0).run(make_learner("structured", task).next([]))


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch, task, log):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "limits.toml").write_text(LIMITS)
    (tmp_path / "kinematic.toml").write_text("speed = 3.0\nacceleration = 10.0\n")
    names = task.arm.names
    header = ",".join(["t", *names, *(f"{name}_torque" for name in names)])
    lines = [",".join(f"{value:.8g}" for value in row) for row in np.column_stack([log.t, log.q, log.tau])]
    moved = [",".join(f"{value:.8g}" for value in row) for row in np.column_stack([log.t, log.q + 0.2, log.tau])]
    spoiled = [*lines[:99], re.sub(r"[^,]+$", "nan", lines[99]), *lines[100:]]
    for name, rows in (("good", lines), ("nan", spoiled), ("half", lines[:1200]), ("hole", lines[:800] + lines[1600:]), ("other", moved)):
        (tmp_path / f"{name}.csv").write_text("\n".join([header, *rows]) + "\n")
    (tmp_path / "torn.csv").write_text("\n".join([header, *lines])[:80000])
    way = [",".join(f"{value:.8g}" for value in row) for row in task.path.eval(np.linspace(0, task.path.length, 40))[0]]
    (tmp_path / "way.csv").write_text("\n".join([",".join(names), *way]) + "\n")
    given = files("guideway").joinpath("data/arms/ur5e/ur5e.urdf").read_text("utf-8")
    (tmp_path / "massless.urdf").write_text(re.sub(r"<inertial>.*?</inertial>", "", given, flags=re.S))
    for name, value in (("zero", "0"), ("below", "-5"), ("nan", "nan")):
        (tmp_path / f"{name}.urdf").write_text(re.sub(r'effort="[^"]*"', f'effort="{value}"', given))
    (tmp_path / "far.toml").write_text(TOOL + "[[-0.1, 0.25, 0.3], [0.4, 0.6, 0.4], [1.4, 0.9, 0.5], [0.2, 0.25, 0.3]]\n")
    (tmp_path / "inner.toml").write_text(TOOL + "[[-0.1, 0.25, 0.3], [0.0, 0.05, 0.3], [0.0, -0.05, 0.3], [0.1, 0.0, 0.3]]\n")


WRONG = [
    (["time", *STAR, "--torque", "--payload", "12"], 3, "static overload"),
    (["learn", *STAR, "--payload", "9"], 3, "static overload"),
    (["time", "--nurbs", "inner.toml", "--robot", "ur5e"], 3, r"cannot be reached by ur5e .* the nearest that was found is 0\.0\d+ m"),
    (["learn", "--nurbs", "inner.toml", "--robot", "ur5e", "--limits", "limits.toml"], 3, "cannot be reached"),
    (["time", "--nurbs", "far.toml", "--robot", "ur5e"], 3, "singular posture"),
    (["learn", "--nurbs", "far.toml", "--robot", "ur5e", "--limits", "limits.toml"], 3, "singular posture"),
    (["learn", "way.csv", "--urdf", "massless.urdf", "--limits", "limits.toml"], 2, "states no masses and inertias"),
    (["time", "way.csv", "--urdf", "massless.urdf", "--limits", "limits.toml", "--torque", "--no-collisions"], 2, "states no masses and inertias"),
    (["learn", "way.csv", "--urdf", "zero.urdf", "--limits", "kinematic.toml"], 2, "no torque limit is given for shoulder_pan_joint"),
    (["time", "way.csv", "--urdf", "zero.urdf", "--torque", "--no-collisions"], 2, "effort 0 or missing"),
    (["learn", "way.csv", "--urdf", "below.urdf", "--limits", "limits.toml"], 2, "joint shoulder_pan_joint, limit effort: -5 is below 0"),
    (["learn", "way.csv", "--urdf", "nan.urdf", "--limits", "limits.toml"], 2, "joint shoulder_pan_joint, limit effort: 'nan'"),
    (["learn", *STAR, "--log", "nan.csv"], 2, "line 101, field wrist_3_joint_torque: 'nan'"),
    (["learn", *STAR, "--log", "other.csv"], 2, "the log of another path"),
    (["learn", *STAR, "--log", "half.csv"], 2, "it is cut"),
    (["learn", *STAR, "--log", "hole.csv"], 2, "a piece is missing"),
    (["learn", *STAR, "--log", "torn.csv"], 2, "ends in the middle of a row"),
    (["learn", *STAR, "--log", "good.csv", "--log", "nowhere.csv"], 2, "nowhere.csv"),
    (["learn", *STAR, "--set", "scale=abc"], 2, "setting scale = 'abc' is out of range"),
]


@pytest.mark.parametrize(("words", "status", "said"), WRONG, ids=lambda value: "-".join(value[-2:]) if isinstance(value, list) else "")
def test_what_is_wrong_is_said_once_and_nothing_is_written(tmp_path, capsys, words, status, said):
    before = sorted(tmp_path.iterdir())
    outputs = ["--out", "out.json", "--csv", "out.csv", "--urscript", "out.script", "--report", "out.html"]
    assert main(["arm", *words, *outputs]) == status
    spoken = " ".join(capsys.readouterr().err.split())
    assert re.search(said, spoken)
    assert spoken.count("guideway: ") == 1
    assert "Traceback" not in spoken
    assert sorted(tmp_path.iterdir()) == before


def test_ctrl_c_keeps_the_trials_that_are_complete(tmp_path, capsys, monkeypatch):
    tried = IdealArm.run

    def run(self, motion):
        if self.trials == 2:
            raise KeyboardInterrupt
        return tried(self, motion)

    monkeypatch.setattr(IdealArm, "run", run)
    assert main(["arm", "learn", *STAR, "--payload", "3", "--out", "out.json", "--csv", "out.csv"]) == 130
    assert "interrupted: 2 of 6 trials are complete" in capsys.readouterr().err
    record = json.loads((tmp_path / "out.json").read_text())
    assert [row["number"] for row in record["trials"]] == [1, 2]
    assert record["best"] == 2
    assert record["oracle_duration"] is None


def test_ctrl_c_before_the_first_trial_writes_nothing(tmp_path, capsys, monkeypatch):
    def run(self, motion):
        raise KeyboardInterrupt

    before = sorted(tmp_path.iterdir())
    monkeypatch.setattr(IdealArm, "run", run)
    assert main(["arm", "learn", *STAR, "--out", "out.json"]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before
