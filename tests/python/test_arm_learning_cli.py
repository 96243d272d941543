"""``guideway arm learn`` in the hands of somebody who gives it the wrong things, or stops it half way."""

from __future__ import annotations

import json
import re
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
import yaml

pytest.importorskip("pinocchio")

import guideway as gw
from guideway import schemas
from guideway.arm.learning import LEARNERS, Log, Task, make_learner
from guideway.arm.learning.loop import best_of, judged
from guideway.cli import main
from guideway.plants.arm import IdealArm, Sensors, make_arm, usual_friction
from guideway.plants.arm_friction import JointFriction

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


def log_friction(task):
    return JointFriction.of("reference", *usual_friction(task))


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
    (tmp_path / "cell.toml").write_text("[[sphere]]\nradius = 0.05\nat = [0.0, -0.25, 0.3]\n")
    quick = IdealArm(task.arm.with_payload(3.0), log_friction(task), Sensors((0.5,) * 6), task.torque, stop=(9.0, 9.0)).run(task.optimum())
    lines_of = [",".join(f"{value:.8g}" for value in row) for row in np.column_stack([quick.t, quick.q, quick.tau])]
    (tmp_path / "fast.csv").write_text("\n".join([header, *lines_of]) + "\n")
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
    (["learn", *STAR, "--log", "good.csv", "--payload", "3"], 2, "--payload describes a simulated plant, and with --log nothing is simulated"),
    (["learn", *STAR, "--log", "good.csv", "--plant", "ideal"], 2, "--plant describes a simulated plant"),
    (["learn", *STAR, "--next", "--payload-at", "0,0,0.1"], 2, "--payload-at describes a simulated plant, and with --next"),
    (["learn", *STAR, "--next", "--clearance", "0.05"], 3, "collision: base_link_inertia and upper_arm_link come as near as"),
    (["learn", *STAR, "--log", "good.csv", "--scene", "cell.toml"], 3, "collision: .* and scene sphere 1|collision: scene sphere 1"),
    (["learn", *STAR, "--scene", "cell.toml"], 3, "collision"),
    (["learn", *STAR, "--learner", "kinematic", "--log", "fast.csv"], 3, "learning has ended, and in none of 1 trials was no violation"),
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


@pytest.mark.parametrize("words", [["--payload", "3", "--trials", "2"], ["--next"], ["--log", "good.csv"], ["--next", "--learner", "source"]])
def test_what_is_written_for_a_cell_is_certified(tmp_path, capsys, words):
    files = ["--out", "out.json", "--csv", "out.csv", "--urscript", "out.script", "--ros", "out.yaml"]
    assert main(["arm", "learn", *STAR, *words, *files]) == 0
    said = capsys.readouterr().out
    record = json.loads((tmp_path / "out.json").read_text())
    jsonschema.validate(record, schemas.load("arm"))
    certificate = record["certificate"]
    assert certificate["ok"]
    assert certificate["collision"]["ok"]
    assert certificate["collision"]["proved"] > 0
    checks = {check["limit"]: check for check in certificate["checks"]}
    assert {"continuity", "speed", "acceleration", "deceleration", "range", "torque"} == set(checks)
    assert checks["acceleration"]["ratio"] <= 1
    torque = checks["torque"]
    assert torque["certified"] is False
    assert torque["note"] in said
    if "--next" in words:
        assert "not measured yet" in torque["note"]
        assert "ratio" not in torque
    else:
        assert torque["note"] == f"learned: expected {100 * torque['ratio']:.1f} % of the limit by the learned model"
        assert 0.9 < torque["ratio"] < 1.02
    assert yaml.safe_load((tmp_path / "out.yaml").read_text())["joint_names"] == record["joints"]
    assert "wrote        out.yaml" in said


def test_a_motion_that_fails_its_certificate_is_not_written(tmp_path, capsys, monkeypatch):
    """A learner that goes twice as fast as it may."""
    before = sorted(tmp_path.iterdir())
    optimum = Task.optimum
    monkeypatch.setattr(Task, "optimum", lambda self, *given: optimum(self, *given).slower(2.0))
    assert main(["arm", "learn", *STAR, "--learner", "kinematic", "--next", "--out", "out.json", "--csv", "out.csv"]) == 3
    assert re.search(r"certificate: speed of shoulder_pan_joint reaches 1\.59\d+ of its limit", " ".join(capsys.readouterr().err.split()))
    assert sorted(tmp_path.iterdir()) == before


def test_the_best_of_the_source_is_the_trial_that_ended_it_and_its_steps_are_told(tmp_path, capsys):
    words = ["--learner", "source", "--set", "reading=literal", "--trials", "40", "--payload", "3", "--out", "out.json"]
    assert main(["arm", "learn", *STAR, *words]) == 0
    said = capsys.readouterr().out
    record = json.loads((tmp_path / "out.json").read_text())
    last = record["trials"][-1]
    assert record["best"] == last["number"]
    assert [row["accepted"] for row in record["trials"]] == [False] * (len(record["trials"]) - 1) + [True]
    assert any(row["clean"] for row in record["trials"][:-1])  # by what noise explains, earlier ones would have passed
    assert last["true"] <= 0
    assert f"{100 * (1 + last['measured']):.1f} % of the limit measured, noise and all, {100 * (1 + last['true']):.1f} % true" in said
    assert record["report"]["speed_step"] == [pytest.approx(0.02, rel=1e-3)] * 2
    assert "step         the motion starts at 0.02 and ends at 0.02 rad/s along the path, not at rest" in said


def test_a_learner_that_did_not_get_there_has_no_best_trial(capsys):
    assert main(["arm", "learn", *STAR, "--learner", "source", "--trials", "2", "--payload", "3", "--no-collisions"]) == 3
    out, err = capsys.readouterr()
    assert "none of 2 trials was without a measured violation" in " ".join(err.split())
    assert "kept         trial 2" in out
    assert "collisions were not checked" in out


def test_what_noise_hides_in_single_samples_shows_in_longer_averages(task):
    """A constant torque 2 % beyond its limit, noise of 4 %: inside by the short average, not by the long one; a slower clean trial is the best."""
    motion, random = task.optimum(), np.random.default_rng(3)
    t = np.arange(500) / 500
    torque = task.torque

    def trial(number, share):
        tau = torque * (share + 0.04 * random.normal(size=(500, 6)) * np.array([0, 0, 0, 0, 1, 0]))
        log = Log(motion.slower(1 / (1 + 0.1 * number)), t, np.zeros((500, 6)), tau)
        return judged(task, number, log, make_learner("structured", task), None)

    beyond, inside = trial(1, np.array([0.5, 0.5, 0.5, 0.5, 1.02, 0.5])), trial(2, np.array([0.5, 0.5, 0.5, 0.5, 0.97, 0.5]))
    assert beyond.clean
    assert inside.clean
    assert beyond.excess > 0 >= inside.excess
    assert beyond.duration < inside.duration
    assert best_of([beyond, inside]) == 1
    assert best_of([beyond]) == 0


def test_help_names_every_learner(capsys):
    assert main(["arm", "learn", "--help"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert all(re.search(rf"\b{name}\b", said) for name in LEARNERS)
