"""``guideway view``: one self-contained HTML file from plans and runs, or from motions of arms."""

from __future__ import annotations

import argparse
from typing import Any

from guideway.commands import options
from guideway.errors import BadParameter

EXAMPLES = """examples:
  guideway view plan.json --out plan.html
  guideway view shortest.json safest.json run.json --out compare.html
  guideway view traj.json --out arm.html"""


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the options."""
    parser.epilog = EXAMPLES
    parser.add_argument("results", nargs="+", metavar="FILE", help="plan.json and run.json files, or traj.json files of arms")
    parser.add_argument("--out", metavar="FILE", required=True, help="the report to write, *.html (or *.png, *.svg: a figure for papers)")
    parser.add_argument("--title", metavar="TEXT", help="title of the report")
    parser.set_defaults(handler=handle)


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    from guideway.results import load_record
    from guideway.view import is_arm

    options.writable(arguments.out, inputs=tuple(arguments.results))
    records = [load_record(path) for path in arguments.results]
    arms = [is_arm(record) for record in records]
    if any(arms) and not all(arms):
        raise BadParameter("motions of arms (traj.json) and plans or runs cannot stand in one report: view them one after the other")
    drawn = arguments.out.lower().endswith((".png", ".svg"))
    try:
        (_arms if all(arms) else _plans)(arguments, records, drawn)
    except ImportError as missing:
        raise BadParameter(str(missing)) from None
    print(f"wrote {arguments.out}")
    return 0


def _arms(arguments: argparse.Namespace, records: list[dict[str, Any]], drawn: bool) -> None:
    from guideway.view import arm_figure, arm_report

    if not drawn:
        arm_report(records, arguments.out, title=arguments.title)
        return
    if len(records) > 1:
        raise BadParameter("a figure of an arm shows one motion: name one traj.json")
    try:
        arm_figure(records[0], arguments.out)
    except ValueError as nothing:
        raise BadParameter(f"{arguments.results[0]}: {nothing}") from None


def _plans(arguments: argparse.Namespace, records: list[dict[str, Any]], drawn: bool) -> None:
    from guideway.results import world_of_record
    from guideway.view import figure, report

    worlds = [world_of_record(record, path) for record, path in zip(records, arguments.results, strict=True)]
    if drawn:
        figure(records, worlds[0], arguments.out)
    else:
        report(records, arguments.out, worlds=worlds, title=arguments.title)
