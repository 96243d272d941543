"""Collisions of arms, proved along the path; brakes and overrides that stay on it; what the certificate finds; files of a motion."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml

pytest.importorskip("pinocchio")

import guideway as gw
from guideway import schemas
from guideway.arm.certificate import worst_rate
from guideway.arm.collisions import Surroundings, check
from guideway.arm.meshes import load_stl, solid
from guideway.arm.motion import ArmMotion
from guideway.arm.paths import path_through
from guideway.arm.shapes import Scene, load_scene, mesh


@pytest.fixture(scope="module")
def arm():
    return gw.arm.arm_for(gw.arm.robot("ur5e", payload=5.0, friction=gw.arm.REFERENCE_FRICTION), gw.arm.star())


@pytest.fixture(scope="module")
def star_path(arm):
    return gw.arm.joint_path(arm, gw.arm.star())


def hand_made(path, limits, arm, top=0.55, count=600):
    """A slow motion: squared path speed up and down in ramps."""
    s = np.linspace(0.0, path.path.length, count + 1)
    x = top**2 * np.clip(8 * np.minimum(s, s[-1] - s) / s[-1], 0.0, 1.0)
    v = np.sqrt(x)
    d = 2 * np.diff(s) / (v[1:] + v[:-1])
    t = np.concatenate([[0.0], np.cumsum(d)[:-1]])
    return ArmMotion(path, np.column_stack([t, s[:-1], v[:-1], np.diff(v) / d, np.zeros(count), d]), limits, arm)


@pytest.fixture(scope="module")
def motion(arm, star_path):
    limits = gw.arm.JointLimits(speed=math.pi, acceleration=10.0, torque=gw.arm.STAR_TORQUE)
    return hand_made(star_path, limits, arm)


def test_a_box_is_a_solid_like_its_mesh():
    x, y, z = 0.4, 0.6, 1.0
    corners = np.array([[i * x, j * y, k * z] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    volume, center, inertia = solid(corners[np.array(faces)])
    assert volume == pytest.approx(x * y * z)
    assert center == pytest.approx([x / 2, y / 2, z / 2])
    assert inertia == pytest.approx(volume / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y]))
    shape, hull = mesh(corners[np.array(faces)])
    assert shape is hull
    dented = np.concatenate([corners[np.array(faces[1:])], [[corners[0], corners[1], [0.2, 0.3, 0.5]]]])
    shape, hull = mesh(dented)
    assert shape is not hull


def test_the_estimated_inertials_are_the_volumes():
    folder = gw.arm.robot("irb6700").source.rsplit("/", 1)[0]
    stated = json.loads((Path(folder) / "estimated_inertials.json").read_text())
    bodies = {link: solid(load_stl(f"{folder}/meshes/{link}.stl")) for link in ["base_link", *stated["links"]]}
    density = stated["mass"] / sum(volume for volume, _, _ in bodies.values())
    for link, body in stated["links"].items():
        volume, center, inertia = bodies[link]
        assert body["mass"] == pytest.approx(density * volume, rel=1e-4)
        assert body["center"] == pytest.approx(center, abs=1e-5)
        assert np.allclose(body["inertia"], density * inertia, atol=1e-4)


def test_the_star_is_free_of_self_collision(arm, star_path):
    around = Surroundings(arm)
    found = check(around, star_path.path)
    assert found["ok"]
    assert found["pairs"] == 15
    assert 0 < found["proved"] <= found["closest"]["distance"]
    assert {entry["why"] for entry in found["dropped"]} == {"one joint lies between them"}
    assert not check(around, star_path.path, clearance=0.05)["ok"]


def test_the_bound_holds_between_samples(arm, star_path):
    around = Surroundings(arm, Scene(({"kind": "sphere", "radius": 0.02, "at": (0.0, -0.25, 0.05)},)))
    found = check(around, star_path.path)
    s = np.linspace(0, star_path.path.length, 3001)
    placed = [around.place(q) for q in star_path.path.eval(s)[0]]
    least = min(around.distance(pair, poses) for pair in around.pairs for poses in placed[::30])
    assert found["proved"] <= least
    for pair in around.pairs:
        values = np.array([around.distance(pair, poses) for poses in placed[::10]])
        assert np.abs(np.diff(values)).max() <= pair.reach * (s[10] - s[0]) * (1 + 1e-6)


def test_the_arm_folds_into_itself():
    arm = gw.arm.robot("ur5e")
    path = gw.arm.joint_path(arm, [[0, -1.5, 2.0, 0, 0, 0], [0, -1.5, 3.1, 0, 0, 0]])
    found = check(Surroundings(arm), path.path)
    assert not found["ok"]
    assert "upper_arm_link" in found["hit"]["pair"]


@pytest.mark.parametrize(
    ("shape", "hit"),
    [
        ({"kind": "box", "size": (2, 2, 0.02), "at": (0, 0, -0.02)}, False),
        ({"kind": "box", "size": (0.05, 0.05, 0.05), "at": (-0.1, -0.25, 0.28)}, True),
        ({"kind": "cylinder", "radius": 0.03, "length": 0.2, "at": (-0.05, -0.25, 0.2)}, True),
        ({"kind": "sphere", "radius": 0.05, "at": (1.0, 1.0, 1.0)}, False),
    ],
)
def test_things_around_the_arm(arm, motion, shape, hit):
    certificate = motion.certify(surroundings=Surroundings(arm, Scene((shape,))))
    assert certificate["ok"] is not hit
    assert certificate["collision"]["ok"] is not hit
    if hit:
        assert f"scene {shape['kind']} 1" in certificate["collision"]["hit"]["pair"]


def test_the_tool_counts(arm, star_path):
    wall = {"kind": "box", "size": (0.02, 1.0, 1.0), "at": (0.0, -0.45, 0.5), "name": "wall"}
    bare = check(Surroundings(arm, Scene((wall,))), star_path.path)
    tool = {"kind": "cylinder", "radius": 0.005, "length": 0.5, "at": (0.0, 0.0, 0.25)}
    assert bare["ok"] == ("wall" not in str(bare["hit"]))
    floor = {"kind": "box", "size": (1.0, 1.0, 0.01), "at": (0.0, -0.25, 0.05), "name": "floor"}
    assert check(Surroundings(arm, Scene((floor,))), star_path.path)["ok"]
    found = check(Surroundings(arm, Scene((floor,), (tool,))), star_path.path)
    assert "tool cylinder 1" in found["hit"]["pair"]


def test_parts_of_one_linkage_may_touch():
    robot = gw.arm.robot("irb6700")
    around = Surroundings(robot)
    path = gw.arm.joint_path(robot, [[0, 0, 0, 0, 0.5, 0], [1, 0.3, 0.2, 0.4, 1, 0.3]])
    assert check(around, path.path)["ok"]
    assert any("piston_joint follows joint joint_2" in entry["why"] for entry in around.dropped)


def test_scenes_from_files(tmp_path):
    path = tmp_path / "cell.toml"
    path.write_text(
        'clearance = 0.01\n[[box]]\nname = "table"\nsize = [1, 1, 0.1]\nat = [0, 0, -0.06]\n'
        '[[tool]]\nkind = "sphere"\nradius = 0.03\nat = [0, 0, 0.1]\n'
    )
    scene = load_scene(path)
    assert scene.clearance == 0.01
    assert scene.shapes[0]["name"] == "table"
    assert scene.tool[0]["kind"] == "sphere"
    for text, message in (
        ("[[box]]\nat = [0, 0, 0]", "size"),
        ("[[sphere]]\nradius = -1", "radius"),
        ("[[cone]]\nradius = 1", "cone"),
        ("[[tool]]\nradius = 1", "kind"),
        ("[[mesh]]\nat = [0, 0, 0]", "file"),
    ):
        path.write_text(text)
        with pytest.raises(gw.BadFile, match=message):
            load_scene(path)


def test_a_motion_is_its_pieces(motion):
    sample = motion.sample(1000)
    assert sample["t"][-1] == motion.duration
    dt = np.diff(sample["t"])[:-1, None]
    assert np.abs(np.diff(sample["q"], axis=0)[:-1] / dt - 0.5 * (sample["qd"][1:-1] + sample["qd"][:-2])).max() < 1e-3
    state = motion.at(0.5)
    assert state["s"] == pytest.approx(float(np.interp(0.5, sample["t"], sample["s"])), abs=1e-5)
    assert motion.time_at(state["s"]) == pytest.approx(0.5, abs=1e-9)
    assert motion.at(-1.0)["qd"].tolist() == motion.at(99.0)["qd"].tolist() == [0.0] * 6


def test_the_certificate_finds_what_is_too_fast(arm, star_path, motion):
    assert motion.certify(collisions=False)["ok"]
    fast = hand_made(star_path, motion.limits, arm, top=2.6)
    certificate = fast.certify(collisions=False)
    assert not certificate["ok"]
    bad = {entry["limit"] for entry in certificate["checks"] if not entry["ok"]}
    assert bad == {"acceleration", "deceleration", "torque"}
    sample = fast.sample(4000)
    ratio = next(entry["ratio"] for entry in certificate["checks"] if entry["limit"] == "torque")
    assert ratio == pytest.approx((np.abs(fast.torques(sample)) / gw.arm.STAR_TORQUE).max(), rel=0.02)
    slow = ArmMotion(motion.path, motion.pieces, gw.arm.JointLimits(tip_speed=0.05, tip_acceleration=0.5), arm)
    assert {entry["limit"] for entry in slow.certify(collisions=False)["checks"] if not entry["ok"]} == {"tip_speed", "tip_acceleration"}


def test_a_torn_motion_is_refused(motion):
    torn = motion.pieces.copy()
    torn[300:, 1] += 1e-3
    checks = ArmMotion(motion.path, torn, motion.limits).certify(collisions=False)["checks"]
    assert not checks[0]["ok"]


@pytest.mark.parametrize("share", [0.001, 0.07, 0.3, 0.5, 0.77, 0.93, 0.999])
def test_a_stop_stays_on_the_path_and_keeps_the_limits(motion, share):
    t = share * motion.duration
    stopped = motion.stop_from(t)
    certificate = stopped.certify(collisions=False)
    assert certificate["ok"], [entry for entry in certificate["checks"] if not entry["ok"]]
    assert stopped.report["brake"]["worst"] < 1e-6
    end = stopped.at(stopped.duration)
    assert end["speed"] == pytest.approx(0.0, abs=1e-6)
    assert motion.at(t)["s"] < end["s"] <= motion.path.path.length
    assert stopped.duration <= motion.duration + 1e-9
    before = stopped.sample(times=np.linspace(0, t, 50))["q"]
    assert np.allclose(before, motion.sample(times=np.linspace(0, t, 50))["q"])
    # a brake uses a limit to the full, or is over within a few steps
    used = max(entry["ratio"] for entry in certificate["checks"] if "ratio" in entry)
    assert used > 0.98


def test_a_stop_is_not_longer_than_it_must_be(arm, star_path):
    limits = gw.arm.JointLimits(acceleration=10.0, deceleration=2.0)
    motion = hand_made(star_path, limits, arm, top=0.4)
    stopped = motion.stop_from(motion.duration / 2)
    brake = stopped.report["brake"]
    state = motion.at(motion.duration / 2)
    at = np.abs(motion.path.path.eval(np.linspace(state["s"], state["s"] + brake["way"], 50), 1)[1]).max(axis=1)
    assert state["speed"] ** 2 / 2 * at.min() / 2.0 <= brake["way"] * 1.2
    assert brake["way"] <= 1.3 * state["speed"] ** 2 / 2 * at.max() / 2.0


@pytest.mark.parametrize("factor", [0.3, 0.8])
def test_an_override_slows_down(motion, factor):
    whole = motion.override(factor)
    assert whole.duration == pytest.approx(motion.duration / factor)
    assert whole.certify(collisions=False)["ok"]
    later = motion.override(factor, at=1.0)
    assert later.certify(collisions=False)["ok"]
    assert motion.duration < later.duration < whole.duration
    assert later.at(later.duration)["s"] == pytest.approx(motion.path.path.length)
    place = 0.8 * motion.path.path.length
    assert later.along(later.time_at(place))[0, 1] == pytest.approx(factor * motion.along(motion.time_at(place))[0, 1], rel=1e-6)
    with pytest.raises(gw.BadParameter, match="override"):
        motion.override(1.5)


def test_an_override_checks_torque_rates():
    """The second joint of an arm held out falls: gravity and the jerk change its torque in opposite ways, less so when it is slower."""
    arm = gw.arm.robot("ur5e")
    path = path_through(np.array([[0.0, -0.9, 0.0, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0, 0.0, 0.0]]), arm.names)
    s = np.array([path.path.length / 2])
    held = gw.arm.torque_rows(arm, path.path, gw.arm.JointLimits(torque=300.0))
    step = 1e-4
    rows, after = held(s), held(s + step)
    change, inertia = (after["c"] - rows["c"])[0, 1] / step, rows["a"][0, 1]
    jerk = -change / inertia
    pieces = np.array([[0.0, s[0], 1.0, 0.0, jerk, 0.01]])
    fast = gw.arm.ArmMotion(path, pieces, gw.arm.JointLimits(torque_rate=0.2 * abs(change)), arm)
    assert worst_rate(fast) < 1
    with pytest.raises(gw.Infeasible, match="limit of torque rate"):
        fast.override(0.6)
    assert worst_rate(fast.override(0.1)) < 1


def test_a_brake_says_what_it_uses_of_the_torque_rate(arm, motion):
    limited = replace(motion, limits=replace(motion.limits, torque_rate=500.0))
    assert limited.stop_from(0.5).report["brake"]["torque_rate"] > 0
    assert "torque_rate" not in motion.stop_from(0.5).report["brake"]


def test_the_record_is_the_motion(arm, motion):
    motion.report["certificate"] = motion.certify()
    record = json.loads(json.dumps(gw.arm.record(motion, 100.0), allow_nan=False))
    jsonschema.validate(record, schemas.load("arm"))
    again = gw.arm.load_motion(record, arm)
    assert np.allclose(again.sample(50)["q"], motion.sample(50)["q"], atol=1e-12)
    assert again.certify()["ok"]
    assert again.limits == gw.arm.JointLimits.of(motion.limits.to_dict(6))
    with pytest.raises(gw.BadParameter, match="no motion of an arm"):
        gw.arm.load_motion({"guideway": "0"})
    with pytest.raises(gw.BadParameter, match="are not those of"):
        gw.arm.load_motion(record, gw.arm.robot("irb120"))


def test_programs(motion, star_path):
    rows = [line.split(",") for line in gw.arm.csv_text(motion, 100.0).splitlines()]
    assert rows[0][:2] == ["t", "shoulder_pan_joint"]
    assert {len(row) for row in rows} == {19}
    program = gw.arm.urscript(motion, 125.0).splitlines()
    moves = [line for line in program if "servoj" in line]
    assert len(moves) == math.ceil(motion.duration * 125)
    last = [float(word) for word in moves[-1][moves[-1].index("[") + 1 : moves[-1].index("]")].split(",")]
    assert np.allclose(last, motion.at(motion.duration)["q"], atol=1e-8)
    assert moves[0].strip().endswith("0, 0, 0.008, 0.1, 300)")
    with pytest.raises(gw.BadParameter, match="look-ahead"):
        gw.arm.urscript(motion, lookahead=1.0)
    ros = yaml.safe_load(gw.arm.ros_yaml(motion))
    times = [point["time_from_start"]["sec"] + 1e-9 * point["time_from_start"]["nanosec"] for point in ros["points"]]
    assert ros["joint_names"] == list(motion.names)
    assert (np.diff(times) > 0).all()
    assert times[-1] == pytest.approx(motion.duration, abs=1e-9)
    assert all(len(point[key]) == 6 for point in ros["points"] for key in ("positions", "velocities", "accelerations"))
    assert all(isinstance(value, float) for point in ros["points"] for value in point["accelerations"])
