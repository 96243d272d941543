"""Every format gives the same cells, and what is written is read back the same."""

from __future__ import annotations

import gzip
import io
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

import guideway.io as gio
from guideway.errors import BadFile
from guideway.io.files import load as load_blob
from guideway.io.images import decode
from guideway.io.map_server import Header, occupancy

GREY = np.array([[0, 254, 205], [254, 0, 254]], np.uint8)
BLOCKED = np.array([[1, 0, 1], [0, 1, 0]], bool)
UNKNOWN = np.array([[0, 0, 1], [0, 0, 0]], bool)
YAML = "image: {image}\nresolution: 0.5\norigin: [-1.0, 2.0, 0.25]\nnegate: {negate}\noccupied_thresh: 0.65\nfree_thresh: 0.196\n{more}"


def pillow(image: Image.Image, kind: str) -> bytes:
    out = io.BytesIO()
    image.save(out, kind)
    return out.getvalue()


def pnm(magic: str, body: bytes, top: int = 255) -> bytes:
    return f"{magic}\n# made by hand\n3 2 # columns, rows\n{top}\n".encode() + body


def text(values: np.ndarray) -> bytes:
    return "\n".join(" ".join(map(str, row)) for row in values.reshape(2, -1).tolist()).encode()


def palette() -> Image.Image:
    image = Image.new("P", (3, 2))
    colors = [0, 254, 205]
    image.putpalette([c for color in colors for c in (color,) * 3])
    image.putdata([colors.index(v) for v in GREY.ravel().tolist()])
    return image


RGB = np.repeat(GREY[..., None], 3, axis=2)
RGBA = np.dstack([RGB, np.full(GREY.shape, 255, np.uint8)])
WIDE = GREY.astype(np.uint16) * 257
ENCODINGS = {
    "p2.pgm": pnm("P2", text(GREY)),
    "p2wide.pgm": pnm("P2", text(WIDE), 65535),
    "p3.ppm": pnm("P3", text(RGB)),
    "p5.pgm": pnm("P5", GREY.tobytes()),
    "p5wide.pgm": pnm("P5", WIDE.astype(">u2").tobytes(), 65535),
    "p5oneline.pgm": b"P5 3 2 255\n" + GREY.tobytes(),
    "p6.pgm": pnm("P6", RGB.tobytes()),
    "p6wide.pgm": pnm("P6", (RGB.astype(np.uint16) * 257).astype(">u2").tobytes(), 65535),
    "grey.png": pillow(Image.fromarray(GREY), "PNG"),
    "grey16.png": pillow(Image.fromarray(WIDE), "PNG"),
    "rgb.png": pillow(Image.fromarray(RGB), "PNG"),
    "rgba.png": pillow(Image.fromarray(RGBA), "PNG"),
    "palette.png": pillow(palette(), "PNG"),
    "la.png": pillow(Image.fromarray(GREY).convert("LA"), "PNG"),
    "grey.bmp": pillow(Image.fromarray(GREY), "BMP"),
    "rgb.bmp": pillow(Image.fromarray(RGB), "BMP"),
}


def write_map(folder: Path, image: str, data: bytes, *, negate: str = "0", more: str = "") -> Path:
    (folder / image).write_bytes(data)
    path = folder / "map.yaml"
    path.write_text(YAML.format(image=image, negate=negate, more=more))
    return path


@pytest.mark.parametrize("image", ENCODINGS)
@pytest.mark.parametrize("packed", [False, True])
def test_same_cells_from_every_encoding(tmp_path: Path, image: str, packed: bool) -> None:
    path = write_map(tmp_path, image, ENCODINGS[image])
    if packed:
        (tmp_path / f"{image}.gz").write_bytes(gzip.compress(ENCODINGS[image]))
        (tmp_path / image).unlink()
    grid = gio.load(path)
    assert isinstance(grid, gio.GridMap)
    assert np.array_equal(grid.blocked, BLOCKED)
    assert grid.unknown is not None
    assert np.array_equal(grid.unknown, UNKNOWN)
    assert (grid.resolution, grid.origin, grid.width, grid.height) == (0.5, (-1.0, 2.0, 0.25), 3, 2)
    assert set(grid.files) == {"map.yaml", image}


def test_unknown_free_and_negate(tmp_path: Path) -> None:
    grid = gio.load_map(write_map(tmp_path, "m.pgm", ENCODINGS["p5.pgm"]), unknown="free")
    assert np.array_equal(grid.blocked, BLOCKED & ~UNKNOWN)
    turned = gio.load_map(write_map(tmp_path, "m.pgm", pnm("P5", (255 - GREY).tobytes()), negate="true"))
    assert np.array_equal(turned.blocked, BLOCKED)


def header(mode: str, *, negate: bool = False, occupied: float = 0.8, free: float = 0.2) -> Header:
    return Header("m", 1.0, (0.0, 0.0, 0.0), occupied, free, negate, mode)  # type: ignore[arg-type]


def pixels(tmp_path: Path, image: Image.Image):
    (tmp_path / "x.png").write_bytes(pillow(image, "PNG"))
    return decode(load_blob(tmp_path / "x.png"))


def test_a_value_on_a_threshold_tells_the_two_readings_apart(tmp_path: Path) -> None:
    ramp = pixels(tmp_path, Image.fromarray(np.array([[0, 50, 51, 52, 128, 203, 204, 205, 255]], np.uint8)))
    # 51 / 255 = 0.2 and 204 / 255 = 0.8 exactly
    assert occupancy(ramp, header("trinary")).tolist() == [[100, 100, 100, -1, -1, -1, 0, 0, 0]]
    assert occupancy(ramp, header("trinary"), "strict").tolist() == [[100, 100, -1, -1, -1, -1, -1, 0, 0]]
    assert occupancy(ramp, header("scale")).tolist() == [[100, 100, 100, 99, 50, 1, 0, 0, 0]]
    assert occupancy(ramp, header("scale"), "strict").tolist() == [[100, 100, 99, 98, 49, 1, 1, 0, 0]]
    extremes = header("trinary", occupied=1.0, free=0.0)
    assert occupancy(ramp, extremes).tolist() == [[100, -1, -1, -1, -1, -1, -1, -1, 0]]
    assert occupancy(ramp, extremes, "strict").tolist() == [[-1] * 9]


def test_raw_mode(tmp_path: Path) -> None:
    ramp = pixels(tmp_path, Image.fromarray(np.array([[0, 1, 99, 100, 101, 255]], np.uint8)))
    assert occupancy(ramp, header("raw")).tolist() == [[0, 1, 99, 100, -1, -1]]
    assert occupancy(ramp, header("raw", negate=True)).tolist() == [[0, 1, 99, 100, -1, -1]]
    assert occupancy(ramp, header("raw", negate=True), "strict").tolist() == [[-1, -1, -1, -1, -1, 0]]


def test_colours_and_alpha(tmp_path: Path) -> None:
    blue = pixels(tmp_path, Image.fromarray(np.array([[[0, 0, 255]]], np.uint8)))
    # Rec. 601 sees blue as dark (0.114), the mean as a third
    assert occupancy(blue, header("trinary")).item() == 100
    assert occupancy(blue, header("trinary"), "strict").item() == -1
    clear = pixels(tmp_path, Image.fromarray(np.array([[[0, 0, 0, 254], [0, 0, 0, 0], [0, 0, 0, 255], [255, 255, 255, 0]]], np.uint8)))
    assert occupancy(clear, header("trinary")).tolist() == [[-1, -1, 100, -1]]
    assert occupancy(clear, header("scale")).tolist() == [[-1, -1, 100, -1]]
    # strict trinary: alpha is a fourth channel, so opaque black has p = 0.75 and transparent black p = 1
    assert occupancy(clear, header("trinary"), "strict").tolist() == [[-1, 100, -1, -1]]
    assert occupancy(clear, header("scale"), "strict").tolist() == [[100, 100, 100, 0]]


def test_maximum_other_than_255_is_scaled(tmp_path: Path) -> None:
    path = write_map(tmp_path, "m.pgm", b"P5\n3 1\n15\n" + bytes([0, 15, 12]))
    grid = gio.load_map(path)
    assert grid.blocked.tolist() == [[True, False, True]]  # 12 / 15 is the 204 of 255: unknown
    assert grid.unknown is not None


def test_moving_ai_and_text(tmp_path: Path) -> None:
    path = tmp_path / "m.map"
    path.write_bytes(b"type octile\r\nheight 2\r\nwidth 7\r\nmap\r\n.GS@OTW\n@......\r\n\n")
    grid = gio.load_map(path)
    assert grid.blocked.tolist() == [[False] * 3 + [True] * 4, [True] + [False] * 6]
    (tmp_path / "m.txt").write_text("\n.#.\n#..\n\n")
    assert gio.load_map(tmp_path / "m.txt").blocked.tolist() == [[False, True, False], [True, False, False]]


def test_scenario_separators(tmp_path: Path) -> None:
    path = tmp_path / "m.scen"
    path.write_text("version 1.0\n\n0\ta map.map\t7\t2\t0\t0\t1\t0\t1.0\n0  m.map 7 2 1 1 6 1 5.0\r\n\n")
    rows = gio.load_scenario(path)
    assert [(r.map, r.start, r.goal, r.length) for r in rows] == [("a map.map", (0, 0), (1, 0), 1.0), ("m.map", (1, 1), (6, 1), 5.0)]


def grids() -> st.SearchStrategy[np.ndarray]:
    return st.tuples(st.integers(1, 9), st.integers(1, 9)).flatmap(lambda shape: arrays(np.int8, shape, elements=st.sampled_from([0, 1, 2])))


@settings(deadline=None, max_examples=30)
@given(cells=grids(), resolution=st.floats(1e-3, 10), origin=st.tuples(*[st.floats(-1e3, 1e3)] * 3))
def test_conversions_round_trip(
    tmp_path_factory: pytest.TempPathFactory, cells: np.ndarray, resolution: float, origin: tuple[float, float, float]
) -> None:
    folder = tmp_path_factory.mktemp("trip")
    unknown = cells == 2
    grid = gio.GridMap(cells > 0, unknown if unknown.any() else None, resolution, origin, folder / "none", "", {}, "test")
    for extension in ("yaml", "map", "txt"):
        target = folder / f"out.{extension}"
        assert gio.write_map(grid, target)[0] == target
        back = gio.load_map(target)
        assert np.array_equal(back.blocked, grid.blocked)
        if extension == "yaml":
            assert (back.resolution, back.origin) == (resolution, origin)
            assert np.array_equal(back.unknown, unknown) if back.unknown is not None else not unknown.any()
    gio.write_map(gio.load_map(folder / "out.yaml"), folder / "scene.toml")
    scene = gio.load_scene(folder / "scene.toml")
    assert scene.map is not None
    assert np.array_equal(scene.map.blocked, grid.blocked)


def test_trajectory(tmp_path: Path) -> None:
    rows = [[0, 1, 2, 0.5, 0, 1, 0, 0], [0.01, 1, 2, 0.5, 0.01, 1, 1e-9, 1 / 3]]
    gio.write_trajectory(tmp_path / "t.csv", rows)
    lines = (tmp_path / "t.csv").read_text().splitlines()
    assert lines[0] == "t,x,y,yaw,speed,acceleration,jerk,curvature"
    assert np.allclose([[float(w) for w in line.split(",")] for line in lines[1:]], rows, rtol=1e-9, atol=0)
    with pytest.raises(BadFile, match=r"shape \(n, 8\)"):
        gio.write_trajectory(tmp_path / "t.csv", [[0, 1]])


def test_pillow_agrees_with_our_reader(tmp_path: Path) -> None:
    generator = np.random.default_rng(5)
    values = generator.integers(0, 256, (17, 23), np.uint8)
    (tmp_path / "a.pgm").write_bytes(b"P5\n23 17\n255\n" + values.tobytes() + b"anything after the image")
    assert np.array_equal(decode(load_blob(tmp_path / "a.pgm")).values, values)
    (tmp_path / "a.bin").write_bytes(struct.pack("<4s", b"none"))
    with pytest.raises(BadFile, match="not an image"):
        decode(load_blob(tmp_path / "a.bin"))
