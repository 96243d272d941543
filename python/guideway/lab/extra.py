"""Libraries of the extras, loaded where they are first used."""

from __future__ import annotations

import importlib
from typing import Any

from guideway.errors import GuidewayError


class MissingExtra(GuidewayError):
    """A library that does not come with the plain package is not there."""


def needed(module: str, extra: str, why: str) -> Any:
    """A module; where it is missing the error says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MissingExtra(f"{why}, which cannot be loaded here ({error}). Install it with: pip install 'guideway[{extra}]'") from error
