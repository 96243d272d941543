"""The generators of grids: the same everywhere for the same seed, solvable, and what they say they are."""

import doctest
import hashlib
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

import guideway as gw
import lattice
from guideway.cli import main
from guideway.scenes.draws import Draws

EIGHT = np.ones((3, 3))


def optimum(scene, rule):
    n, cells = lattice.read(scene.text())
    return lattice.optimum(n, cells, rule)


def whole(scene):
    """What holds of every grid: square, ends free in opposite corners, a path under the strictest rule."""
    n = len(scene.blocked)
    assert scene.blocked.shape == (n, n)
    assert scene.blocked.dtype == bool
    assert (scene.start, scene.goal) == ((0, n - 1), (n - 1, 0))
    assert not scene.blocked[n - 1, 0]
    assert not scene.blocked[0, n - 1]
    assert scene.record["blocked"] == scene.blocked.sum()
    assert scene.world.shortest(scene.start, scene.goal, "clear") is not None


def test_the_draws_are_the_published_ones():
    draws = Draws(0)
    draws._state = 1234567  # the state of the published example
    assert [draws.bits() for _ in range(3)] == [6457827717110365317, 3203168211198807973, 9817491932198370423]


def test_draws_differ_by_seed_and_stream_and_stay_in_range():
    rows = {tuple(Draws(seed, stream).below(1000) for _ in range(1)) for seed in range(20) for stream in ("", "a", "b")}
    assert len(rows) > 50
    draws = Draws(3)
    seen = [draws.between(-2, 4) for _ in range(2000)]
    assert set(seen) == set(range(-2, 5))
    items = list(range(50))
    draws.shuffle(items)
    assert sorted(items) == list(range(50)) != items


GOLDEN = {
    ("simple", 0): "226902c8b0734f7a",
    ("cluttered", 0): "c07ce350dd113fd2",
    ("crowded", 0): "7a96f1a7f0468da0",
    ("maze", 0): "8fab08fd750d5793",
    ("complexity", 0): "3fe8a0f89933d6a4",
    ("calibrated", 0): "c5699d4900c97aa9",
}


@pytest.mark.parametrize(("kind", "seed"), GOLDEN)
def test_the_same_seed_gives_the_same_grid_everywhere(kind, seed):
    scene = gw.scenes.make(kind, seed)
    assert hashlib.sha256(scene.text().encode()).hexdigest()[:16] == GOLDEN[kind, seed]
    assert scene.text() != gw.scenes.make(kind, seed + 1).text()


@pytest.mark.parametrize("kind", gw.scenes.ENVIRONMENTS)
def test_environments_are_whole(kind):
    for seed in range(30):
        whole(gw.scenes.environment(kind, seed))
    for size in (*range(12, 40), 97, 200):
        scene = gw.scenes.environment(kind, 1, size)
        whole(scene)
        assert len(scene.blocked) == size


def test_the_reachability_of_a_path_is_that_of_the_strictest_rule():
    for seed in range(10):
        scene = gw.scenes.environment("cluttered", seed, 12)
        assert optimum(scene, "clear") is not None


def parts(blocked):
    """Bounding slices of what hangs together, corners included, and whether each fills its own."""
    label, _ = ndimage.label(blocked, EIGHT)
    found = ndimage.find_objects(label)
    return [(blocked[place].shape, bool(blocked[place].all())) for place in found]


def test_simple_has_six_rectangles():
    for seed in range(30):
        found = parts(gw.scenes.environment("simple", seed).blocked)
        assert len(found) == 6
        assert all(full and 2 <= min(shape) <= max(shape) <= 5 for shape, full in found)


def test_cluttered_has_its_share():
    for size, blocked in ((30, 198), (20, 88), (12, 32)):
        assert gw.scenes.environment("cluttered", 5, size).record["blocked"] == blocked


def test_crowded_is_blocks_with_narrow_aisles():
    for size in (*range(12, 61), 200):
        blocked = gw.scenes.environment("crowded", 2, size).blocked
        found = parts(blocked)
        assert set(found) == {((2, 2), True)}
        assert len(found) == (round(0.38 * size * size) + 2) // 4
        for row in blocked[blocked.any(1)]:
            starts = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(int)))
            gaps = starts[2::2] - starts[1:-1:2]
            assert set(gaps.tolist()) <= {1, 2}


def test_a_maze_has_one_way_between_any_two_rooms():
    for size in (12, 13, 14, 30, 32, 200):
        blocked = gw.scenes.environment("maze", 4, size).blocked
        rooms = (size + 1) // 3
        assert not any(blocked[3 * y : 3 * y + 2, 3 * x : 3 * x + 2].any() for x in range(rooms) for y in range(rooms))
        doors = [blocked[3 * y : 3 * y + 2, 3 * x + 2] for x in range(rooms - 1) for y in range(rooms)]
        doors += [blocked[3 * y + 2, 3 * x : 3 * x + 2] for x in range(rooms) for y in range(rooms - 1)]
        assert all(door.all() or not door.any() for door in doors)
        assert sum(not door.any() for door in doors) == rooms * rooms - 1  # with one connected whole: a tree over the rooms
        assert ndimage.label(~blocked)[1] == 1


@pytest.mark.parametrize("size", [20, 30, 50, 70])
@pytest.mark.parametrize("density", [0.1, 0.3, 0.5, 0.7])
def test_complexity_maps_have_their_share_and_a_corridor(size, density):
    for seed in range(3):
        scene = gw.scenes.complexity(size, density, seed)
        whole(scene)
        assert scene.record["blocked"] == round(density * size * size)
        assert scene.record["corridor"] <= size * size - scene.record["blocked"]


@given(st.integers(2, 40), st.floats(0, 0.999), st.integers(0, 2**63 - 1))
def test_complexity_maps_of_any_size(size, density, seed):
    fits = int(density * size * size + 0.5) <= (size - 1) ** 2
    if not fits:
        with pytest.raises(gw.BadParameter, match="corridor"):
            gw.scenes.complexity(size, density, seed)
        return
    scene = gw.scenes.complexity(size, density, seed)
    whole(scene)
    assert abs(scene.record["blocked"] - density * size * size) <= 0.5 + 1e-9


def test_unusual_sizes():
    assert gw.scenes.complexity(2, 0.25, 0).text() in (".." + "\n" + ".#" + "\n", "#.\n..\n")
    assert gw.scenes.complexity(2, 0, 0).text() == "..\n..\n"
    whole(gw.scenes.complexity(200, 0.7, 0))
    tight = gw.scenes.complexity(9, 64 / 81, 3)  # not a cell more than the corridor
    assert tight.record["corridor"] == 17
    assert optimum(tight, "touch") is not None


def test_all_classes_are_the_same_everywhere():
    texts = "".join(gw.scenes.calibrated(kind, seed).text() for kind in gw.scenes.CLASSES for seed in range(5, 8))
    assert hashlib.sha256(texts.encode()).hexdigest()[:16] == "0acca11263829381"


@pytest.mark.parametrize("kind", gw.scenes.CLASSES)
def test_calibrated_grids_meet_every_target(kind):
    targets = gw.scenes.CLASSES[kind]
    for seed in range(3):
        scene = gw.scenes.calibrated(kind, seed)
        whole(scene)
        assert scene.record["exact"]
        assert scene.record["deviation"] == {}
        n, cells = lattice.read(scene.text())
        assert (n, len(cells)) == (targets.size, targets.blocked)
        assert targets.inner in (None, sum(x < n and y < n for x, y in cells))
        for rule in ("touch", "clear"):
            pair, turns = lattice.optimum(n, cells, rule)
            assert pair == getattr(targets, rule)[:2]
            assert getattr(targets, rule)[2] in (None, turns)
            assert scene.record[rule] == {"diagonals": pair[0], "straights": pair[1], "turns": turns}


@pytest.mark.slow
@pytest.mark.parametrize("kind", gw.scenes.CLASSES)
def test_a_hundred_calibrated_grids_of_each_class_are_exact_and_different(kind):
    texts = set()
    for seed in range(100):
        scene = gw.scenes.calibrated(kind, seed)
        assert scene.record["exact"], (seed, scene.record["deviation"])
        n, cells = lattice.read(scene.text())
        for rule in ("touch", "clear"):
            pair, turns = lattice.optimum(n, cells, rule)
            assert (pair, turns) == (getattr(gw.scenes.CLASSES[kind], rule)[:2], getattr(gw.scenes.CLASSES[kind], rule)[2] or turns)
        texts.add(scene.text())
    assert len(texts) == 100


def test_the_examples_of_the_documentation():
    assert doctest.testmod(gw.scenes) == (0, 5)


def test_what_is_missed_is_said():
    blocked = gw.scenes.load("pso-aco-1").blocked.copy()
    assert blocked[0, 1]  # of the last row
    assert blocked[2, 1]
    blocked[0, 1] = blocked[2, 1] = False
    found = gw.scenes.describe(blocked, gw.scenes.CLASSES["pso-aco-1"])
    assert not found["exact"]
    assert found["deviation"] == {"blocked": -2, "inner": -1}
    blocked[:] = True
    blocked[-1, 0] = blocked[0, -1] = False
    found = gw.scenes.describe(blocked, gw.scenes.CLASSES["pso-aco-1"])
    assert found["touch"] is None
    assert found["deviation"]["touch turns"] is None


def test_packaged_grids():
    assert gw.scenes.names() == [*gw.scenes.CLASSES, "w0", "w1"]
    for name in gw.scenes.CLASSES:
        scene = gw.scenes.load(name)
        whole(scene)
        assert scene.record["exact"]
        assert scene.query().goal == [len(scene.blocked) - 0.5] * 2
    with pytest.raises(gw.BadParameter, match="pso-aco-2"):
        gw.scenes.load("pso-aco-3")


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda s: s.environment("jungle", 0), "simple, cluttered, crowded, maze"),
        (lambda s: s.environment("maze", 0, 11), "12 to 500"),
        (lambda s: s.environment("maze", -1), "seed -1"),
        (lambda s: s.environment("maze", True), "seed True"),
        (lambda s: s.environment("maze", 0, 30.0), "whole number"),
        (lambda s: s.complexity(1, 0.0, 0), "2 to 1000"),
        (lambda s: s.complexity(20, 1.0, 0), "below 1"),
        (lambda s: s.complexity(20, float("nan"), 0), "below 1"),
        (lambda s: s.complexity(20, -0.1, 0), "below 1"),
        (lambda s: s.complexity(2, 0.5, 0), "at most 0.25"),
        (lambda s: s.calibrated("m40", 0), "m30"),
        (lambda s: s.calibrated("m20", 1 << 63), "seed"),
        (lambda s: s.make("forest"), "calibrated, simple"),
        (lambda s: s.make("layout", size=20), "size 20 is not an option of layout"),
        (lambda s: s.layout(-1), "seed -1"),
        (lambda s: s.room("w2"), "w0, w1"),
        (lambda s: s.load("w0").query("moving"), "none, static, dynamic"),
        (lambda s: s.load("m20", 3), "nothing in it is random"),
        (lambda s: s.make("maze", density=0.3), "density 0.3 is not an option of maze"),
        (lambda s: s.make("calibrated", size=20), "size 20 is not an option of calibrated"),
    ],
)
def test_bad_arguments(call, word):
    with pytest.raises(gw.BadParameter, match=word):
        call(gw.scenes)


def test_maps_make(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for target in ("a.txt", "a.map", "a.yaml", "b.toml"):
        assert main(["maps", "make", "cluttered", "--seed", "3", "--size", "15", target]) == 0
    text = gw.scenes.environment("cluttered", 3, 15).text()
    assert (tmp_path / "a.txt").read_text() == (tmp_path / "b.txt").read_text() == text
    for target in ("a.txt", "a.map", "a.yaml", "b.toml"):
        world = gw.World.load(target)
        assert (world.occupancy() > 0).tolist() == [[c == "#" for c in row] for row in text.split()]
    assert main(["plan", "b.toml", "--planner", "jump-point"]) == 0
    capsys.readouterr()
    assert main(["maps", "make", "complexity", "--size", "20", "--density", "0.7", "c.toml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["blocked"] == 280
    assert main(["maps", "make", "calibrated", "--class", "2", "d.txt"]) == 0
    assert main(["maps", "make", "--list"]) == 0
    listed = capsys.readouterr().out
    assert all(kind in listed for kind in gw.scenes.KINDS)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["maze"], "DST"),
        (["jungle", "a.txt"], "'jungle' is not known"),
        (["maze", "a.jpg"], ".yaml, .map, .txt or .toml"),
        (["maze", "nowhere/a.txt"], "does not exist"),
        (["maze", "a.txt", "--size", "3"], "12 to 500"),
        (["maze", "a.txt", "--seed", "-1"], "seed"),
        (["complexity", "a.txt", "--density", "nan"], "density"),
        (["calibrated", "a.txt", "--class", "3"], "pso-aco-1"),
    ],
)
def test_maps_make_refuses(words, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["maps", "make", *words]) == 2
    message = " ".join(capsys.readouterr().err.split())
    assert said in message
    assert "Traceback" not in message
    assert not list(tmp_path.iterdir())


def test_a_packaged_scene_becomes_files_that_stand_on_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("m20", "warehouse"):
        assert main(["maps", "convert", f"scene:{name}", f"{name}.toml"]) == 0
        text = (tmp_path / f"{name}.toml").read_text()
        assert f'map = "{name}.' in text
        ours, theirs = gw.World.load(f"scene:{name}"), gw.World.load(f"{name}.toml")
        assert (ours.occupancy() == theirs.occupancy()).all()
        assert ours.origin == theirs.origin
        assert ours.resolution == theirs.resolution
        assert ours.movers == theirs.movers
