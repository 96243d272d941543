"""Scenes that ship with the package and are opened by name: ``scene:pso-aco-1``."""

from __future__ import annotations

import os
from dataclasses import replace
from importlib.resources import as_file, files
from pathlib import Path

from guideway.errors import BadFile
from guideway.io.files import show
from guideway.io.scene import load_scene
from guideway.io.types import Scene, Thresholds, Unknown

PREFIX = "scene:"
"""What a name begins with where a file could stand; a file of such a name is opened as ``./scene:...``."""

FILES = {
    "pso-aco-1": "scenes/pso-aco-1.toml",
    "pso-aco-2": "scenes/pso-aco-2.toml",
    "m20": "scenes/m20.toml",
    "m30": "scenes/m30.toml",
    "w0": "scenes/w0.toml",
    "w1": "scenes/w1.toml",
    "warehouse": "demo.toml",
}
"""Where each scene lies among the package's data."""


def is_packaged(path: str | os.PathLike[str]) -> bool:
    """Is it the name of a scene that ships with the package rather than a path?"""
    return os.fspath(path).startswith(PREFIX)


def load_packaged(path: str | os.PathLike[str], *, unknown: Unknown | None = None, thresholds: Thresholds | None = None) -> Scene:
    """Loads ``scene:NAME``; its source stays that name, so that records of it are read anywhere. Raises :class:`BadFile` for unknown names."""
    text = os.fspath(path)
    place = FILES.get(text.removeprefix(PREFIX))
    if place is None:
        known = ", ".join(PREFIX + name for name in FILES)
        raise BadFile(show(text)[1:-1], "no scene of this name ships with Guideway", known, "Use one of these, or the path of a file")
    with as_file(files("guideway").joinpath("data")) as folder:
        scene = load_scene(folder / place, unknown=unknown, thresholds=thresholds)
    return replace(scene, source=Path(text))
