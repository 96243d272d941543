"""``guideway arm``: motions of robot arms along a path."""

from __future__ import annotations

import argparse
import importlib
from typing import Any

SUB_VERBS = {
    "time": ("arm_time", "the fastest motion along a path under the limits of the joints, with its certificate"),
    "learn": ("arm_learn", "the fastest motion along a path, learned from measured torques"),
}
"""Sub-verbs: the module below ``guideway.commands`` and a line each."""


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the sub-verbs."""
    parser.epilog = "\n".join(["examples:", *(line for module, _ in SUB_VERBS.values() for line in _load(module).EXAMPLES.splitlines()[1:])])
    found = parser.add_subparsers(metavar="WHAT", parser_class=type(parser))
    for name, (module, about) in SUB_VERBS.items():
        sub = found.add_parser(name, help=about, description=about[0].upper() + about[1:] + ".", allow_abbrev=False)
        sub.formatter_class = argparse.RawDescriptionHelpFormatter
        _load(module).declare(sub)

    def show_help(_: argparse.Namespace) -> int:
        parser.print_help()
        return 2

    parser.set_defaults(handler=show_help)


def _load(module: str) -> Any:
    return importlib.import_module(f"guideway.commands.{module}")
