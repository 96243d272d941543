"""What an experiment file says about its source: figures in print, and claims with how they are judged."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from guideway.io.files import show
from guideway.io.tables import Table
from guideway.lab.experiment import Claim, Published

Names = Mapping[str, list[str]]
TESTS = ("lower", "higher", "within", "share", "growth", "none")
STATISTICS = ("mean", "sd", "median", "best", "worst", "min", "max", "share")


def read_published(top: Table, names: Names, metrics: list[str]) -> tuple[Published, ...]:
    """The tables headed ``[[published]]``; what they name must be there, unless ``elsewhere = true`` says that the map or method is not."""
    return tuple(_published(table, names, metrics) for table in top.tables("published"))


def _published(table: Table, names: Names, metrics: list[str]) -> Published:
    elsewhere = table.flag("elsewhere")
    found = Published(
        table=_text(table, "table"),
        world=_text(table, "world") if elsewhere else _named(table, "world", names["worlds"]),
        query=_text(table, "query") if elsewhere else _named(table, "query", names["queries"], names["queries"][0]),
        method=_text(table, "method") if elsewhere else _named(table, "method", names["methods"]),
        metric=_named(table, "metric", metrics),
        statistic=table.choice("statistic", STATISTICS, "mean"),
        value=table.number("value", -1e12, 1e12, ""),
    )
    table.done()
    return found


def read_claims(top: Table, names: Names, metrics: list[str]) -> tuple[Claim, ...]:
    """The tables headed ``[[claims]]``."""
    return tuple(_claim(table, names, metrics) for table in top.tables("claims"))


def _claim(table: Table, names: Names, metrics: list[str]) -> Claim:
    test = table.choice("test", TESTS, "none")
    judged = test != "none"
    found = Claim(
        says=table.text("says") or _missing(table, "says", "a text in quotes"),
        table=_text(table, "table"),
        test=test,
        metric=_named(table, "metric", metrics, None if judged else ""),
        method=_named(table, "method", names["methods"], None if judged else ""),
        than=_list(table, "than", names["methods"]),
        worlds=_list(table, "worlds", names["worlds"]),
        value=table.optional("value", -1e12, 1e12, ""),
        tolerance=table.optional("tolerance", 0, 1e12, ""),
        alpha=table.number("alpha", 0, 1, "", 0.05, above=True),
        reason=_text(table, "reason"),
        possible=table.flag("possible"),
    )
    if found.possible and test != "share":
        raise table.bad("possible", "true only with test = 'share'")
    needs = {"lower": ["than"], "higher": ["than"], "within": ["value", "tolerance"], "share": ["value"], "growth": ["value"], "none": ["reason"]}[
        test
    ]
    for key in needs:
        if getattr(found, key) in (None, (), ""):
            raise table.bad(key, f"it is needed for test = {test!r}")
    table.done()
    return found


def _text(table: Table, key: str) -> str:
    value: Any = table.raw(key)
    if key not in table:
        return ""
    if not isinstance(value, str) or len(value) > 4096:
        raise table.bad(key, "a text in quotes")
    return value


def _missing(table: Table, key: str, allowed: str) -> str:
    raise table.bad(key, allowed)


def _named(table: Table, key: str, known: list[str], default: str | None = None) -> str:
    value: Any = table.raw(key)
    if key not in table and default is not None:
        return default
    if not isinstance(value, str) or value not in known:
        raise table.bad(key, f"one of {show(known)[1:-1]}")
    return value


def _list(table: Table, key: str, known: list[str]) -> tuple[str, ...]:
    value: Any = table.raw(key)
    if key not in table:
        return ()
    if not isinstance(value, list) or not value or not all(isinstance(name, str) and name in known for name in cast("list[Any]", value)):
        raise table.bad(key, f"a list of names: {show(known)[1:-1]}")
    return tuple(cast("list[str]", value))
