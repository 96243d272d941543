"""Triangle meshes of links: STL files, and the volume, centre and inertia of the solid they bound."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from guideway.errors import BadFile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def load_stl(path: str | os.PathLike[str]) -> Floats:
    """The triangles (n, 3, 3) of an STL file, binary or text, in m; raises :class:`guideway.errors.BadFile`."""
    from guideway.io.files import load, name

    where, raw = name(path), load(path).data()
    count = int.from_bytes(raw[80:84], "little") if len(raw) >= 84 else -1
    if len(raw) == 84 + 50 * count:
        rows = np.frombuffer(raw[84:], np.dtype([("normal", "<3f4"), ("corners", "<9f4"), ("more", "<u2")]))
        triangles = rows["corners"].astype(float).reshape(-1, 3, 3)
    else:
        words = [line.split() for line in raw.decode("utf-8", "replace").splitlines()]
        try:
            corners = np.array([row[1:4] for row in words if row[:1] == ["vertex"]], float)
            triangles = corners.reshape(-1, 3, 3)
        except ValueError:
            triangles = np.zeros((0, 3, 3))
    if not len(triangles) or not np.isfinite(triangles).all():
        raise BadFile(where, "this is no STL mesh, or an empty one", "an STL file of triangles", "Export the mesh again")
    return triangles


def solid(triangles: Floats) -> tuple[float, Floats, Floats]:
    """Volume (m3), centre (m) and the inertia about that centre for density 1 (m5) of the solid inside a closed mesh."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    volume = float(volumes.sum())
    center = np.einsum("i,ij->j", volumes, a + b + c) / (4 * volume)
    # second moments of tetrahedra with one corner at the origin
    total = a + b + c
    moments = sum(np.einsum("i,ij,ik->jk", volumes, p, p) for p in (a, b, c, total)) / 20
    moments = np.asarray(moments) - volume * np.outer(center, center)
    return volume, center, np.trace(moments) * np.eye(3) - moments
