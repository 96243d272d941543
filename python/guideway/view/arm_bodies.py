"""Surfaces of a robot's links, packed for the page."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np

MOST_FACES = 16000
"""Triangles of a whole robot; beyond, links are left to be drawn as capsules."""
STEPS = 32000
"""Steps that the longest side of a link is divided into."""


def bodies(robot: Any) -> list[dict[str, Any]] | None:
    """The links of a record's robot, each with its ``joint`` and its surface as numbers in base64: ``corners`` (int16, ``scale`` m a step, from
    ``origin``) and ``faces`` (uint16). None where the robot's description is not at hand or cannot be read: the page draws capsules then."""
    if not isinstance(robot, Mapping) or not isinstance(robot.get("chain"), Mapping):
        return None
    from guideway.arm import surfaces
    from guideway.errors import GuidewayError

    try:
        found = surfaces(robot)
    except (GuidewayError, OSError, KeyError, TypeError, ValueError):
        return None
    total = sum(len(part["faces"]) for part in found)
    if not 0 < total <= MOST_FACES or any(len(part["corners"]) > 65535 for part in found):
        return None
    return [packed(part) for part in found]


def around(record: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What stood around the arm when collisions were checked, and its tool: as of :func:`bodies`, each with ``name`` and ``part``."""
    certificate = record.get("certificate")
    collision = certificate.get("collision") if isinstance(certificate, Mapping) else None
    scene = collision.get("scene") if isinstance(collision, Mapping) else None
    robot = record.get("robot")
    if not isinstance(scene, Mapping) or not isinstance(robot, Mapping):
        return []
    from guideway.arm import obstacles
    from guideway.errors import GuidewayError

    try:
        found = obstacles(robot, scene)
    except (GuidewayError, OSError, AttributeError, KeyError, TypeError, ValueError):
        return []
    kept: list[dict[str, Any]] = []
    faces = 0
    for part in found:
        faces += len(part["faces"])
        if faces <= MOST_FACES:
            kept.append(packed(part) | {"name": part["name"], "part": part["part"]})
    return kept


def packed(part: Mapping[str, Any]) -> dict[str, Any]:
    """One link."""
    corners = np.asarray(part["corners"], float)
    origin = (corners.min(axis=0) + corners.max(axis=0)) / 2
    scale = float(np.abs(corners - origin).max()) / STEPS or 1.0
    steps = np.round((corners - origin) / scale).astype("<i2")
    faces = np.asarray(part["faces"]).astype("<u2")
    return {
        "joint": int(part["joint"]),
        "origin": np.round(origin, 6).tolist(),
        "scale": scale,
        "corners": base64.b64encode(steps.tobytes()).decode("ascii"),
        "faces": base64.b64encode(faces.tobytes()).decode("ascii"),
    }
