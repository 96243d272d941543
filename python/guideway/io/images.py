"""Images as arrays of integers: PGM and PPM (text and binary, 8 and 16 bit) by our own reader, PNG and BMP by Pillow.

The kind is told by the first bytes, never by the name: three-channel images named ``.pgm`` exist. Sizes are read from the header and checked before
anything is unpacked or allocated.
"""

from __future__ import annotations

import io
import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from guideway.errors import BadFile
from guideway.io.files import MAX_BYTES, Blob, guard, name
from guideway.io.types import MAX_CELLS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from PIL.Image import Image

    Array = NDArray[np.uint8 | np.uint16]

KINDS = "PGM or PPM (P2, P3, P5, P6), PNG, BMP"
_HEAD = 1 << 16  # bytes in which a header with its comments must end
_PNM = re.compile(rb"P[2356](?:\s|#[^\r\n]*[\r\n])+(\d+)(?:\s|#[^\r\n]*[\r\n])+(\d+)(?:\s|#[^\r\n]*[\r\n])+(\d+)(?:#[^\r\n]*)?\s")
_KIND = bytes(1 if chr(c).isdigit() and c < 128 else 0 if c in b" \t\r\n\v\f" else 2 for c in range(256))  # digit 1, space 0, other 2
_DEFLATE = 1032  # largest factor by which deflate can shrink data


@dataclass(frozen=True, eq=False)
class Pixels:
    """An image: ``grey`` of shape (height, width) or ``rgb`` of shape (height, width, 3), values 0 to ``top``; ``alpha`` (height, width) or None.

    Row 0 is the top row. ``alpha`` has the same scale, ``top`` is opaque. Values are stored as the file has them.
    """

    values: Array
    top: int
    alpha: Array | None = None


def decode(blob: Blob) -> Pixels:
    """Decodes the image in ``blob`` (gzip is unpacked under a bound given by the image's own header).

    Raises :class:`BadFile` for other formats, more than 2^28 cells, truncated or damaged data and values above the declared maximum.
    """
    head = blob.head(_HEAD)
    if re.match(rb"P[2356][\s#]", head):
        return _pnm(blob, head)
    if head.startswith(b"\x89PNG\r\n\x1a\n"):
        return _png(blob, head)
    if head.startswith(b"BM"):
        return _bmp(blob, head)
    raise BadFile(name(blob.path), "this is not an image of a known kind", KINDS, "Convert the image")


def check_size(where: str, width: int, height: int) -> None:
    """Refuses an empty grid and one of more than 2^28 cells."""
    if width < 1 or height < 1 or width * height > MAX_CELLS:
        raise BadFile(where, f"the header says {_digits(width)} x {_digits(height)} cells", f"1 to {MAX_CELLS} cells in all", "Use a smaller map")


def _digits(value: int) -> str:
    return str(value) if abs(value) < 10**15 else "more than 10^15"


def _pnm(blob: Blob, head: bytes) -> Pixels:
    import numpy as np

    where = name(blob.path)
    match = _PNM.match(head)
    if not match:
        raise BadFile(
            where, "the header is damaged or too long", "P2, P3, P5 or P6, then width, height and maximum as whole numbers", "Write it again"
        )
    if any(len(group.lstrip(b"0")) > 18 for group in match.groups()):
        raise BadFile(where, "the header holds a number of more than 18 digits", f"1 to {MAX_CELLS} cells in all", "Use a smaller map")
    width, height, top = (int(group) for group in match.groups())
    check_size(where, width, height)
    if not 1 <= top <= 65535:
        raise BadFile(where, f"the header's maximum value is {top}", "1 to 65535", "Write the image again")
    shape = (height, width, 3) if head[1:2] in b"36" else (height, width)
    count = int(np.prod(shape))
    values = _plain(blob, match.end(), count, top) if head[1:2] in b"23" else _binary(blob, match.end(), count, top)
    if top not in (255, 65535) and int(values.max()) > top:
        raise BadFile(where, f"a pixel has the value {int(values.max())}", f"0 to {top}, the maximum in the header", "Write the image again")
    return Pixels(_grey_if_equal(values.reshape(shape)), top)


def _grey_if_equal(values: Array) -> Array:
    """Three equal channels are one: every way to weigh them gives the same grey."""
    if values.ndim == 3 and (values[..., 0] == values[..., 1]).all() and (values[..., 0] == values[..., 2]).all():
        return values[..., 0].copy()
    return values


def _binary(blob: Blob, start: int, count: int, top: int) -> Array:
    import numpy as np

    size = count * (1 if top < 256 else 2)
    where = name(blob.path)
    if size > MAX_BYTES:
        raise BadFile(where, f"the header promises {size} bytes of pixels", f"at most {MAX_BYTES}", "Use 8 bits and one channel")
    # what follows the first image of the file is not looked at
    data = blob.head(start + size) if blob.packed else blob.raw
    if len(data) < start + size:
        raise BadFile(where, f"the image is cut off: {len(data) - start} bytes of pixels", f"{size} bytes as its header says", "Copy the file again")
    if top < 256:
        return np.frombuffer(data, np.uint8, count, start)
    return np.frombuffer(data, ">u2", count, start).astype(np.uint16)


def _plain(blob: Blob, start: int, count: int, top: int) -> Array:
    import numpy as np

    where = name(blob.path)
    limit = min(MAX_BYTES, start + 16 * count + (1 << 20))  # room for wide spacing and comments
    data = blob.data(limit) if blob.packed else blob.raw
    body = data[start:]
    if b"#" in body:
        body = re.sub(rb"#[^\r\n]*", b"", body)
    if len(body) < 2 * count - 1:
        raise BadFile(where, f"the image is cut off: {len(body)} bytes of text", f"{count} whole numbers as its header says", "Copy the file again")
    kinds = body.translate(_KIND)
    if b"\2" in kinds or b"\1" * 10 in kinds:
        raise BadFile(where, "the pixels are not whole numbers of at most 9 digits", f"{count} numbers from 0 to {top}", "Write the image again")
    found = kinds.count(b"\0\1") + kinds.startswith(b"\1")
    if found != count:
        raise BadFile(where, f"there are {found} pixels", f"{count} pixels, as the header says", "Copy the file again")
    values = np.fromstring(body, np.int32, sep=" ")  # any white space counts as a separator
    if int(values.max()) > top:
        raise BadFile(where, f"a pixel has the value {int(values.max())}", f"0 to {top}, the maximum in the header", "Write the image again")
    return values.astype(np.uint8 if top < 256 else np.uint16)


def _png(blob: Blob, head: bytes) -> Pixels:
    where = name(blob.path)
    if len(head) < 29 or head[12:16] != b"IHDR":
        raise BadFile(where, "the PNG header is damaged", todo="Write the image again")
    width, height, depth, color = struct.unpack(">IIBB", head[16:26])
    check_size(where, width, height)
    bits = width * height * depth * {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}.get(color, 1)
    _plausible(where, bits, blob, _DEFLATE)
    with guard(where, "the PNG image"):
        from PIL.PngImagePlugin import PngImageFile

        # the plug-in itself: Image.open would load every other format and judge sizes by a global setting
        return _pillow(where, lambda: PngImageFile(io.BytesIO(_encoded(blob))))


def _bmp(blob: Blob, head: bytes) -> Pixels:
    where = name(blob.path)
    if len(head) < 30:
        raise BadFile(where, "the BMP header is cut off", todo="Copy the file again")
    (kind,) = struct.unpack("<I", head[14:18])
    if kind == 12:
        (width, height), (_, bits), packing = struct.unpack("<HH", head[18:22]), struct.unpack("<HH", head[22:26]), 0
    elif 16 <= kind <= 1024 and len(head) >= 34:
        width, height, _, bits, packing = struct.unpack("<iiHHI", head[18:34])
    else:
        raise BadFile(where, f"the BMP header has {kind} bytes", "12, or 40 to 124", "Convert the image to PNG")
    height = abs(height)
    check_size(where, width, height)
    _plausible(where, width * height * bits, blob, 1 if packing in (0, 3) else 512)
    with guard(where, "the BMP image"):
        from PIL.BmpImagePlugin import BmpImageFile

        return _pillow(where, lambda: BmpImageFile(io.BytesIO(_encoded(blob))))


def _encoded(blob: Blob) -> bytes:
    return blob.data(MAX_BYTES // 4) if blob.packed else blob.raw


def _plausible(where: str, bits: int, blob: Blob, factor: int) -> None:
    """Refuses an image whose file is too small to hold the pixels that its header promises, before memory is taken for them."""
    if bits // 8 > MAX_BYTES:
        raise BadFile(where, f"the header promises {bits // 8} bytes of pixels", f"at most {MAX_BYTES}", "Use 8 bits and one channel")
    stored = len(blob.raw) * (_DEFLATE if blob.packed else 1)
    if stored * factor < bits // 8:
        raise BadFile(
            where, f"{len(blob.raw)} bytes cannot hold the {bits // 8} bytes of pixels that the header promises", todo="Copy the file again"
        )


def _pillow(where: str, read: Callable[[], Image]) -> Pixels:
    import numpy as np

    try:
        image = read()
        check_size(where, *image.size)
        transparent = image.info.get("transparency")
        if image.mode.startswith("I"):
            values = np.asarray(image).astype(np.uint16)
            alpha = np.where(values == transparent, 0, 65535).astype(np.uint16) if isinstance(transparent, int) else None
            return Pixels(values, 65535, alpha)
        wanted = {"1": "L", "L": "L", "LA": "LA", "RGB": "RGB", "RGBA": "RGBA", "P": "RGB", "PA": "RGBA"}.get(image.mode)
        if wanted is None:
            raise BadFile(where, f"pixels of the kind {image.mode}", "grey, RGB, RGBA or palette", "Convert the image to 8 bit grey")
        if transparent is not None:
            wanted = {"L": "LA", "RGB": "RGBA"}.get(wanted, wanted)
        array = np.asarray(image if image.mode == wanted else image.convert(wanted))
    except (BadFile, OSError, ValueError, MemoryError):
        raise
    except Exception as e:  # decoders raise what they like on damaged data: SyntaxError, struct.error, zlib.error ...
        raise BadFile(where, "the image data are damaged", todo="Write the image again") from e
    if wanted == "LA":
        return Pixels(array[..., 0], 255, array[..., 1])
    if wanted == "RGBA":
        return Pixels(_grey_if_equal(array[..., :3]), 255, array[..., 3])
    return Pixels(_grey_if_equal(array), 255)
