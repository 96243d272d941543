"""The replay of a drive in the report: what is embedded, what the page draws, how large it may become."""

from __future__ import annotations

import json
import math
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import guideway as gw
from guideway import schemas
from guideway.view import report
from guideway.view.report import MOST_NUMBERS, count, page
from pages import drawn

LAYERS = ("Plan in force, former plans", "Lidar points", "Tracked obstacles", "Reachable before rest", "Candidates, chosen", "Sub-goal")


def step(t: float, rays: int = 36, fan: int = 12) -> dict[str, Any]:
    """A step of a robot that drives along y = 0 and stops between 2 and 3 s."""
    x, stop = 0.5 + 0.8 * t, 2.0 <= t < 3.0
    arcs = [[[x + 0.1 * k * math.cos(0.1 * a * k), 0.1 * k * math.sin(0.1 * a * k)] for k in range(8)] for a in range(-fan // 2, fan // 2)]
    return {
        "t": t,
        "pose": [x, 0.0, 0.1],
        "v": 0.0 if stop else 0.8,
        "w": 0.0,
        "command": [0.0 if stop else 0.8, 0.0],
        "rays": [-math.pi, 2 * math.pi / rays],
        "ranges": [None if k % 9 == 0 else 1.5 + 0.01 * k for k in range(rays)],
        "tracks": [[3.0, 1.5 - 0.4 * t, 0.3, 0.0, -0.4]],
        "discs": [[3.0, 1.5 - 0.4 * t, 0.8]],
        "fan": arcs,
        "chosen": arcs[fan // 2],
        "sub_goal": [4.0, 0.5],
        "state": "no admissible command" if stop else "drive",
    }


def trace(seconds: float = 4.0) -> dict[str, Any]:
    plans = [
        {"t": 0.0, "path": [[0.5, 0.0], [5.0, 0.0]], "reason": "start"},
        {"t": 2.5, "path": [[2.1, 0.0], [3.0, 1.0], [5.0, 0.0]], "reason": "blocked by mover 0"},
    ]
    return {"steps": [step(0.1 * k) for k in range(round(10 * seconds))], "plans": plans}


@pytest.fixture(scope="module")
def drive() -> tuple[dict[str, Any], gw.World]:
    """A run of ours whose trace is the example, so that every layer has something to show."""
    mover = {"shape": {"disc": 0.3}, "track": [[0.0, 3.0, 1.5], [7.0, 3.0, -1.3]], "loop": "shuttle", "phase": 0.0}
    world = gw.World(bounds=(0, -2, 6, 2), shapes=[{"disc": {"center": [4.2, -1.2], "radius": 0.4}}], movers=[mover])
    query = gw.Query(world, (0.5, 0.0), (5.0, 0.0), footprint=gw.Disc(0.25), clearance=0.05)
    run = gw.drive(query, gw.time(gw.plan(query).path, gw.Limits(1.0, 1.0, jerk=4.0)), "tracker", trace=True)
    return run, world


def data_of(text: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert found is not None
    return json.loads(found.group(1))["entries"][0]["data"]


def test_a_real_run_has_a_trace_and_a_histogram(drive: tuple[dict[str, Any], gw.World]) -> None:
    run, _ = drive
    jsonschema.validate(run, schemas.load("run"))
    steps = run["trace"]["steps"]
    assert len(steps) > 20
    assert all(b["t"] > a["t"] for a, b in pairwise(steps))
    assert max(row["command"][0] for row in steps) == pytest.approx(1.0, abs=0.1)
    counts, driven = run["step_seconds"]["counts"], run["driven"]
    assert abs(sum(counts) - len(driven)) <= 2
    middle = next(k for k in range(24) if 2 * sum(counts[: k + 1]) >= sum(counts))
    assert 10 ** (middle / 4 - 6.01) <= run["step_seconds"]["p50"] <= 10 ** ((middle + 1) / 4 - 5.99)


def test_the_page_has_the_whole_trace(drive: tuple[dict[str, Any], gw.World]) -> None:
    run, world = drive
    shown = data_of(page([run | {"trace": trace()}], world))["trace"]
    assert [row["t"] for row in shown["steps"]] == [pytest.approx(0.1 * k) for k in range(40)]
    assert shown["plans"][1]["reason"] == "blocked by mover 0"
    assert shown["steps"][3]["ranges"][:2] == [None, 1.51]


def test_a_long_trace_is_thinned(drive: tuple[dict[str, Any], gw.World]) -> None:
    run, world = drive
    long = trace() | {"steps": [step(0.1 * k, rays=180) for k in range(2000)]}
    text = page([run | {"trace": long}], world)
    kept = data_of(text)["trace"]["steps"]
    assert count(long["steps"]) > 2 * MOST_NUMBERS
    assert MOST_NUMBERS / 4 < count(kept) <= MOST_NUMBERS
    assert len(text) < 3_000_000
    assert kept[-1]["t"] > 195


@pytest.mark.parametrize(
    "broken",
    [
        {},
        {"steps": None, "plans": 3},
        {"steps": [None, 4, {"t": "x"}, {"t": 0.0, "pose": [1], "ranges": [1, None], "tracks": [[1]], "fan": [[], [[0, 0]]], "sub_goal": 5}]},
        {"steps": [{"t": 1.0, "pose": [0, 0, 0], "rays": [0.0, 0.1], "ranges": "all", "discs": 7, "state": {"a": 1}}], "plans": [{"path": [[0, 0]]}]},
    ],
)
def test_broken_traces_still_make_a_page(drive: tuple[dict[str, Any], gw.World], broken: dict[str, Any], tmp_path: Path, browser: None) -> None:
    run, world = drive
    path = report([run | {"trace": broken}], tmp_path / "run.html", world)
    shown, complaints = drawn(path.as_uri(), tmp_path)
    assert not complaints
    assert "Arrived after" in shown
    assert not any(name in shown for name in ("Lidar points", "Tracked obstacles", "Plan in force"))


def test_the_page_shows_every_layer_and_the_step(drive: tuple[dict[str, Any], gw.World], tmp_path: Path, browser: None) -> None:
    run, world = drive
    example = run | {
        "trace": trace(),
        "events": [{"t": 2.0, "kind": "stop", "reason": "no admissible command"}, {"t": 2.5, "kind": "replan", "reason": "blocked"}],
    }
    path = report([example], tmp_path / "run.html", world)
    shown, complaints = drawn(path.as_uri() + "#t=2.2", tmp_path)
    assert not complaints
    for words in LAYERS:
        assert words in shown
    assert "Stops: no admissible command" in shown
    assert "dashed: commanded" in shown
    assert shown.count('class="bar"') >= 1
    assert 'class="replan"' in shown
    later, complaints = drawn(path.as_uri() + "#t=3.2", tmp_path)
    assert not complaints
    assert "New plan: blocked by mover 0" in later


def test_what_a_plant_measured_is_shown(drive: tuple[dict[str, Any], gw.World], tmp_path: Path, browser: None) -> None:
    run, world = drive
    rows = [[0.02 * k, 2.0 * math.sin(0.1 * k), 0.5] for k in range(200)]
    tilt = {"max": 2.0, "mean": 1.3, "rms": 1.5, "psi": 94.0, "ms": 94.8, "rows": rows}
    path = report([run | {"plant": {"name": "mujoco", "contacts": 0, "tilt": tilt}}], tmp_path / "run.html", world)
    shown, complaints = drawn(path.as_uri(), tmp_path)
    assert not complaints
    assert "Posture stability index" in shown
    assert "pitch, dashed: roll" in shown
    assert "Measured by the plant" not in drawn(report([run], tmp_path / "plain.html", world).as_uri(), tmp_path)[0]
