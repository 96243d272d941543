"""The improved ant colony on the command line and from Python."""

import json
import math

import pytest

import guideway as gw
from guideway.cli import main

OPTIMUM = 18 * math.sqrt(2) + 2


def test_the_settings_of_the_source_on_the_command_line(capsys):
    words = ["plan", "scene:m20", "--planner", "improved-aco", "--seed", "3", "--set", "preset=paper", "--set", "iterations=20", "--json"]
    assert main(words) == 0
    first = json.loads(capsys.readouterr().out)
    assert main([*words, "--threads", "2"]) == 0
    second = json.loads(capsys.readouterr().out)
    assert (first["planner"], first["parameters"]["preset"], first["parameters"]["loop_cutting"]) == ("improved-aco", "paper", False)
    assert first["path"] == second["path"]


def test_a_switch_and_a_range_are_parameters():
    paper = gw.parameters("improved-aco", {"preset": "paper"})
    assert all(paper[f"o{k}"] for k in range(1, 7))
    assert (paper["alpha_range"], paper["beta_range"], paper["seeding"], paper["loop_cutting"]) == ([1.2, 3.8], [2.5, 5.2], "off", False)
    with pytest.raises(gw.errors.BadParameter):
        gw.plan(gw.scenes.load("m20").query(), planner="improved-aco", set={"conversion": "never"})


def test_smoothing_with_the_curvature_limit_of_the_source():
    for name in ("m20", "m30"):
        query = gw.scenes.load(name).query()
        solution = gw.plan(query, planner="improved-aco", seed=1)
        straight = gw.plan(query).cost
        refined = gw.refine(solution.path, query, max_curvature=0.28)
        assert refined.path.length <= 1.015 * straight
        curvature = gw.measure(refined.path, query)["max_curvature"]
        assert refined.unmet or curvature <= 0.28 * (1 + 1e-6)
