"""ROS map_server maps: a YAML file and its image.

Two readings of such a file are in use. They differ in how a pixel becomes a brightness and in whether a value equal to a threshold belongs to it;
one switch, ``thresholds``, picks the whole reading:

``inclusive`` (default): ``nav2_map_server/src/map_io.cpp`` of Nav2 since its loader was vectorised (pull request 5071, 2025). The image
    becomes 8-bit grey, colours by the Rec. 601 weights of GraphicsMagick; ``p = 1 - grey / 255`` (``grey / 255`` with ``negate``) in single
    precision; a cell is free if ``p <= free_thresh``, else occupied if ``p >= occupied_thresh``; otherwise unknown in ``trinary`` mode and a value
    from 0 to 100 between the thresholds in ``scale`` mode. A pixel that is not fully opaque is unknown in both. In ``raw`` mode grey 0 to 100 is
    the value, above is unknown, ``negate`` is not used.
``strict``: ``map_server/src/image_loader.cpp`` of ROS 1 (Nav2 before 2025 compares alike). The brightness is the plain mean of
    the channels; in ``trinary`` mode alpha counts as one more channel; ``p = (255 - mean) / 255`` (``negate`` first replaces the mean by
    255 - mean) in double precision; a cell is occupied if ``p > occupied_thresh``, else free if ``p < free_thresh``; otherwise unknown in
    ``trinary`` mode, and in ``scale`` mode unknown where fully transparent, else ``1 + 98 (p - free) / (occupied - free)`` cut to a whole number.
    In ``raw`` mode the mean is the value (``negate`` applies), above 100 is unknown.

A cell blocks the robot if its value is 100, like Nav2's static layer with its default settings; unknown cells block unless asked otherwise.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, cast

from guideway.errors import BadFile
from guideway.io.files import MAX_TEXT, Blob, load, name, show
from guideway.io.types import GridMap, Thresholds, Unknown

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from guideway.io.images import Pixels

Mode = Literal["trinary", "scale", "raw"]
_UNKNOWN, _FREE, _OCCUPIED = -1, 0, 100
_TRUE = {"1", "true", "yes", "on", "y"}
_FALSE = {"0", "false", "no", "off", "n"}


@dataclass(frozen=True)
class Header:
    """The YAML file: ``resolution`` in m per pixel, ``origin`` x, y (m), yaw (rad) of the lower-left corner, thresholds as probabilities."""

    image: str
    resolution: float
    origin: tuple[float, float, float]
    occupied: float
    free: float
    negate: bool
    mode: Mode


def load_map_server(path: str | os.PathLike[str], *, unknown: Unknown = "blocked", thresholds: Thresholds = "inclusive") -> GridMap:
    """Loads a map_server YAML file and its image (or the image with ``.gz`` added to its name) as a :class:`GridMap`.

    Raises :class:`BadFile` naming the file and the field.
    """
    from guideway.io.images import decode

    blob = load(path, MAX_TEXT)
    header = read_header(blob)
    image = _image(blob.path, header.image)
    values = occupancy(decode(image), header, thresholds)
    blocked, unseen = values == _OCCUPIED, values == _UNKNOWN
    seen_all = not unseen.any()
    if unknown == "blocked" and not seen_all:
        blocked |= unseen
    return GridMap(
        blocked=blocked,
        unknown=None if seen_all else unseen,
        resolution=header.resolution,
        origin=header.origin,
        source=blob.path,
        sha256=blob.sha256,
        files={blob.path.name: blob.sha256, header.image: image.sha256},
        kind="map_server",
        thresholds=thresholds,
    )


def read_header(blob: Blob) -> Header:
    """The checked fields of a map_server YAML file; fields it does not know are passed over, as ROS does."""
    from guideway.io.yaml_fields import read_fields

    where = name(blob.path)
    fields = read_fields(where, blob.text(1 << 20))
    image = fields.get("image")
    if not isinstance(image, str) or not image.strip() or "\0" in image:
        raise _bad(where, "image", fields.get("image"), "the file name of the map image, relative to this file")
    resolution = _number(where, fields, "resolution", 1e-6, 1e6, "m per pixel")
    occupied = _number(where, fields, "occupied_thresh", 0.0, 1.0, "(a probability)")
    free = _number(where, fields, "free_thresh", 0.0, 1.0, "(a probability)")
    if free > occupied:
        raise _bad(where, "free_thresh", free, f"at most occupied_thresh ({occupied})")
    mode = str(fields.get("mode", "trinary")).lower()
    if mode not in ("trinary", "scale", "raw"):
        raise _bad(where, "mode", fields.get("mode"), "trinary, scale or raw")
    return Header(image, resolution, _origin(where, fields), occupied, free, _flag(where, fields), cast(Mode, mode))


def _origin(where: str, fields: dict[str, object]) -> tuple[float, float, float]:
    origin = fields.get("origin")
    allowed = "[x, y, yaw]: three finite numbers, m and rad, between -1e9 and 1e9"
    if not isinstance(origin, list) or len(origin) != 3:
        raise _bad(where, "origin", origin, allowed)
    x, y, yaw = (_parse(value) for value in origin)
    if x is None or y is None or yaw is None or max(abs(x), abs(y), abs(yaw)) > 1e9:
        raise _bad(where, "origin", origin, allowed)
    return x, y, yaw


def _flag(where: str, fields: dict[str, object]) -> bool:
    word = str(fields.get("negate", "0")).lower()
    if word in _TRUE | _FALSE:
        return word in _TRUE
    raise _bad(where, "negate", fields.get("negate"), "0 or 1")


def _number(where: str, fields: dict[str, object], key: str, low: float, high: float, unit: str) -> float:
    value = _parse(fields.get(key))
    if value is None or not low <= value <= high:
        raise _bad(where, key, fields.get(key), f"a number from {low:g} to {high:g} {unit}")
    return value


def _parse(value: object) -> float | None:
    """A finite decimal number; YAML files of the wild write 5e-2 without a dot, which strict YAML 1.1 calls a string."""
    if not isinstance(value, str) or len(value) > 60 or "_" in value:
        return None
    try:
        number = float(value)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def _bad(where: str, key: str, value: object, allowed: str) -> BadFile:
    what = "the field is missing" if value is None else f"{show(value)} cannot be used"
    return BadFile(f"{where}, field {key}", what, allowed, "Correct the field")


def _image(yaml: Path, image: str) -> Blob:
    path = yaml.parent / image
    if not os.path.lexists(path):
        packed = path.with_name(path.name + ".gz")
        if not os.path.lexists(packed):
            raise BadFile(f"{name(yaml)}, field image", f"the image {name(path)} does not exist", todo="Correct the field or copy the image there")
        path = packed
    return load(path)


def occupancy(pixels: Pixels, header: Header, thresholds: Thresholds = "inclusive") -> NDArray[np.int8]:
    """Occupancy of shape (height, width), row 0 at the top: -1 unknown, 0 free ... 100 occupied."""
    if thresholds == "strict":
        return _strict(pixels, header)
    if thresholds == "inclusive":
        return _inclusive(pixels, header)
    raise BadFile("thresholds", f"{show(thresholds)} is not a reading", "inclusive or strict", "Name one of the two")


def _inclusive(pixels: Pixels, header: Header) -> NDArray[np.int8]:
    import numpy as np

    levels = np.arange(256, dtype=np.float32)
    if header.mode == "raw":
        table = np.where(levels <= 100, levels, _UNKNOWN)
    else:
        p = levels / np.float32(255)
        p = p if header.negate else np.float32(1) - p
        low, high = np.float32(header.free), np.float32(header.occupied)
        table = np.full(256, _UNKNOWN, np.float32)
        if header.mode == "scale" and high > low:
            between = (p > low) & (p < high)
            share = (p[between] - low) / np.float32(header.occupied - header.free)
            table[between] = np.floor(share * np.float32(100) + np.float32(0.5))
        table[p >= high] = _OCCUPIED
        table[p <= low] = _FREE
    values = _look_up(_grey8(pixels), table.astype(np.int8))
    if pixels.alpha is not None and header.mode != "raw":
        values = np.where(pixels.alpha < pixels.top, np.int8(_UNKNOWN), values)
    return values


def _grey8(pixels: Pixels) -> NDArray[np.uint8]:
    """8-bit grey, rounded to nearest; colours by Rec. 601 in 1/1024."""
    import numpy as np

    values, top = pixels.values, pixels.top
    if values.ndim == 2 and top == 255:
        return values.astype(np.uint8, copy=False)
    if values.ndim == 2:
        return ((values.astype(np.uint32) * 510 + top) // (2 * top)).astype(np.uint8)
    grey = np.empty(values.shape[:2], np.uint8)
    for i in range(0, len(values), 64):  # bands of rows: the wide integers stay small in memory
        weighted = values[i : i + 64] @ np.array([306, 601, 117], np.uint64)
        grey[i : i + 64] = (weighted * 510 + 1024 * top) // (2048 * top)
    return grey


def _strict(pixels: Pixels, header: Header) -> NDArray[np.int8]:
    import numpy as np

    levels, top = _channel_sum(pixels, header.mode)
    mean = np.arange(top + 1) * (255.0 / top) if top != 255 else np.arange(256.0)
    mean = 255.0 - mean if header.negate else mean
    if header.mode == "raw":
        return _look_up(levels, np.where(mean < 101, np.floor(mean), _UNKNOWN).astype(np.int8))
    p = (255.0 - mean) / 255.0
    table = np.full(top + 1, _UNKNOWN, np.float64)
    if header.mode == "scale":
        width = header.occupied - header.free
        # both thresholds equal: only p == threshold is between, and any share of the range will do
        table = np.trunc(1 + 98 * np.clip((p - header.free) / width, 0, 1)) if width > 0 else np.full(top + 1, 1.0)
    table[p < header.free] = _FREE
    table[p > header.occupied] = _OCCUPIED
    values = _look_up(levels, table.astype(np.int8))
    if header.mode == "scale" and pixels.alpha is not None:
        values = np.where((pixels.alpha == 0) & (values != _FREE) & (values != _OCCUPIED), np.int8(_UNKNOWN), values)
    return values


def _channel_sum(pixels: Pixels, mode: Mode) -> tuple[NDArray[np.uint8] | NDArray[np.uint32], int]:
    """Sum of the channels that count, and its largest possible value."""
    import numpy as np

    values, top = pixels.values, pixels.top
    alpha = pixels.alpha if mode == "trinary" else None
    if values.ndim == 2 and alpha is None:
        return (values.astype(np.uint8, copy=False), 255) if top == 255 else (values.astype(np.uint32), top)
    total = values.astype(np.uint32) if values.ndim == 2 else values.sum(axis=2, dtype=np.uint32)
    channels = 1 if values.ndim == 2 else 3
    if alpha is not None:
        # SDL unpacks grey with alpha to RGBA: grey counts three times
        total = total * (3 // channels) + alpha
        channels = 4
    return total, channels * top


def _look_up(levels: NDArray[np.uint8] | NDArray[np.uint32], table: NDArray[np.int8]) -> NDArray[np.int8]:
    import numpy as np

    if levels.dtype == np.uint8 and len(table) == 256:
        # bytes.translate takes 1 ns a cell and no index array; the result is read-only
        return np.frombuffer(levels.tobytes().translate(table.tobytes()), np.int8).reshape(levels.shape)
    return table[levels]
