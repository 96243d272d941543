"""The report of an arm's motion: one file, offline, safe against its data, small, and what it shows is what the record says."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import guideway as gw
from guideway import cli, view
from guideway.arm import skeleton
from guideway.view import arm_course
from pages import markup

JOINTS = ["base_joint", "elbow_joint"]
HALF = 1.0
"""Time and length of either half of the motion below: up to 2 rad/s with 2 rad/s2, and down again."""


def chain() -> dict[str, Any]:
    """A planar arm of two links of 0.5 m."""
    still = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
    along = [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0]
    joints = [
        {"name": JOINTS[0], "parent": 0, "pose": still, "axis": [0, 0, 1], "slides": False, "factors": [1, 0], "offset": 0},
        {"name": JOINTS[1], "parent": 1, "pose": along, "axis": [0, 0, 1], "slides": False, "factors": [0, 1], "offset": 0},
    ]
    return {"joints": joints, "links": [{"name": "hand", "joint": 2, "pose": along}], "tip": "hand", "base": "root"}


def traj(**more: Any) -> dict[str, Any]:
    """The base turns by 2 rad, the elbow stands still; the record as ``guideway arm time`` writes it."""
    t = np.linspace(0, 2 * HALF, 201)
    speed = np.where(t < HALF, 2 * t, 2 * (2 * HALF - t))
    place = np.where(t < HALF, t**2, 2 - (2 * HALF - t) ** 2)
    still = np.zeros_like(t)
    s = np.linspace(0, 2, 41)
    base = {
        "guideway": "0.1.0", "schema": 1, "kind": "arm", "joints": JOINTS, "duration": 2 * HALF,
        "robot": {"name": "two links", "source": None, "tip": "hand", "frame": "root", "inertials": "none", "chain": chain(),
                  "payload": {"mass": 0.0, "at": [0, 0, 0], "inertia": []}, "friction": {"viscous": [0, 0], "coulomb": [0, 0]}},
        "limits": {"speed": [4.0, 4.0], "acceleration": [2.0, 2.0]},
        "t": t.tolist(), "q": np.stack([place, still], 1).tolist(), "qd": np.stack([speed, still], 1).tolist(),
        "qdd": np.stack([np.where(t < HALF, 2.0, -2.0), still], 1).tolist(),
        "path": {"degree": 1, "knots": [0, 0, 2, 2], "control_points": [[0, 0], [2, 0]], "length": 2.0, "source": "way.csv"},
        "pieces": [{"t": 0, "s": 0, "speed": 0, "acceleration": 2, "jerk": 0, "duration": HALF},
                   {"t": HALF, "s": 1, "speed": 2, "acceleration": -2, "jerk": 0, "duration": HALF}],
        "grid": {"s": s.tolist(), "x": (4 * np.minimum(s, 2 - s)).tolist(), "mvc": [16.0] * 41, "active": ["acceleration of base_joint"] * 41},
        "report": {"method": "reachability", "solver": {"points": 41, "seconds": 0.002}, "price": None, "path": {}},
        "certificate": {"ok": True, "samples": 12, "collision": None, "checks": [
            {"name": "speed of base_joint", "limit": "speed", "joint": "base_joint", "ok": True, "ratio": 0.5, "t": 1.0, "s": 1.0}]},
    }  # fmt: skip
    return base | more


def learned(count: int = 4, **more: Any) -> dict[str, Any]:
    s = np.linspace(0, 2, 41)
    rows = [
        {"number": k + 1, "duration": 2.6 - 0.1 * k, "lower_bound": 1.9, "measured": 0.04 - 0.02 * k, "samples": max(0, 3 - 2 * k), "clean": k > 1,
         "stopped": False, "true": 0.03 - 0.02 * k, "profile": {"s": s.tolist(), "x": (3 * np.minimum(s, 2 - s)).tolist()}}
        for k in range(count)
    ]  # fmt: skip
    oracle = {"s": s.tolist(), "x": (4.2 * np.minimum(s, 2 - s)).tolist()}
    return traj(trials=rows, best=count, learner="structured", oracle_duration=1.95, oracle=oracle, certificate=None) | more


def data_of(text: str) -> dict[str, Any]:
    found = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert len(found) == 1
    return json.loads(found[0])


def motion_of(record: dict[str, Any]) -> dict[str, Any]:
    return data_of(view.arm_page(record))["motions"][0]


def test_one_file_without_any_link(tmp_path: Path) -> None:
    text = view.arm_report([traj(), learned()], tmp_path / "r.html").read_text("utf-8")
    assert [p.name for p in tmp_path.iterdir()] == ["r.html"]
    assert "://" not in text
    assert not re.search(r"<(link|iframe|object|embed|base)\b|\bsrc=|@import|url\((?!#)|\bfetch\(|XMLHttpRequest|WebSocket", text, re.I)
    assert "default-src 'none'" in text
    assert not re.search(r"\{\{\w+\}\}", text)
    assert len(text) < 400_000


@pytest.mark.parametrize(
    "text", ["</script><script>alert(1)</script>", "<!--<script>", "https://example.org/x", "{{data}}", "a\u2028b", '"\\</ScRiPt>']
)
def test_hostile_names_stay_text(text: str) -> None:
    named = traj(joints=[text, "elbow_joint"], learner=text, robot=traj()["robot"] | {"name": text, "tip": text})
    named["grid"] = named["grid"] | {"active": [f"torque of {text}"] * 41}
    page = view.arm_page(named, title=text)
    assert data_of(page)["title"] == text
    assert data_of(page)["motions"][0]["joints"][0] == text
    assert page.lower().count("<script") == page.lower().count("</script") == 2
    assert "://" not in page
    assert "<!--" not in page


def test_the_motion_is_evaluated_from_its_pieces() -> None:
    found = motion_of(traj(q=[], qd=[], qdd=[]))["course"]
    t = np.array(found["t"])
    assert t[[0, -1]] == pytest.approx([0, 2])
    assert np.interp(0.5, t, found["q"][0]) == pytest.approx(0.25, abs=1e-4)
    assert np.interp(1.5, t, found["qd"][0]) == pytest.approx(1.0, abs=1e-4)
    assert np.abs(found["qdd"][0]) == pytest.approx(2.0)
    assert found["jerky"]  # no limit of jerk: the acceleration steps


def test_without_pieces_the_table_is_read() -> None:
    found = motion_of(traj(pieces=[], path={}))["course"]
    assert np.interp(0.5, found["t"], found["q"][0]) == pytest.approx(0.25, abs=1e-3)
    assert "qddd" not in found


def test_long_motions_are_thinned() -> None:
    n = 40_000
    t = np.linspace(0, 2, n)
    tall = {key: np.zeros((n, 2)).tolist() for key in ("q", "qd", "qdd", "tau")}
    s = np.linspace(0, 2, n)
    pieces = [{"t": 2 * k / n, "s": 2 * k / n, "speed": 1.0, "acceleration": 0, "jerk": 0, "duration": 2 / n} for k in range(n)]
    grid = {"s": s.tolist(), "x": [1.0] * n, "mvc": [None] * n, "active": ["speed of joint 1"] * n}
    page = view.arm_page(traj(t=t.tolist(), grid=grid, pieces=pieces, **tall))
    found = data_of(page)["motions"][0]
    assert len(page) < 600_000
    assert len(found["course"]["t"]) <= arm_course.MOST_SAMPLES
    assert len(found["course"]["tau"][0]) == len(found["course"]["t"])
    assert len(found["phase"]["s"]) <= arm_course.MOST_POINTS + 1
    assert len(found["stretches"]) == 1


def test_many_trials_stay_small_and_complete() -> None:
    found = motion_of(learned(2000, best=777))
    assert len(found["trials"]) == 2000
    drawn = [row["number"] for row in found["trials"] if "profile" in row]
    assert len(drawn) < 70
    assert {1, 777, 2000} <= set(drawn)


def test_the_phase_plane_has_both_curves() -> None:
    shape = motion_of(traj())["phase"]
    assert shape["first"] == pytest.approx([4.0] * len(shape["s"]))  # 4 rad/s of the base
    assert shape["second"] == pytest.approx([4.0] * len(shape["s"]))
    assert max(shape["v"]) == pytest.approx(2.0)
    assert not shape["kinematic"]


def test_a_curve_that_the_record_has_not_is_that_of_speeds_and_accelerations() -> None:
    none = traj()["grid"] | {"mvc": [None] * 41, "active": [None] * 41}
    shape = motion_of(traj(grid=none))["phase"]
    assert shape["kinematic"]
    assert shape["second"] == pytest.approx([4.0] * len(shape["s"]))
    assert motion_of(traj(grid=none))["stretches"] == []


def test_highest_speed_at_a_bend() -> None:
    """A joint whose speed along the path is 0 there must bend with 3 x <= its acceleration; two that pull apart leave no room beyond."""
    one, two = np.array([[0.0, 1.0], [1.0, 1.0]]), np.array([[3.0, 0.0], [2.0, -2.0]])
    faster = np.array([6.0, 6.0])
    assert arm_course.highest(one, two, faster, faster) == pytest.approx([2.0, 3.0])
    # brute force: the largest x for which some u keeps both
    for x, fits in ((2.99, True), (3.01, False)):
        u = np.linspace(-20, 20, 4001)
        assert bool((np.abs(u[:, None] * one[1] + two[1] * x) <= 6.0).all(axis=1).any()) is fits


def test_stretches_name_joint_and_kind() -> None:
    names = ["speed of joint 2"] * 10 + ["torque of elbow_joint"] * 20 + ["ceiling"] * 11
    rows = motion_of(traj(grid=traj()["grid"] | {"active": names}))["stretches"]
    assert [(row["kind"], row["joint"]) for row in rows] == [("speed", 1), ("torque", 1), ("ceiling", None)]
    assert rows[0]["from"] == 0
    assert rows[1]["from"] == rows[0]["to"] == pytest.approx(0.5)
    assert rows[1]["begins"] == pytest.approx(np.sqrt(0.5), abs=1e-3)
    assert rows[-1]["to"] == pytest.approx(2.0)


def test_a_limit_without_a_joint_is_given_the_one_that_uses_most_of_it() -> None:
    rows = motion_of(traj(grid=traj()["grid"] | {"active": ["acceleration"] * 41}))["stretches"]
    assert [(row["kind"], row["joint"]) for row in rows] == [("acceleration", 0)]


def test_ties_do_not_flicker() -> None:
    names = ["acceleration of joint 1", "speed of joint 2"] * 20 + ["speed of joint 2"]
    rows = motion_of(traj(grid=traj()["grid"] | {"active": names}))["stretches"]
    assert [row["name"] for row in rows[:1]] == ["acceleration of joint 1"]
    assert len(rows) <= 3  # the base accelerates at its limit all along; the elbow, named in between, stands still


POOR = [
    {},
    {"kind": "arm"},
    traj(joints=None),
    traj(limits=7, grid="x", path=3, pieces=4, certificate=[], report=5),
    traj(robot={"name": "x", "chain": {"joints": [{"pose": [1], "axis": 3}]}}),
    traj(robot={"chain": {"joints": [{"parent": 5, "pose": [0] * 12, "axis": [0, 0, 1]}], "links": 3}, "source": "nowhere.urdf"}),
    traj(q=[[1], [1, 2]], t=["x"], qd=None),
    traj(grid={"s": [0, 1], "x": [None, None], "mvc": [1], "active": [1, 2]}),
    traj(trials=[1, {}, {"number": "x", "duration": None, "profile": {"s": [0], "x": [1, 2]}}], best="?"),
    learned(certificate={"ok": False, "checks": [{"name": "x", "ok": False, "ratio": float("nan")}, 3], "collision": {"hit": {"pair": 3}}}),
]


@pytest.mark.parametrize("record", POOR)
def test_poor_records_still_make_a_page(record: dict[str, Any]) -> None:
    assert len(data_of(view.arm_page(record))["motions"]) == 1


def test_no_records_make_a_page() -> None:
    assert data_of(view.arm_page([]))["motions"] == []
    with pytest.raises(TypeError, match=r"records\[1\] is a list"):
        view.arm_page([traj(), []])  # type: ignore[list-item]


def test_labels_tell_motions_apart() -> None:
    def label(*records: dict[str, Any]) -> list[str]:
        return [entry["label"] for entry in data_of(view.arm_page(list(records)))["motions"]]

    loaded = traj(robot=traj()["robot"] | {"payload": {"mass": 5.0}})
    assert label(traj(), loaded) == ["reachability, 0 kg", "reachability, 5 kg"]
    assert label(traj(), traj(limits=traj()["limits"] | {"jerk": 50.0})) == ["reachability, no jerk limit", "reachability, jerk"]
    assert label(traj(), traj())[1].endswith("#2")


def test_the_command_writes_report_and_figure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "traj.json").write_text(json.dumps(traj()))
    assert cli.main(["view", str(tmp_path / "traj.json"), "--out", str(tmp_path / "r.html"), "--title", "Cell 4"]) == 0
    assert data_of((tmp_path / "r.html").read_text("utf-8"))["title"] == "Cell 4"
    (tmp_path / "plan.json").write_text(json.dumps({"guideway": "0.1.0", "schema": 1, "planner": "visibility"}))
    assert cli.main(["view", str(tmp_path / "traj.json"), str(tmp_path / "plan.json"), "--out", str(tmp_path / "x.html")]) == 2
    assert "cannot stand in one report" in capsys.readouterr().err
    assert not (tmp_path / "x.html").exists()


def test_figures_for_papers(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    for name, record in (("a", traj()), ("b", learned()), ("c", traj(limits={"speed": 4.0}, tau=np.zeros((201, 2)).tolist()))):
        png, svg = view.arm_figure(record, tmp_path / name)
        assert png.read_bytes()[:4] == b"\x89PNG"
        assert "<svg" in svg.read_text("utf-8")
    with pytest.raises(ValueError, match="no motion"):
        view.arm_figure({}, tmp_path / "none")


@pytest.fixture(scope="module")
def real() -> Any:
    """The chain and surfaces of an arm that ships with the package; skips without Pinocchio."""
    pytest.importorskip("pinocchio")
    return gw.arm.robot("irb6700")


def placed(found: dict[str, Any], q: np.ndarray) -> list[np.ndarray]:
    """Poses of the root and the joints of a chain, as the page computes them."""
    poses = [np.eye(4)]
    for joint in found["joints"]:
        value, axis = joint["offset"] + np.dot(joint["factors"], q), np.array(joint["axis"])
        cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        turn, fixed = np.eye(4), np.eye(4)
        fixed[:3] = np.reshape(joint["pose"], (3, 4))
        if joint["slides"]:
            turn[:3, 3] = axis * value
        else:
            turn[:3, :3] += np.sin(value) * cross + (1 - np.cos(value)) * cross @ cross
        poses.append(poses[joint["parent"]] @ fixed @ turn)
    return poses


def test_the_chain_places_the_tip(real: Any) -> None:
    found = gw.arm.chain(real)
    links = {link["name"]: link for link in found["links"]}
    rng = np.random.default_rng(3)
    for q in rng.uniform(-1, 1, (5, real.joints)):
        poses = placed(found, q)
        tip, base = (
            poses[links[found[key]]["joint"]] @ np.vstack([np.reshape(links[found[key]]["pose"], (3, 4)), [0, 0, 0, 1]]) for key in ("tip", "base")
        )
        assert np.linalg.inv(base) @ tip == pytest.approx(real.forward(q), abs=1e-7)


def test_surfaces_are_packed_to_a_tenth_of_a_millimetre(real: Any) -> None:
    robot = {"source": "elsewhere/irb6700.urdf", "chain": gw.arm.chain(real)}
    exact = gw.arm.surfaces(robot)  # the file is not there: the one that ships with the package is taken
    text = view.arm_page(traj(robot=traj()["robot"] | robot))
    packed = data_of(text)["surfaces"][0]
    assert len(text) < 700_000
    assert len(packed) == len(exact) == 9
    for part, whole in zip(packed, exact, strict=True):
        steps = np.frombuffer(base64.b64decode(part["corners"]), "<i2").reshape(-1, 3)
        faces = np.frombuffer(base64.b64decode(part["faces"]), "<u2").reshape(-1, 3)
        assert np.array(part["origin"]) + part["scale"] * steps == pytest.approx(whole["corners"], abs=1e-4)
        assert np.array_equal(faces, whole["faces"])


def test_obstacles_and_tools_are_placed(tmp_path: Path) -> None:
    shapes = [{"kind": "box", "name": "table", "size": [1.0, 2.0, 0.1], "at": [3.0, 0.0, 0.0]}, {"kind": "sphere", "radius": 0.2, "at": [0, 0, 1.0]},
              {"kind": "mesh", "file": str(tmp_path / "none.stl")}]  # fmt: skip
    tool = [{"kind": "cylinder", "name": "gripper", "radius": 0.1, "length": 0.4, "at": [0, 0, 0.2]}]
    record = traj(
        certificate={"ok": True, "checks": [], "collision": {"ok": True, "pairs": 2, "closest": None, "scene": {"shapes": shapes, "tool": tool}}}
    )
    table, ball, gripper = gw.arm.obstacles(record["robot"], record["certificate"]["collision"]["scene"])
    assert (table["corners"].min(axis=0), table["corners"].max(axis=0)) == (pytest.approx([2.5, -1, -0.05]), pytest.approx([3.5, 1, 0.05]))
    assert np.linalg.norm(ball["corners"] - [0, 0, 1.0], axis=1).max() == pytest.approx(0.2)
    assert gripper["joint"] == 2  # on the hand, 0.5 m along the last link
    assert gripper["corners"].mean(axis=0) == pytest.approx([0.5, 0, 0.2], abs=1e-6)
    assert [part["name"] for part in motion_of(record)["around"]] == ["table", "sphere", "gripper"]


def test_closed_surfaces_turn_outwards() -> None:
    """The volume inside, by the divergence theorem: positive where all faces turn outwards."""
    shapes = [{"kind": "box", "size": [1, 2, 3]}, {"kind": "cylinder", "radius": 1, "length": 2}, {"kind": "sphere", "radius": 1}]
    for part, volume, within in zip(gw.arm.obstacles({}, {"shapes": shapes}), (6.0, 2 * np.pi, 4 / 3 * np.pi), (1e-9, 0.02, 0.05), strict=True):
        a, b, c = (part["corners"][part["faces"][:, k]] for k in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(volume, rel=within)


def test_dense_meshes_are_simplified() -> None:
    angle = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], 1)
    height = np.linspace(-1, 1, 60)
    points = np.array([[*(ring[i] * np.sqrt(1 - h * h)), h] for h in height for i in range(120)]).reshape(60, 120, 3)
    quads = np.stack([points[:-1], np.roll(points, -1, 1)[:-1], np.roll(points, -1, 1)[1:], points[1:]], 2)
    triangles = np.concatenate([quads[:, :, [0, 1, 2]], quads[:, :, [0, 2, 3]]]).reshape(-1, 3, 3)
    corners, faces = skeleton.simplified(triangles)
    assert len(triangles) > 2 * skeleton.MOST_TRIANGLES >= 2 * len(faces)
    assert np.abs(np.linalg.norm(corners, axis=1) - 1).max() < 1e-9  # corners are kept, not moved
    assert len(faces) > 400


def complaints(log: str) -> list[str]:
    """What the page complained about; what the browser says of its own drawing does not count."""
    return [line for line in log.splitlines() if "CONSOLE" in line and "WebGL" not in line]


@pytest.mark.usefixtures("browser")
def test_the_page_draws_itself(tmp_path: Path) -> None:
    smooth = traj()["report"] | {"price": [["jerk of joint 1", 0.03], ["jerk of joint 2", 0.0]]}
    target = view.arm_report([traj(report=smooth), learned()], tmp_path / "r.html", title="A <cell>")
    text, log = markup(f"{target.as_uri()}#t=0.5", tmp_path)
    assert complaints(log) == []
    assert '<h1 id="title">A &lt;cell&gt;</h1>' in text
    assert "All limits kept" in text
    assert "<b>0.50</b> / 2.00 s" in text
    assert "<b>1.00 rad/s</b> at 0.25 rad" in text
    assert text.count('class="curve"') == 4  # position, speed, acceleration, tool
    assert "<dd>+0.030<small>s</small></dd>" in text
    assert text.count("Jerk of base") == 1
    assert "Jerk of elbow" not in text  # it costs nothing
    assert ">1.00 m/s<" in text  # the tool, 1 m out, at 1 rad/s


@pytest.mark.usefixtures("browser")
def test_any_motion_is_shown_without_complaints(tmp_path: Path) -> None:
    """All poor records in one page, brought to the front one after the other."""
    page = view.arm_page([learned(), *POOR])
    press = (
        "<script>for (let i = 0; i < 99; i += 1) { const all = document.querySelectorAll('#compare button'); if (all[i]) all[i].click(); }</script>"
    )
    target = tmp_path / "r.html"
    target.write_text(page.replace("</body>", f"{press}</body>"), "utf-8")
    text, log = markup(target.as_uri(), tmp_path)
    assert complaints(log) == []
    assert text.count('aria-pressed="true"') >= 1
    assert "3 checks failed" in text or "A check failed" in text or "collides" in text


HANDS = """
const send = (node, type, x, y, more) => {
  const box = node.getBoundingClientRect();
  const at = { clientX: box.left + x * box.width, clientY: box.top + y * box.height, bubbles: true, pointerId: 1, ...more };
  node.dispatchEvent(type === "wheel" ? new WheelEvent(type, { deltaY: 120, ...at }) : new PointerEvent(type, at));
};
const key = (name) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true }));
const over = document.getElementById("over");
over.setPointerCapture = () => {};
for (const name of ["2", "+", "f", "0", "g", "ArrowRight", "End", "Home", "a", "2"]) key(name);
send(over, "pointerdown", 0.5, 0.5, { button: 0, buttons: 1 });
send(over, "pointermove", 0.6, 0.4, { buttons: 1 });
send(over, "pointerup", 0.6, 0.4);
send(over, "wheel", 0.5, 0.5);
send(over, "pointermove", 0.4, 0.5);
document.querySelector("#trials tbody tr").dispatchEvent(new PointerEvent("pointerenter"));
document.getElementById("theme").click();
const chart = document.querySelector("#curves .chart");
send(chart, "pointermove", 0.5, 0.5);
send(chart, "pointerdown", 0.5, 0.5, { button: 0, buttons: 1 });
document.title = document.getElementById("clock").textContent + "; " + document.querySelector("#phase output").textContent;
send(chart, "pointerleave", 0.5, 0.5);
document.getElementById("play").click();
"""


@pytest.mark.usefixtures("browser")
def test_hands_on_the_page(tmp_path: Path) -> None:
    """Keys, drags, the wheel, pointing and pressing do what they say, without complaints."""
    page = view.arm_page(learned())
    target = tmp_path / "r.html"
    target.write_text(page.replace("</body>", f"<script>{HANDS}</script></body>"), "utf-8")
    text, log = markup(target.as_uri(), tmp_path)
    assert complaints(log) == []
    clock, speed = re.findall(r"<title>(\d\.\d+) / 2\.00 s; (\d\.\d+) rad/s at", text)[0]
    assert float(clock) == pytest.approx(1.0, abs=0.1)  # the middle of the chart, but for its margins
    assert float(speed) == pytest.approx(2 * min(float(clock), 2 - float(clock)), abs=0.03)
    assert re.search(r'aria-pressed="true"[^>]*><i></i>elbow<', text)
    assert "limit 4<" in text  # one joint in its units
