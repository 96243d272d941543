"""``guideway maps info | convert | view | make``: look at maps, convert them, make new ones."""

from __future__ import annotations

import argparse
import json
import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from guideway.commands import options
from guideway.errors import BadParameter
from guideway.io.packaged import is_packaged

if TYPE_CHECKING:
    from guideway.io import GridMap, Scene

EXAMPLES = """examples:
  guideway maps info warehouse.yaml
  guideway maps convert warehouse.yaml warehouse.map
  guideway maps convert barn_worlds.json.gz#7 barn7.toml
  guideway maps view warehouse.yaml --out warehouse.png
  guideway maps make maze --seed 3 maze.toml
  guideway maps make complexity --size 70 --density 0.5 hard.map
  guideway maps make --list"""

_MAP = "map_server *.yaml, Moving AI *.map, text *.txt, scene *.toml, scene:NAME, or number N of a collection (*.json#N)"


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the options."""
    parser.epilog = EXAMPLES
    actions = parser.add_subparsers(metavar="ACTION", required=True, dest="action")
    info = actions.add_parser("info", help="size, resolution, how much is free, how many separate areas")
    info.add_argument("map", metavar="MAP", help=_MAP)
    info.add_argument("--json", action="store_true", help="the facts on stdout as JSON")
    convert = actions.add_parser("convert", help="between map_server, Moving AI, text and scene files")
    convert.add_argument("source", metavar="SRC[#N]", help="a map, a scene, or number N of a collection")
    convert.add_argument("target", metavar="DST", help="*.yaml, *.map, *.txt or *.toml")
    view = actions.add_parser("view", help="a picture of a map with its clearance")
    view.add_argument("map", metavar="MAP", help=_MAP)
    view.add_argument("--out", metavar="FILE.png", required=True, help="the picture to write")
    make = actions.add_parser("make", help="a new random map, the same for the same seed on every machine")
    make.add_argument("kind", metavar="KIND", help="what to make; --list names the kinds")
    make.add_argument("target", metavar="DST", help="*.yaml, *.map, *.txt, or *.toml with start and goal")
    make.add_argument("--list", action=_Kinds, nargs=0, help="the kinds, with a line each")
    make.add_argument("--size", type=int, metavar="N", help="side, cells (default 30)")
    make.add_argument("--density", type=float, metavar="P", help="blocked share of a complexity map, 0 to below 1 (default 0.3)")
    make.add_argument("--class", dest="scene_class", metavar="NAME", help="scene class of a calibrated map (default pso-aco-1)")
    make.add_argument("--seed", type=int, default=0, metavar="N", help="seed (default 0)")
    make.add_argument("--json", action="store_true", help="what is known about the map on stdout as JSON")
    parser.set_defaults(handler=handle)


class _Kinds(argparse.Action):
    """Prints the kinds and leaves, as ``--help`` does: KIND and DST need not be there."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from guideway.scenes import KINDS

        print("\n".join(f"{kind:<12} {about}" for kind, about in KINDS.items()))
        parser.exit()


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    return {"info": _info, "convert": _convert, "view": _view, "make": _make}[arguments.action](arguments)


def _info(arguments: argparse.Namespace) -> int:
    from guideway.io import maps_info

    facts = maps_info(arguments.map)
    if arguments.json:
        print(json.dumps(facts, default=str))
    else:
        for key, value in facts.items():
            print(f"{key.replace('_', ' '):<22} {_shown(value)}")
    return 0


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(_shown(item) for item in value)
    if isinstance(value, dict):
        return ", ".join(f"{key} {_shown(item)}" for key, item in value.items())
    return "-" if value is None else str(value)


def _convert(arguments: argparse.Namespace) -> int:
    from guideway.io import load, write_map

    found = load(arguments.source)
    if is_packaged(arguments.source) and arguments.target.lower().endswith(".toml"):
        found = _unpacked(found, arguments.target)
    for path in write_map(found, arguments.target):
        print(f"wrote {path}")
    return 0


def _unpacked(found: GridMap | Scene, target: str) -> GridMap | Scene:
    """A packaged scene with its map beside ``target``: scene files name their map by a path, and one into the package is found nowhere else."""
    from guideway.io import Scene, write_map

    if not isinstance(found, Scene) or found.map is None:
        return found
    ending = ".txt" if found.map.kind == "text" else ".yaml"
    beside = write_map(found.map, os.path.splitext(target)[0] + ending)
    for path in beside[::-1]:
        print(f"wrote {path}")
    return replace(found, map=replace(found.map, source=beside[0]))


def _make(arguments: argparse.Namespace) -> int:
    from guideway import scenes

    options.writable(arguments.target)
    scene = scenes.make(arguments.kind, arguments.seed, size=arguments.size, density=arguments.density, scene_class=arguments.scene_class)
    written = scene.write(arguments.target)
    if arguments.json:
        print(json.dumps({"kind": arguments.kind, "seed": arguments.seed} | scene.record))
        return 0
    for key, value in scene.record.items():
        print(f"{key:<12} {_shown(value) or 'none'}")
    print("\n".join(f"wrote        {path}" for path in written))
    return 0


def _view(arguments: argparse.Namespace) -> int:
    from guideway.view import map_png
    from guideway.worlds import load

    if not arguments.out.lower().endswith(".png"):
        raise BadParameter(f"--out {arguments.out!r} must end in .png")
    map_png(load(arguments.map), arguments.out)
    print(f"wrote {arguments.out}")
    return 0
