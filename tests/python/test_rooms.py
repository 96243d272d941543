"""The rooms and the random layouts: what is known about them, found again by an oracle of its own."""

import itertools
import json
import math

import numpy as np
import pytest

import guideway as gw
import tangents
from guideway.cli import main

SHORTEST = {"w0": 6.198, "w1": 15.305}


@pytest.mark.parametrize("name", SHORTEST)
def test_shortest_paths(name):
    room = gw.scenes.load(name)
    query = room.query()
    length = tangents.shortest(tuple(query.start), tuple(query.goal), room.discs, 0.3, room.scene.bounds)
    assert length == pytest.approx(SHORTEST[name], abs=0.005)
    assert room.record["shortest"] == pytest.approx(length, abs=1e-9)
    assert room.query("none").limits == query.limits
    assert gw.plan(room.query("none")).cost == pytest.approx(room.record["straight"])


def test_shortest_paths_of_random_layouts():
    exact = 0
    for seed in range(20):
        room = gw.scenes.layout(seed)
        found, ends = room.record["shortest"], ((0, 0), (5, 3))
        low, high = tangents.shortest(*ends, room.discs, 0.3), tangents.shortest(*ends, room.discs, 0.3, (0, 0, 10, 6))
        assert low - 1e-9 <= found <= (math.inf if high is None else high) + 1e-9
        exact += high is not None and high - low < 1e-9
    assert exact >= 15


def test_random_layouts():
    seen = set()
    for seed in range(100):
        discs = gw.scenes.layout(seed).discs
        seen.add(str(discs))
        assert len(discs) == 8
        assert all(0.25 <= r <= 0.6 and 0 <= x <= 10 and 0 <= y <= 6 for x, y, r in discs)
        assert all(math.dist(a[:2], b[:2]) >= a[2] + b[2] + 0.9 for a, b in itertools.combinations(discs, 2))
        assert all(math.dist(d[:2], end) >= d[2] + 0.5 for d in discs for end in ((0, 0), (5, 3)))
        assert gw.scenes.layout(seed).discs == discs
    assert len(seen) == 100


@pytest.mark.parametrize("name", SHORTEST)
def test_moving_obstacles(name):
    room = gw.scenes.load(name)
    assert room.scene.movers == gw.scenes.load(name, 0).scene.movers  # the file holds what seed 0 draws
    assert room.scene.movers == gw.scenes.MOVERS[name](room.scene, 0)
    tops, count = {"w0": (0.4, 0.4, 0.6, 0.3), "w1": (0.8,) * 5}[name], {"w0": 4, "w1": 5}[name]
    for seed in range(30):
        movers = gw.scenes.load(name, seed).scene.movers
        assert len(movers) == count
        assert seed == 0 or movers != gw.scenes.load(name, seed - 1).scene.movers
        for mover, top in zip(movers, tops, strict=True):
            times, places = np.array(mover.track)[:, 0], np.array(mover.track)[:, 1:]
            speeds = np.hypot(*np.diff(places, axis=0).T) / np.diff(times)
            assert speeds == pytest.approx(np.full(len(speeds), mover.speed))
            assert mover.speed <= top
            period = times[-1] * (2 if mover.loop == "shuttle" else 1)
            assert 0 <= mover.phase < period
            if mover.loop == "cycle":
                assert tuple(places[0]) == tuple(places[-1])


def test_conditions():
    room = gw.scenes.load("w0", 7)
    count = {name: (len(room.world(name).shapes), len(room.world(name).movers)) for name in gw.scenes.CONDITIONS}
    assert count == {"none": (0, 0), "static": (8, 0), "dynamic": (8, 4)}
    assert room.world().source is None  # not what the file has
    assert gw.scenes.load("w0").world().source == "scene:w0"


def test_limits():
    query = gw.scenes.load("w1").query()
    assert query.limits == gw.scenes.NOMINAL.to_dict()
    assert query.clearance == query.radius == 0.3
    other = gw.scenes.load("w1").query(limits=gw.scenes.ASYMMETRIC).limits
    assert {key: (value, other[key]) for key, value in query.limits.items() if value != other[key]} == {
        "acceleration": (5.0, 2.0),
        "deceleration": (5.0, 3.0),
    }


def test_on_the_command_line(tmp_path, capsys):
    out = tmp_path / "plan.json"
    assert main(["plan", "scene:w0", "--out", str(out)]) == 0
    record = json.loads(out.read_text())
    assert record["query"]["clearance"] == 0.3
    assert record["trajectory"]["limits"] == gw.scenes.NOMINAL.to_dict()
    assert main(["plan", "scene:w1", "--acceleration", "2", "--deceleration", "3", "--out", str(out)]) == 0
    assert json.loads(out.read_text())["trajectory"]["limits"]["deceleration"] == 3
    made = tmp_path / "layout.toml"
    assert main(["maps", "make", "layout", "--seed", "3", str(made)]) == 0
    capsys.readouterr()
    found = gw.World.load(made)
    assert [(*s["disc"]["center"], s["disc"]["radius"]) for s in found.shapes] == gw.scenes.layout(3).discs
    assert main(["plan", str(made), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["search"]["raw_length"] == pytest.approx(gw.scenes.layout(3).record["shortest"])


def test_written_and_read_again(tmp_path):
    room = gw.scenes.load("w1", 5)
    room.write(tmp_path / "w1.toml")
    again = gw.io.load(tmp_path / "w1.toml")
    assert (again.shapes, again.movers, again.query, again.robot) == (room.scene.shapes, room.scene.movers, room.scene.query, room.scene.robot)
