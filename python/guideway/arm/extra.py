"""Pinocchio and Coal, loaded where they are first used."""

from __future__ import annotations

import importlib
from typing import Any


def pinocchio() -> Any:
    """The module ``pinocchio``; raises ``ImportError`` with what to install where it is missing."""
    return _module("pinocchio")


def coal() -> Any:
    """The module ``coal`` (collision geometry), which comes with Pinocchio."""
    return _module("coal")


def _module(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ImportError(f"arms need Pinocchio, which cannot be loaded here ({error}). Install it with: pip install 'guideway[arm]'") from error
