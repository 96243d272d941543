"""The view floor: one file, offline, safe against its data, whole or not at all."""

from __future__ import annotations

import base64
import io
import json
import re
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import guideway as gw
from guideway import view
from guideway.view import profile, scenery
from pages import markup

report_module = import_module("guideway.view.report")
figure_module = import_module("guideway.view.figure")


class Room:
    """A fake world: a grid with a wall, its clearance by brute force."""

    def __init__(self, cells: np.ndarray, resolution: float = 0.5, origin: tuple[float, float, float] = (-1.0, 2.0, 0.0), shapes: tuple = ()) -> None:
        self.sha256: str | None = None
        self.cells, self.resolution, self.origin, self.shapes = cells, resolution, origin, list(shapes)
        height, width = cells.shape
        self.bounds = (origin[0], origin[1], origin[0] + width * resolution, origin[1] + height * resolution)

    def occupancy(self) -> np.ndarray:
        return self.cells

    def clearance_field(self) -> np.ndarray:
        blocked = np.argwhere(self.cells == scenery.BLOCKED)
        at = np.stack(np.indices(self.cells.shape), axis=-1)
        if not len(blocked):
            return np.full(self.cells.shape, 9.0)
        return np.linalg.norm(at[:, :, None] - blocked, axis=-1).min(axis=-1) * self.resolution


class Scene:
    """A fake world without a grid."""

    resolution, origin, bounds = 0.05, (0.0, 0.0, 0.0), (0.0, 0.0, 10.0, 6.0)
    shapes = ({"disc": {"center": [3.0, 3.0], "radius": 1.0}}, {"polygon": {"points": [[6, 2], [7, 2], [7, 4], [6, 4]]}})

    def occupancy(self) -> None:
        return None

    def clearance_field(self) -> None:
        return None


def room() -> Room:
    cells = np.zeros((12, 16), dtype=np.uint8)
    cells[2:9, 7] = scenery.BLOCKED
    cells[11, :4] = scenery.UNKNOWN
    return Room(cells)


PIECE = {"t": 0, "s": 0, "speed": 0.5, "acceleration": 0, "jerk": 0, "duration": 8.6}
HIDDEN = {"shape": {"box": [1, 1]}, "states": [[0, 4, 3, 0], [9, 4, 3, 0]]}


def plan(**more: Any) -> dict[str, Any]:
    base = {
        "guideway": "0.1.0", "schema": 1, "planner": "visibility", "parameters": {}, "seed": 7,
        "world": {"source": "room.yaml", "width": 16, "height": 12, "resolution": 0.5},
        "query": {"start": [0, 3], "goal": [4, 3, 1.5], "via": [], "footprint": {"disc": 0.2}, "clearance": 0.1, "material": "standard"},
        "path": {"degree": 3, "knots": [0, 0, 0, 0, 1, 1, 1, 1], "control_points": [[0, 3], [1, 4], [3, 4], [4, 3]]},
        "polyline": [[0, 3], [1, 3.5], [2, 3.75], [3, 3.5], [4, 3]], "grid_path": [], "raw_path": [[0, 3], [4, 3]],
        "metrics": {"length": 4.3, "min_clearance": 0.15}, "reference": {"any_angle_gap": 0.01, "proved": True, "path": [[0, 3], [4, 3]]},
        "certificate": {"ok": True, "collision_free": True, "step": 0.01, "checks": []}, "unmet": [],
        "trajectory": {"duration": 8.6, "limits": {"speed": 0.5, "jerk": None}, "pieces": [PIECE]},
    }  # fmt: skip
    return base | more


def run(**more: Any) -> dict[str, Any]:
    times = [0.1 * i for i in range(50)]
    base = {
        "outcome": "arrived", "time": 4.9, "driven": [[t, t, 3.0, 0.0, 1.0, 0.0] for t in times], "query": plan()["query"],
        "movers": [{"shape": {"disc": 0.3}, "states": [[t, 2.0, 5.0, 1] for t in times]}, HIDDEN],
        "events": [{"t": 1.0, "kind": "stop", "reason": "mover"}], "replans": 1, "min_separation": 1.5,
    }  # fmt: skip
    return base | more


def data_of(text: str) -> dict[str, Any]:
    found = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert len(found) == 1
    return json.loads(found[0])


def test_one_file_without_any_link(tmp_path: Path) -> None:
    written = view.report([plan(), run()], tmp_path / "r.html", worlds=room())
    assert [p.name for p in tmp_path.iterdir()] == ["r.html"]
    text = written.read_text("utf-8")
    assert "://" not in text
    assert not re.search(r"<(link|iframe|object|embed|base)\b|\bsrc=|@import|url\(|\bfetch\(|XMLHttpRequest|WebSocket|webgl", text, re.I)
    assert "default-src 'none'" in text
    assert len(text) < 250_000


def test_every_template_field_is_filled() -> None:
    assert not re.search(r"\{\{\w+\}\}", view.page([plan()]))


def test_data_parses_back(tmp_path: Path) -> None:
    data = data_of(view.report([plan(), run()], tmp_path / "r.html", worlds=room()).read_text("utf-8"))
    assert [entry["kind"] for entry in data["entries"]] == ["plan", "run"]
    assert data["entries"][0]["data"]["polyline"] == plan()["polyline"]
    assert data["entries"][1]["data"]["driven"][3] == pytest.approx(run()["driven"][3])
    assert len(data["worlds"]) == 1
    assert data["title"] == "room.yaml"


@pytest.mark.parametrize(
    "text", ["</script><script>alert(1)</script>", "<!--<script>", "]]>", "https://example.org/x", "{{data}}", "a\u2028b", '"\\</ScRiPt>']
)
def test_hostile_text_stays_text(text: str) -> None:
    page = view.page([plan(planner=text, unmet=[text], query=plan()["query"] | {"material": text}, **{text: text})], title=text)
    data = data_of(page)
    assert data["title"] == text
    assert data["entries"][0]["data"]["planner"] == text
    assert page.lower().count("</script") == 2
    assert page.lower().count("<script") == 2
    assert "://" not in page
    assert "<!--" not in page


def test_numbers_that_json_has_not() -> None:
    data = data_of(view.page([plan(metrics={"length": float("nan"), "turns": np.int64(3), "max_curvature": np.float64("inf")})]))
    assert data["entries"][0]["data"]["metrics"] == {"length": None, "turns": 3, "max_curvature": None}


POOR = [
    {},
    {"polyline": []},
    {"polyline": None, "path": 3, "trajectory": "x"},
    {"path": {"degree": 3, "knots": [0, [1]], "control_points": 7}},
    {"outcome": "stuck", "driven": [], "movers": []},
    {"driven": None},
    {**run(), "movers": True},
    {
        **run(),
        "movers": [
            {"shape": {"disc": "x"}, "states": [[0, 1, 1, 1]]},
            {"shape": 7, "states": [[0, 1, 1, 1]]},
            {"shape": {"box": [1]}, "states": [[0, 1, 1, 1]]},
        ],
    },
    {**run(), "robot": {"footprint": {"polygon": []}}},
    plan(trace=7),
    plan(trace={"legs": [3, {"pheromone": [[1], [0, 0, -1], ["x", 1, 2], [1e9, 0, 1.0], [0, 1e9, 2.0]], "paths": [1, [[1]]]}]}),
]


@pytest.mark.parametrize("result", POOR)
def test_poor_results_still_make_a_page(result: dict[str, Any]) -> None:
    assert data_of(view.page([result], worlds=room()))["entries"][0]["data"] is not None


def test_no_results_make_a_page() -> None:
    assert data_of(view.page([]))["entries"] == []


def test_wrong_arguments_are_named() -> None:
    with pytest.raises(TypeError, match=r"results\[1\] is a list"):
        view.page([plan(), []])  # type: ignore[list-item]
    with pytest.raises(ValueError, match="2 worlds for 1 results"):
        view.page([plan()], worlds=[room(), None])


def test_a_world_is_embedded_once_and_found_by_each() -> None:
    one, other = room(), room()
    data = data_of(view.page([plan(), plan(), run(), plan()], worlds=[one, other, one, None]))
    assert [entry["world"] for entry in data["entries"]] == [0, 1, 0, None]
    assert len(data["worlds"]) == 2
    one.sha256 = other.sha256 = "same file"
    assert len(data_of(view.page([plan(), plan()], worlds=[one, other]))["worlds"]) == 1


def test_labels_tell_results_apart() -> None:
    heavy = plan()["query"] | {"material": "heavy"}
    assert report_module.labels([plan(), plan(query=heavy), run()]) == ["visibility, standard", "visibility, heavy", "drive"]
    assert report_module.labels([plan(seed=1), plan(seed=2)]) == ["visibility, seed 1", "visibility, seed 2"]
    assert report_module.labels([plan(), plan()]) == ["visibility #1", "visibility #2"]


def test_a_failed_write_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "r.html"
    target.write_text("old")

    def refuse(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(report_module.os, "fsync", refuse)
    with pytest.raises(OSError, match="disk full"):
        view.report([plan()], target)
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["r.html"]


def test_walls_are_exact_at_full_resolution() -> None:
    entry = scenery.picture(room())["walls"]
    assert np.array_equal(decoded(entry), room().cells)
    assert (entry["cell"], entry["top"], entry["span"]) == (0.5, 6.0, 8.0)


def decoded(entry: dict[str, Any]) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(entry["png"]))))


def test_reduction_keeps_single_wall_cells() -> None:
    cells = np.zeros((7, 10), dtype=np.uint8)
    cells[3, 5], cells[6, 9], cells[0, 0] = scenery.BLOCKED, scenery.UNKNOWN, scenery.BLOCKED
    small = scenery.shrink_walls(cells, 3)
    assert small.tolist() == [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 2]]


def test_large_maps_stay_within_their_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    cells = (np.random.default_rng(5).random((1500, 1700)) < 0.2).astype(np.uint8)
    full = scenery.walls(cells, 0.1)
    assert full["factor"] == 1
    monkeypatch.setattr(scenery, "WALL_BYTES", 200_000)
    less = scenery.walls(cells, 0.1)
    assert less["factor"] > 1
    assert len(less["png"]) <= 200_000 * 4 / 3 + 4
    assert decoded(less).shape == (-(-1500 // less["factor"]), -(-1700 // less["factor"]))
    monkeypatch.setattr(scenery, "WALL_PIXELS", 10_000)
    assert decoded(scenery.walls(cells, 0.1)).size <= 1.1 * 10_000


def test_shading_grows_with_clearance() -> None:
    field = np.tile(np.linspace(0, 4, 2000, dtype=np.float32), (30, 1))
    entry = scenery.shading(field, 0.02)
    assert entry is not None
    tones = decoded(entry)
    assert max(tones.shape) <= scenery.SHADE_SIDE
    assert (np.diff(tones[0].astype(int)) >= 0).all()
    assert (tones[0, 0], tones[0, -1]) == (0, scenery.SHADES - 1) or tones[0, 0] <= 2
    assert scenery.shading(np.zeros((4, 4)), 1.0) is None


def test_a_scene_of_shapes_is_shaded() -> None:
    entry = scenery.picture(Scene())
    tones = decoded(entry["shade"])
    assert (entry["walls"], tones.shape) == (None, (144, 240))
    assert tones[72, 72] == 0  # the middle of the disc
    assert tones[72, 156] == 0  # the middle of the box
    assert tones[0, 239] == scenery.SHADES - 1


def test_curvature_of_a_circle() -> None:
    k = 4 / 3 * np.tan(np.pi / 8)
    control = [[2, 0], [2, 2 * k], [2 * k, 2], [0, 2]]
    table = np.array(profile.curvature({"degree": 3, "knots": [0] * 4 + [1] * 4, "control_points": control}))
    assert table[:, 1] == pytest.approx(0.5, rel=0.03)  # a cubic is a circle only nearly
    assert table[-1, 0] == pytest.approx(np.pi, rel=1e-3)
    assert profile.curvature({"degree": 1, "knots": [0, 0, 1, 1], "control_points": [[0, 0], [1, 1]]}) is None
    assert profile.curvature({"degree": 3, "knots": [0, 1], "control_points": control}) is None


def test_clearance_is_measured_from_the_map_and_the_shapes() -> None:
    line = np.array([[0.0, 3.0], [10.0, 3.0]])
    table = np.array(profile.clearance(Scene(), line, np.array([0.0, 10.0]), 0.25))
    at = dict(zip(np.round(table[:, 0], 3), table[:, 1], strict=True))
    assert at[0.0] == pytest.approx(1.75)
    assert at[10.0] == pytest.approx(2.75)
    assert min(at.values()) == pytest.approx(-0.25)
    turned = Room(room().cells, origin=(0.0, 0.0, np.pi / 2))
    straight = Room(room().cells, origin=(0.0, 0.0, 0.0))
    place = np.array([[1.3, 2.2], [3.1, 4.4]])
    rotated = np.column_stack([-place[:, 1], place[:, 0]])
    assert profile.sample_field(turned, rotated) == pytest.approx(profile.sample_field(straight, place))


def test_field_is_read_with_row_zero_on_top() -> None:
    cells = np.zeros((4, 6), dtype=np.uint8)
    cells[0, 0] = scenery.BLOCKED
    world = Room(cells, resolution=1.0, origin=(0.0, 0.0, 0.0))
    assert profile.sample_field(world, np.array([[0.5, 3.5], [0.5, 0.5]])) == pytest.approx([0.0, 3.0])


def test_distance_to_movers() -> None:
    table = np.array(profile.separation(run(robot={"footprint": {"disc": 0.2}})))
    assert table[0, 1] == pytest.approx(np.hypot(2, 2) - 0.5, abs=1e-4)
    assert table[:, 1].min() == pytest.approx(1.5, abs=1e-4)
    mover = {"shape": {"box": [1.0, 1.0]}, "states": [[0, 2.0, 3.0, 1], [9, 2.0, 3.0, 1]]}
    boxes = np.array(profile.separation(run(movers=[mover], robot={"footprint": {"box": [0.4, 0.4]}})))
    assert boxes[0, 1] == pytest.approx(1.3, abs=1e-4)
    assert boxes[20, 1] == 0
    rounded = {"shape": {"points": [[0.0, 0.0]], "radius": 0.3}, "states": [[0, 2.0, 5.0, 1], [9, 2.0, 5.0, 1]]}
    assert np.array(profile.separation(run(movers=[rounded], robot={"footprint": {"disc": 0.2}})))[:, 1].min() == pytest.approx(1.5, abs=1e-4)
    assert profile.separation(run(movers=[])) is None


def test_map_png_needs_pillow_only(tmp_path: Path) -> None:
    image = np.asarray(Image.open(view.map_png(room(), tmp_path / "map.png")))
    assert image.shape == (12 * 32, 16 * 32, 3)  # small maps get larger cells
    assert (image.reshape(12, 32, 16, 32, 3) == image[::32, None, ::32, None]).all()
    image = image[::32, ::32]
    assert (image[5, 7] < 100).all()
    assert (image[5, 0] > image[5, 6]).all()
    with pytest.raises(ValueError, match="no grid"):
        view.map_png(Scene(), tmp_path / "none.png")


def test_figures_for_papers(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    for name, results, world in (("a", [plan()], room()), ("b", [plan(), run()], Scene()), ("c", [], None), ("d", [{}], None)):
        png, svg = view.figure(results, world, tmp_path / name)
        assert png.read_bytes()[:4] == b"\x89PNG"
        assert "<svg" in svg.read_text("utf-8")


def test_missing_matplotlib_is_explained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    with pytest.raises(ImportError, match=r"guideway\[figures\]"):
        view.figure([plan()], None, tmp_path / "x")


@pytest.mark.usefixtures("browser")
def test_the_page_draws_itself(tmp_path: Path) -> None:
    target = view.report([plan(), run()], tmp_path / "r.html", worlds=room(), title="A <room>")
    text, log = markup(target.as_uri(), tmp_path)
    assert "CONSOLE" not in log
    assert '<h1 id="title">A &lt;room&gt;</h1>' in text
    assert "1.0 % longer than the proved optimum" in text
    assert text.count('class="strip"') >= 4


@pytest.mark.usefixtures("browser")
def test_the_page_evaluates_the_trajectory(tmp_path: Path) -> None:
    pieces = [
        {"t": 0.0, "duration": 2.0, "turn": 1.0, "s": 0.0, "from": 0.0},
        {"t": 2.0, "s": 0.0, "speed": 0.5, "acceleration": 0.2, "jerk": -0.06, "duration": 4.0},
    ]
    target = view.report([plan(trajectory={"duration": 6.0, "limits": {}, "pieces": pieces})], tmp_path / "r.html")
    text, _ = markup(f"{target.as_uri()}#t=5", tmp_path)
    shown = [float(value.replace("\N{MINUS SIGN}", "-")) for value in re.findall(r"<output><span[^>]*>([^ <]+) ", text)]
    assert shown[:3] == pytest.approx([0.5 + 0.2 * 3 - 0.06 * 9 / 2, 0.2 - 0.06 * 3, -0.06], abs=0.006)
    assert re.search(r"<b>5.00</b> / 6.00 s", text)
    assert text.count('class="turn"') == 1


def test_what_is_only_forbidden_is_drawn_apart_from_walls(tmp_path: Path) -> None:
    cells = np.zeros((6, 8), dtype=np.uint8)
    cells[2, 1:4] = scenery.BLOCKED
    rule = np.zeros((6, 8), dtype=bool)
    rule[2:4, 3:6] = True
    world = gw.World(cells, resolution=0.5).forbidding(cells=rule)
    expected = np.where(cells == scenery.BLOCKED, scenery.BLOCKED, np.where(rule, scenery.FORBIDDEN, scenery.FREE))
    assert np.array_equal(decoded(scenery.picture(world)["walls"]), expected)
    assert np.array_equal(decoded(scenery.picture(scenery.Snapshot.of(world))["walls"]), expected)
    pixels = figure_module.map_pixels(world, 100, plain=True)
    assert (pixels[rule & (cells == 0)] == scenery.OFF_LIMITS).all()
    assert (pixels[cells == 1] == figure_module.WALL).all()
    halls = gw.World(bounds=(0, 0, 6, 4), resolution=0.1, shapes=[{"disc": {"center": [2, 2], "radius": 0.5}}])
    shapes = scenery.picture(halls.forbidding(shapes=[{"disc": {"center": [4, 2], "radius": 0.5}}]))["shapes"]
    assert [(shape["disc"]["center"], shape.get("forbidden", False)) for shape in shapes] == [([2.0, 2.0], False), ([4.0, 2.0], True)]
    assert not any("forbidden" in shape for shape in scenery.picture(halls)["shapes"])
