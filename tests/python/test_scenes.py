"""Every number that is known about the scenes that ship with the package, found again by searches that share no code with it."""

import itertools
import json
import math
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BSpline

import guideway as gw
import lattice
from guideway.cli import main

ROOT2 = math.sqrt(2)
FACTS = {
    # blocked, blocked without the last row and column, touch and clear: (diagonals, straights), turns; any angle over cell centres; energies
    "pso-aco-1": (20, 133, 120, ((16, 6), 3), ((15, 8), 7), 27.3808, (30.1274, 32.7132)),
    "pso-aco-2": (20, 207, 187, ((14, 10), 6), ((10, 18), 13), 28.2293, (32.7990, 38.6421)),
    "m20": (20, 100, None, ((18, 2), 2), ((17, 4), None), 26.9325, None),
    "m30": (30, 225, None, ((28, 2), 3), ((25, 8), None), 41.0714, None),
}
LENGTHS = {"pso-aco-1": ("28.6274", "29.2132"), "pso-aco-2": ("29.7990", "32.1421"), "m20": ("27.4558", None), "m30": ("41.5980", None)}


def text_of(name):
    return (files("guideway") / "data" / "scenes" / f"{name}.txt").read_text()


@pytest.fixture(params=FACTS)
def name(request):
    return request.param


def test_blocked_cells(name):
    side, blocked, inner, *_ = FACTS[name]
    n, cells = lattice.read(text_of(name))
    assert (n, len(cells)) == (side, blocked)
    assert (1, 1) not in cells
    assert (n, n) not in cells
    if inner is None:
        assert 4 * blocked == n * n  # 25 %
    else:
        assert sum(x < n and y < n for x, y in cells) == inner


def test_lattice_optima_turns_and_energies(name):
    n, cells = lattice.read(text_of(name))
    energies = FACTS[name][6] or (None, None)
    for rule, (pair, turns), energy, printed in zip(("touch", "clear"), FACTS[name][3:5], energies, LENGTHS[name], strict=True):
        found, least = lattice.optimum(n, cells, rule)
        assert found == pair
        assert turns is None or least == turns
        assert printed is None or f"{lattice.length(found):.4f}" == printed
        assert energy is None or f"{lattice.length(found) + 0.5 * least:.4f}" == f"{energy:.4f}"


def test_any_angle_optimum_over_cell_centres(name):
    n, cells = lattice.read(text_of(name))
    found = lattice.any_angle(cells, lattice.centres(n, cells), (2, 2), (2 * n, 2 * n))
    assert f"{found:.4f}" == f"{FACTS[name][5]:.4f}"


@pytest.mark.parametrize(("name", "every", "turns", "few"), [("pso-aco-1", 4880, 3, 5), ("pso-aco-2", 3672, 6, 6)])
def test_how_many_shortest_paths_there_are(name, every, turns, few):
    n, cells = lattice.read(text_of(name))
    found = lattice.counts(n, cells, "touch")
    assert sum(found.values()) == every
    assert min(found) == turns
    assert found[turns] == few


def test_the_counting_by_hand():
    assert lattice.counts(3, {(2, 2)}, "touch") == {2: 2}  # two ways around; a touched corner each
    assert lattice.counts(3, {(2, 2)}, "clear") == {1: 2}
    assert lattice.counts(2, set(), "touch") == {0: 1}
    assert lattice.optimum(2, {(1, 2), (2, 1)}, "touch") is None


def headings(path):
    return [(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise(path)]


def test_the_optimum_of_scene_1_that_is_written_out():
    n, cells = lattice.read(text_of("pso-aco-1"))
    path = [(1, y) for y in range(1, 4)] + [(x, x + 3) for x in range(1, 17)] + [(17, 19), (18, 19), (19, 19), (20, 20)]
    for a, b in itertools.pairwise(path):
        assert b in {to: way for way, to in lattice.moves(n, cells, a, "touch")}
    steps = headings(path)
    assert (sum(abs(x * y) for x, y in steps), sum(1 - abs(x * y) for x, y in steps)) == (16, 6)
    assert sum(a != b for a, b in itertools.pairwise(steps)) == 3


def fewest_turns(name):
    """All shortest paths with the fewest turns, touch."""
    n, cells = lattice.read(text_of(name))
    ahead = lattice.distances(n, cells, "touch", (n, n))
    least, found, stack = FACTS[name][3][1], [], [([(1, 1)], None, 0)]
    while stack:
        path, heading, turns = stack.pop()
        if path[-1] == (n, n):
            found.append(path)
        for way, to in lattice.moves(n, cells, path[-1], "touch"):
            step = (ahead[to][0] + way % 2, ahead[to][1] + 1 - way % 2)
            more = turns + (heading is not None and way != heading)
            if more <= least and abs(lattice.length(step) - lattice.length(ahead[path[-1]])) < 1e-9:
                stack.append(([*path, to], way, more))
    return found


def spline_length(path):
    """Length of the clamped uniform cubic B-spline over all cells of a path."""
    knots = np.concatenate([np.zeros(3), np.arange(len(path) - 2), np.full(3, len(path) - 3)])
    curve = BSpline(knots, np.array(path, float), 3)
    spots = np.linspace(0, len(path) - 3, 200_001)
    return float(np.linalg.norm(np.diff(curve(spots), axis=0), axis=1).sum())


@pytest.mark.parametrize(("name", "length"), [("pso-aco-1", 28.362), ("pso-aco-2", 29.286)])
def test_a_spline_over_an_optimum_is_shorter_than_it(name, length):
    lengths = [spline_length(path) for path in fewest_turns(name)]
    assert len(lengths) == {"pso-aco-1": 5, "pso-aco-2": 6}[name]
    assert f"{length:.3f}" in {f"{found:.3f}" for found in lengths}


def test_what_the_published_numbers_say():
    for printed, diagonals, straights in (("28.6240", 16, 6), ("29.7960", 14, 10), ("31.2100", 15, 10), ("31.5540", 11, 16)):
        assert f"{1.414 * diagonals + straights:.4f}" == printed  # 1.414 for the root of two
    for printed, diagonals, straights in (("29.7990", 14, 10), ("30.3848", 13, 12), ("29.2132", 15, 8), ("32.1421", 10, 18)):
        assert f"{ROOT2 * diagonals + straights:.4f}" == printed
    assert f"{18 * ROOT2 + 3:.2f}" == "28.46"
    assert f"{18 * ROOT2 + 2:.2f}" == "27.46"
    assert f"{19 * ROOT2:.3f}" == "26.870"
    assert f"{29 * ROOT2:.3f}" == "41.012"
    assert f"{28 * ROOT2 + 2:.3f}" == "41.598"


def documented():
    """The first table of docs/scenes.md: a row of words for each scene, by the name of the row."""
    text = (Path(__file__).resolve().parents[2] / "docs" / "scenes.md").read_text(encoding="utf-8")
    lines = ("|" + text.partition("\n|")[2].partition("\n\n")[0]).splitlines()
    rows = [[word.strip() for word in line.split("|")[1:-1]] for line in lines if line.startswith("|") and not line.startswith("|---")]
    return {row[0]: dict(zip((word.strip("`") for word in rows[0][1:]), row[1:], strict=True)) for row in rows[1:]}


def test_the_documented_table(name):
    n, cells = lattice.read(text_of(name))
    optima = {rule: lattice.optimum(n, cells, rule) for rule in ("touch", "clear")}
    paths = lattice.counts(n, cells, "touch")
    said = {row: words[name] for row, words in documented().items()}
    found = {"cells": f"{n} x {n}", "blocked": str(len(cells))}
    found["of them in the lower left 19 x 19"] = str(sum(x < n and y < n for x, y in cells)) if FACTS[name][2] else ""
    for rule, ((diagonals, straights), turns) in optima.items():
        found[f"`{rule}`: diagonals + straights, turns"] = f"{diagonals} + {straights}, {turns}"
        found[f"`{rule}`: length"] = f"{lattice.length((diagonals, straights)):.4f}"
    found["shortest paths, of them with fewest turns"] = f"{sum(paths.values())}, {paths[optima['touch'][1]]}"
    found["any angle, between cell centres"] = f"{FACTS[name][5]:.4f}"  # found again above
    found["any angle, exact"] = f"{lattice.any_angle(cells, lattice.corners(n, cells), (2, 2), (2 * n, 2 * n)):.4f}"
    energies = [f"{lattice.length(pair) + turns / 2:.4f}" for pair, turns in optima.values()]
    found["energy, length + turns / 2: `touch`, `clear`"] = ", ".join(energies)
    assert found == said


def test_the_published_coverages_are_those_of_19_x_19_cells():
    def shares(cells):
        return {f"{100 * blocked / cells:.2f}" for blocked in range(cells + 1)}

    assert [cells for cells in range(200, 501) if {"33.24", "51.80"} <= shares(cells)] == [361]
    assert f"{100 * 120 / 361:.2f}" == "33.24"
    assert f"{100 * 187 / 361:.2f}" == "51.80"
    assert f"{100 * 133 / 400:.2f}" == "33.25"
    assert f"{100 * 207 / 400:.2f}" == "51.75"


def test_the_package_agrees(name):
    n, cells = lattice.read(text_of(name))
    world = gw.World.load(f"scene:{name}")
    for rule in ("touch", "clear"):
        found = world.shortest((0, n - 1), (n - 1, 0), rule)
        assert found is not None
        pair, turns = lattice.optimum(n, cells, rule)
        assert found[0] == pytest.approx(lattice.length(pair), abs=1e-9)
        exact = gw.lattice_optimum(world, (0, n - 1), (n - 1, 0), rule)
        assert exact is not None
        assert ((exact["diagonals"], exact["straights"]), exact["turns"]) == (pair, turns)
    best = gw.plan(gw.Query(world, (0.5, 0.5), (n - 0.5, n - 0.5)), planner="visibility", seed=0).cost
    assert best == pytest.approx(lattice.any_angle(cells, lattice.corners(n, cells), (2, 2), (2 * n, 2 * n)), abs=1e-9)
    assert best <= FACTS[name][5]


def test_a_scene_is_planned_driven_and_shown_by_its_name(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["plan", "scene:pso-aco-1", "--planner", "jump-point", "--out", "plan.json"]) == 0
    plan = json.loads((tmp_path / "plan.json").read_text())
    assert plan["world"]["source"] == "scene:pso-aco-1"
    assert plan["query"]["start"] == [0.5, 0.5]
    assert plan["query"]["goal"] == [19.5, 19.5]
    assert plan["search"]["raw_length"] == pytest.approx(16 * ROOT2 + 6)
    assert main(["drive", "plan.json", "--out", "run.json"]) == 0
    assert main(["view", "plan.json", "run.json", "--out", "both.html"]) == 0
    assert main(["maps", "info", "scene:m30"]) == 0
    assert main(["plan", "scene:m20", "--start-cell", "0,0", "--json"]) == 0
    capsys.readouterr()


def test_another_scene_under_the_same_name_is_noticed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["plan", "scene:m20", "--out", "plan.json"]) == 0
    text = (tmp_path / "plan.json").read_text()
    (tmp_path / "plan.json").write_text(text.replace("scene:m20", "scene:m30"))
    assert main(["drive", "plan.json"]) == 2
    assert "sha256" in capsys.readouterr().err


@pytest.mark.parametrize("word", ["scene:m31", "scene:", "scene:../m20", "scene:m20.txt", "scene:M20"])
def test_names_that_are_not_known(word, capsys):
    assert main(["plan", word]) == 2
    message = capsys.readouterr().err
    assert "scene:pso-aco-2" in message
    assert "Traceback" not in message


def test_every_packaged_scene_is_a_whole_scene():
    from guideway.io import load
    from guideway.io.packaged import FILES

    for known in FILES:
        scene = load(f"scene:{known}")
        assert str(scene.source) == f"scene:{known}"
        assert scene.query is not None
        assert scene.query.start is not None
        assert scene.query.goal is not None
