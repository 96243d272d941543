"""Continuous planners in the report: bounded traces, layers and tables that the page has."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
from PIL import Image

import guideway as gw
from guideway import jobs, schemas
from guideway.traces import MOST_CURVES, MOST_EDGES, MOST_GENERATIONS, MOST_POINTS, trace_record
from guideway.view import search_figure
from guideway.view.report import page

REGION = {"from": 1.0, "to": 1.6, "worst": 1.3, "ratio": 1.2, "excess": 0.05}


def trace(points: int) -> dict[str, Any]:
    line = [[0.1 * i, 0.2 * i] for i in range(points)]
    return {
        "objective": {"value": 0.38, "length": 6.2, "time": 4.0, "turning": 6.0, "clearance": 0.3, "overspeed": 0.0, "form": "repaired"},
        "population": [{"generation": 10 * g, "paths": [line] * 60} for g in range(30)],
        "classes": [{"path": line, "length": 6.2, "signature": "+1", "best": 0.38, "chosen": True}],
        "loop": [{"stage": 1, "value": 0.38, "found": [REGION], "corrected": 1, "nodes": 2, "remaining": [], "fed_back": ["box around point 2"]}],
        "speed": {"ceiling": line, "before": line, "after": line, "regions_before": [REGION], "regions_after": []},
        "bound": {"lower": 0.35, "value": 0.38, "gap": 0.38 / 0.35 - 1},
        "tree": [[0.0, 0.0, 1.0, 0.123456789]] * (2 * MOST_EDGES),
    }


def record() -> tuple[dict[str, Any], gw.World]:
    world = gw.World.load("scene:pso-aco-1")
    job = jobs.Job(world, start=(0.5, 0.5), goal=(19.5, 19.5), planner="visibility")
    return jobs.run(job).record, world


def test_traces_of_continuous_planners_are_bounded() -> None:
    kept = trace_record(trace(5000))
    assert kept is not None
    assert len(kept["population"]) == MOST_GENERATIONS
    assert [kept["population"][k]["generation"] for k in (0, -1)] == [0, 290]
    assert all(len(each["paths"]) == MOST_CURVES for each in kept["population"])
    assert len(kept["speed"]["ceiling"]) == len(kept["classes"][0]["path"]) == MOST_POINTS
    assert kept["speed"]["ceiling"][-1] == [499.9, 999.8]
    assert len(kept["tree"]) == MOST_EDGES
    assert kept["tree"][0] == [0.0, 0.0, 1.0, 0.1235]
    assert trace_record({"population": [], "classes": None}) is None


def test_the_page_has_what_the_trace_has() -> None:
    found, world = record()
    found["trace"] = trace_record(trace(30))
    jsonschema.validate(found, schemas.load("plan"))
    text = page([found], world)
    bundle = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert bundle is not None
    shown = json.loads(bundle.group(1))["entries"][0]["data"]["trace"]
    assert shown["loop"][0]["found"] == [REGION]
    for words in ("Speed before and after correction", "Closed loop", "Homotopy classes", "Population on the map", "Search tree"):
        assert words in text


def test_the_figure_draws_the_whole_trace(tmp_path: Path) -> None:
    found, world = record()
    found["search"]["history"] = [[0, 0.6], [10, 0.5], [60, 0.38]]
    found["trace"] = trace_record(trace(30))
    written = search_figure([found], world, tmp_path / "loop")
    texts = written[1].read_text("utf-8")
    assert texts.count('id="axes_') == 3  # map, objective, speed
    assert min(Image.open(written[0]).size) > 600
