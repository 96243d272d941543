"""Markdown and CSV of the records of scripts."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parents[1] / "docs/experiments.md"


def markdown(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)]) + "\n"


def write_csv(path: Path, rows: list[dict[str, Any]]) -> None:
    names = list(dict.fromkeys(name for row in rows for name in row))
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)


def publish(name: str, command: str, text: str, out: Path, docs: bool) -> None:
    """Prints the text, writes it to ``out/NAME.md`` and, if asked, between its marks in docs/experiments.md."""
    print(text)
    (out / f"{name}.md").write_text(text)
    if docs:
        begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
        page = DOCS.read_text()
        before, after = page[: page.index(begin)], page[page.index(end) :]
        DOCS.write_text(f"{before}{begin}\nMade by `{command}`.\n\n{text}\n{after}")
