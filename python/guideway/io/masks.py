"""Masks of site rules: where a robot must not go, and where how fast it may go.

The masks are those of Nav2's costmap filters (https://docs.nav2.org, keepout filter and speed filter): map_server files of their own
resolution and origin. What their values mean is said in :mod:`guideway.site_rules`.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from guideway.io.files import MAX_TEXT, load

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from guideway.io.map_server import Header


def read_mask(path: str | os.PathLike[str]) -> tuple[NDArray[np.int8], Header, dict[str, str]]:
    """Values (-1 unknown, 0 to 100) of shape (height, width), row 0 on top, the frame, and the sha256 of each file."""
    from guideway.io.images import decode
    from guideway.io.map_server import _image, occupancy, read_header

    blob = load(path, MAX_TEXT)
    header = read_header(blob)
    image = _image(blob.path, header.image)
    return occupancy(decode(image), header), header, {blob.path.name: blob.sha256, header.image: image.sha256}
