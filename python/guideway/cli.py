"""The command line: ``guideway demo | plan | drive | arm | lab | maps | view``.

Exit status: 0 success, 2 bad input, 3 no result, 130 Ctrl-C. Errors are one short paragraph on stderr; ``--debug`` shows the traceback.
"""

from __future__ import annotations

import argparse
import importlib
import os
import re
import sys
import textwrap
from collections.abc import Sequence
from typing import NoReturn

from guideway.errors import GuidewayError

VERBS = {
    "demo": "the main job on a real map that ships with the package",
    "plan": "plan, smooth, time and certify a path on a map or in a scene",
    "drive": "drive a planned motion in a world that moves",
    "arm": "time-optimal motions of robot arms along a path",
    "lab": "experiments: every published table as one command, statistics and reports",
    "maps": "look at maps, convert them, make new ones",
    "view": "one self-contained HTML report from results",
}

EXAMPLES = """examples:
  guideway demo
  guideway plan warehouse.yaml --start=-5.4,-19 --goal 9.5,21.5 --footprint disc:0.35 --out plan.json --report plan.html
  guideway plan --list
  guideway drive plan.json --report run.html
  guideway arm time --nurbs star --robot ur5e --out traj.json
  guideway lab run pso-aco-scenes --quick --out results
  guideway maps info warehouse.yaml
  guideway view plan.json run.json --out report.html"""

_VALUE = re.compile(r"^-(\d|\.\d)[-+\d.,;eE]*$")


class _Parser(argparse.ArgumentParser):
    """Reports bad usage as one paragraph, exit status 2."""

    def error(self, message: str) -> NoReturn:
        raise _Usage(f"{self.prog}: {message}. See '{self.prog} --help'.")


class _Usage(GuidewayError):
    """The words on the command line are off."""


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status."""
    words = list(sys.argv[1:] if argv is None else argv)
    debug = "--debug" in words
    try:
        return _run([word for word in words if word != "--debug"])
    except SystemExit as leave:  # --help, --version
        return leave.code if isinstance(leave.code, int) else 0
    except KeyboardInterrupt:
        if debug:
            raise
        print("guideway: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of our output has gone; say nothing, and keep the interpreter from complaining at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except GuidewayError as error:
        if debug:
            raise
        _say(str(error))
        return error.exit_code
    except MemoryError:
        _say("out of memory. Use a smaller or coarser map (guideway maps info shows its size).")
        return 2
    except OSError as error:
        if debug:
            raise
        _say(
            f"{error.filename or 'a file'}: it cannot be used ({error.strerror or error}). Check the name, the permissions and the space on the disk."
        )
        return 2
    except BaseException as error:  # a panic of the compiled core is not an Exception
        if debug:
            raise
        _say(f"internal error ({type(error).__name__}: {error}). This is a bug in Guideway; run again with --debug for the details and report it.")
        return 1


def _run(words: list[str]) -> int:
    parser = _parser(words[0] if words else None)
    if not words:
        parser.print_help()
        return 2
    arguments = parser.parse_args(_glued(words))
    return int(arguments.handler(arguments))


def _parser(verb: str | None) -> _Parser:
    parser = _Parser(
        prog="guideway",
        description="Motion planning for industrial robots: a map in, a motion out.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=_version())
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    verbs = parser.add_subparsers(metavar="VERB", required=True, parser_class=_Parser)
    for name, about in VERBS.items():
        sub = verbs.add_parser(name, help=about, description=about[0].upper() + about[1:] + ".", allow_abbrev=False)
        sub.formatter_class = argparse.RawDescriptionHelpFormatter
        if name == verb:  # the others stay unloaded: a quick start matters
            importlib.import_module(f"guideway.commands.{name}").declare(sub)
    return parser


def _glued(words: list[str]) -> list[str]:
    """Joins ``--start -1,2`` to ``--start=-1,2``, which argparse would take for an option."""
    glued: list[str] = []
    for word in words:
        if glued and glued[-1].startswith("--") and "=" not in glued[-1] and _VALUE.match(word):
            glued[-1] += "=" + word
        else:
            glued.append(word)
    return glued


def _version() -> str:
    from guideway import __version__

    return f"guideway {__version__}"


def _say(message: str) -> None:
    width = max(40, min(110, _columns()))
    print(textwrap.fill(f"guideway: {message}", width, break_long_words=False, break_on_hyphens=False), file=sys.stderr)


def _columns() -> int:
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns
    except (OSError, ValueError):
        return 110


if __name__ == "__main__":
    sys.exit(main())
