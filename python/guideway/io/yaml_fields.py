"""The flat part of a YAML file, read from parser events: no objects are built, so nesting, aliases and tags can do no harm."""

from __future__ import annotations

from typing import Any

from guideway.errors import BadFile
from guideway.io.files import guard, show

_MAX_DEPTH = 20
_MAX_EVENTS = 10_000


def read_fields(where: str, text: str) -> dict[str, object]:
    """Top-level fields of the first document of a YAML file: ``str`` for a scalar, ``list[str]`` for a list of scalars, ``...`` for anything deeper.

    Raises :class:`BadFile` for text that is no YAML, for anchors, aliases, repeated fields, and for nesting or lengths that no map needs.
    """
    import yaml

    loader: Any = getattr(yaml, "CBaseLoader", yaml.BaseLoader)
    with guard(where):
        try:
            return _Fields(where).read(yaml.parse(text, Loader=loader))
        except yaml.MarkedYAMLError as e:
            line = f", line {e.problem_mark.line + 1}" if e.problem_mark else ""
            raise BadFile(f"{where}{line}", f"this is not valid YAML: {show(e.problem or 'syntax error')}", todo="Correct the line") from e
        except yaml.YAMLError as e:
            raise BadFile(where, "this is not valid YAML", todo="Check that the file is text and not damaged") from e


class _Fields:
    def __init__(self, where: str) -> None:
        self.where = where
        self.fields: dict[str, object] = {}
        self.key: str | None = None
        self.depth = 0

    def read(self, events: Any) -> dict[str, object]:
        for count, event in enumerate(events):
            if count > _MAX_EVENTS or self.depth > _MAX_DEPTH:
                raise BadFile(self._at(event), "nested too deeply or too long for a map", "about ten fields", "Check that this is a map file")
            kind = type(event).__name__
            if kind == "AliasEvent" or getattr(event, "anchor", None):
                raise BadFile(self._at(event), "anchors and aliases are not used in map files", todo="Write the value out")
            if kind == "DocumentEndEvent":
                return self.fields
            self._take(kind, event)
        return self.fields

    def _take(self, kind: str, event: Any) -> None:
        if kind == "ScalarEvent":
            self._scalar(event)
        elif kind in ("MappingStartEvent", "SequenceStartEvent"):
            if self.depth == 0 and kind == "SequenceStartEvent":
                raise self._no_mapping(event)
            if self.depth == 1:
                self._set(event, [] if kind == "SequenceStartEvent" else ...)
            elif self.depth > 1:
                self._deep()
            self.depth += 1
        elif kind in ("MappingEndEvent", "SequenceEndEvent"):
            self.depth -= 1
            if self.depth == 1:
                self.key = None

    def _scalar(self, event: Any) -> None:
        if self.depth == 0:
            raise self._no_mapping(event)
        if self.depth == 1 and self.key is None:
            self.key = str(event.value)
            if self.key in self.fields:
                raise BadFile(f"{self._at(event)}, field {show(self.key)}", "the field is given twice", todo="Keep one")
        elif self.depth == 1:
            self._set(event, str(event.value))
            self.key = None
        elif self.depth == 2 and self.key is not None and isinstance(self.fields[self.key], list):
            values: Any = self.fields[self.key]
            values.append(str(event.value))

    def _set(self, event: Any, value: object) -> None:
        if self.key is None:
            raise BadFile(self._at(event), "a field's name is not plain text", todo="Correct the line")
        self.fields[self.key] = value

    def _deep(self) -> None:
        if self.key is not None:
            self.fields[self.key] = ...

    def _at(self, event: Any) -> str:
        return f"{self.where}, line {event.start_mark.line + 1}"

    def _no_mapping(self, event: Any) -> BadFile:
        return BadFile(self._at(event), "this is not a map", "fields such as image, resolution and origin", "Name a map_server YAML file")
