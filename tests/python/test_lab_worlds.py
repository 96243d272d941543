"""Worlds by what an experiment says of them."""

from __future__ import annotations

import numpy as np
import pytest

import guideway as gw
from guideway.lab import worlds


def test_scene_of_the_package() -> None:
    spec = {"name": "scene 1", "source": "scene:pso-aco-1"}
    query = worlds.query(spec, {"name": "long", "material": "long"})
    assert (query.start, query.goal, query.corners) == ([0.5, 0.5], [19.5, 19.5], "clear")
    assert (worlds.make(spec).occupancy() == gw.scenes.load("pso-aco-1").world.occupancy()).all()


@pytest.mark.parametrize(
    ("spec", "scene"),
    [
        ({"make": "calibrated", "scene_class": "m20", "seed": 3}, lambda: gw.scenes.calibrated("m20", 3)),
        ({"make": "environment", "kind": "maze", "seed": 2, "size": 20}, lambda: gw.scenes.environment("maze", 2, 20)),
        ({"make": "complexity", "size": 20, "density": 0.3, "seed": 1}, lambda: gw.scenes.complexity(20, 0.3, 1)),
    ],
)
def test_grids_are_those_of_the_generator(spec, scene) -> None:
    assert (worlds.make({"name": "w", **spec}).occupancy() == scene().world.occupancy()).all()


def test_rooms_have_their_robot_and_conditions() -> None:
    spec = {"name": "w0", "make": "room", "room": "w0", "resolution": 0.1}
    query = worlds.query(spec, {"condition": "static", "limits": {"speed": 1.5}})
    assert (query.world.resolution, len(query.world.shapes), len(query.world.movers)) == (0.1, 8, 0)
    assert (query.clearance, query.limits["speed"], query.limits["jerk"]) == (0.3, 1.5, 10.0)
    assert len(worlds.query(spec, {"condition": "dynamic"}).world.movers) == 4


def test_a_world_may_have_a_query_of_its_own() -> None:
    spec = {"name": "w0", "source": "scene:w0", "query": {"condition": "static", "limits": {"jerk": 2.0}, "footprint": {"disc": 0.2}}}
    query = worlds.query(spec)
    assert (len(query.world.movers), query.limits["jerk"], query.limits["speed"], query.footprint) == (0, 2.0, 2.0, {"disc": 0.2})
    assert worlds.query(spec, {"limits": {"speed": 1.0}}).limits["jerk"] == 2.0
    with pytest.raises(gw.BadParameter, match=r"world 'w0': query.speed is not known"):
        worlds.place({**spec, "query": {"speed": 1}})


def test_seed_of_the_run_draws_the_world() -> None:
    spec = {"name": "layout", "make": "layout", "seed": "run"}
    one, other = worlds.make(spec, seed=1), worlds.make(spec, seed=2)
    assert one.shapes != other.shapes
    assert one.shapes == worlds.make({"name": "layout", "make": "layout", "seed": 1}).shapes
    assert worlds.make(spec, seed=1) is one  # kept


def test_files_are_relative_to_the_experiment(tmp_path) -> None:
    (tmp_path / "maps").mkdir()
    gw.scenes.load("m20").write(tmp_path / "maps" / "m.toml")
    query = worlds.query({"name": "m", "source": "maps/m.toml"}, None, tmp_path)
    assert query.start == [0.5, 0.5]
    bare = gw.scenes.load("m20").write(tmp_path / "m.txt")[0]
    with pytest.raises(gw.BadParameter, match=r"query '' in world 'bare': no start is given"):
        worlds.query({"name": "bare", "source": bare.name}, None, tmp_path)
    asked = worlds.query({"name": "bare", "source": bare.name}, {"start_cell": [0, 19], "goal_cell": [19, 0]}, tmp_path)
    assert np.allclose(asked.goal, [19.5, 19.5])
    assert worlds.query({"name": "bare", "source": bare.name, "query": {"start": [0.5, 0.5], "goal": [3.5, 0.5]}}, None, tmp_path).goal == [3.5, 0.5]


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ({}, "source or make must say what it is"),
        ({"source": "scene:m20", "make": "layout"}, "source or make must say what it is"),
        ({"make": "labyrinth"}, "make 'labyrinth' is not known: one of calibrated"),
        ({"make": "complexity", "size": 20, "density": 0.3}, "seed is missing"),
        ({"make": "complexity", "size": 20, "density": "much", "seed": 0}, "density 'much' is not a number"),
        ({"make": "complexity", "size": 20, "density": 1.5, "seed": 0}, "density 1.5 is out of range"),
        ({"make": "complexity", "size": 20.5, "density": 0.1, "seed": 0}, "size 20.5 is not a whole number"),
        ({"make": "layout", "seed": 0, "size": 20}, "'size' is not known"),
        ({"source": "scene:atlantis"}, "source 'scene:atlantis'"),
        ({"source": "nowhere.map"}, "source 'nowhere.map'"),
        ({"source": "scene:m20", "resolution": 0.5}, "resolution 0.5 is for worlds without a grid"),
        ({"source": "scene:w0", "resolution": -1}, "resolution -1 is not a length"),
    ],
)
def test_errors_name_world_and_field(spec, words, tmp_path) -> None:
    with pytest.raises(gw.BadParameter, match="world 'w'") as caught:
        worlds.place({"name": "w", **spec}, tmp_path)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"speed": 1}, "'speed' is not known"),
        ({"material": "gas"}, "material"),
        ({"condition": "static"}, "is for rooms"),
        ({"start_cell": [0, 99]}, "start_cell [0, 99] is no cell"),
        ({"limits": {"sped": 1}}, "limits.sped is not known"),
        ({"clearance": "wide"}, "clearance"),
    ],
)
def test_errors_name_query_and_field(asked, words) -> None:
    with pytest.raises(gw.BadParameter, match="query 'q' in world 'w'") as caught:
        worlds.query({"name": "w", "source": "scene:m20"}, {"name": "q", **asked})
    assert words in str(caught.value)
