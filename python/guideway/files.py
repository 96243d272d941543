"""Writing files whole or not at all, for everything in this package that writes one."""

from __future__ import annotations

import contextlib
import os
import stat


def write_whole(path: str | os.PathLike[str], data: bytes | str) -> None:
    """Writes ``data`` (text as UTF-8) to ``path``, whole or not at all: beside it, synced to disk, then renamed.

    An interrupted write leaves the old file (or none) and nothing beside it. A link is followed; a pipe or device (``/dev/stdout``) is written
    directly. Raises ``OSError`` if the folder is missing or not writable, or the disk is full.
    """
    raw = data.encode() if isinstance(data, str) else data
    target = os.path.realpath(path)
    if _special(target):
        with open(path, "wb") as file:
            file.write(raw)
        return
    if os.path.isdir(target):
        raise IsADirectoryError(0, "it is a folder", os.fspath(path))
    _replace(target, raw)


def _special(target: str) -> bool:
    with contextlib.suppress(OSError):
        mode = os.stat(target).st_mode
        return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))
    return False


def _replace(target: str, raw: bytes) -> None:
    folder, base = os.path.split(target)
    beside = os.path.join(folder, f".{base[:100]}.{os.getpid()}.{os.urandom(4).hex()}.part")
    descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
    try:
        with open(descriptor, "wb") as file:
            with contextlib.suppress(OSError):
                os.chmod(beside, stat.S_IMODE(os.stat(target).st_mode))
            file.write(raw)
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(beside)
        raise
    _sync_folder(folder)


def _sync_folder(folder: str) -> None:
    """Makes the rename itself durable where the system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
