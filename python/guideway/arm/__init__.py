"""Robot arms: kinematics, dynamics, paths, time-optimal motion along them, its safety and its files. Needs ``pip install 'guideway[arm]'``.

>>> import guideway as gw
>>> arm = gw.arm.robot("ur5e")
>>> path = gw.arm.joint_path(arm, gw.arm.star())
>>> round(path.path.length, 4)
3.5684

SI units, radians; joints in the order from the root to the tip. Names are loaded when they are first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from guideway.arm.build import ROBOTS, robot, ur5e_from_dh, ur5e_rows
    from guideway.arm.certificate import certify
    from guideway.arm.collisions import Surroundings
    from guideway.arm.inverse import Branch, branches, follow, solve
    from guideway.arm.learning import LEARNERS
    from guideway.arm.learning.log import Log
    from guideway.arm.learning.loop import Learned, Trial, learn
    from guideway.arm.limits import JointLimits, load_limits
    from guideway.arm.model import REFERENCE_FRICTION, Arm, Friction, Payload
    from guideway.arm.motion import ArmMotion
    from guideway.arm.nurbs import STAR_POSTURE, STAR_TORQUE, Nurbs, load_nurbs, star
    from guideway.arm.outputs import csv_text, load_motion, record, ros_yaml, urscript
    from guideway.arm.paths import JointPath, all_branches, arm_for, joint_path, load_way_points
    from guideway.arm.rows import torque_coefficients, torque_rows
    from guideway.arm.shapes import Scene, load_scene
    from guideway.arm.skeleton import chain, obstacles, surfaces
    from guideway.arm.timing import time

_HOME = {
    **dict.fromkeys(("ROBOTS", "robot", "ur5e_from_dh", "ur5e_rows"), "build"),
    "certify": "certificate",
    "Surroundings": "collisions",
    **dict.fromkeys(("Branch", "branches", "follow", "solve"), "inverse"),
    "LEARNERS": "learning",
    "Log": "learning.log",
    **dict.fromkeys(("Learned", "Trial", "learn"), "learning.loop"),
    **dict.fromkeys(("JointLimits", "load_limits"), "limits"),
    **dict.fromkeys(("REFERENCE_FRICTION", "Arm", "Friction", "Payload"), "model"),
    "ArmMotion": "motion",
    **dict.fromkeys(("STAR_POSTURE", "STAR_TORQUE", "Nurbs", "load_nurbs", "star"), "nurbs"),
    **dict.fromkeys(("csv_text", "load_motion", "record", "ros_yaml", "urscript"), "outputs"),
    **dict.fromkeys(("JointPath", "all_branches", "arm_for", "joint_path", "load_way_points"), "paths"),
    **dict.fromkeys(("torque_coefficients", "torque_rows"), "rows"),
    **dict.fromkeys(("Scene", "load_scene"), "shapes"),
    **dict.fromkeys(("chain", "obstacles", "surfaces"), "skeleton"),
    "time": "timing",
}

__all__ = [
    "LEARNERS",
    "REFERENCE_FRICTION",
    "ROBOTS",
    "STAR_POSTURE",
    "STAR_TORQUE",
    "Arm",
    "ArmMotion",
    "Branch",
    "Friction",
    "JointLimits",
    "JointPath",
    "Learned",
    "Log",
    "Nurbs",
    "Payload",
    "Scene",
    "Surroundings",
    "Trial",
    "all_branches",
    "arm_for",
    "branches",
    "certify",
    "chain",
    "csv_text",
    "follow",
    "joint_path",
    "learn",
    "load_limits",
    "load_motion",
    "load_nurbs",
    "load_scene",
    "load_way_points",
    "obstacles",
    "record",
    "robot",
    "ros_yaml",
    "solve",
    "star",
    "surfaces",
    "time",
    "torque_coefficients",
    "torque_rows",
    "ur5e_from_dh",
    "ur5e_rows",
    "urscript",
]


def __getattr__(name: str) -> Any:
    """Loads a part when it is first used."""
    if name in _HOME:
        return getattr(importlib.import_module(f"guideway.arm.{_HOME[name]}"), name)
    raise AttributeError(f"module 'guideway.arm' has no attribute {name!r}")
