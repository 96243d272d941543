"""How a search went: bounded traces in plan.json, their layers and chart in the report, their figure."""

from __future__ import annotations

import copy
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from PIL import Image

import guideway as gw
from guideway import jobs, schemas, view
from guideway.traces import MOST_CELLS, MOST_PATHS, trace_record


def record(planner: str, **more: Any) -> tuple[dict[str, Any], gw.World]:
    world = gw.World.load("scene:pso-aco-1")
    job = jobs.Job(world, start=(0.5, 0.5), goal=(19.5, 19.5), planner=planner, seed=7, timing=False, refine="none", **more)
    return jobs.run(job).record, world


def test_a_trace_is_kept_where_there_is_one() -> None:
    found, world = record("pso-aco", set={"preset": "paper"})
    jsonschema.validate(found, schemas.load("plan"))
    (leg,) = found["trace"]["legs"]
    assert 20 <= leg["swarm_iterations"] <= 50
    assert 1 <= len(leg["paths"]) <= MOST_PATHS
    cells = np.array(leg["pheromone"])
    free = np.asarray(world.occupancy())[::-1] == 0  # row 0 at the bottom
    assert free[cells[:, 1].astype(int), cells[:, 0].astype(int)].all()
    assert ((cells[:, 2] >= 0.01) & (cells[:, 2] <= 10)).all()
    strong = {(int(x), int(y)) for x, y, _ in cells[cells[:, 2] > np.median(cells[:, 2])]}
    path = {(int(x), int(y)) for x, y in found["grid_path"]}
    assert len(path & strong) > 0.8 * len(path)  # the ants come to go where the best way is
    assert "trace" not in record("jump-point")[0]
    swarm = record("grouped-pso")[0]["trace"]["legs"][0]
    assert set(swarm) == {"paths"}


def test_every_product_has_its_own_trace() -> None:
    from guideway import products
    from guideway.view.products import expand

    world = gw.World.load("scene:pso-aco-1")
    job = jobs.Job(world, start=(0.5, 0.5), goal=(19.5, 19.5), planner="pso-aco", seed=7)
    found = products.compare(job, ".", own=True).record
    shown, _ = expand([found], [world])
    traces = [each["trace"] for each in shown]
    assert len(traces) == 3
    assert traces[0] == found["trace"]
    assert traces[0] != traces[1]


def test_traces_are_bounded() -> None:
    cells = [[i % 300, i // 300, 1.0 + i * 1e-6 / 3] for i in range(30_000)]
    leg = {"pheromone": cells, "paths": [[[0.5, 0.5], [i, 1.0]] for i in range(50)] + [[[0.0, 0.0]] * 1000]}
    kept = trace_record({"legs": [leg]})
    assert kept is not None
    assert len(kept["legs"][0]["pheromone"]) == MOST_CELLS
    assert min(row * 300 + column for column, row, _ in kept["legs"][0]["pheromone"]) == 30_000 - MOST_CELLS  # the strongest
    assert kept["legs"][0]["paths"] == leg["paths"][:MOST_PATHS]
    assert trace_record({"lower_bound": 3.0}) is None
    assert trace_record({"legs": [{"graph": "corners"}]}) is None
    assert trace_record(None) is None


def test_the_schema_minds_the_trace() -> None:
    found, _ = record("mmas", set={"iterations": 3})
    for wrong in ([[0, 0]], [[0, 0, -1.0]], [[0.5, 0, 1.0]], [[0, 0, 1.0, 2.0]]):
        other = copy.deepcopy(found)
        other["trace"]["legs"][0]["pheromone"] = wrong
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(other, schemas.load("plan"))


def test_the_figure_shows_the_search(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    (colony, world), (swarm, _) = record("pso-aco"), record("grouped-pso")
    png, svg = view.search_figure([colony, swarm], world, tmp_path / "search")
    text = svg.read_text("utf-8")
    for word in ("pso-aco", "swarm of pso-aco", "exact optimum", "pheromone"):
        assert f"<!-- {word} -->" in text
    pixels = np.asarray(Image.open(png).convert("RGB")).astype(int)
    assert ((pixels[..., 0] - pixels[..., 2]) > 120).mean() > 0.02  # amber
    view.search_figure([swarm], None, tmp_path / "swarm")
    with pytest.raises(ValueError, match="no result has a history"):
        view.search_figure([record("jump-point")[0]], world, tmp_path / "none")


def test_the_page_charts_the_search(tmp_path: Path) -> None:
    found, world = record("pso-aco", set={"preset": "paper"})
    target = view.report([found], tmp_path / "r.html", worlds=world)
    if shutil.which("chromium") is None:
        pytest.skip("no chromium")
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--virtual-time-budget=3000", "--dump-dom"]
    done = subprocess.run(
        [*command, f"--user-data-dir={tmp_path}/profile", target.as_uri()], capture_output=True, text=True, timeout=120, check=False
    )
    if "<html" not in done.stdout:
        pytest.skip("no chromium that runs here")
    assert "CONSOLE" not in done.stderr
    assert "Best path over the iterations" in done.stdout
    assert f"exact optimum {found['reference']['grid_optimum']:.3f}" in done.stdout
    assert re.search(r">swarm<.*>colony<", done.stdout)
    assert "Population" in done.stdout
    assert re.search(r'class="ramp scent"[^>]*>0.01<', done.stdout)
