"""``guideway view``: one self-contained HTML file from plans and runs."""

from __future__ import annotations

import argparse

from guideway.commands import options
from guideway.errors import BadParameter

EXAMPLES = """examples:
  guideway view plan.json --out plan.html
  guideway view shortest.json safest.json run.json --out compare.html"""


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the options."""
    parser.epilog = EXAMPLES
    parser.add_argument("results", nargs="+", metavar="FILE", help="plan.json and run.json files")
    parser.add_argument("--out", metavar="FILE", required=True, help="the report to write, *.html (or *.png, *.svg: a figure for papers)")
    parser.add_argument("--title", metavar="TEXT", help="title of the report")
    parser.set_defaults(handler=handle)


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    from guideway.results import load_record, world_of_record

    options.writable(arguments.out, inputs=tuple(arguments.results))
    records = [load_record(path) for path in arguments.results]
    worlds = [world_of_record(record, path) for record, path in zip(records, arguments.results, strict=True)]
    if arguments.out.lower().endswith((".png", ".svg")):
        from guideway.view import figure

        try:
            figure(records, worlds[0], arguments.out)
        except ImportError as missing:
            raise BadParameter(str(missing)) from None
    else:
        from guideway.view import report

        report(records, arguments.out, worlds=worlds, title=arguments.title)
    print(f"wrote {arguments.out}")
    return 0
