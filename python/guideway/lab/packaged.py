"""Experiments that ship with the package."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from guideway.lab.experiment import Experiment
from guideway.lab.reading import read


def packaged() -> dict[str, Path]:
    """Name -> file of the experiments that ship with the package, sorted by name."""
    folder = Path(str(files("guideway").joinpath("data/experiments")))
    return {path.stem: path for path in sorted(folder.glob("*.toml"), key=lambda path: path.stem)}


def experiments() -> list[Experiment]:
    """All experiments that ship with the package."""
    return [read(path) for path in packaged().values()]
