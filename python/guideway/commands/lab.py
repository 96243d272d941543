"""``guideway lab run | report | tune | list``: experiments, their records, statistics and reports."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from guideway.commands import options
from guideway.errors import BadFile, BadParameter

if TYPE_CHECKING:
    from guideway.lab import Experiment

EXAMPLES = """examples:
  guideway lab list
  guideway lab run pso-aco-scenes --quick --out results
  guideway lab run mine.toml --workers 4 --out results
  guideway lab run mine.toml --resume --out results
  guideway lab run all --cluster dask://10.0.0.5:8786 --out results
  guideway lab report results --out report.html
  guideway lab tune mine.toml --trials 100 --out tuning"""

ALL = "all"


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the sub-verbs."""
    parser.epilog = EXAMPLES
    actions = parser.add_subparsers(metavar="ACTION", required=True, parser_class=type(parser))
    _declare_run(_action(actions, "run", "run experiments: one record per world, query, method and seed", _run))
    report = _action(actions, "report", "HTML, CSV, LaTeX and figures from records", _report)
    report.add_argument("folder", metavar="DIR", help="folder of records")
    report.add_argument("--out", metavar="FILE.html", help="the report (default DIR/report.html); tables and figures go beside it")
    report.add_argument("--page", metavar="FILE.md", help="also a page in Markdown: what of each source holds, with the command of every figure")
    report.add_argument("--no-figures", action="store_true", help="without the SVG figures")
    _declare_tune(_action(actions, "tune", "seek better parameters of a method: what [tune] of an experiment asks for", _tune))
    listed = _action(actions, "list", "the experiments that ship with Guideway", _list)
    listed.add_argument("--json", action="store_true", help="on stdout as JSON")


def _action(actions: Any, name: str, about: str, handler: Any) -> argparse.ArgumentParser:
    found = actions.add_parser(name, help=about, description=about[0].upper() + about[1:] + ".", allow_abbrev=False)
    found.formatter_class = argparse.RawDescriptionHelpFormatter
    found.epilog = "\n".join(["examples:", *(line for line in EXAMPLES.splitlines() if f"lab {name}" in line)])
    found.set_defaults(handler=handler)
    return found


def _declare_run(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("experiments", nargs="+", metavar="EXPERIMENT", help="a *.toml file, the name of one that 'guideway lab list' shows, or all")
    parser.add_argument("--out", default="results", metavar="DIR", help="folder of the records (default results)")
    parser.add_argument("--workers", type=int, metavar="N", help="processes on this machine (default: its cores)")
    parser.add_argument("--cluster", metavar="WHERE", help="dask://HOST:PORT of a Dask scheduler, or local[:N] for a small cluster here")
    parser.add_argument("--resume", action="store_true", help="go on where an earlier run was stopped; its records are kept")
    parser.add_argument("--quick", action="store_true", help="the small version: fewer seeds, worlds and evaluations")
    parser.add_argument("--seeds", type=int, metavar="N", help="seeds 0 to N - 1 instead of those of the file")


def _declare_tune(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("experiment", metavar="EXPERIMENT", help="a *.toml file, or the name of one that 'guideway lab list' shows")
    parser.add_argument("--out", default="results", metavar="DIR", help="folder of the records and of what was found (default results)")
    parser.add_argument("--trials", type=int, metavar="N", help="sets of parameters to try instead of the file's number")
    parser.add_argument("--workers", type=int, metavar="N", help="processes on this machine (default: its cores)")
    parser.add_argument("--cluster", metavar="WHERE", help="dask://HOST:PORT of a Dask scheduler, or local[:N] for a small cluster here")
    parser.add_argument("--resume", action="store_true", help="go on where an earlier search was stopped; its records are kept")


def _run(arguments: argparse.Namespace) -> int:
    """Runs one experiment after the other; Ctrl-C keeps what there is."""
    from guideway.lab import journal, run, told
    from guideway.lab.coordinator import troubles

    if arguments.seeds is not None and not 1 <= arguments.seeds <= 100_000:
        raise BadParameter(f"--seeds {arguments.seeds} is out of range: 1 to 100000")
    chosen = [_version(experiment, arguments) for experiment in _chosen(arguments.experiments)]
    for experiment in chosen:
        try:
            tally = run(experiment, arguments.out, workers=arguments.workers, cluster=arguments.cluster, resume=arguments.resume)
        except KeyboardInterrupt:
            kept = Path(arguments.out) / f"{experiment.name}.jsonl"
            options.note(f"guideway: interrupted; the records so far are in {kept}. Go on with the same command and --resume.")
            return 130
        print(f"{experiment.name}: {told(tally)}")
        if tally["ok"] < tally.total():
            for line in troubles(journal.read(Path(arguments.out) / f"{experiment.name}.jsonl"), 3):
                options.note(f"  {line}")
    options.note(f"guideway: now 'guideway lab report {arguments.out}'")
    return 0


def _chosen(words: list[str]) -> list[Experiment]:
    """The experiments, all read and checked before the first is run."""
    from guideway.lab import packaged, read

    known, paths = packaged(), []
    for word in words:
        if word == ALL:
            paths += known.values()
        elif word in known and not os.path.exists(word):
            paths.append(known[word])
        elif not os.path.exists(word) and not word.endswith(".toml"):
            raise BadFile(
                word, "there is no such file or experiment", f"a *.toml file, all, {', '.join(known) or 'none ships'}", "See 'guideway lab list'"
            )
        else:
            paths.append(Path(word))
    found = [read(path) for path in dict.fromkeys(paths)]
    names = [experiment.name for experiment in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise BadParameter(f"two of the experiments have the name {twice!r}: run them apart, each with its own --out")
    return found


def _version(experiment: Experiment, arguments: argparse.Namespace) -> Experiment:
    from guideway.lab import quick, with_seeds

    small = quick(experiment) if arguments.quick else experiment
    return small if arguments.seeds is None else with_seeds(small, arguments.seeds)


def _report(arguments: argparse.Namespace) -> int:
    from guideway.lab.report import write_report

    print(f"wrote {write_report(arguments.folder, arguments.out, figures=not arguments.no_figures, markdown=arguments.page)}")
    return 0


def _tune(arguments: argparse.Namespace) -> int:
    from guideway.lab import tune

    if arguments.trials is not None and not 1 <= arguments.trials <= 100_000:
        raise BadParameter(f"--trials {arguments.trials} is out of range: 1 to 100000")
    experiment = _chosen([arguments.experiment])[0]
    how = {name: getattr(arguments, name) for name in ("trials", "workers", "cluster", "resume")}
    try:
        found = tune(experiment, arguments.out, **how)
    except KeyboardInterrupt:
        options.note("guideway: interrupted; the records so far are kept. Go on with the same command and --resume.")
        return 130
    for group in found["groups"]:
        seen = group["evidence"]
        change = f"{found['metric']} {_shown(seen['before'])} before, {_shown(seen['after'])} with {json.dumps(group['best']['set'])}"
        print(f"{group['group']}: {group['recommended']}; {change}")
    print(f"wrote {Path(arguments.out) / found['experiment']}.tuned.toml")
    return 0


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _list(arguments: argparse.Namespace) -> int:
    from guideway.lab import packaged, read

    rows = [_row(read(path, check=False)) for path in packaged().values()]
    if arguments.json:
        print(json.dumps(rows))
        return 0
    width = max((len(row["name"]) for row in rows), default=0)
    for row in rows:
        place = f"{row['source']} {row['table']}".strip()
        print(f"{row['name']:<{width}}  {row['kind']:<8} {row['runs']:>6} runs, {len(row['methods']):>2} methods  {place}: {row['title']}")
    return 0


def _row(experiment: Experiment) -> dict[str, Any]:
    return {
        "name": experiment.name,
        "title": experiment.title,
        "source": experiment.source,
        "table": experiment.table,
        "kind": experiment.kind,
        "runs": len(experiment.worlds) * len(experiment.queries) * len(experiment.methods) * len(experiment.seeds),
        "worlds": [world["name"] for world in experiment.worlds],
        "methods": [method["name"] for method in experiment.methods],
        "published": len(experiment.published),
        "claims": len(experiment.claims),
    }
