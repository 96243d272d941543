"""Files as bytes: only regular files, bounded sizes, gzip unpacked under a bound, nothing written by halves."""

from __future__ import annotations

import contextlib
import os
import stat
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from guideway.errors import BadFile

MAX_BYTES = 1 << 30
"""Largest file that is read, and largest size that a gzip file may unpack to (1 GiB)."""

MAX_TEXT = 1 << 23
"""Largest text file with settings (YAML, TOML, CSV): 8 MiB; parsed, such text may take a hundred times its size."""


def show(value: object, width: int = 60) -> str:
    """``value`` on one line, at most about ``width`` characters, whatever it is."""
    import reprlib

    short = reprlib.Repr()
    short.maxstring = short.maxother = short.maxlong = width
    short.maxlist = short.maxtuple = 8
    short.maxdict, short.maxlevel = 4, 3
    text = " ".join("".join(c if c.isprintable() else " " for c in short.repr(value)).split())
    return text if len(text) <= 2 * width else text[: 2 * width] + "..."


def word(value: object, width: int = 60) -> str:
    """A name out of a file as it is shown without quotes: one line, single spaces."""
    return " ".join(show(str(value), width)[1:-1].split())


def name(path: str | os.PathLike[str]) -> str:
    """A path as it is shown in messages: one line, printable, not absurdly long."""
    text = "".join(c if c.isprintable() else "?" for c in os.fspath(path))
    return text if len(text) <= 200 else "..." + text[-197:]


@contextlib.contextmanager
def guard(where: str, what: str = "the file") -> Iterator[None]:
    """Turns what the system and the standard parsers raise into :class:`BadFile`."""
    try:
        yield
    except UnicodeDecodeError as e:
        raise BadFile(where, f"{what} is not text: byte {e.start} is not valid UTF-8", todo="Save it as UTF-8 text") from e
    except OSError as e:
        raise BadFile(where, f"{what} cannot be used ({(e.strerror or str(e)).lower()})", todo="Check the name and the permissions") from e
    except MemoryError as e:
        raise BadFile(where, f"{what} does not fit in memory", todo="Use a smaller file or a machine with more memory") from e
    except (RecursionError, OverflowError) as e:
        raise BadFile(where, f"{what} is nested too deeply or holds numbers that are too large", todo="Simplify it") from e
    except ValueError as e:
        raise BadFile(where, f"{what} cannot be understood ({show(str(e))})", todo="Check its contents") from e


@dataclass(frozen=True)
class Blob:
    """A file in memory: ``raw`` bytes as stored and their ``sha256``."""

    path: Path
    raw: bytes
    sha256: str

    @property
    def packed(self) -> bool:
        """Is it gzip?"""
        return self.raw[:2] == b"\x1f\x8b"

    def head(self, count: int) -> bytes:
        """The first ``count`` bytes of the contents, unpacked."""
        return _gunzip(self.raw, count, self.path, cut=True) if self.packed else self.raw[:count]

    def data(self, limit: int = MAX_BYTES) -> bytes:
        """The contents, unpacked; more than ``limit`` bytes are refused."""
        if self.packed:
            return _gunzip(self.raw, limit, self.path, cut=False)
        if len(self.raw) > limit:
            raise _too_large(self.path, len(self.raw), limit)
        return self.raw

    def text(self, limit: int = MAX_TEXT) -> str:
        """The contents as UTF-8 text; a byte order mark is dropped."""
        data = self.data(limit)
        with guard(name(self.path)):
            return data.decode("utf-8-sig")


def load(path: str | os.PathLike[str], limit: int = MAX_BYTES) -> Blob:
    """Reads a regular file of at most ``limit`` bytes.

    Raises :class:`BadFile` if it is missing, unreadable, not a regular file (a folder, pipe or device is refused before it is read) or too large.
    """
    import hashlib

    where = name(path)
    with guard(where):
        if "\0" in os.fspath(path):
            raise BadFile(where, "the name holds a NUL character", todo="Check the name")
        _regular(where, os.stat(path), limit)
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0))
        with open(descriptor, "rb") as file:
            status = os.fstat(descriptor)
            _regular(where, status, limit)
            raw = file.read(status.st_size + 1)  # one more tells whether it grew
        if len(raw) > limit:
            raise _too_large(path, len(raw), limit)
        if not raw:
            raise BadFile(where, "the file is empty", todo="Check that it was written or copied completely")
        return Blob(Path(path), raw, hashlib.sha256(raw).hexdigest())


def _regular(where: str, status: os.stat_result, limit: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        kinds = {stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket"}
        raise BadFile(where, f"this is {kinds.get(stat.S_IFMT(status.st_mode), 'a device')}, not a file", todo="Name a regular file")
    if status.st_size > limit:
        raise _too_large(where, status.st_size, limit)


def _too_large(path: str | os.PathLike[str], size: int, limit: int) -> BadFile:
    return BadFile(name(path), f"the file has {size} bytes", f"at most {limit} bytes", "Use a smaller file")


def _gunzip(raw: bytes, limit: int, path: Path, *, cut: bool) -> bytes:
    """Unpacks gzip members one after the other and stops at ``limit``; ``cut``: return what there is then, else refuse."""
    where, parts, left, rest = name(path), [], limit if cut else limit + 1, raw
    while rest[:2] == b"\x1f\x8b" and left > 0:
        stream = zlib.decompressobj(wbits=31)
        try:
            part = stream.decompress(rest, left)
        except zlib.error as e:
            raise BadFile(where, f"the gzip data are damaged ({show(str(e))})", todo="Copy the file again") from e
        parts.append(part)
        left -= len(part)
        if not stream.eof and left > 0:
            if cut:
                break
            raise BadFile(where, "the gzip data end too early", todo="Copy the file again")
        rest = stream.unused_data
    if left <= 0 and not cut:
        raise BadFile(where, f"the gzip data unpack to more than {limit} bytes", "what the header promises", "Use a smaller file or copy it again")
    return b"".join(parts)
