"""Public maps and scenes: a few small ones that are part of the repository, all of them where the full set is at hand."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import guideway.io as gio

SMALL = Path(__file__).parents[1] / "data"


def test_arena_and_its_scenario() -> None:
    grid = gio.load_map(SMALL / "arena.map.gz")
    assert (grid.width, grid.height, int(grid.blocked.sum())) == (49, 49, 347)
    assert gio.maps_info(SMALL / "arena.map.gz")["components"] == 1
    rows = gio.load_scenario(SMALL / "arena.map.scen.gz")
    assert len(rows) == 160
    assert (rows[0].start, rows[0].goal, rows[0].length) == ((1, 11), (1, 12), 1.0)
    assert not any(grid.blocked[row.start[1], row.start[0]] or grid.blocked[row.goal[1], row.goal[0]] for row in rows)


@pytest.mark.parametrize(("name", "size", "unknown"), [("turtlebot3/map", (384, 384), 138722), ("depot/depot", (604, 307), 0)])
def test_map_server_maps_with_packed_images(name: str, size: tuple[int, int], unknown: int) -> None:
    grid = gio.load_map(SMALL / f"{name}.yaml")
    assert ((grid.width, grid.height), grid.resolution) == (size, 0.05)
    assert (0 if grid.unknown is None else int(grid.unknown.sum())) == unknown
    free = gio.load_map(SMALL / f"{name}.yaml", unknown="free")
    assert int(grid.blocked.sum()) - int(free.blocked.sum()) == unknown


def test_a_dynabarn_world() -> None:
    scene = gio.load_collection(f"{SMALL}/dynabarn_worlds.json#3")
    assert len(scene.movers) == 8
    assert scene.source == SMALL / "dynabarn_worlds.json#3"
    assert scene.query is not None
    assert (scene.query.start, scene.query.start_yaw, scene.query.goal) == ((11.0, 0.0), 3.14, (-9.0, 0.0))
    # the back wall is 0.5 m deep around x = -10, with sides of 20 m
    assert np.array(scene.shapes[0].points).min(0).tolist() == [-10.25, -10.0]  # type: ignore[union-attr]
    assert {len(m.track) > 2 and m.track[0][0] == 0 for m in scene.movers} == {True}
    assert set(scene.files) == {"dynabarn_worlds.json", "dynabarn_traj.json"}
    # the fastest leg of all motions of the collection
    assert scene.mover_speed is not None
    legs = [(a, b) for m in scene.movers for a, b in pairwise(m.track)]
    assert max(math.dist(a[1:], b[1:]) / (b[0] - a[0]) for a, b in legs) <= scene.mover_speed < 2.0


def test_a_barn_world() -> None:
    scene = gio.load(f"{SMALL}/barn_worlds.json.gz#7")
    assert isinstance(scene, gio.Scene)
    assert {type(shape).__name__ for shape in scene.shapes} == {"Disc"}
    assert len(scene.shapes) == 207
    assert scene.robot.footprint.to_dict() == {"box": [0.42, 0.33]}
    limits = scene.robot.limits()
    assert [limits[k] for k in ("speed", "acceleration", "deceleration", "turn_rate", "turn_acceleration")] == [2, 2, 2, 2, 4]
    assert scene.lidar == gio.Lidar(720, pytest.approx(1.5 * np.pi), 10.0, 0.01, 40.0)  # type: ignore[arg-type]
    assert scene.query is not None
    assert (scene.query.start, scene.query.start_yaw, scene.query.goal) == ((-2.25, 3.0), 1.57, (-2.25, 13.0))
    assert (scene.query.arrival, scene.query.time_limit) == (1.0, 100.0)


def test_every_world_of_the_collections_converts(data: Path, tmp_path: Path) -> None:
    for number in range(1, 300, 26):
        scene = gio.load_collection(f"{data}/barn/barn_worlds.json.gz#{number}")
        gio.write_map(scene, tmp_path / "b.toml")
        assert gio.load_scene(tmp_path / "b.toml").shapes == scene.shapes
    for number in range(1, 60, 2):
        scene = gio.load_collection(f"{data}/dynabarn/dynabarn_worlds.json#{number}")
        assert len(scene.shapes) == 3
        assert 5 <= len(scene.movers) <= 24
        assert {m.loop for m in scene.movers} == {"cycle"}
        assert scene.mover_speed == pytest.approx(1.947, abs=1e-3)
        gio.write_map(scene, tmp_path / "d.toml")
        again = gio.load_scene(tmp_path / "d.toml")
        assert (again.movers, again.query, again.robot, again.lidar) == (scene.movers, scene.query, scene.robot, scene.lidar)
        assert again.mover_speed == scene.mover_speed


def test_public_maps_load(data: Path) -> None:
    maps = [p for pattern in ("ros_maps/**/*.yaml", "moving_ai/maps/**/*.gz") for p in sorted(data.glob(pattern))]
    assert len(maps) >= 20
    for path in maps:
        for thresholds in ("inclusive", "strict"):
            grid = gio.load_map(path, thresholds=thresholds)
            assert grid.blocked.shape == (grid.height, grid.width)
            assert 0 < grid.blocked.sum() < grid.blocked.size or "speed" in path.name
    for path in sorted(data.glob("moving_ai/scen/**/*.gz")):
        grid = gio.load_map(path.parents[2] / "maps" / path.parent.name / path.name.replace(".scen", ""))
        for row in gio.load_scenario(path):
            assert (row.width, row.height) == (grid.width, grid.height)
            assert not grid.blocked[row.start[1], row.start[0]]
            assert not grid.blocked[row.goal[1], row.goal[0]]
