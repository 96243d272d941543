"""``guideway maps info | convert | view``: look at maps and convert them."""

from __future__ import annotations

import argparse
import json
from typing import Any

from guideway.errors import BadParameter

EXAMPLES = """examples:
  guideway maps info warehouse.yaml
  guideway maps convert warehouse.yaml warehouse.map
  guideway maps convert barn_worlds.json.gz#7 barn7.toml
  guideway maps view warehouse.yaml --out warehouse.png"""

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
    parser.set_defaults(handler=handle)


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    return {"info": _info, "convert": _convert, "view": _view}[arguments.action](arguments)


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

    for path in write_map(load(arguments.source), arguments.target):
        print(f"wrote {path}")
    return 0


def _view(arguments: argparse.Namespace) -> int:
    from guideway.view import map_png
    from guideway.worlds import load

    if not arguments.out.lower().endswith(".png"):
        raise BadParameter(f"--out {arguments.out!r} must end in .png")
    map_png(load(arguments.map), arguments.out)
    print(f"wrote {arguments.out}")
    return 0
