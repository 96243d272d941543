"""The schemas are valid, accept what the command line promises and refuse what it does not."""

from __future__ import annotations

import copy
from typing import Any

import jsonschema
import pytest

from guideway import schemas

WORLD = {"source": "warehouse.yaml", "sha256": "0" * 64, "width": 4, "height": 3, "resolution": 0.05, "origin": [0, 0, 0]}
QUERY = {"start": [0, 0], "goal": [0, 0, 1.5], "via": [], "footprint": {"disc": 0.35}, "clearance": 0.1, "corners": "touch", "material": "standard"}
PLAN: dict[str, Any] = {
    "guideway": "0.1.0",
    "schema": 1,
    "planner": "pso-aco",
    "parameters": {},
    "seed": 7,
    "world": WORLD,
    "query": QUERY,
    "path": {"degree": 1, "knots": [0, 0, 1, 1], "control_points": [[0, 0], [1, 1]]},
    "polyline": [[0, 0], [1, 1]],
    "grid_path": None,
    "metrics": {"length": 0, "turns": 0, "total_turning": 0, "min_clearance": 0, "max_curvature": 0, "smoothness": 0, "energy": 0},
    "search": {"iterations": 0, "evaluations": 0, "seconds": 0, "stop": "converged", "history": [[0, 0.0]], "raw_length": 0},
    "reference": {"grid_optimum": 0, "grid_gap": 0, "any_angle_optimum": None, "any_angle_gap": None, "proved": True},
    "certificate": {"ok": True, "collision_free": True, "step": 0.01, "checks": []},
    "trajectory": {
        "duration": 0,
        "limits": {"speed": 1, "acceleration": 1, "deceleration": 1, "jerk": 1, "turn_rate": None, "lateral_acceleration": None},
        "pieces": [{"t": 0, "s": 0, "speed": 0, "acceleration": 0, "jerk": 0, "duration": 0}, {"turn": -1.5, "t": 0, "duration": 1}],
    },
    "further": "fields are welcome",
}
RUN: dict[str, Any] = {
    "guideway": "0.1.0",
    "schema": 1,
    "outcome": "arrived",
    "time": 1.0,
    "world": WORLD,
    "query": QUERY | {"arrival": 0.1},
    "robot": {"footprint": {"box": [0.42, 0.33]}, "speed": 2, "acceleration": 2, "deceleration": 2, "jerk": 2, "turn_rate": None},
    "obstacles": {
        "shapes": [{"disc": {"center": [0, 0], "radius": 1}}],
        "movers": [{"shape": {"disc": 0.5}, "track": [[0, 0, 0]], "loop": "cycle", "phase": 0, "appears": {"within": 3}}],
    },
    "driven": [[0, 0, 0, 0, 0, 0]],
    "movers": [{"shape": {"points": [[0, 0]], "radius": 0.5}, "since": None, "states": [[0, 0, 0, 1]]}],
    "replans": 0,
    "min_separation": None,
    "emergency_stops": 0,
    "step_seconds": {"mean": 0, "p50": 0, "p95": 0, "p99": 0},
    "tracking": {"tte": 0, "path_error": 0, "worst": 0, "tpe": 0, "length": 0, "length_deviation": 0},
    "energy": {"ttec": 0, "moec": 0},
}
ROW = {"row": 0, "start_cell": [1, 2], "goal_cell": [1, 2], "published": 1.0, "length": 1.0, "seconds": 0.0, "error": None}
SCENE: dict[str, Any] = {
    "world": {"bounds": [0, 0, 10, 6], "resolution": 0.05},
    "disc": [{"center": [1, 1], "radius": 0.4}],
    "mover": [{"shape": {"box": [0.8, 0.8]}, "path": [[3, 2], [3, 4]], "speed": 0.4, "loop": "shuttle", "appears": {"within": 3}}],
    "robot": {"footprint": {"disc": 0.2}, "speed": 2},
    "query": {"start": [0, 0], "goal": [5, 3], "clearance": 0.3},
}
ARM: dict[str, Any] = {
    "guideway": "0.1.0",
    "schema": 1,
    "kind": "arm",
    "joints": ["a", "b"],
    "duration": 1.0,
    "limits": {"speed": [1, 2], "acceleration": 3, "torque": [40, 20], "tip_speed": 0.5},
    "t": [0, 1],
    "q": [[0, 0], [1, 1]],
    "qd": [[0, 0], [0, 0]],
    "qdd": [[0, 0], [0, 0]],
    "path": {"degree": 1, "knots": [0, 0, 1, 1], "control_points": [[0, 0], [1, 1]], "length": 1.4, "source": None},
    "pieces": [{"t": 0, "s": 0, "speed": 0, "acceleration": 1, "jerk": 0, "duration": 1}],
    "grid": {"s": [0, 1], "x": [0, 0], "mvc": [None, 1], "active": ["speed of a", None]},
    "report": {},
}
SUMMARY: dict[str, Any] = {"schema": 1, "guideway": "0.1.0", "experiments": []}
RECORD: dict[str, Any] = {
    "schema": 1,
    "experiment": "e",
    "digest": "0",
    "world": "w",
    "query": "",
    "method": "m",
    "seed": 0,
    "status": "failed",
    "error": {"type": "NoPath", "message": "there is none"},
    "measures": {"length": 1.5, "hit": True, "gap": None},
    "curve": [[1, 2.0]],
    "path": None,
    "certified": None,
    "times": {"wall": 0.1},
    "peak_mib": None,
    "version": "0.1.0",
    "machine": "a computer",
}
GOOD = {"record": RECORD, "summary": SUMMARY, "arm": ARM, "plan": PLAN, "run": RUN, "row": ROW, "scene": SCENE}


def accepts(name: str, value: object) -> bool:
    return jsonschema.Draft202012Validator(schemas.load(name)).is_valid(value)


@pytest.mark.parametrize("name", schemas.NAMES)
def test_schema_is_valid_and_every_required_field_counts(name: str) -> None:
    schema = schemas.load(name)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.Draft202012Validator(schema).validate(GOOD[name])
    for field in schema["required"]:
        assert not accepts(name, {key: value for key, value in GOOD[name].items() if key != field}), field


@pytest.mark.parametrize(
    ("name", "path", "value"),
    [
        ("arm", ["limits", "speed"], 0),
        ("arm", ["limits", "haste"], 1),
        ("arm", ["pieces", 0, "duration"], 0),
        ("arm", ["q", 0], 1),
        ("plan", ["schema"], 2),
        ("plan", ["world", "sha256"], "abc"),
        ("plan", ["query", "footprint"], {"disc": 1, "box": [1, 1]}),
        ("plan", ["query", "material"], "glass"),
        ("plan", ["polyline", 0], [1]),
        ("plan", ["reference", "any_angle_gap"], -1e-6),
        ("plan", ["metrics", "length"], None),
        ("plan", ["trajectory", "pieces", 0], {"t": 0, "s": 0}),
        ("run", ["outcome"], "lost"),
        ("run", ["driven", 0], [0, 0, 0]),
        ("run", ["replans"], 0.5),
        ("scene", ["disc", 0, "radius"], "wide"),
        ("scene", ["mover", 0, "loop"], "zigzag"),
        ("record", ["status"], "lost"),
        ("record", ["error"], {"type": "NoPath"}),
        ("record", ["times", "wall"], None),
        ("row", ["error"], "NoPath"),
        ("row", ["start_cell"], [0.5, 1]),
    ],
)
def test_wrong_values_are_refused(name: str, path: list[Any], value: object) -> None:
    wrong = copy.deepcopy(GOOD[name])
    target: Any = wrong
    for key in path[:-1]:
        target = target[key]
    target[path[-1]] = value
    assert not accepts(name, wrong)


def test_names() -> None:
    with pytest.raises(KeyError, match="plan, record, row, run"):
        schemas.load("../plan")
