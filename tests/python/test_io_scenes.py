"""Scenes, movers, collections, and what ``maps info`` says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import guideway.io as gio
from guideway.io.info import component_sizes
from guideway.io.raster import rasterize

FULL = """
[world]
bounds = [0, 0, 10, 6]
resolution = 0.05
mover_speed = 1.6
[[disc]]
center = [1.2, 0.95]
radius = 0.4
[[polygon]]
points = [[0, 0], [1, 0], [1, 1]]
[[mover]]
shape = { box = [0.8, 0.8] }
path = [[3.2, 2.95], [3.2, 2.95], [3.2, 4.3], [4.2, 4.3]]
speed = 0.5
loop = "shuttle"
phase = 0.25
appears = { within = 3.0 }
[[mover]]
shape = { disc = 0.3 }
trajectory = "track.csv"
appears = { at = 12.0 }
[[mover]]
shape = { polygon = [[-1, -1], [1, -1], [0, 1]] }
path = [[5, 5]]
[robot]
footprint = { disc = 0.2 }
speed = 2.0
acceleration = 5.0
jerk = 10.0
turn_rate = 2.0
[lidar]
beams = 720
field_of_view = 6.283185307
[query]
start = [0, 0]
goal = [5, 3, 1.5]
clearance = 0.3
material = "long"
[plan]
planner = "astar"
set = { ants = 20, "greedy" = true }
seed = 3
seconds = 0.5
corners = "clear"
out = "plan \\"1\\".json"
"""


@pytest.fixture
def full(tmp_path: Path) -> Path:
    (tmp_path / "track.csv").write_text("t,x,y\n0,1,2\n\n2.5, 1.5,2\r\n")
    (tmp_path / "s.toml").write_text(FULL)
    return tmp_path / "s.toml"


def test_every_field_arrives(full: Path) -> None:
    scene = gio.load_scene(full)
    assert (scene.bounds, scene.resolution, scene.kind) == ((0, 0, 10, 6), 0.05, "scene")
    assert [s.to_dict() for s in scene.shapes] == [
        {"disc": {"center": [1.2, 0.95], "radius": 0.4}},
        {"polygon": {"points": [[0, 0], [1, 0], [1, 1]]}},
    ]
    first, second, third = scene.movers
    assert first.track == ((0, 3.2, 2.95), (pytest.approx(2.7), 3.2, 4.3), (pytest.approx(4.7), 4.2, 4.3))
    assert (first.loop, first.phase, first.to_dict()["appears"]) == ("shuttle", 0.25, {"within": 3.0})
    assert second.to_dict() == {"shape": {"disc": 0.3}, "track": [[0, 1, 2], [2.5, 1.5, 2]], "loop": "once", "phase": 0.0, "appears": {"at": 12.0}}
    assert third.track == ((0, 5, 5),)
    assert scene.robot.limits() == {
        "speed": 2.0,
        "acceleration": 5.0,
        "deceleration": 5.0,
        "jerk": 10.0,
        "turn_rate": 2.0,
        "turn_acceleration": None,
        "lateral_acceleration": None,
    }
    assert scene.lidar == gio.Lidar(beams=720)
    assert scene.mover_speed == 1.6
    assert scene.query is not None
    assert (scene.query.start, scene.query.start_yaw, scene.query.goal, scene.query.goal_yaw) == ((0, 0), None, (5, 3), 1.5)
    assert (scene.query.clearance, scene.query.arrival, scene.query.material) == (0.3, 0.1, "long")
    assert scene.plan is not None
    assert (scene.plan.set, scene.plan.seed, scene.plan.refine, scene.plan.out) == ({"ants": 20, "greedy": True}, 3, None, 'plan "1".json')
    assert set(scene.files) == {"s.toml", "track.csv"}


def test_scene_written_and_read_is_the_same(full: Path) -> None:
    scene = gio.load_scene(full)
    gio.write_map(scene, full.with_name("again.toml"))
    again = gio.load_scene(full.with_name("again.toml"))
    for field in ("bounds", "resolution", "mover_speed", "shapes", "movers", "robot", "lidar", "query", "plan"):
        assert getattr(again, field) == getattr(scene, field), field


coordinate = st.floats(-1e6, 1e6)
points = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=4)
footprints = st.one_of(
    st.builds(gio.Footprint, disc=st.floats(0, 100)),
    st.builds(gio.Footprint, box=st.tuples(st.floats(1e-3, 100), st.floats(1e-3, 100))),
    st.just(gio.Footprint(polygon=((-1.0, -1.0), (2.0, -1.0), (0.0, 1.5)))),
)
tracks = st.lists(st.tuples(st.floats(1e-3, 10), coordinate, coordinate), min_size=1, max_size=5)
movers = st.builds(
    lambda shape, steps, loop, phase, appears: gio.Mover(
        shape, tuple((sum(s[0] for s in steps[1 : i + 1]), x, y) for i, (_, x, y) in enumerate(steps)), loop, phase, appears
    ),
    footprints,
    tracks,
    st.sampled_from(["once", "cycle", "shuttle"]),
    st.floats(-100, 100),
    st.one_of(st.none(), st.builds(gio.Appears, within=st.floats(0, 50)), st.builds(gio.Appears, at=st.floats(0, 50))),
)
queries = st.builds(
    gio.Query,
    start=st.tuples(coordinate, coordinate),
    goal=st.none() | st.tuples(coordinate, coordinate),
    start_yaw=st.none() | st.floats(-10, 10),
    via=points.map(tuple),
    clearance=st.floats(0, 10),
    material=st.sampled_from(["standard", "long", "heavy"]),
    time_limit=st.none() | st.floats(1e-3, 1e5),
)
plans = st.builds(
    gio.Plan,
    planner=st.none() | st.text(min_size=1, max_size=20).filter(lambda t: "\0" not in t),
    set=st.dictionaries(st.text(max_size=9), st.one_of(st.booleans(), st.integers(-9, 9), st.floats(-9, 9), st.text(max_size=9)), max_size=3),
    seed=st.none() | st.integers(0, 2**63 - 1),
)


@settings(deadline=None, max_examples=60)
@given(st.lists(movers, max_size=3), queries, st.none() | plans, st.lists(st.builds(gio.Disc, st.tuples(coordinate, coordinate), st.floats(0, 9))))
def test_any_scene_round_trips(
    tmp_path_factory: pytest.TempPathFactory, moving: list[gio.Mover], query: gio.Query, plan: gio.Plan | None, discs: list[gio.Disc]
) -> None:
    target = tmp_path_factory.getbasetemp() / "any.toml"
    scene = gio.Scene((-1e6, -1e6, 1e6, 1e6), 200.0, target, "", shapes=tuple(discs), movers=tuple(moving), query=query, plan=plan)
    gio.write_map(scene, target)
    again = gio.load_scene(target)
    for field in ("bounds", "resolution", "shapes", "movers", "robot", "has_robot", "lidar", "query", "plan"):
        assert getattr(again, field) == getattr(scene, field), field


def test_movers_files(full: Path) -> None:
    assert gio.load_movers(full) == gio.load_scene(full).movers
    (mover,) = gio.load_movers(full.with_name("track.csv"))
    assert mover.track == ((0, 1, 2), (2.5, 1.5, 2))


def test_defaults_and_a_map(tmp_path: Path) -> None:
    (tmp_path / "m.txt").write_text("..#\n...\n")
    (tmp_path / "s.toml").write_text("[world]\nmap = 'm.txt'\n[[disc]]\ncenter = [0.5, 0.5]\nradius = 0.1\n")
    scene = gio.load_scene(tmp_path / "s.toml")
    assert scene.map is not None
    assert (scene.bounds, scene.resolution, scene.query, scene.has_robot) == ((0, 0, 3, 2), 1.0, None, False)
    assert scene.robot == gio.Robot()
    assert rasterize(scene).blocked.tolist() == [[False, False, True], [True, False, False]]


def test_turned_grid_bounds() -> None:
    grid = gio.GridMap(np.zeros((2, 3), bool), None, 0.5, (1.0, 2.0, np.pi / 2), Path("m"), "", {}, "test")
    assert grid.bounds == pytest.approx((0.0, 2.0, 1.0, 3.5))


def test_rasterized_shapes_hold_every_point(tmp_path: Path) -> None:
    shapes = (gio.Disc((2.03, 1.47), 0.81), gio.Polygon(((3.1, 0.2), (4.7, 0.9), (3.4, 2.6))), gio.Disc((-5.0, -5.0), 0.3))
    scene = gio.Scene((0.0, 0.0, 5.0, 3.0), 0.25, tmp_path, "", shapes=shapes)
    blocked = rasterize(scene).blocked
    assert blocked.shape == (12, 20)
    x, y = np.meshgrid(np.linspace(0, 4.999, 400), np.linspace(0, 2.999, 300))
    disc = np.hypot(x - 2.03, y - 1.47) <= 0.81
    corners = np.array(shapes[1].points)  # pyright: ignore[reportAttributeAccessIssue]
    edges = zip(corners, np.roll(corners, -1, 0), strict=True)
    polygon = np.all([(b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) >= 0 for a, b in edges], axis=0)
    seen = blocked[11 - (y / 0.25).astype(int), (x / 0.25).astype(int)]
    assert seen[disc | polygon].all()
    # no more than the cells within a cell's diagonal of a shape
    near = np.hypot(x - 2.03, y - 1.47) <= 0.81 + 0.25 * np.sqrt(2)
    assert not (seen & ~near & (x < 2.7)).any()


def test_info(tmp_path: Path) -> None:
    (tmp_path / "m.txt").write_text(".#.\n.#.\n##.\n")
    info = gio.maps_info(tmp_path / "m.txt")
    assert info["cells"] == [3, 3]
    assert info["size"] == [3.0, 3.0]
    assert (info["free"], info["blocked"], info["unknown"]) == pytest.approx((5 / 9, 4 / 9, 0))
    assert (info["components"], info["largest_component"]) == (2, pytest.approx(3 / 5))


def flood(free: np.ndarray) -> list[int]:
    left = {(int(i), int(j)) for i, j in zip(*np.nonzero(free), strict=True)}
    sizes = []
    while left:
        stack, size = [left.pop()], 0
        while stack:
            i, j = stack.pop()
            size += 1
            for n in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
                if n in left:
                    left.remove(n)
                    stack.append(n)
        sizes.append(size)
    return sorted(sizes)


@settings(deadline=None)
@given(arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12))))
def test_components_agree_with_flood_fill(free: np.ndarray) -> None:
    assert sorted(component_sizes(free).tolist()) == flood(free)


def test_a_winding_corridor_is_one_component() -> None:
    free = np.ones((401, 401), bool)
    free[1::2] = False
    free[1::4, -1] = True
    free[3::4, 0] = True
    assert component_sizes(free).tolist() == [int(free.sum())]


def test_importing_costs_nothing() -> None:
    script = "import sys, guideway.io; print(sorted({'numpy', 'yaml', 'PIL', 'tomllib', 'json'} & set(sys.modules)))"
    package = Path(gio.__file__).parents[1]
    alone = f"import sys, types; m = types.ModuleType('guideway'); m.__path__ = [{str(package)!r}]; sys.modules['guideway'] = m\n"
    assert subprocess.run([sys.executable, "-c", alone + script], capture_output=True, text=True, check=True).stdout.strip() == "[]"
