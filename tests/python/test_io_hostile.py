"""Bad and hostile input: every kind ends in one paragraph that names the file and the field, before memory or time is taken."""

from __future__ import annotations

import gzip
import io
import json
import os
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import guideway.io as gio
from guideway.errors import BadFile
from guideway.io.files import MAX_BYTES

GOOD_YAML = "image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
GOOD_PGM = b"P5\n2 2\n255\n\xfe\xfe\x00\xfe"
GOOD_SCENE = "[world]\nbounds = [0, 0, 10, 6]\n"
MOVER = "[[mover]]\nshape = { disc = 0.3 }\n"

Files = dict[str, bytes | str]
Case = tuple[str, Files, tuple[str, ...]]


def yaml(change: str, value: str | None, image: bytes | None = GOOD_PGM) -> Files:
    """A map whose YAML has one field changed (None: left out)."""
    lines = [line for line in GOOD_YAML.splitlines() if not line.startswith(f"{change}:")]
    files: Files = {"m.yaml": "\n".join([*lines, *([] if value is None else [f"{change}: {value}"])])}
    return files | ({} if image is None else {"m.pgm": image})


def image(data: bytes) -> Files:
    return {"m.yaml": GOOD_YAML, "m.pgm": data}


def scene(text: str) -> Files:
    return {"s.toml": GOOD_SCENE + text}


def png_header(width: int, height: int, depth: int = 8, color: int = 0) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, depth, color, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0" * 64)) + chunk(b"IEND", b"")


def saved(kind: str, cut: int) -> bytes:
    out = io.BytesIO()
    Image.fromarray(np.random.default_rng(1).integers(0, 255, (40, 40), np.uint8)).save(out, kind)
    return out.getvalue()[:cut]


def bmp_header(width: int, height: int, packing: int = 0) -> bytes:
    info = struct.pack("<IiiHHIIiiII", 40, width, height, 1, 8, packing, 0, 0, 0, 0, 0)
    return b"BM" + struct.pack("<IHHI", 100, 0, 0, 54) + info + b"\0" * 40


YAML_CASES: list[Case] = [
    ("m.yaml", yaml("resolution", "-1"), ("m.yaml", "field resolution", "'-1'", "1e-06 to 1e+06 m")),
    ("m.yaml", yaml("resolution", "0"), ("field resolution",)),
    ("m.yaml", yaml("resolution", ".nan"), ("field resolution", ".nan")),
    ("m.yaml", yaml("resolution", ".inf"), ("field resolution",)),
    ("m.yaml", yaml("resolution", "1" * 5000), ("field resolution",)),
    ("m.yaml", yaml("resolution", "[0.05]"), ("field resolution",)),
    ("m.yaml", yaml("resolution", None), ("field resolution", "missing")),
    ("m.yaml", yaml("image", None), ("field image", "missing")),
    ("m.yaml", yaml("image", "''"), ("field image",)),
    ("m.yaml", yaml("image", "none.pgm"), ("m.yaml, field image", "none.pgm does not exist")),
    ("m.yaml", yaml("image", "."), ("a folder",)),
    ("m.yaml", yaml("image", '"a\\0b"'), ("field image",)),
    ("m.yaml", yaml("origin", "[0, 0]"), ("field origin", "[x, y, yaw]")),
    ("m.yaml", yaml("origin", "[0, 0, nan]"), ("field origin",)),
    ("m.yaml", yaml("origin", "[0, 0, 1e400]"), ("field origin",)),
    ("m.yaml", yaml("origin", "[0, [0], 0]"), ("field origin",)),
    ("m.yaml", yaml("origin", None), ("field origin", "missing")),
    ("m.yaml", yaml("occupied_thresh", "65"), ("field occupied_thresh", "0 to 1")),
    ("m.yaml", yaml("free_thresh", "0.9"), ("field free_thresh", "at most occupied_thresh (0.65)")),
    ("m.yaml", yaml("negate", "maybe"), ("field negate", "0 or 1")),
    ("m.yaml", yaml("mode", "binary"), ("field mode", "trinary, scale or raw")),
    ("m.yaml", yaml("mode", "raw\nresolution: 1"), ("m.yaml, line 8, field 'resolution'", "given twice")),
    ("m.yaml", {"m.yaml": "- a\n- b\n"}, ("m.yaml, line 1", "not a map")),
    ("m.yaml", {"m.yaml": "just words"}, ("m.yaml, line 1", "not a map")),
    ("m.yaml", {"m.yaml": "a: [1, 2\nb: {"}, ("m.yaml, line", "not valid YAML")),
    ("m.yaml", {"m.yaml": "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n"}, ("line 1", "aliases")),
    ("m.yaml", {"m.yaml": "a: " + "[" * 50_000}, ("m.yaml", "nested too deeply")),
    ("m.yaml", {"m.yaml": "a: [" + "1," * 50_000 + "1]"}, ("m.yaml", "too long")),
    ("m.yaml", {"m.yaml": "a:\n" + " b: 1\n" * (1 << 18)}, ("m.yaml", "1048576 bytes")),
    ("m.yaml", {"m.yaml": "? [a]\n: 1\n"}, ("m.yaml, line 1", "not plain text")),
    ("m.yaml", {"m.yaml": b"image: \xff\xfe\n"}, ("m.yaml", "not text", "UTF-8")),
    ("m.yaml", {"m.yaml": b"\0\1\2\3"}, ("m.yaml", "YAML")),
    ("m.yaml", {"m.yaml": b""}, ("m.yaml", "empty")),
    ("none.yaml", {}, ("none.yaml", "no such file")),
    ("m.pgm", {"m.pgm": GOOD_PGM}, ("m.pgm", "not a kind of map", "YAML file that describes this image")),
    ("m.xyz", {"m.xyz": "a"}, ("m.xyz", ".xyz", "*.yaml")),
]
IMAGE_CASES: list[Case] = [
    ("m.yaml", image(b"P5\n1000000000 1000000000\n255\n"), ("m.pgm", "1000000000 x 1000000000", "268435456 cells")),
    ("m.yaml", image(b"P5\n" + b"9" * 5000 + b" 2\n255\n"), ("m.pgm", "more than 18 digits")),
    ("m.yaml", image(b"P5\n-2 2\n255\n...."), ("m.pgm", "header")),
    ("m.yaml", image(b"P5\n0 2\n255\n"), ("m.pgm", "0 x 2")),
    ("m.yaml", image(b"P5\n2 2\n0\n...."), ("m.pgm", "maximum value is 0")),
    ("m.yaml", image(b"P5\n2 2\n65536\n........"), ("m.pgm", "65536", "1 to 65535")),
    ("m.yaml", image(b"P5\n2 2\n"), ("m.pgm", "header")),
    ("m.yaml", image(b"P5\n#" + b"x" * 100_000 + b"\n2 2\n255\n...."), ("m.pgm", "header")),
    ("m.yaml", image(b"P5\n2 2\n255\n..."), ("m.pgm", "cut off: 3 bytes", "4 bytes")),
    ("m.yaml", image(b"P5\n2 2\n100\n\x65..."), ("m.pgm", "value 101", "0 to 100")),
    ("m.yaml", image(b"P2\n2 2\n255\n1 2 3"), ("m.pgm", "cut off")),
    ("m.yaml", image(b"P2\n2 2\n255\n1 2 3 x"), ("m.pgm", "whole numbers")),
    ("m.yaml", image(b"P2\n2 2\n255\n1 2 3 256"), ("m.pgm", "value 256")),
    ("m.yaml", image(b"P2\n2 2\n255\n1 2 3 -1"), ("m.pgm", "whole numbers")),
    ("m.yaml", image(b"P2\n2 2\n255\n1 2 3 4294967297"), ("m.pgm", "at most 9 digits")),
    ("m.yaml", image(b"P2\n2 2\n255\n1 2      3"), ("m.pgm", "there are 3 pixels", "4 pixels")),
    ("m.yaml", image(b"P2\n16000 16000\n255\n1 2 3"), ("m.pgm", "cut off")),
    ("m.yaml", image(b"P6\n16000 16000\n65535\n"), ("m.pgm", "promises")),
    ("m.yaml", image(b"P4\n2 2\n...."), ("m.pgm", "known kind", "PNG")),
    ("m.yaml", image(b"GIF89a"), ("m.pgm", "known kind")),
    ("m.yaml", image(png_header(2_000_000_000, 2_000_000_000)), ("m.pgm", "2000000000 x 2000000000")),
    ("m.yaml", image(png_header(16384, 16384)), ("m.pgm", "cannot hold")),
    ("m.yaml", image(png_header(300, 300)), ("m.pgm", "PNG")),
    ("m.yaml", image(png_header(4, 4, 8, 9)), ("m.pgm",)),
    ("m.yaml", image(b"\x89PNG\r\n\x1a\n" + b"\0" * 9), ("m.pgm", "PNG header")),
    ("m.yaml", image(saved("PNG", 500)), ("m.pgm", "PNG")),
    ("m.yaml", image(bmp_header(16384, 16384)), ("m.pgm", "cannot hold")),
    ("m.yaml", image(bmp_header(-4, 4)), ("m.pgm", "-4 x 4")),
    ("m.yaml", image(bmp_header(4, 4, 77)), ("m.pgm", "BMP")),
    ("m.yaml", image(b"BM" + b"\1" * 100), ("m.pgm", "BMP header")),
    ("m.yaml", image(b"BM"), ("m.pgm", "BMP header")),
    ("m.yaml", image(saved("BMP", 900)), ("m.pgm", "cannot hold")),
    ("m.yaml", yaml("image", "m.pgm", None) | {"m.pgm.gz": gzip.compress(GOOD_PGM)[:-12]}, ("m.pgm.gz", "cut off")),
    ("m.yaml", yaml("image", "m.pgm", None) | {"m.pgm.gz": b"\x1f\x8b\x08\x00junkjunkjunkjunk"}, ("m.pgm.gz", "damaged")),
    ("m.yaml", image(b""), ("m.pgm", "empty")),
]
GRID_CASES: list[Case] = [
    ("m.map", {"m.map": "type octile\nheight 99999999999\nwidth 9\nmap\n"}, ("m.map, line 2, field height", "99999999999")),
    ("m.map", {"m.map": "type octile\nheight 1000000\nwidth 1000000\nmap\n"}, ("m.map", "1000000 x 1000000")),
    ("m.map", {"m.map": "type octile\nheight x\nwidth 1\nmap\n."}, ("m.map, line 2, field height", "'x'")),
    ("m.map", {"m.map": "type octile\nheight -1\nwidth 1\nmap\n."}, ("field height",)),
    ("m.map", {"m.map": "type hexagon\nheight 1\nwidth 1\nmap\n."}, ("m.map, line 1", "hexagon", "octile")),
    ("m.map", {"m.map": "type octile\nheight 1\nmap\n."}, ("m.map", "header is incomplete")),
    ("m.map", {"m.map": "type octile\nheight 1\ndepth 1\nmap\n."}, ("m.map, line 3", "depth 1")),
    ("m.map", {"m.map": "type octile\nheight 2\nwidth 3\nmap\n...\n..\n"}, ("m.map, line 6", "2 characters", "3")),
    ("m.map", {"m.map": "type octile\nheight 2\nwidth 3\nmap\n...\n"}, ("m.map", "1 rows", "2 rows")),
    ("m.map", {"m.map": "type octile\nheight 1\nwidth 3\nmap\n...\n...\n"}, ("m.map", "2 rows")),
    ("m.map", {"m.map": "type octile\nheight 1\nwidth 3\nmap\n.x.\n"}, ("m.map, line 5, column 2", "'x'", ". G S @ O T W")),
    ("m.map.gz", {"m.map.gz": gzip.compress(b"type octile\nheight 2\nwidth 2\nmap\n" + b".." * 10**6)}, ("m.map.gz", "unpack to more than")),
    ("m.map.gz", {"m.map.gz": gzip.compress(b"type octile\nheight 1\nwidth 1\nmap\n.\n")[:-6]}, ("m.map.gz", "end too early")),
    ("m.map", {"m.map": b"\xff" * 100}, ("m.map, line 1", "not a header line")),
    ("m.txt", {"m.txt": "\n \n"}, ("m.txt", "no rows")),
    ("m.txt", {"m.txt": "...\n.a.\n"}, ("m.txt, line 2, column 2", "'a'", ". #")),
    ("m.txt", {"m.txt": "\n...\n..\n"}, ("m.txt, line 3", "2 characters")),
]
SCEN_CASES: list[Case] = [
    ("m.scen", {"m.scen": "version 2\n"}, ("m.scen, line 1", "version 1 or version 1.0")),
    ("m.scen", {"m.scen": "\n\n"}, ("m.scen", "no lines")),
    ("m.scen", {"m.scen": "version 1\n0 m 2 2 0 0 1\n"}, ("m.scen, line 2", "7 columns", "9:")),
    ("m.scen", {"m.scen": "version 1\n0 m 2 2 0 -1 1 1 1\n"}, ("field start y", "'-1'")),
    ("m.scen", {"m.scen": "version 1\n0 m 2 2 0 0 1 1 nan\n"}, ("field length", "'nan'")),
    ("m.scen", {"m.scen": "version 1\n0 m 2 2 0 0 1 1 1e999\n"}, ("field length",)),
    ("m.scen", {"m.scen": b"version 1\n\xff\xff"}, ("m.scen", "not text")),
]
SCENE_CASES: list[Case] = [
    ("s.toml", {"s.toml": "[[disc]]\ncenter = [0, 0]\nradius = 1\n"}, ("s.toml, [world]", "missing")),
    ("s.toml", {"s.toml": "[world]\n"}, ("s.toml, [world], field bounds", "neither bounds nor map")),
    ("s.toml", {"s.toml": "[world]\nbounds = [0, 0, -1, 1]\n"}, ("[world], field bounds", "x0 < x1")),
    ("s.toml", {"s.toml": "[world]\nbounds = [0, 0, inf, 1]\n"}, ("[world], field bounds",)),
    ("s.toml", {"s.toml": "[world]\nbounds = [0, 0, 1e9, 1e9]\nresolution = 0.001\n"}, ("[world], field resolution", "268435456 cells")),
    ("s.toml", {"s.toml": "[world]\nmap = 'none.yaml'\n"}, ("s.toml, [world], field map", "none.yaml does not exist")),
    ("s.toml", {"s.toml": "[world]\nmap = 's.toml'\n"}, ("[world], field map", "map_server")),
    ("s.toml", {"s.toml": "[world]\nmap = 'm.txt'\nbounds = [0, 0, 1, 1]\n", "m.txt": ".."}, ("[world], field bounds", "both given")),
    ("s.toml", {"s.toml": "[world]\nmap = 'm.txt'\nresolution = 0.1\n", "m.txt": ".."}, ("[world], field resolution", "1 m")),
    ("s.toml", {"s.toml": "[world\n"}, ("s.toml", "not valid TOML", "line 1")),
    ("s.toml", {"s.toml": "a = " + "[" * 10_000}, ("s.toml", "nested too deeply")),
    ("s.toml", {"s.toml": "a = " + "1" * 10_000}, ("s.toml",)),
    ("s.toml", {"s.toml": GOOD_SCENE + "a" + ".a" * 500_000 + " = 1\n"}, ("s.toml", "too many parts")),
    ("s.toml", {"s.toml": b"#" * (1 << 24)}, ("s.toml", "at most 8388608 bytes")),
    ("s.toml", {"s.toml": b"\xff\xfe[\0w\0"}, ("s.toml", "not text")),
    ("s.toml", scene("[[disk]]\ncenter = [0, 0]\n"), ("s.toml, field disk", "not known", "Did you mean disc")),
    ("s.toml", scene("[[disc]]\ncentre = [0, 0]\ncenter = [0, 0]\nradius = 1\n"), ("[[disc]] number 1, field centre", "center, radius")),
    ("s.toml", scene("[disc]\ncenter = [0, 0]\n"), ("field disc", "[[disc]]")),
    ("s.toml", scene("[[disc]]\ncenter = [0, 0]\nradius = -1\n"), ("[[disc]] number 1, field radius", "-1", "0 to 1e+06 m")),
    ("s.toml", scene("[[disc]]\ncenter = [0, 0]\nradius = true\n"), ("field radius", "True")),
    ("s.toml", scene("[[disc]]\ncenter = [0, 0, 0]\nradius = 1\n"), ("field center", "[x, y]")),
    ("s.toml", scene("[[disc]]\nradius = 1\n"), ("field center", "missing")),
    ("s.toml", scene('[[disc]]\n"center\\n" = [0, 0]\nradius = 1\n'), ("field center", "missing", "meant to be it?")),
    ("s.toml", scene(f"[[disc]]\ncenter = [0, 0]\nradius = 1{'0' * 400}\n"), ("field radius",)),
    ("s.toml", scene("[[polygon]]\npoints = [[0, 0], [1, 0]]\n"), ("[[polygon]] number 1, field points", "at least 3")),
    ("s.toml", scene("[[polygon]]\npoints = [[0, 0], [1, 0], [nan, 1]]\n"), ("field points, entry 3", "nan")),
    ("s.toml", scene("[[polygon]]\npoints = [[0, 0], [2, 0], [1, 0.5], [1, 2]]\n"), ("field points", "not convex at (1, 0.5)", "convex parts")),
    ("s.toml", scene("[[polygon]]\npoints = [[0, 0], [1, 1], [2, 2]]\n"), ("field points", "area")),
    ("s.toml", scene("[[polygon]]\npoints = [[0, 1], [0.6, -0.8], [-1, 0.3], [1, 0.3], [-0.6, -0.8]]\n"), ("field points",)),
    ("s.toml", scene("[[mover]]\npath = [[0, 0]]\n"), ("[[mover]] number 1, field shape", "missing")),
    ("s.toml", scene("[[mover]]\nshape = { disc = 1, box = [1, 1] }\npath = [[0, 0]]\n"), ("field shape", "{ disc = radius }")),
    ("s.toml", scene("[[mover]]\nshape = { ball = 1 }\npath = [[0, 0]]\n"), ("field shape",)),
    ("s.toml", scene("[[mover]]\nshape = { box = [1, 0] }\npath = [[0, 0]]\n"), ("[[mover]] number 1.shape, field box", "above 0")),
    ("s.toml", scene(MOVER), ("field path", "neither path nor trajectory")),
    ("s.toml", scene(MOVER + "path = [[0, 0], [1, 0]]\n"), ("field speed", "missing")),
    ("s.toml", scene(MOVER + "path = [[0, 0], [1, 0]]\nspeed = 0\n"), ("field speed", "above 0")),
    ("s.toml", scene(MOVER + "path = [[0, 0], [1e9, 0]]\nspeed = 1e-5\n"), ("field speed",)),
    ("s.toml", scene(MOVER + "path = [[0, 0]]\nloop = 'forever'\n"), ("field loop", "once | cycle | shuttle")),
    ("s.toml", scene(MOVER + "path = [[0, 0]]\nappears = { within = 1, at = 2 }\n"), ("field appears", "within")),
    ("s.toml", scene(MOVER + "trajectory = 'none.csv'\n"), ("field trajectory", "none.csv does not exist")),
    ("s.toml", scene(MOVER + "trajectory = 't.csv'\n") | {"t.csv": "t,x\n0,1\n"}, ("t.csv, line 1", "t,x,y")),
    ("s.toml", scene(MOVER + "trajectory = 't.csv'\n") | {"t.csv": "t,x,y\n0,1,abc\n"}, ("t.csv, line 2, field y", "'abc'")),
    ("s.toml", scene(MOVER + "trajectory = 't.csv'\n") | {"t.csv": "t,x,y\n0,1,1\n0,2,2\n"}, ("t.csv, field t", "increase")),
    ("s.toml", scene(MOVER + "trajectory = 't.csv'\n") | {"t.csv": "t,x,y\n1,1,1\n"}, ("t.csv, field t", "first time is 1 s")),
    ("s.toml", scene(MOVER + "trajectory = 't.csv'\n") | {"t.csv": "t,x,y\n"}, ("t.csv", "no rows")),
    ("s.toml", scene("[robot]\nspeed = 0\n"), ("s.toml, [robot], field speed", "1e-06 to 1e+06 m/s")),
    ("s.toml", scene("[robot]\nspeed = 'fast'\n"), ("[robot], field speed", "'fast'")),
    ("s.toml", scene("[robot]\nfootprint = { polygon = [[1, 0], [2, 0], [1, 1]] }\n"), ("[robot].footprint, field polygon", "(0, 0)")),
    ("s.toml", {"s.toml": "robot = 3\n" + GOOD_SCENE}, ("[robot]", "not a table")),
    ("s.toml", scene("[lidar]\nbeams = 0\n"), ("[lidar], field beams", "1 to 100000")),
    ("s.toml", scene("[lidar]\nfield_of_view = 7\n"), ("[lidar], field field_of_view", "rad")),
    ("s.toml", scene("[query]\nstart = [0]\n"), ("[query], field start", "[x, y, yaw]")),
    ("s.toml", scene("[query]\nclearance = -0.1\n"), ("[query], field clearance", "-0.1")),
    ("s.toml", scene("[query]\nmaterial = 'glass'\n"), ("[query], field material", "standard | long | heavy")),
    ("s.toml", scene("[plan]\nseed = -1\n"), ("[plan], field seed", "0 to")),
    ("s.toml", scene("[plan]\nset = { ants = [1] }\n"), ("[plan].set, field ants",)),
    ("s.toml", scene("[plan]\nrefine = 'shine'\n"), ("[plan], field refine", "none | simplify | smooth")),
    ("s.toml", scene("[plan]\nplaner = 'astar'\n"), ("[plan], field planer", "Did you mean planner")),
]
BARN = {"radius": 0.075, "start": [0, 0, 0], "goal": [1, 1], "worlds": {"1": [[0, 5]], "3": [[0, "x"]]}}
COLLECTION_CASES: list[Case] = [
    ("b.json", {"b.json": json.dumps(BARN)}, ("b.json", "number of a world", "b.json#1")),
    ("b.json#2", {"b.json": json.dumps(BARN)}, ("b.json", "no world #2", "1, 3")),
    ("b.json#x", {"b.json": json.dumps(BARN)}, ("no world #x",)),
    ("b.json#3", {"b.json": json.dumps(BARN)}, ("b.json, world 3, field centers, entry 1",)),
    ("b.json#1", {"b.json": json.dumps({**BARN, "radius": 0})}, ("b.json, field radius",)),
    ("b.json#1", {"b.json": "{"}, ("b.json, line 1", "not valid JSON")),
    ("b.json#1", {"b.json": '{"worlds": NaN}'}, ("b.json", "NaN")),
    ("b.json#1", {"b.json": "[" * 200_000}, ("b.json", "nested")),
    ("b.json#1", {"b.json": "3"}, ("b.json", "not a table")),
    ("b.json#1", {"b.json": '{"worlds": {"1": ' + "1" * 5000 + "}}"}, ("b.json",)),
    ("b.json.gz#1", {"b.json.gz": gzip.compress(b" " * (1 << 25))}, ("b.json.gz", "unpack to more than 16777216")),
    ("d_worlds.json#1", {"d_worlds.json": '[{"world": 1, "moving": ["a"], "static": []}]'}, ("d_traj.json", "no such file")),
    (
        "d_worlds.json#1",
        {
            "d_worlds.json": '[{"world": 1, "moving": ["a"], "static": []}]',
            "d_traj.json": '{"obstacle_radius": 1, "start": [0, 0, 0], "goal_relative": [1, 1], "trajectories": {"b": {}}}',
        },
        ("d_traj.json", "motion 'a' is missing"),
    ),
]
CASES = YAML_CASES + IMAGE_CASES + GRID_CASES + SCEN_CASES + SCENE_CASES + COLLECTION_CASES


def refused(call: Callable[[], object]) -> str:
    """The message of the refusal, checked for its form."""
    with pytest.raises(BadFile) as caught:
        call()
    message = str(caught.value)
    assert message == " ".join(message.split()), "one paragraph without line breaks"
    assert 20 < len(message) < 700
    assert message.endswith((".", "?"))
    assert "Traceback" not in message
    assert "Error(" not in message
    assert caught.value.exit_code == 2
    return message


@pytest.mark.parametrize("case", CASES, ids=[f"{i}-{case[2][-1][:30]}" for i, case in enumerate(CASES)])
def test_bad_input(tmp_path: Path, case: Case) -> None:
    target, files, parts = case
    for file, contents in files.items():
        (tmp_path / file).write_bytes(contents.encode() if isinstance(contents, str) else contents)
    path = tmp_path / target
    message = refused(lambda: gio.load_scenario(path) if target.endswith(".scen") else gio.load(str(path)))
    for part in parts:
        assert part in message, message


def test_there_are_many_kinds() -> None:
    assert len(CASES) >= 100


@pytest.mark.parametrize(
    "files",
    [
        image(b"P5\n1000000000 1000000000\n255\n"),
        image(b"P5\n16384 16384\n255\n...."),
        image(b"P2\n16384 16384\n255\n1 1"),
        image(png_header(16384, 16384)),
        image(png_header(60_000, 60_000, 16, 6)),
        image(bmp_header(16384, 16384)),
        {"m.yaml": GOOD_YAML, "m.pgm.gz": gzip.compress(b"P5\n16384 16384\n255\n" + b"\0" * 10**6)},
        {"m.yaml": GOOD_YAML, "m.pgm.gz": gzip.compress(b"P2\n9 9\n255\n" + b"\0" * 10**8)},
    ],
)
def test_refused_before_memory_is_taken(tmp_path: Path, files: Files) -> None:
    for file, contents in files.items():
        (tmp_path / file).write_bytes(contents.encode() if isinstance(contents, str) else contents)
    tracemalloc.start()
    try:
        refused(lambda: gio.load(tmp_path / "m.yaml"))
        assert tracemalloc.get_traced_memory()[1] < 16e6
    finally:
        tracemalloc.stop()


def test_not_regular_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    (tmp_path / "loop.yaml").symlink_to(tmp_path / "loop.yaml")
    (tmp_path / "folder.yaml").mkdir()
    (tmp_path / "device.yaml").symlink_to("/dev/zero")
    (tmp_path / "m.yaml").write_text(GOOD_YAML)
    os.mkfifo(tmp_path / "m.pgm")
    for file, part in (
        ("pipe", "a pipe"),
        ("loop", "symbolic links"),
        ("folder", "a folder"),
        ("device", "a device"),
        ("m", "m.pgm: this is a pipe"),
    ):
        assert part in refused(lambda f=file: gio.load(tmp_path / f"{f}.yaml"))
    assert "NUL" in refused(lambda: gio.load(f"{tmp_path}/a\0b.yaml"))
    refused(lambda: gio.load(tmp_path / ("x" * 5000 + ".yaml")))
    refused(lambda: gio.load(tmp_path / "new\nline.yaml"))


def test_too_large_by_size_alone(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(GOOD_YAML)
    with open(tmp_path / "m.pgm", "wb") as file:
        file.truncate(MAX_BYTES + 1)  # a hole: no disk is used
    assert f"at most {MAX_BYTES} bytes" in refused(lambda: gio.load(tmp_path / "m.yaml"))


def test_unreadable(tmp_path: Path) -> None:
    path = tmp_path / "m.txt"
    path.write_text("...")
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read everything")
    assert "permission denied" in refused(lambda: gio.load(path))


def test_writers_refuse_and_leave_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "m.txt").write_text("..\n.#\n")
    grid = gio.load_map(tmp_path / "m.txt")
    assert "not a kind of map" in refused(lambda: gio.write_map(grid, tmp_path / "m.png"))
    assert "no such file" in refused(lambda: gio.write_map(grid, tmp_path / "none" / "m.map"))
    assert "folder" in refused(lambda: gio.write_atomic(tmp_path, b"x"))
    before = sorted(p.name for p in tmp_path.iterdir())

    def interrupted(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        gio.write_atomic(tmp_path / "m.txt", b"half")
    assert sorted(p.name for p in tmp_path.iterdir()) == before
    assert (tmp_path / "m.txt").read_text() == "..\n.#\n"


def test_write_follows_links_and_keeps_the_mode(tmp_path: Path) -> None:
    real, link = tmp_path / "real.txt", tmp_path / "link.txt"
    real.write_text("old")
    real.chmod(0o640)
    link.symlink_to(real)
    gio.write_atomic(link, "new")
    assert real.read_text() == "new"
    assert link.is_symlink()
    assert real.stat().st_mode & 0o777 == 0o640
    gio.write_atomic("/dev/null", "gone")
