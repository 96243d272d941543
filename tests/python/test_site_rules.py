"""Keep-out and speed masks, changed worlds, and the order of via points."""

import itertools
import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from PIL import Image

import guideway as gw
from guideway.cli import main
from guideway.errors import BadParameter
from guideway.plants.movers import position


def mask(folder: Path, name: str, grey: np.ndarray, resolution: float, origin=(0, 0, 0), mode="trinary") -> Path:
    Image.fromarray(grey.astype(np.uint8)).save(folder / f"{name}.pgm")
    thresholds = (1.0, 0.0) if mode == "scale" else (0.65, 0.25)
    text = f"image: {name}.pgm\nmode: {mode}\nresolution: {resolution}\norigin: {list(origin)}\nnegate: 0\n"
    path = folder / f"{name}.yaml"
    path.write_text(text + f"occupied_thresh: {thresholds[0]}\nfree_thresh: {thresholds[1]}\n")
    return path


def forbidden(height, width, rows, columns):
    grey = np.full((height, width), 255)
    grey[rows, columns] = 0
    return grey


def test_a_mask_of_another_resolution_blocks_every_cell_it_touches(tmp_path):
    world = gw.World(np.zeros((40, 60), bool), 0.1, (1.0, 2.0, 0.0))
    path = mask(tmp_path, "keep", forbidden(30, 40, slice(10, 12), slice(5, 8)), 0.15, (1.0, 2.0, 0.0))
    kept = world.with_keep_out(path)
    blocked = kept.occupancy() == 1
    # columns 5 to 7 of 0.15 m: 0.75 to 1.2 m, cells 7 to 11; rows 18, 19 from below: 2.7 to 3.0 m, cells 27 to 29
    expected = np.zeros((40, 60), bool)
    expected[40 - 30 : 40 - 27, 7:12] = True
    assert (blocked == expected).all()
    again = world.with_keep_out(np.roll(expected, 3))
    assert (again.occupancy() == 1).sum() == expected.sum()


def test_worlds_of_shapes_take_masks_as_rectangles(tmp_path):
    world = gw.World(bounds=(0, 0, 6, 4), resolution=0.1)
    path = mask(tmp_path, "keep", forbidden(40, 60, slice(0, 30), slice(28, 32)), 0.1)
    kept = world.with_keep_out(path)
    assert len(kept.shapes) == 1
    query = gw.Query(kept, (1, 3), (5, 3), footprint={"disc": 0.2})
    assert gw.plan(query).length > 4.5 > gw.plan(gw.Query(world, (1, 3), (5, 3))).length


def test_speeds_are_percent_of_the_top_speed_as_nav2_has_them(tmp_path):
    grey = np.full((20, 30), 255)
    grey[:, 10:20] = 127  # value 50
    path = mask(tmp_path, "slow", grey, 0.2, mode="scale")
    speeds = gw.SpeedMap.load(path, 2.0)
    assert speeds.at(1.0, 1.0) == np.inf
    assert abs(speeds.at(3.0, 1.0) - 1.0) < 0.021
    assert speeds.at(-1, -1) == np.inf
    assert abs(gw.SpeedMap.load(path, 2.0, base=0.0, multiplier=1.0).at(3.0, 1.0) - 1.0) < 0.021
    assert abs(gw.SpeedMap.load(path, 2.0, base=0.0, multiplier=0.01, absolute=True).at(3.0, 1.0) - 0.5) < 0.011
    grey[0, 0] = 0  # value 100: 0 percent, which is Nav2's word for no limit
    assert gw.SpeedMap.load(mask(tmp_path, "wall", grey, 0.2, mode="scale"), 2.0).at(0.1, 3.9) == np.inf
    assert gw.SpeedMap.load(path, 2.0, base=0.0, multiplier=5.0).at(3.0, 1.0) == np.inf, "more than 100 percent"
    for options in ({"base": math.nan}, {"multiplier": math.inf}):
        with pytest.raises(BadParameter, match="finite"):
            gw.SpeedMap.load(path, 2.0, **options)
    with pytest.raises(BadParameter, match="speed"):
        gw.SpeedMap.load(path, math.nan)
    for bad in (np.zeros((2, 2)), np.full((2, 2), np.nan), np.ones(3)):
        with pytest.raises(BadParameter):
            gw.SpeedMap(bad)


def test_plan_and_drive_keep_to_the_masks(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mask(tmp_path, "hall", np.full((60, 100), 255), 0.1)
    mask(tmp_path, "keep", forbidden(60, 100, slice(20, 60), slice(45, 50)), 0.1)
    grey = np.full((60, 100), 255)
    grey[:, 60:80] = 76  # value 70: 30 percent
    mask(tmp_path, "slow", grey, 0.1, mode="scale")
    site = ["--keep-out", "keep.yaml", "--speed-mask", "slow.yaml"]
    ends = ["--start", "1,1", "--goal", "9,1", "--footprint", "disc:0.25", "--clearance", "0.05"]
    assert main(["plan", "hall.yaml", *ends, *site, "--out", "plan.json"]) == 0
    plan = json.loads((tmp_path / "plan.json").read_text())
    speeds = gw.SpeedMap.load("slow.yaml", 1.0)
    checks = {check["name"]: check for check in plan["certificate"]["checks"]}
    assert checks["speed zones"]["ok"]
    assert plan["metrics"]["length"] > 10
    assert plan["speed_mask"]["source"] == "slow.yaml"
    assert plan["world"]["keep_out"][0]["source"] == "keep.yaml"
    jsonschema.validate(plan, gw.schemas.load("plan"))
    code = main(["drive", "plan.json", "--controller", "tracker", "--out", "run.json", "--report", "run.html"])
    run = json.loads((tmp_path / "run.json").read_text())
    assert code == 0
    assert run["outcome"] == "arrived"
    assert run["trace"]["plans"][0]["reason"] == "start"
    jsonschema.validate(run, gw.schemas.load("run"))
    over = max(v - speeds.at(x, y) for _, x, y, _, v, _ in run["driven"])
    assert over < 0.03
    assert max(row[4] for row in run["driven"]) > 0.7
    assert not any(4.5 < x < 5.0 and y < 4.2 for _, x, y, *_ in run["driven"])
    (tmp_path / "keep.pgm").write_bytes((tmp_path / "hall.pgm").read_bytes())
    assert main(["drive", "plan.json"]) == 2
    assert "sha256" in capsys.readouterr().err


def test_scenes_name_masks_and_the_order(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mask(tmp_path, "keep", forbidden(40, 60, slice(0, 30), slice(28, 32)), 0.1)
    (tmp_path / "room.toml").write_text(
        '[world]\nbounds = [0, 0, 6, 4]\nkeep_out = ["keep.yaml"]\n'
        '[query]\nstart = [1, 3]\ngoal = [5, 3.5]\nvia = [[5, 1], [1, 1], [3, 0.5]]\norder = "best"\n[robot]\nfootprint = { disc = 0.2 }\n'
    )
    assert main(["plan", "room.toml", "--out", "plan.json"]) == 0
    plan = json.loads((tmp_path / "plan.json").read_text())
    assert plan["tour"]["order"] == [1, 2, 0]
    assert plan["query"]["via"] == [[1, 1], [3, 0.5], [5, 1]]
    assert main(["plan", "room.toml", "--order", "given", "--out", "given.json"]) == 0
    given = json.loads((tmp_path / "given.json").read_text())
    assert "tour" not in given
    assert given["search"]["raw_length"] > plan["search"]["raw_length"] + 1
    (tmp_path / "bad.toml").write_text('[world]\nbounds = [0, 0, 6, 4]\nkeep_out = ["none.yaml"]\n')
    assert main(["plan", "bad.toml", "--start", "1,1", "--goal", "2,2"]) == 2


def test_the_tour_is_the_shortest_of_all_orders():
    world = gw.World(bounds=(0, 0, 10, 8), shapes=[{"polygon": {"points": [[4, 0], [4.5, 0], [4.5, 6], [4, 6]]}}])
    via = [(2, 6), (8, 1), (2, 1), (8, 6)]
    ends = {"start": (1, 4), "goal": (9, 4), "footprint": {"disc": 0.3}}
    found = gw.tour(gw.Query(world, **ends, via=via))
    lengths = {order: gw.plan(gw.Query(world, **ends, via=[via[i] for i in order])).length for order in itertools.permutations(range(4))}
    assert abs(found["length"] - min(lengths.values())) < 1e-6
    assert abs(lengths[tuple(found["order"])] - found["length"]) < 1e-6
    assert found["bound"] == found["length"]
    assert np.allclose(found["costs"], np.transpose(found["costs"]))


def test_a_part_of_a_world_changes():
    rng = np.random.default_rng(1)
    blocked = rng.random((50, 70)) < 0.1
    world = gw.World(blocked, 0.1)
    world.clearance_field()
    part = rng.random((10, 20)) < 0.5
    changed = world.updated(part, row=30, column=15)
    blocked[30:40, 15:35] = part
    new = gw.World(blocked, 0.1)
    assert (changed.occupancy() == new.occupancy()).all()
    assert (changed.clearance_field() == new.clearance_field()).all()
    for row, column in ((45, 0), (0, 60)):
        with pytest.raises(BadParameter):
            world.updated(part, row=row, column=column)


@pytest.mark.parametrize(("mode", "value"), [("trinary", 0), ("scale", 50), ("raw", 50)])
def test_modes_of_a_mask_are_those_of_the_map_server(tmp_path, mode, value):
    grey = np.full((4, 4), 50 if mode == "raw" else 127)
    grey[0] = 0 if mode == "raw" else 255
    path = mask(tmp_path, "slow", grey, 1.0, mode=mode)
    if mode == "trinary":  # grey is unknown, or free, but never a share
        assert gw.SpeedMap.load(path, 2.0).at(1.5, 0.5) == np.inf
    else:
        assert abs(gw.SpeedMap.load(path, 2.0).at(1.5, 0.5) - 2.0 * (100 - value) / 100) < 0.021
    assert gw.SpeedMap.load(path, 2.0).at(1.5, 3.5) == np.inf


@pytest.mark.parametrize("name", ["depot", "warehouse"])
def test_masks_of_nav2_are_kept_to(data, name):
    folder = data / "ros_maps/nav2"
    world = gw.World.load(folder / f"{name}.yaml")
    kept = world.with_keep_out(folder / f"{name}_keepout.yaml")
    free = world.occupancy() == 0
    more = (kept.occupancy() != 0) & free
    grey = np.asarray(Image.open(folder / f"{name}_keepout.pgm"))
    assert np.array_equal(more, (grey == 0) & free)
    assert more.sum() > 1000
    speeds = gw.SpeedMap.load(folder / f"{name}_speed.yaml", 1.0)
    grey = np.asarray(Image.open(folder / f"{name}_speed.pgm"))
    shade = 127 if name == "depot" else 204
    row, column = (int(i) for i in np.argwhere(grey == shade)[len(np.argwhere(grey == shade)) // 2])
    x, y = world.cell_centers([[column, row]])[0]
    assert speeds.at(x, y) == pytest.approx(1 - round(100 * (255 - shade) / 255) / 100, abs=0.011)
    row, column = (int(i) for i in np.argwhere(grey == 254)[0])
    assert speeds.at(*world.cell_centers([[column, row]])[0]) == np.inf


def test_a_motion_keeps_to_a_speed_mask_and_to_movers_at_once(tmp_path):
    grey = np.full((60, 100), 255)
    grey[:, 40:60] = 76  # 30 percent from x = 4 m to 6 m
    speeds = gw.SpeedMap.load(mask(tmp_path, "slow", grey, 0.1, mode="scale"), 1.0)
    crossing = {"shape": {"disc": 0.3}, "track": [[0.0, 5.0, 0.5], [14.0, 5.0, 5.5]], "loop": "once", "phase": 0.0}
    query = gw.Query(gw.World(bounds=(0, 0, 10, 6), movers=[crossing]), (1, 3), (9, 3), footprint=gw.Disc(0.25), clearance=0.1)
    path, limits = gw.plan(query).path, gw.Limits(1.0, 1.0, jerk=4.0)
    motion = gw.time(path, limits, among=query, speed_map=speeds)
    certificate = gw.certify(path, query, motion, speed_map=speeds)
    assert certificate["ok"]
    checks = {check["name"]: check["ok"] for check in certificate["checks"]}
    assert checks["speed zones"]
    for t in np.linspace(0, motion.duration, 2000):
        state = motion.at(t)
        x, y = state["pose"][:2]
        assert state["speed"] <= speeds.at(x, y) + 1e-6
        share = min(t / 14.0, 1.0)
        assert math.hypot(x - 5.0, y - 0.5 - 5.0 * share) > 0.3 + 0.25 + 0.1 - 1e-6


def test_a_motion_of_aide_is_timed_anew_under_a_speed_mask(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    grey = np.full((60, 100), 255)
    grey[:, 30:50] = 76
    mask(tmp_path, "slow", grey, 0.1, mode="scale")
    words = ["plan", "scene:w0", "--planner", "aide", "--evaluations", "2000", "--speed-mask", "slow.yaml", "--out", "plan.json"]
    assert main(words) == 0
    plan = json.loads((tmp_path / "plan.json").read_text())
    checks = {check["name"]: check for check in plan["certificate"]["checks"]}
    assert plan["certificate"]["ok"]
    assert checks["speed zones"]["ok"]
    assert main([*words[:6], "--out", "free.json"]) == 0
    free = json.loads((tmp_path / "free.json").read_text())
    assert "speed zones" not in {check["name"] for check in free["certificate"]["checks"]}
    assert free["trace"]["speed"]["movers"]["timed"]
    told = plan["trace"]["speed"]["movers"]
    assert told["timed"]
    assert told["delay"] != free["trace"]["speed"]["movers"]["delay"], "it is that of this motion"
    # The motion under the mask keeps off the movers, as the one without does: looked up in the movers' own tracks.
    world = gw.scenes.load("w0").query("dynamic").world
    path = gw.Path(plan["path"]["degree"], plan["path"]["knots"], plan["path"]["control_points"])
    motion = gw.Trajectory(path, gw.Limits(**plan["trajectory"]["limits"]), plan["trajectory"]["pieces"])
    for t in np.linspace(0, motion.duration, 3000):
        x, y = motion.at(t)["pose"][:2]
        for mover in world.movers:
            mx, my = position(mover, t)
            half = [0.5 * side for side in mover["shape"]["box"]]
            assert math.hypot(max(abs(x - mx) - half[0], 0), max(abs(y - my) - half[1], 0)) > 0.3 - 1e-6


def test_what_is_forbidden_is_no_wall(tmp_path):
    walls = np.zeros((40, 60), bool)
    walls[0] = True
    band = np.zeros_like(walls)
    band[10:, 28:32] = True
    kept = gw.World(walls, 0.1).with_keep_out(band)
    assert kept.clearance([(3.0, 1.0)])[0] < 0 < kept.solid.clearance([(3.0, 1.0)])[0]
    assert (kept.solid.occupancy() == walls).all()
    assert (kept.emptied().occupancy() == band).all()
    assert (gw.driving.unseen(kept).occupancy() == band).all(), "site rules hold without a map"
    assert (kept.emptied().solid.occupancy() == np.zeros_like(walls)).all()
    with pytest.raises(BadParameter, match="forbidden"):
        gw.World(walls, 0.1).forbidding(band[1:])
    shaped = gw.World(bounds=(0, 0, 6, 4), resolution=0.1).forbidding(shapes=[{"disc": {"center": [3, 2], "radius": 0.5}}])
    assert shaped.shapes
    assert not shaped.solid.shapes


def test_a_simulated_room_has_no_walls_where_it_is_only_forbidden():
    from xml.etree.ElementTree import Element

    from guideway.plants import room

    def walls(world):
        root = Element("mujoco")
        room.furnish(root, world)
        return len(list(root.iter("geom")))

    plain = gw.World(bounds=(0, 0, 6, 4), resolution=0.1)
    assert walls(plain.forbidding(shapes=[{"disc": {"center": [3, 2], "radius": 0.5}}])) == walls(plain)


def test_masks_are_clipped_to_the_bounds_of_shapes_and_cells_merged(tmp_path):
    grey = np.full((200, 200), 0)
    grey[::7, ::7] = 255  # holes
    path = mask(tmp_path, "keep", grey, 0.1)
    kept = gw.World(bounds=(0.0, 0.0, 2.0, 1.5), resolution=0.05).with_keep_out(path)
    assert len(kept.shapes) < 30
    for x in np.arange(0.05, 2.0, 0.1):
        for y in np.arange(0.05, 1.5, 0.1):
            inside = grey[199 - int(y / 0.1), int(x / 0.1)] == 0
            assert (kept.clearance([(x, y)])[0] < 0) == inside
    assert all(point[0] < 2.11 and point[1] < 1.61 for shape in kept.shapes for point in shape["polygon"]["points"])


def test_a_plan_refuses_masks_that_it_was_not_made_with(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mask(tmp_path, "hall", np.full((40, 60), 255), 0.1)
    for name, columns in (("slow", slice(20, 30)), ("other", slice(40, 50))):
        grey = np.full((40, 60), 255)
        grey[:, columns] = 76
        mask(tmp_path, name, grey, 0.1, mode="scale")
    mask(tmp_path, "keep", forbidden(40, 60, slice(20, 40), slice(28, 32)), 0.1)
    ends = ["--start", "1,1", "--goal", "5,1", "--footprint", "disc:0.2"]
    assert main(["plan", "hall.yaml", *ends, "--speed-mask", "slow.yaml", "--keep-out", "keep.yaml", "--out", "plan.json"]) == 0
    assert main(["plan", "hall.yaml", *ends, "--out", "plain.json"]) == 0
    for words in (
        ["plan.json", "--speed-mask", "other.yaml"],
        ["plain.json", "--keep-out", "keep.yaml"],
        ["plain.json", "--speed-mask", "slow.yaml"],
    ):
        capsys.readouterr()
        assert main(["drive", *words]) == 2
        assert f"{words[1]} '{words[2]}' is not a mask" in capsys.readouterr().err
    same = ["--speed-mask", "slow.yaml", "--keep-out", "keep.yaml"]
    assert main(["drive", "plan.json", *same, "--controller", "tracker", "--out", "run.json"]) == 0
    assert json.loads((tmp_path / "run.json").read_text())["forbidden"] == 0.0
