"""What a picture of an arm needs: its chain of joints as plain numbers, and the surfaces of its links."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element

import numpy as np

from guideway.arm import urdf
from guideway.arm.meshes import load_stl
from guideway.errors import BadFile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from guideway.arm.model import Arm

    Floats = NDArray[np.float64]

MOST_TRIANGLES = 2500
"""Of the surface of one link; larger meshes are simplified."""
SIDES = 28
"""Of the prism that stands for a cylinder."""


def chain(arm: Arm) -> dict[str, Any]:
    """The chain of an arm as plain numbers, ready for JSON.

    ``joints``, each with ``name``, ``parent`` (number of the joint that carries it from 1, 0: the root), ``pose`` (3 x 4, row by row, on the parent),
    the ``axis`` it turns about or, with ``slides``, moves along, and its value ``offset + sum(factors * q)`` (rad or m); ``links`` with the ``joint``
    that carries them and their pose on it; ``tip`` and ``base`` are names of links.
    """
    model, data = arm.model, arm.model.createData()
    from guideway.arm.extra import pinocchio

    pin = pinocchio()
    pin.computeJointJacobians(model, data, np.zeros(model.nq))
    joints: list[dict[str, Any]] = []
    for k in range(1, model.njoints):
        row, motion = model.joints[k].idx_q, np.asarray(data.joints[k].S, float).reshape(-1)
        slides = bool(np.abs(motion[:3]).max() > 0.5)
        joints.append(
            {
                "name": str(model.names[k]),
                "parent": int(model.parents[k]),
                "pose": _flat(model.jointPlacements[k].homogeneous),
                "axis": np.round(motion[:3] if slides else motion[3:], 9).tolist(),
                "slides": slides,
                "factors": arm.coupling[row].tolist(),
                "offset": float(arm.offset[row]),
            }
        )
    bodies = [frame for frame in model.frames if frame.type == pin.FrameType.BODY]
    links = [{"name": str(frame.name), "joint": int(frame.parentJoint), "pose": _flat(frame.placement.homogeneous)} for frame in bodies]
    return {"joints": joints, "links": links, "tip": arm.tip, "base": arm.base}


def _flat(pose: Floats) -> list[float]:
    return (np.round(pose[:3], 9) + 0.0).ravel().tolist()


def surfaces(robot: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The links' surfaces of the ``robot`` of a record with a ``chain``, from its description if that is at hand, else an empty list.

    Each has the ``joint`` that carries it, ``corners`` (n, 3) in the frame of that joint, m, and ``faces`` (m, 3). Raises ``BadFile`` where the
    description or one of its meshes cannot be read. Needs no more than this package.
    """
    source, frame = _description(robot), robot.get("chain")
    if source is None or not isinstance(frame, Mapping):
        return []
    links = {str(link["name"]): link for link in frame["links"]}
    found: list[dict[str, Any]] = []
    for name, element in urdf.read(source).links.items():
        if name not in links:
            continue
        for part in element.findall("collision") or element.findall("visual"):
            triangles = _triangles(part, os.path.dirname(source))
            if triangles is None:
                continue
            pose = np.asarray(links[name]["pose"], float).reshape(3, 4)
            corners, faces = simplified(triangles @ pose[:, :3].T + pose[:, 3])
            found.append({"joint": int(links[name]["joint"]), "corners": corners, "faces": faces})
    return found


def obstacles(robot: Mapping[str, Any], scene: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What stood around an arm and what its tip carried, from the ``scene`` of a collision check (``shapes`` and ``tool``), as of :func:`surfaces`,
    each with its ``name`` and ``part``: "scene" or "tool". Meshes whose file is not at hand are left out."""
    from guideway.arm.shapes import pose_of

    frame = robot.get("chain")
    links = {str(link["name"]): link for link in frame["links"]} if isinstance(frame, Mapping) else {}
    tip = links.get(str(frame["tip"])) if isinstance(frame, Mapping) else None
    found: list[dict[str, Any]] = []
    for part, key in (("scene", "shapes"), ("tool", "tool")):
        carrier = np.eye(4)[:3] if part == "scene" else np.asarray(tip["pose"], float).reshape(3, 4) if tip is not None else None
        for shape in scene.get(key) or []:
            triangles = _shape(shape)
            if triangles is None or carrier is None:
                continue
            pose = carrier @ pose_of(shape.get("at") or (0, 0, 0), shape.get("rpy") or (0, 0, 0))
            corners, faces = simplified(triangles @ pose[:, :3].T + pose[:, 3])
            joint = int(tip["joint"]) if part == "tool" and tip is not None else 0
            found.append({"part": part, "name": str(shape.get("name") or shape.get("kind")), "joint": joint, "corners": corners, "faces": faces})
    return found


def _shape(shape: Mapping[str, Any]) -> Floats | None:
    """Triangles of a shape of a scene, before it is placed."""
    if shape.get("kind") == "mesh":
        try:
            return load_stl(str(shape["file"])) * float(shape.get("scale") or 1.0)
        except (BadFile, OSError):
            return None
    element = Element(str(shape.get("kind")), {key: str(shape[key]) for key in ("radius", "length") if key in shape})
    element.set("size", " ".join(str(value) for value in shape.get("size") or ()))
    return _solid(element)


def _description(robot: Mapping[str, Any]) -> str | None:
    """The file of the robot's description: where the record says, else the one that ships with the package."""
    source = robot.get("source")
    if not isinstance(source, str) or not source.lower().endswith(".urdf"):
        return None
    if os.path.isfile(source):
        return source
    stem = Path(source.replace("\\", "/")).stem
    shipped = files("guideway").joinpath("data").joinpath("arms").joinpath(stem).joinpath(f"{stem}.urdf")
    return str(shipped) if stem.isidentifier() and shipped.is_file() else None


def _triangles(part: Element, folder: str) -> Floats | None:
    """Triangles (n, 3, 3) of a <collision> or <visual> in the frame of its link; None for shapes that are not known."""
    from guideway.arm.shapes import _mesh_file, pose_of

    origin, geometry = part.find("origin"), part.find("geometry")
    at, rpy = ([float(x) for x in ((origin.get(key) if origin is not None else None) or "0 0 0").split()] for key in ("xyz", "rpy"))
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        return None
    try:
        if shape.tag == "mesh":
            scale = [float(x) for x in (shape.get("scale") or "1 1 1").split()]
            triangles = load_stl(_mesh_file(shape.get("filename") or "", folder, folder)) * np.asarray(scale)
        else:
            triangles = _solid(shape)
    except (BadFile, ValueError, OSError):
        return None
    pose = pose_of(at, rpy)
    return None if triangles is None else triangles @ pose[:3, :3].T + pose[:3, 3]


def _solid(shape: Element) -> Floats | None:
    """Triangles of a box, a cylinder or a sphere."""
    if shape.tag == "box":
        x, y, z = (float(v) / 2 for v in (shape.get("size") or "").split())
        return _swept(np.array([[x, y], [-x, y], [-x, -y], [x, -y]]), np.array([-z, z]), np.ones(2))
    angle = np.arange(SIDES) * 2 * math.pi / SIDES
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    radius = float(shape.get("radius") or "nan")
    if shape.tag == "cylinder":
        half = float(shape.get("length") or "nan") / 2
        return _swept(radius * circle, np.array([-half, half]), np.ones(2))
    if shape.tag == "sphere":
        height = np.linspace(-math.pi / 2, math.pi / 2, SIDES // 2)
        return _swept(radius * circle, radius * np.sin(height), np.cos(height))
    return None


def _swept(outline: Floats, heights: Floats, widths: Floats) -> Floats:
    """A closed surface: the outline (n, 2), widened and lifted ring by ring, with a lid at both ends."""
    if not (np.isfinite(outline).all() and np.isfinite(heights).all()):
        raise ValueError("sizes are not finite")
    rings = np.array([np.column_stack([outline * width, np.full(len(outline), z)]) for z, width in zip(heights, widths, strict=True)])
    after = np.roll(rings, -1, axis=1)
    low, high, low_after, high_after = rings[:-1], rings[1:], after[:-1], after[1:]
    walls = [np.stack([low, low_after, high_after], axis=2), np.stack([low, high_after, high], axis=2)]
    middles = [np.broadcast_to([0.0, 0.0, z], (len(outline), 3)) for z in heights[[0, -1]]]
    lids = [np.stack([middles[0], after[0], rings[0]], axis=1), np.stack([middles[1], rings[-1], after[-1]], axis=1)]
    return np.concatenate([*(wall.reshape(-1, 3, 3) for wall in walls), *lids])


def simplified(triangles: Floats, most: int = MOST_TRIANGLES) -> tuple[Floats, NDArray[np.int64]]:
    """Corners (n, 3) and faces (m, 3) of triangles (k, 3, 3); where they are more than ``most``, corners that are near each other are joined."""
    points = triangles.reshape(-1, 3)
    size = float(np.ptp(points, axis=0).max()) or 1.0
    cells = 20000
    while True:
        keys = np.round((points - points.min(axis=0)) * (cells / size)).astype(np.int64)
        _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        faces = index.reshape(-1, 3)
        faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
        if len(faces) <= most or cells <= 4:
            kept, renamed = np.unique(faces, return_inverse=True)
            return points[first][kept], renamed.reshape(-1, 3)
        cells = 96 if cells > 96 else int(cells * 0.8)
