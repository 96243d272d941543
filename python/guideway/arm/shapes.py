"""What can collide: the links' collision shapes from the robot description, boxes, spheres, cylinders and meshes around the arm and on its tip."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element

import numpy as np

from guideway.arm import urdf
from guideway.arm.extra import coal
from guideway.arm.meshes import load_stl
from guideway.arm.model import Arm, frame_of
from guideway.errors import BadFile, BadParameter

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

KINDS = {"box": ("size",), "sphere": ("radius",), "cylinder": ("radius", "length"), "mesh": ("file",)}
"""Kinds of shapes and the fields each of them needs; all take ``at`` (m) and ``rpy`` (rad), meshes ``scale``."""


@dataclass(frozen=True)
class Shape:
    """A solid: ``name``, the ``joint`` of the model that carries it (0: it stands still), its pose on that joint, the solid and its convex hull."""

    name: str
    joint: int
    pose: Floats = field(repr=False)
    solid: Any = field(repr=False)
    hull: Any = field(repr=False)
    radius: float = 0.0
    part: str = "scene"

    @property
    def convex(self) -> bool:
        """Is the solid its own hull?"""
        return self.solid is self.hull


def pose_of(at: Sequence[float], rpy: Sequence[float]) -> Floats:
    """A pose (4, 4) from a place (m) and roll, pitch, yaw (rad)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    pose = np.eye(4)
    pose[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    pose[:3, 3] = at
    return pose


def mesh(triangles: Floats) -> tuple[Any, Any]:
    """A mesh as a solid of triangles, and its convex hull; one and the same where the mesh is convex."""
    library = coal()
    points = np.ascontiguousarray(triangles.reshape(-1, 3) + 0.0)
    _, kept, index = np.unique(points.view("V24").ravel(), return_index=True, return_inverse=True)
    corners, index = points[kept], index.reshape(-1, 3)
    index = index[(index[:, 0] != index[:, 1]) & (index[:, 1] != index[:, 2]) & (index[:, 2] != index[:, 0])]
    solid = library.BVHModelOBBRSS()
    solid.beginModel(len(index), len(corners))
    solid.addVertices(corners)
    solid.addTriangles(index.astype(np.int64))
    solid.endModel()
    solid.buildConvexHull(False, "Qt")
    hull = solid.convex
    return (hull, hull) if _is_convex(corners, index) else (solid, hull)


def _is_convex(corners: Floats, index: NDArray[np.int64]) -> bool:
    """Is the mesh one closed surface without holes that bends outwards at every edge?"""
    edges = np.sort(np.concatenate([index[:, [0, 1]], index[:, [1, 2]], index[:, [2, 0]]]), axis=1)
    keys = edges[:, 0] * len(corners) + edges[:, 1]
    order = np.argsort(keys, kind="stable")
    paired = keys[order].reshape(-1, 2) if len(keys) % 2 == 0 else np.array([[0, 1]])
    if (paired[:, 0] != paired[:, 1]).any() or (np.diff(paired[:, 0]) == 0).any() or len(corners) - len(paired) + len(index) != 2:
        return False
    a, b, c = (corners[index[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    sizes = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(sizes, 1e-300)[:, None]
    first, second = order.reshape(-1, 2).T
    opposite = np.concatenate([index[:, 2], index[:, 0], index[:, 1]])
    for side, across in ((first, second), (second, first)):
        face = side % len(index)
        heights = np.sum(normals[face] * (corners[opposite[across]] - a[face]), axis=1)
        if (heights[sizes[face] > 1e-12] > 1e-5).any():
            return False
    return True


def solid_of(kind: str, fields: Mapping[str, Any], folder: str) -> tuple[Any, Any, float]:
    """The solid of a shape's fields, its hull, and the largest distance of its points from its own origin, m."""
    library = coal()
    if kind == "box":
        size = np.asarray(fields["size"], float)
        box = library.Box(*size)
        return box, box, float(np.linalg.norm(size)) / 2
    if kind == "sphere":
        ball = library.Sphere(float(fields["radius"]))
        return ball, ball, float(fields["radius"])
    if kind == "cylinder":
        radius, length = float(fields["radius"]), float(fields["length"])
        drum = library.Cylinder(radius, length)
        return drum, drum, math.hypot(radius, length / 2)
    path = fields["file"] if os.path.isabs(fields["file"]) else os.path.join(folder, fields["file"])
    triangles = load_stl(path) * np.asarray(fields.get("scale", 1.0), float)
    solid, hull = mesh(triangles)
    return solid, hull, float(np.linalg.norm(triangles.reshape(-1, 3), axis=1).max())


def links_of(arm: Arm) -> list[Shape]:
    """The collision shapes of an arm's links as its description has them; empty for arms from Denavit-Hartenberg rows.

    Meshes are STL files, named relative to the folder of the URDF file; raises :class:`guideway.errors.BadFile` for others.
    """
    if arm.source is None:
        return []
    found = urdf.read(arm.source)
    shapes: list[Shape] = []
    for link, element in found.links.items():
        for number, collision in enumerate(element.findall("collision")):
            shapes.append(_link_shape(arm, link if number == 0 else f"{link} ({number + 1})", link, collision, found.path))
    return shapes


def _link_shape(arm: Arm, title: str, link: str, collision: Element, path: str) -> Shape:
    origin, geometry = collision.find("origin"), collision.find("geometry")
    at, rpy = ([float(x) for x in ((origin.get(key) if origin is not None else None) or "0 0 0").split()] for key in ("xyz", "rpy"))
    solid, hull, radius = _geometry(geometry, f"{path}, link {link}", os.path.dirname(path))
    frame = arm.model.frames[frame_of(arm.model, link)]
    pose = frame.placement.homogeneous @ pose_of(at, rpy)
    return Shape(title, int(frame.parentJoint), pose, solid, hull, radius, "arm")


def _geometry(geometry: Element | None, where: str, folder: str) -> tuple[Any, Any, float]:
    shape = next(iter(geometry), None) if geometry is not None else None
    try:
        if shape is not None and shape.tag == "mesh":
            scale = [float(x) for x in (shape.get("scale") or "1 1 1").split()]
            return solid_of("mesh", {"file": _mesh_file(shape.get("filename") or "", where, folder), "scale": scale}, folder)
        if shape is not None and shape.tag == "box":
            return solid_of("box", {"size": [float(x) for x in (shape.get("size") or "").split()]}, folder)
        if shape is not None and shape.tag in ("sphere", "cylinder"):
            return solid_of(shape.tag, {key: float(value) for key, value in shape.attrib.items()}, folder)
    except (ValueError, TypeError, KeyError):
        raise BadFile(
            f"{where}, collision", f"its <{shape.tag if shape is not None else ''}> cannot be used", "finite sizes, m", "Correct it"
        ) from None
    raise BadFile(f"{where}, collision", "it has no shape that is known", ", ".join(KINDS), "Correct the file")


def _mesh_file(text: str, where: str, folder: str) -> str:
    """The file of a mesh: relative to the description's folder; ``package://`` names are looked for in the folders above it."""
    text = text.removeprefix("file://")
    if not text.lower().endswith(".stl"):
        raise BadFile(
            f"{where}, collision", f"mesh {text!r} is not an STL file", "STL meshes", "Convert it, or check without collisions (--no-collisions)"
        )
    if not text.startswith("package://"):
        return text if os.path.isabs(text) else os.path.join(folder, text)
    inside = text.removeprefix("package://")
    above, names = os.path.abspath(folder), [inside, inside.partition("/")[2]]
    while True:
        for name in names:
            if os.path.isfile(os.path.join(above, name)):
                return os.path.join(above, name)
        if os.path.dirname(above) == above:
            raise BadFile(f"{where}, collision", f"mesh {text!r} was not found near the file", "", "Put the package's folder beside the URDF file")
        above = os.path.dirname(above)


@dataclass(frozen=True)
class Scene:
    """What stands around an arm, in the frame of its root, and what its tip carries; ``clearance`` (m) is to be kept from all of it and by the
    arm from itself. Shapes are records with one of :data:`KINDS` as ``kind``, its fields (m), ``at``, ``rpy``, ``name``."""

    shapes: tuple[Mapping[str, Any], ...] = ()
    tool: tuple[Mapping[str, Any], ...] = ()
    clearance: float = 0.0
    folder: str = "."
    source: str | None = None

    def solids(self, arm: Arm) -> list[Shape]:
        """The shapes of the scene and of the tool."""
        tip = arm.model.frames[frame_of(arm.model, arm.tip)]
        found: list[Shape] = []
        for part, records in (("scene", self.shapes), ("tool", self.tool)):
            for number, record in enumerate(records):
                kind = record.get("kind", "")
                if kind not in KINDS:
                    raise BadParameter(f"shape {kind!r} is not known; allowed: {', '.join(KINDS)}")
                solid, hull, radius = solid_of(kind, record, self.folder)
                pose = pose_of(record.get("at", (0, 0, 0)), record.get("rpy", (0, 0, 0)))
                title = record.get("name") or f"{part} {kind} {number + 1}"
                if part == "tool":
                    found.append(Shape(title, int(tip.parentJoint), tip.placement.homogeneous @ pose, solid, hull, radius, part))
                else:
                    found.append(Shape(title, 0, pose, solid, hull, radius, part))
        return found


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Reads what stands around an arm (TOML: ``clearance``, ``[[box]]``, ``[[sphere]]``, ``[[cylinder]]``, ``[[mesh]]``, and the same under
    ``[[tool]]`` with ``kind``). Raises :class:`guideway.errors.BadFile`."""
    from guideway.io.files import load, name
    from guideway.io.tables import Table, parse_toml

    where = name(path)
    top = Table(where, "", parse_toml(where, load(path).text()))
    shapes = [_record(table, kind) for kind in KINDS for table in top.tables(kind)]
    tool = [_record(table, table.choice("kind", tuple(KINDS), "")) for table in top.tables("tool")]
    clearance = top.number("clearance", 0.0, 10.0, "m", 0.0)
    top.done()
    return Scene(tuple(shapes), tuple(tool), clearance, os.path.dirname(os.fspath(path)) or ".", os.fspath(path))


def _record(table: Any, kind: str) -> dict[str, Any]:
    if kind not in KINDS:
        raise table.bad("kind", " | ".join(KINDS))
    record: dict[str, Any] = {"kind": kind, "name": table.text("name")}
    for key in KINDS[kind]:
        if key == "size":
            record[key] = table.numbers(key, (3,), "[x, y, z] in m")
            if record[key] is None or min(record[key]) <= 0:
                raise table.bad(key, "[x, y, z] in m, above 0")
        elif key == "file":
            record[key] = table.text(key)
            if record[key] is None:
                raise table.bad(key, "the name of an STL file")
        else:
            record[key] = table.number(key, 0.0, 1e3, "m", above=True)
    record["at"] = table.numbers("at", (3,), "[x, y, z] in m") or (0.0, 0.0, 0.0)
    record["rpy"] = table.numbers("rpy", (3,), "[roll, pitch, yaw] in rad") or (0.0, 0.0, 0.0)
    if kind == "mesh":
        record["scale"] = table.number("scale", 0.0, 1e6, "", 1.0, above=True)
    table.done()
    return record
