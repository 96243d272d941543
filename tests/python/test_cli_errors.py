"""Bad input on the command line: one short paragraph that names the thing, exit status 2 (3 where the input is fine but there is no result)."""

import os

import pytest

from guideway.cli import main

MAP = "type octile\nheight 3\nwidth 4\nmap\n....\n.@..\n....\n"
SCENE = """[world]
bounds = [0, 0, 10, 6]
[[disc]]
center = [5, 3]
radius = 1.0
[robot]
footprint = { disc = 0.2 }
[query]
start = [1, 3]
goal = [9, 3]
"""
PLAN = ["plan", "a.map", "--start", "0.5,0.5", "--goal", "3.5,2.5"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.map").write_text(MAP)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "empty.yaml").write_text("")
    (tmp_path / "junk.yaml").write_bytes(bytes(range(256)))
    (tmp_path / "lost.yaml").write_text(
        "image: nowhere.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    (tmp_path / "noquery.toml").write_text(SCENE[: SCENE.index("[query]")])
    (tmp_path / "badfield.toml").write_text(SCENE.replace("radius = 1.0", "radius = -1.0"))
    (tmp_path / "unknownkey.toml").write_text(SCENE.replace("radius", "raduis"))
    (tmp_path / "nan.toml").write_text(SCENE.replace("[1, 3]", "[nan, 3]"))
    (tmp_path / "half.toml").write_text(SCENE[:-20])
    (tmp_path / "short.map").write_text(MAP[:-8])
    (tmp_path / "huge.map").write_text("type octile\nheight 999999999\nwidth 999999999\nmap\n....\n")
    (tmp_path / "bad.scen").write_text("version 1\n0 a.map 4 3 0 0 x 2 3.0\n")
    (tmp_path / "notplan.json").write_text("{}")
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "scene.json").write_text("[1, 2]")
    (tmp_path / "plan.txt").write_text("..#\n.?.\n")


BAD = [
    ([], None),
    (["fly"], "fly"),
    (["plan"], "MAP"),
    (["plan", "nowhere.yaml", "--start", "0,0", "--goal", "1,1"], "nowhere.yaml"),
    (["plan", ".", "--start", "0,0", "--goal", "1,1"], "."),
    (["plan", "a.png", "--start", "0,0", "--goal", "1,1"], "a.png"),
    (["plan", "empty.yaml", "--start", "0,0", "--goal", "1,1"], "empty.yaml"),
    (["plan", "junk.yaml", "--start", "0,0", "--goal", "1,1"], "junk.yaml"),
    (["plan", "lost.yaml", "--start", "0,0", "--goal", "1,1"], "nowhere.pgm"),
    (["plan", "short.map", "--start", "0,0", "--goal", "1,1"], "short.map"),
    (["plan", "huge.map", "--start", "0,0", "--goal", "1,1"], "huge.map"),
    (["plan", "plan.txt", "--start", "0,0", "--goal", "1,1"], "plan.txt"),
    (["plan", "a.map", "--goal", "1,1"], "start"),
    (["plan", "a.map", "--start", "0.5,0.5"], "goal"),
    (["plan", "a.map", "--start", "0.5", "--goal", "1,1"], "--start"),
    (["plan", "a.map", "--start", "0.5,abc", "--goal", "1,1"], "abc"),
    (["plan", "a.map", "--start", "nan,0", "--goal", "1,1"], "--start"),
    (["plan", "a.map", "--start", "-5,-5", "--goal", "1,1"], "outside"),
    (["plan", "a.map", "--start-cell", "9,9", "--goal", "1,1"], "columns 0 to 3"),
    (["plan", "a.map", "--start-cell", "1.5,2", "--goal", "1,1"], "COL,ROW"),
    ([*PLAN, "--start-cell", "1,1"], "--start-cell"),
    ([*PLAN, "--planner", "teleport"], "teleport"),
    ([*PLAN, "--set", "speed"], "key=value"),
    ([*PLAN, "--set", "warp=9"], "warp"),
    ([*PLAN, "--footprint", "disc:-1"], "disc"),
    ([*PLAN, "--footprint", "disc:x"], "disc:R"),
    ([*PLAN, "--footprint", "blob:1"], "blob"),
    ([*PLAN, "--footprint", "polygon:0,0;1,0"], "corners"),
    ([*PLAN, "--footprint", "polygon:1,1;2,1;2,2;1,2"], "reference point"),
    ([*PLAN, "--clearance", "-1"], "clearance"),
    ([*PLAN, "--clearance", "nan"], "clearance"),
    ([*PLAN, "--corners", "round"], "round"),
    ([*PLAN, "--material", "feather"], "feather"),
    ([*PLAN, "--refine", "polish"], "polish"),
    ([*PLAN, "--speed", "0"], "--speed"),
    ([*PLAN, "--jerk", "inf"], "--jerk"),
    ([*PLAN, "--seconds", "-1"], "seconds"),
    ([*PLAN, "--iterations", "-3"], "--iterations"),
    ([*PLAN, "--seed", "-1"], "--seed"),
    ([*PLAN, "--via", "1"], "--via"),
    ([*PLAN, "--via", "77,1"], "outside"),
    ([*PLAN, "--max-curvature", "0"], "--max-curvature"),
    ([*PLAN, "--out", "nowhere/plan.json"], "nowhere"),
    ([*PLAN, "--csv", "x.csv", "--no-timing"], "--no-timing"),
    ([*PLAN, "--frobnicate"], "--frobnicate"),
    ([*PLAN, "--out", "a.map"], "an input"),
    ([*PLAN, "--out", "same", "--csv", "same"], "another result"),
    (["plan", "--list", "teleport"], "teleport"),
    (["plan", "a.map", "--scen", "bad.scen"], "bad.scen"),
    (["plan", "a.map", "--scen", "nowhere.scen"], "nowhere.scen"),
    (["plan", "noquery.toml"], "start"),
    (["plan", "badfield.toml"], "radius"),
    (["plan", "unknownkey.toml"], "raduis"),
    (["plan", "nan.toml"], "start"),
    (["plan", "half.toml"], "half.toml"),
    (["drive", "nowhere.json"], "nowhere.json"),
    (["drive", "notplan.json"], "notplan.json"),
    (["drive", "broken.json"], "broken.json"),
    (["drive", "scene.toml", "--controller", "autopilot"], "autopilot"),
    (["drive", "scene.toml", "--movers", "nowhere.toml"], "nowhere.toml"),
    (["drive", "scene.toml", "--time-limit", "-1"], "--time-limit"),
    (["drive", "scene.toml", "--sense", "sonar"], "sonar"),
    (["drive", "scene.toml", "--worlds", "worlds.json"], "--worlds"),
    (["drive", "scene.toml", "--set", "jerk_limited=perhaps"], "jerk_limited"),
    (["maps", "info", "nowhere.map"], "nowhere.map"),
    (["maps", "convert", "a.map", "a.doc"], "a.doc"),
    (["maps", "view", "a.map", "--out", "a.jpeg"], ".png"),
    (["view", "scene.json", "--out", "r.html"], "scene.json"),
    (["view", "nowhere.json", "--out", "r.html"], "nowhere.json"),
]


@pytest.mark.parametrize(("words", "named"), BAD, ids=lambda value: " ".join(value) if isinstance(value, list) else None)
def test_bad_input(words, named, capsys):
    assert main(words) == 2
    out, err = capsys.readouterr()
    if named is None:
        return
    assert named in " ".join(err.split())
    assert "Traceback" not in err
    assert "\n\n" not in err.strip(), "one paragraph"
    assert 20 < len(err) < 900
    assert not out


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["plan", "a.map", "--start", "1.5,1.5", "--goal", "3.5,2.5"], "start"),
        (["plan", "a.map", "--start", "0.5,0.5", "--goal", "1.5,1.5"], "goal"),
        ([*PLAN, "--footprint", "disc:0.9"], "blocked"),
        (["plan", "wall.txt", "--start", "0.5,0.5", "--goal", "4.5,0.5"], "proved"),
    ],
)
def test_no_result(words, named, capsys, tmp_path):
    (tmp_path / "wall.txt").write_text("..#..\n..#..\n..#..\n")
    assert main(words) == 3
    out, err = capsys.readouterr()
    assert named in " ".join(err.split())
    assert not out


def test_nothing_is_half_written(tmp_path, capsys):
    assert main([*PLAN, "--planner", "teleport", "--out", "plan.json", "--report", "plan.html"]) == 2
    assert not [path for path in tmp_path.iterdir() if path.name in ("plan.json", "plan.html") or path.name.endswith(".part")]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
@pytest.mark.parametrize("option", ["--out", "--report", "--csv"])
def test_a_full_disk_is_said_plainly(option, capsys):
    assert main([*PLAN, option, "/dev/full"]) == 2
    err = " ".join(capsys.readouterr().err.split())
    assert "no space left" in err.lower()
    assert "internal error" not in err
