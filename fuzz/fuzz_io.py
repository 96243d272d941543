"""Fuzzes every reader of :mod:`guideway.io`: whatever the bytes, the answer is data or a :class:`guideway.errors.BadFile`.

    python fuzz/fuzz_io.py --seconds 60              # all targets in turn, own mutations, reproducible by --seed
    python fuzz/fuzz_io.py --target pgm --atheris    # one target under coverage guidance, if atheris is installed; further arguments go to libFuzzer

A finding is written to ``fuzz/findings/`` and its path printed.
"""

from __future__ import annotations

import argparse
import gzip
import io
import json
import os
import random
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

MEMORY = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # rewriting files on disk is what takes the time
YAML = b"image: m.pgm\nresolution: 0.05\norigin: [-1.5, 2e1, 0.1]\nnegate: 0\nmode: scale\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
SCENE = b"""[world]
bounds = [0, 0, 10, 6]
resolution = 0.05
[[disc]]
center = [1.2, 0.95]
radius = 0.4
[[polygon]]
points = [[0, 0], [1, 0], [1, 1]]
[[mover]]
shape = { box = [0.8, 0.8] }
path = [[3.2, 2.95], [3.2, 4.3]]
speed = 0.4
loop = "shuttle"
appears = { within = 3.0 }
[[mover]]
shape = { polygon = [[-1, -1], [1, -1], [0, 1]] }
trajectory = [[0, 1, 2], [1, 2, 2]]
[robot]
footprint = { disc = 0.2 }
speed = 2.0
[lidar]
beams = 360
[query]
start = [0, 0]
goal = [5, 3, 1.5]
via = [[1, 1]]
[plan]
planner = "astar"
set = { ants = 20 }
seed = 3
"""
BARN = {"radius": 0.075, "start": [0, 0, 0], "goal": [1, 1], "worlds": {"1": [[0, 5], [1, 5]]}}
DYNABARN = [{"world": 1, "moving": ["a"], "static": [{"size": [1, 1, 1], "pose": [0, 0, 0, 0, 0, 0]}]}]
MOTIONS = {"obstacle_radius": 1, "start": [0, 0, 0], "goal_relative": [1, 1], "trajectories": {"a": {"keyframes": [[0, 0, 0], [1, 1, 1]]}}}
WORDS = [
    b"0",
    b"-1",
    b"1e999",
    b"nan",
    b"inf",
    b"99999999999999999999",
    b"65536",
    b"\0",
    b"\n",
    b" ",
    b"#",
    b"[",
    b"]",
    b"{",
    b"}",
    b"*a",
    b"&a ",
    b"\xff\xfe",
    b'"',
    b"''",
]
WORDS += [
    b"\x1f\x8b",
    b"P5",
    b"P2",
    b"true",
    b"map",
    b"!!python/object:os.system ",
    b"\r\n",
    b"---\n",
    b"? ",
    b": ",
    b"\\u0000",
    b"\xef\xbb\xbf",
    b"\x80",
    b"#1",
]


@dataclass(frozen=True)
class Target:
    """A reader: the file the bytes become, files beside it, and inputs to start from."""

    file: str
    seeds: list[bytes]
    beside: dict[str, bytes]
    suffix: str = ""
    loads: str = ""


def images() -> dict[str, bytes]:
    """Small images in every kind that is read."""
    import numpy as np
    from PIL import Image

    grey = np.arange(24, dtype=np.uint8).reshape(4, 6) * 10
    made = {
        "p5": b"P5\n# note\n6 4\n255\n" + grey.tobytes(),
        "p2": b"P2 2 2 15 0 1 15 # x\n 7",
        "p6": b"P6 2 1 65535\n" + bytes(12),
        "p3": b"P3 1 1 9 1 2 3",
    }
    pictures = {"png": Image.fromarray(grey), "rgba": Image.fromarray(grey).convert("RGBA"), "palette": Image.fromarray(grey).convert("P")}
    pictures["wide"] = Image.fromarray(grey.astype(np.uint16) * 257)
    for key, picture in pictures.items():
        out = io.BytesIO()
        picture.save(out, "PNG")
        made[key] = out.getvalue()
    for mode in ("L", "RGB", "1"):
        out = io.BytesIO()
        Image.fromarray(grey).convert(mode).save(out, "BMP")
        made["bmp" + mode] = out.getvalue()
    return made


def targets() -> dict[str, Target]:
    """Every reader by name."""
    pictures = images()
    octile = b"type octile\nheight 2\nwidth 3\nmap\n.@T\nGSW\n"
    scenario = b"version 1\n0\tm.map\t3\t2\t0\t0\t1\t1\t1.41421356\n"
    return {
        "yaml": Target("m.yaml", [YAML], {"m.pgm": pictures["p5"]}),
        "pgm": Target("m.pgm", [v for k, v in pictures.items() if k[0] == "p" and k[1].isdigit()], {"m.yaml": YAML}, loads="m.yaml"),
        "png": Target("m.pgm", [pictures[k] for k in ("png", "rgba", "palette", "wide")], {"m.yaml": YAML}, loads="m.yaml"),
        "bmp": Target("m.pgm", [v for k, v in pictures.items() if k.startswith("bmp")], {"m.yaml": YAML}, loads="m.yaml"),
        "gzip": Target("m.pgm.gz", [gzip.compress(v, mtime=0) for v in pictures.values()], {"m.yaml": YAML}, loads="m.yaml"),
        "octile": Target("m.map", [octile, gzip.compress(octile, mtime=0)], {}),
        "text": Target("m.txt", [b"..#\n#..\n"], {}),
        "scenario": Target("m.scen", [scenario, scenario.replace(b"\t", b" ")], {}),
        "scene": Target("s.toml", [SCENE], {}),
        "track": Target("t.csv", [b"t,x,y\n0,1,2\n1.5,2,2\n"], {}),
        "barn": Target("b.json", [json.dumps(BARN).encode()], {}, "#1"),
        "dynabarn": Target("d_worlds.json", [json.dumps(DYNABARN).encode()], {"d_traj.json": json.dumps(MOTIONS).encode()}, "#1"),
        "motions": Target("d_traj.json", [json.dumps(MOTIONS).encode()], {"d_worlds.json": json.dumps(DYNABARN).encode()}, "#1", "d_worlds.json"),
    }


def runner(target: Target, folder: Path) -> Callable[[bytes], None]:
    """A function that reads bytes as the target's file; anything but data or BadFile is raised."""
    import guideway.io as gio
    from guideway.errors import BadFile

    for file, data in target.beside.items():
        (folder / file).write_bytes(data)
    path = f"{folder}/{target.loads or target.file}{target.suffix}"
    load = {"m.scen": gio.load_scenario, "t.csv": gio.load_movers}.get(target.file, gio.load)

    def run(data: bytes) -> None:
        (folder / target.file).write_bytes(data)
        try:
            load(path)
        except BadFile as bad:
            message = str(bad)
            if message != " ".join(message.split()) or len(message) > 1000 or not message.endswith((".", "?")):
                raise AssertionError(f"not one paragraph: {message!r}") from bad

    return run


def mutated(chance: random.Random, seeds: list[bytes]) -> bytes:
    """One of the seeds with one to five random changes."""
    data = bytearray(chance.choice(seeds))
    for _ in range(chance.randint(1, 5)):
        i = chance.randint(0, len(data))
        j = min(len(data), i + chance.randint(0, 12))
        kind = chance.randrange(7)
        if kind == 0 and data:
            data[min(i, len(data) - 1)] = chance.randrange(256)
        elif kind == 1:
            data[i:j] = b""
        elif kind == 2:
            data[i:i] = chance.choice(WORDS)
        elif kind == 3:
            data[i:j] = chance.choice(WORDS)
        elif kind == 4:
            data[i:i] = data[i:j] * chance.choice((1, 3, 1000))
        elif kind == 5:
            del data[i:]
        else:
            other = chance.choice(seeds)
            data[i:] = other[chance.randint(0, len(other)) :]
    return bytes(data)


def campaign(target: Target, seed: int, keep_on: Callable[[int], bool]) -> tuple[int, bytes | None]:
    """Mutations while ``keep_on(count)``; how many were run, and the first input that failed."""
    chance = random.Random(seed)
    warnings.simplefilter("error", DeprecationWarning)
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
        run = runner(target, Path(folder))
        for seed_input in target.seeds:
            run(seed_input)
        count = 0
        while keep_on(count):
            data = mutated(chance, target.seeds)
            try:
                run(data)
            except BaseException as e:
                if isinstance(e, KeyboardInterrupt):
                    raise
                print(f"{type(e).__name__}: {e}", file=sys.stderr)
                return count, data
            count += 1
    return count, None


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target", choices=sorted(targets()), action="append", help="default: all")
    parser.add_argument("--seconds", type=float, default=60.0, help="for all targets together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--atheris", action="store_true")
    options, rest = parser.parse_known_args()
    chosen = options.target or sorted(targets())
    if options.atheris:
        return guided(targets()[chosen[0]], rest)
    failed = 0
    for name in chosen:
        end = time.monotonic() + options.seconds / len(chosen)
        count, data = campaign(targets()[name], options.seed, lambda _, end=end: time.monotonic() < end)
        print(f"{name:<10} {count:>8} inputs {'ok' if data is None else 'FAILED'}")
        if data is not None:
            failed += 1
            finding = Path(__file__).parent / "findings" / f"{name}.bin"
            finding.parent.mkdir(exist_ok=True)
            finding.write_bytes(data)
            print(finding)
    return 1 if failed else 0


def guided(target: Target, rest: list[str]) -> int:
    """Coverage-guided fuzzing by atheris."""
    import atheris

    with atheris.instrument_imports(include=["guideway", "yaml", "tomllib", "PIL", "json"]):
        import guideway.io.collections
        import guideway.io.images
        import guideway.io.lines
        import guideway.io.map_server
        import guideway.io.scene  # noqa: F401
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
        run = runner(target, Path(folder))
        corpus = Path(folder) / "corpus"
        corpus.mkdir()
        for i, data in enumerate(target.seeds):
            (corpus / str(i)).write_bytes(data)
        atheris.Setup([sys.argv[0], *rest, str(corpus)], lambda data: run(bytes(data)))
        atheris.Fuzz()
    return 0


if __name__ == "__main__":
    sys.exit(main())
