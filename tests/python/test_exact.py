"""Exact lattice references from Python."""

import math

import pytest

import guideway as gw


@pytest.fixture(scope="module")
def scene():
    return gw.World.load("scene:pso-aco-1")


def best(scene, **words):
    found = gw.lattice_optimum(scene, (0, 19), (19, 0), **words)
    assert found is not None
    return found


def counts(found):
    return found["diagonals"], found["straights"], found["turns"]


def test_the_fewest_turns_of_the_shortest_paths(scene):
    found = best(scene)
    assert counts(found) == (16, 6, 3)
    assert found["length"] == pytest.approx(16 * math.sqrt(2) + 6)
    assert (found["cells"][0], found["cells"][-1]) == ((0, 19), (19, 0))
    assert counts(best(scene, corners="clear")) == (15, 8, 7)


def test_the_least_energy_trades_length_for_turns(scene):
    found = best(scene, aim="energy")
    assert found["energy"] == pytest.approx(found["length"] + 0.5 * found["turns"])
    assert found["energy"] <= 16 * math.sqrt(2) + 6 + 1.5 + 1e-12


def test_no_path_and_bad_words(scene):
    assert gw.lattice_optimum(scene, (1, 0), (19, 0)) is None
    assert gw.lattice_optimum(scene, (0, 99), (19, 0)) is None
    assert gw.lattice_optimum(scene, (0, 19), (19, 0), radius=5.0) is None
    for words in ({"corners": "round"}, {"aim": "speed"}, {"radius": -1.0}):
        with pytest.raises(gw.BadParameter):
            gw.lattice_optimum(scene, (0, 19), (19, 0), **words)


def test_the_exact_planner_follows_the_material(scene):
    def plan(material):
        query = gw.Query(scene, (0.5, 0.5), (19.5, 19.5), corners="touch", material=material)
        return gw.plan(query, "lexicographic")

    assert plan("standard").cost == pytest.approx(16 * math.sqrt(2) + 6)
    assert plan("heavy").cost == pytest.approx(best(scene, aim="energy")["length"])
