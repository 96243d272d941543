"""Arms: kinematics against Denavit-Hartenberg rows, dynamics against direct evaluation, rows of the solver, hostile descriptions."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("pinocchio")

import guideway as gw
from guideway.arm.inverse import follow
from guideway.arm.limits import JointLimits, load_limits
from guideway.arm.model import Friction, Payload
from guideway.arm.paths import arm_for, places, pose_at
from guideway.arm.rows import check_static, tip_ceiling, tip_derivatives, tip_rows

ROBOT = """<robot name="two"><link name="base"/><link name="one">{inertial}</link><link name="two">{inertial}</link>
<joint name="a" type="{kind}"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/>{limit}</joint>
<joint name="b" type="revolute"><origin xyz="0.5 0 0"/><parent link="one"/><child link="two"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="3" effort="{effort}"/></joint></robot>"""
INERTIAL = '<inertial><mass value="2"/><origin xyz="0.2 0 0"/><inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>'
LIMIT = '<limit lower="-3" upper="3" velocity="2" effort="50"/>'


def written(tmp_path, **parts):
    path = tmp_path / "two.urdf"
    path.write_text(ROBOT.format(**({"inertial": INERTIAL, "kind": "revolute", "limit": LIMIT, "effort": 30} | parts)))
    return path


@pytest.fixture(scope="module")
def arm():
    return gw.arm.robot("ur5e", base="base", payload=3.0, friction=gw.arm.REFERENCE_FRICTION)


@pytest.fixture(scope="module")
def star_path(arm):
    return gw.arm.joint_path(arm, gw.arm.star())


def test_the_description_and_the_manufacturers_rows_agree(arm):
    q = np.random.default_rng(1).uniform(-3, 3, (40, 6))
    rows = gw.arm.ur5e_from_dh()
    assert np.allclose(rows.forward(q), arm.forward(q), atol=1e-8)
    assert np.allclose(rows.jacobian(q), arm.jacobian(q), atol=1e-8)
    assert np.abs(gw.arm.ur5e_from_dh("printed").forward(q) - arm.forward(q)).max() > 0.05


def test_forward_of_rows_is_the_product_of_their_transforms():
    table = gw.arm.ur5e_rows()
    q = np.random.default_rng(2).uniform(-3, 3, 6)
    pose = np.eye(4)
    for angle, row in zip(q, table, strict=True):
        ct, st, ca, sa = math.cos(angle), math.sin(angle), math.cos(row["alpha"]), math.sin(row["alpha"])
        step = [[ct, -st * ca, st * sa, row["a"] * ct], [st, ct * ca, -ct * sa, row["a"] * st], [0, sa, ca, row["d"]], [0, 0, 0, 1]]
        pose = pose @ np.array(step)
    assert np.allclose(gw.arm.ur5e_from_dh().forward(q), pose, atol=1e-12)


@pytest.mark.parametrize("name", list(gw.arm.ROBOTS))
def test_the_jacobian_is_the_derivative_of_the_pose(name):
    robot = gw.arm.robot(name)
    rng, h = np.random.default_rng(3), 1e-6
    for q in rng.uniform(-1, 1, (5, robot.joints)):
        jacobian = robot.jacobian(q)
        for k, e in enumerate(np.eye(robot.joints)):
            before, after = robot.forward(q - h * e), robot.forward(q + h * e)
            assert np.allclose((after - before)[:3, 3] / (2 * h), jacobian[:3, k], atol=1e-7)
            spin = (after - before)[:3, :3] / (2 * h) @ robot.forward(q)[:3, :3].T
            assert np.allclose([spin[2, 1], spin[0, 2], spin[1, 0]], jacobian[3:, k], atol=1e-7)


def test_gravity_is_the_gradient_of_the_potential_energy(arm):
    import pinocchio

    def energy(q):
        return pinocchio.computePotentialEnergy(arm.model, arm.model.createData(), q)

    for q in np.random.default_rng(4).uniform(-2, 2, (5, 6)):
        gradient = [(energy(q + 1e-5 * e) - energy(q - 1e-5 * e)) / 2e-5 for e in np.eye(6)]
        assert np.allclose(arm.torques(q, np.zeros(6), np.zeros(6)), gradient, atol=1e-6)


def test_a_payload_is_a_body_at_the_tip(arm):
    q = np.random.default_rng(5).uniform(-2, 2, 6)
    still = np.zeros(6)
    light, heavy = arm.with_payload(0.0), arm.with_payload(2.0, (0.03, 0.02, 0.08))
    pose = arm.forward(q, "tool0")
    lever = pose[:3, :3] @ [0.03, 0.02, 0.08]
    jacobian = arm.jacobian(q)
    point = jacobian[:3] - np.cross(lever, jacobian[3:].T).T
    assert np.allclose(heavy.torques(q, still, still) - light.torques(q, still, still), point.T @ [0, 0, 2.0 * 9.81], atol=1e-9)
    assert heavy.payload == Payload(2.0, (0.03, 0.02, 0.08))
    assert arm.payload.mass == 3.0


def test_the_rows_are_the_inverse_dynamics_along_the_path(arm, star_path):
    path = star_path.path
    rows = gw.arm.torque_rows(arm, path, JointLimits(torque=40.0))
    s = np.linspace(0, path.length, 57)
    u, x = np.random.default_rng(6).uniform(-5, 5, 57), np.random.default_rng(7).uniform(0, 4, 57)
    q, first, second = path.eval(s, 2)
    speed = first * np.sqrt(x)[:, None]
    speed[np.abs(first) < 1e-6] = 0.0  # a joint that stands still has no direction
    direct = arm.torques(q, speed, first * u[:, None] + second * x[:, None])
    found = rows(s)
    affine = found["a"] * u[:, None] + found["b"] * x[:, None] + found["d"] * np.sqrt(x)[:, None] + found["c"]
    assert np.abs(affine - direct).max() < 1e-9 + 2 * 2 * 1e-6
    moving = np.abs(first) > 1e-6
    assert np.abs(affine - direct)[moving].max() < 1e-9
    assert (found["low"] >= -40.0).all()
    assert np.mean(found["low"] == -40.0) > 0.8
    assert np.allclose(found["low"], -found["high"])


def test_the_tips_rows_bound_its_acceleration(arm, star_path):
    path = star_path.path
    s, h = np.linspace(0.2, path.length - 0.2, 23), 1e-4
    own = arm_for(arm, gw.arm.star())
    first, second = tip_derivatives(own, path, s)
    place = [own.forward(path.eval(s + k * h)[0])[:, :3, 3] for k in (-1, 0, 1)]
    turn = np.array([-1, -1, 1])  # the base's axes in those of the root
    assert np.allclose(first * turn, (place[2] - place[0]) / (2 * h), atol=1e-6)
    assert np.allclose(second * turn, (place[2] - 2 * place[1] + place[0]) / h**2, atol=1e-3)
    assert np.allclose(np.sqrt(tip_ceiling(own, path, 0.3)(s)) * np.linalg.norm(first, axis=1), 0.3)
    found = tip_rows(own, path, 2.0)(s)
    rng = np.random.default_rng(8)
    kept = 0
    for u, x in zip(rng.uniform(-30, 30, 4000), rng.uniform(0, 60, 4000), strict=True):
        inside = (np.abs(found["a"] * u + found["b"] * x) <= found["high"]).all(axis=1)
        size = np.linalg.norm(first * u + second * x, axis=1)
        assert (size[inside] <= 2.0 + 1e-9).all()
        assert inside[size < 1.98].all()
        kept += int(inside.sum())
    assert kept > 100


def test_the_star_is_the_sources():
    nurbs = gw.arm.star()
    assert nurbs.length() == pytest.approx(0.72725, abs=5e-6)
    fine = nurbs.at(np.linspace(0, 1, 4001))
    assert fine.min(axis=0) == pytest.approx([-0.1, 0.25, 0.2003], abs=1e-4)
    assert fine.max(axis=0) == pytest.approx([0.1536, 0.25, 0.3997], abs=1e-4)


def test_a_rational_quadratic_is_an_exact_circle():
    half = math.sqrt(0.5)
    arc = gw.arm.Nurbs([[1, 0, 0], [1, 1, 0], [0, 1, 0]], [1, half, 1], degree=2)
    assert np.abs(np.linalg.norm(arc.at(np.linspace(0, 1, 999)), axis=1) - 1).max() < 1e-14


def test_the_star_in_one_branch(arm, star_path):
    assert star_path.path.length == pytest.approx(3.5684, abs=5e-5)
    report = star_path.report
    assert report["smallest_singular_value"] == pytest.approx(0.14, abs=0.001)
    assert report["deviation"] < 5e-6
    own = arm_for(arm, gw.arm.star())
    w = gw.arm.star().spread(1777)
    exact = follow(own, lambda at: pose_at(gw.arm.star(), at), w, gw.arm.star().posture)
    there = own.forward(star_path.path.eval(places(star_path.path, exact.q))[0])
    assert np.linalg.norm(there[:, :3, 3] - gw.arm.star().at(w), axis=1).max() < 5e-6
    ranges = np.degrees(np.ptp(exact.q, axis=0))
    assert ranges == pytest.approx([56, 17, 21, 35, 0, 56], abs=0.5)


def test_the_star_has_eight_branches(arm):
    nurbs = gw.arm.star()
    own = arm_for(arm, nurbs)
    pose = pose_at(nurbs, np.zeros(1))[0]
    found = gw.arm.branches(own, pose)
    assert len(found) == 8
    assert np.allclose(own.forward(found), pose, atol=1e-8)
    assert np.abs(np.degrees(found) - gw.arm.STAR_POSTURE).max(axis=1).min() < 0.01


def test_points_out_of_reach_and_singular_paths_say_where(arm):
    far = gw.arm.Nurbs([[-0.1, 0.25, 0.3], [-0.5, 0.25, 0.3], [-1.5, 0.25, 0.3]], degree=2, frame="base", posture=gw.arm.star().posture)
    with pytest.raises(gw.NoPath, match=r"cannot be reached|singular posture .* % of the way, point"):
        gw.arm.joint_path(arm, far)
    with pytest.raises(gw.NoPath, match="at the start of the path cannot be reached"):
        gw.arm.joint_path(arm, gw.arm.Nurbs([[2, 0, 0], [2, 1, 0]], degree=1))
    corner = gw.arm.Nurbs([[-0.1, 0.25, 0.3], [0.0, 0.25, 0.3], [0.0, 0.25, 0.4]], degree=1, frame="base", posture=gw.arm.star().posture)
    with pytest.raises(gw.NoPath, match="corner"):
        gw.arm.joint_path(arm, corner)


def test_limits_of_joints_stop_a_path(arm):
    with pytest.raises(gw.NoPath, match="elbow_joint"):
        gw.arm.joint_path(arm, [[0, -1, 1, 0, 0, 0], [0, -1, 3.3, 0, 0, 0]])


@pytest.mark.parametrize("shift", ["payload", "friction"])
def test_static_overload_is_named(arm, star_path, shift):
    loaded = arm.with_payload(60.0) if shift == "payload" else arm.with_friction(Friction(coulomb=200.0))
    with pytest.raises(gw.Infeasible, match=r"static overload: at s = .*joint, its limit is 28 N m"):
        check_static(loaded, star_path.path, JointLimits(torque=arm.torque_limits()))


def test_the_irb_6700_has_no_inertials_until_they_are_estimated():
    bare, estimated = gw.arm.robot("irb6700"), gw.arm.robot("irb6700", estimated=True)
    q = np.zeros(6)
    with pytest.raises(gw.BadParameter, match="no masses and inertias"):
        bare.torques(q, q, q)
    with pytest.raises(gw.BadParameter, match="no torque limit is given for joint_1"):
        estimated.torque_limits()
    assert (bare.inertials, estimated.inertials) == ("none", "estimated")
    load = estimated.torques([0, 1.0, 0, 0, 0, 0], q, q)
    assert 1000 < abs(load[1]) < 15000  # an arm of half a tonne, leaning forward


def test_followers_move_with_their_leader():
    robot = gw.arm.robot("irb6700")
    q = np.array([0.1, 0.5, -0.3, 0.2, 0.4, 0.1])
    assert robot.names == tuple(f"joint_{k}" for k in range(1, 7))
    assert np.allclose((robot.coupling @ q)[1:3], [-0.25 * 0.5, 0.15 * 0.5])


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"limit": '<limit lower="-3" upper="nan" velocity="2" effort="5"/>'}, "joint a, limit upper"),
        ({"limit": ""}, "joint a: it has no limits"),
        ({"limit": '<limit lower="3" upper="-3" velocity="2" effort="5"/>'}, "above its upper limit"),
        ({"kind": "floating"}, "type floating"),
        ({"inertial": '<inertial><mass value="two"/></inertial>'}, "link one, mass value"),
    ],
)
def test_hostile_descriptions_are_refused(tmp_path, parts, message):
    with pytest.raises(gw.BadFile, match=message):
        gw.arm.Arm.load(written(tmp_path, **parts))


@pytest.mark.parametrize("text", ["<robot", "<html/>", "<robot name='x'/>", "<robot><link name='a'/><link name='b'/></robot>"])
def test_what_is_no_robot_is_refused(tmp_path, text):
    (tmp_path / "x.urdf").write_text(text)
    with pytest.raises(gw.BadFile, match=r"valid XML|a <html>|no link|2 links hang on no joint"):
        gw.arm.Arm.load(tmp_path / "x.urdf")


def test_a_joint_may_be_called_as_a_link_is_and_foreign_elements_are_left_alone(tmp_path):
    path = written(tmp_path, inertial=INERTIAL + '<collision><verbose value="Yes"/></collision>')
    plain = gw.arm.Arm.load(path, tip="one")
    path.write_text(path.read_text().replace('<joint name="b"', '<joint name="two"').replace('<joint name="a"', '<joint name="one"'))
    for tip, joints in (("one", ("one",)), ("two", ("one", "two"))):
        arm = gw.arm.Arm.load(path, tip=tip)
        assert arm.names == joints
    q = np.array([0.4])
    one = gw.arm.Arm.load(path, tip="one")
    assert np.array_equal(one.forward(q), plain.forward(q))
    assert np.array_equal(one.torques(q, q, q), plain.torques(q, q, q))


def test_an_effort_of_zero_means_not_given(tmp_path):
    arm = gw.arm.Arm.load(written(tmp_path, effort=0))
    with pytest.raises(gw.BadParameter, match="no torque limit is given for b"):
        arm.torque_limits()


def test_a_continuous_joint_has_no_range(tmp_path):
    arm = gw.arm.Arm.load(written(tmp_path, kind="continuous", limit='<limit velocity="2" effort="5"/>'))
    assert arm.lower[0] == -math.inf
    assert np.allclose(arm.forward([50.0, 0.0])[:2, 3], [0.5 * math.cos(50), 0.5 * math.sin(50)])


def test_limits_files(tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text("speed = 2\nacceleration = [1, 2.5]\ndeceleration = 3.0\njerk = 40\n")
    limits = load_limits(path)
    assert limits.to_dict(2) == {"speed": [2, 2], "acceleration": [1, 2.5], "deceleration": [3, 3], "jerk": [40, 40]}
    with pytest.raises(gw.BadParameter, match="acceleration has 2 numbers"):
        limits.per_joint("acceleration", 6)
    for text, message in (
        ("speed = -1", "field speed"),
        ("speed = nan", "field speed"),
        ("sped = 1", "speed"),
        ("# none", "no limit"),
        ("torque = []", "torque"),
    ):
        path.write_text(text)
        with pytest.raises(gw.BadFile, match=message):
            load_limits(path)


def test_way_points_of_another_robot_are_refused(tmp_path, arm):
    path = tmp_path / "way.csv"
    path.write_text(",".join(reversed(arm.names)) + "\n0,0,0,0,0,1\n1,0,0,0,0,2\n")
    points, names = gw.arm.load_way_points(path, arm.names)
    assert points[:, 0].tolist() == [1, 2]
    assert names == arm.names
    for text, message in (
        ("a,b\n0,0\n1,1\n", "is not of this robot"),
        ("0,0,0,0,0,1\n1,0,0,0,0,2\n", "no header"),
        (",".join(arm.names) + "\n0,0,0,0,0,nan\n1,0,0,0,0,1\n", "line 2, field wrist_3_joint"),
        (",".join(arm.names) + "\n0,0,0,0,0,0\n", "one way point"),
        (",".join(arm.names[:5]) + "\n0,0,0,0,0\n1,0,0,0,0\n", "wrist_3_joint' has no column.*--tip"),
    ):
        path.write_text(text)
        with pytest.raises(gw.BadFile, match=message):
            gw.arm.load_way_points(path, arm.names)


def test_an_arm_of_seven_joints_follows_a_tool_path():
    quarter = math.pi / 2
    table = zip((0.36, 0, 0.42, 0, 0.4, 0, 0.126), (-quarter, quarter, quarter, -quarter, -quarter, quarter, 0), strict=True)
    arm = gw.arm.Arm.from_dh([{"a": 0.0, "alpha": alpha, "d": d} for d, alpha in table], lower=-6.2, upper=6.2)
    line = gw.arm.Nurbs([[0.5, -0.2, 0.4], [0.55, 0.0, 0.45], [0.5, 0.2, 0.4]], degree=2, posture=[-0.3, 0.6, 0.1, -1.3, 0.1, 1.2, 0.2])
    found = gw.arm.joint_path(arm, line)
    poses = arm.forward(found.path.eval(np.linspace(0, found.path.length, 50))[0])
    assert np.allclose(poses[:, :3, :3], np.diag([1.0, -1.0, -1.0]), atol=2e-5)
    assert poses[0, :3, 3] == pytest.approx([0.5, -0.2, 0.4], abs=1e-5)
    assert poses[-1, :3, 3] == pytest.approx([0.5, 0.2, 0.4], abs=1e-5)
    with pytest.raises(gw.BadParameter, match="six joints only"):
        gw.arm.branches(arm, poses[0])
