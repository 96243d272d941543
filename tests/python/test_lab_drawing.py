"""What the report draws: worlds under their conditions, tracks of what moves, and a share of the file for every experiment."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from guideway.lab import worlds
from guideway.lab.cells import grid
from guideway.lab.reading import of_data
from guideway.lab.report import drawing
from guideway.lab.report.drawing import Budget, moving, pictured

ROOM = {"name": "w0", "make": "room", "room": "w0"}


def experiment(name: str, places: list[dict[str, Any]], kind: str = "plan", seeds: int = 4, **more: Any) -> Any:
    data = {"schema": 1, "name": name, "kind": kind, "seeds": seeds, "worlds": places, "methods": [{"name": "m", "planner": "visibility"}], **more}
    return of_data(f"{name}.toml", f"{name}.toml", data)


def filled(one: Any, points: int) -> Any:
    """Its grid, with a record for every run; paths of so many points that none can be left out."""
    rng = np.random.default_rng(1)
    keys = [dict(zip(("world", "query", "method", "seed"), run.key, strict=True)) for run in one.runs()]
    rows = [{**key, "status": "ok", "certified": True, "measures": {"length": 1.0}, "path": rng.random((points, 2)).tolist()} for key in keys]
    return grid(one, rows)


@pytest.mark.parametrize(("condition", "movers"), [("none", 0), ("static", 0), ("dynamic", 1)])
def test_worlds_are_drawn_under_the_condition_of_the_query(condition: str, movers: int) -> None:
    one = experiment("rooms", [ROOM], queries=[{"name": "q", "condition": condition}])
    found, world = pictured(one.runs()[0]), worlds.query(ROOM, {"condition": condition}).world
    assert len(found["shapes"]) == len(world.shapes)
    assert len(found.get("movers", [])) == len(world.movers)
    assert bool(found.get("movers")) == bool(movers)


def test_movers_that_cross_the_path_are_those_of_the_seed() -> None:
    place = {"name": "w", "source": "scene:m20", "crossed": True}
    one = experiment("crossed", [place], kind="drive")
    first, other = (pictured(run)["movers"] for run in one.runs()[:2])
    assert first
    assert first != other
    budget = Budget()
    budget.share(1)
    assert [budget.world(run) for run in one.runs()] == [0, 1, 2, 3]
    assert [budget.world(run) for run in experiment("still", [{"name": "v", "source": "scene:m20"}]).runs()] == [4] * 4


def test_a_track_says_where_the_mover_is_at_first() -> None:
    mover = {"shape": {"disc": 0.3}, "track": [[0.0, 1.0, 2.0], [2.0, 3.0, 2.0]], "loop": "shuttle", "phase": 1.0, "appears": None}
    assert moving(mover) == {"track": [1.0, 2.0, 3.0, 2.0], "at": [2.0, 2.0], "half": 0.3, "cycle": False}
    box = mover | {"shape": {"box": (2.0, 1.0)}, "loop": "cycle"}
    assert (moving(box)["half"], moving(box)["cycle"]) == (0.5, True)


def test_every_experiment_has_its_share_of_the_file() -> None:
    places = [{"name": "{seed}", "make": "complexity", "size": 30, "density": 0.3, "each": {"seed": list(range(40))}}]
    large, small = filled(experiment("a-large", places), 60), filled(experiment("small", [{"name": "m", "source": "scene:m30"}]), 60)
    budget = Budget(40_000, 30_000)
    much, little = (found["cells"] for found in drawing.drawings([large, small], budget))
    assert [len(cell["paths"]) for cell in little] == [4]
    assert all(path["world"] is not None for path in little[0]["paths"])
    drawn = [path for cell in much for path in cell["paths"]]
    assert 0 < len(drawn) < 160
    assert drawn[0]["world"] is not None
    assert drawn[-1]["world"] is None
    assert sum(len(json.dumps(path["path"])) for cell in (*much, *little) for path in cell["paths"]) < 1.3 * 40_000
    assert len(json.dumps(budget.worlds)) < 1.1 * 30_000


def test_a_picture_that_has_no_room_is_left_to_the_next_experiment() -> None:
    run = experiment("one", [{"name": "m", "source": "scene:m30"}]).runs()[0]
    size = len(json.dumps(pictured(run)))
    budget = Budget(pictures=size + 100)
    budget.share(2)
    assert budget.world(run) is None
    budget.share(1)
    assert budget.world(run) == 0
    assert budget.world(replace(run, world={"name": "gone", "source": "none.map"})) is None


def test_what_cannot_be_made_again_is_drawn_without_its_world() -> None:
    one = experiment("lost", [{"name": "gone", "source": "none.map"}])
    budget = Budget()
    budget.share(1)
    cell = drawing.drawing(filled(one, 5), budget)["cells"][0]
    assert [path["world"] for path in cell["paths"]] == [None] * 4
