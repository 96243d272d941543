"""Writing files whole or not at all, with complaints that name the file."""

from __future__ import annotations

import os

from guideway.files import write_whole
from guideway.io.files import guard, name


def write_atomic(path: str | os.PathLike[str], data: bytes | str) -> None:
    """Writes ``data`` (text as UTF-8) to ``path``, whole or not at all; see :func:`guideway.files.write_whole`.

    Raises :class:`guideway.errors.BadFile` if the folder is missing or not writable, or the disk is full.
    """
    with guard(name(path), "the output"):
        write_whole(path, data)
