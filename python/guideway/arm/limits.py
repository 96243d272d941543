"""Limits of joints, and the TOML file that states them."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from guideway.errors import BadFile, BadParameter

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from guideway.arm.model import Arm

    Value = float | Sequence[float] | NDArray[np.float64] | None

ACCELERATION = 10.0
"""Joint acceleration where nobody states one, rad/s2: robot descriptions have none."""

JOINT = ("speed", "acceleration", "deceleration", "jerk", "torque", "torque_rate")
TIP = ("tip_speed", "tip_acceleration")


@dataclass(frozen=True)
class JointLimits:
    """Limits of a motion of joints: a number or one per joint; None is unlimited.

    ``speed`` (rad/s), ``acceleration`` (rad/s2), ``deceleration`` (rad/s2; against the joint's direction of motion; left out it equals the
    acceleration), ``jerk`` (rad/s3), ``torque`` (N m), ``torque_rate`` (N m/s); for prismatic joints the same in m and N. ``tip_speed`` (m/s) and
    ``tip_acceleration`` (m/s2) bound the moved link's origin.
    """

    speed: Value = None
    acceleration: Value = None
    deceleration: Value = None
    jerk: Value = None
    torque: Value = None
    torque_rate: Value = None
    tip_speed: float | None = None
    tip_acceleration: float | None = None

    def __post_init__(self) -> None:
        for name in (*JOINT, *TIP):
            value = getattr(self, name)
            if value is not None:
                _check(name, value, single=name in TIP)

    def per_joint(self, name: str, joints: int) -> NDArray[np.float64] | None:
        """A limit as an array of one number per joint, or None; raises ``BadParameter`` where their count differs."""
        value = getattr(self, name)
        if value is None:
            return None
        array = np.asarray(value, float)
        if array.ndim and len(array) != joints:
            raise BadParameter(f"limit {name} has {len(array)} numbers; allowed: one, or one for each of the {joints} joints")
        return np.broadcast_to(array, (joints,)).copy()

    def to_dict(self, joints: int | None = None) -> dict[str, Any]:
        """As in files, without what is unlimited; with ``joints`` one number per joint."""
        record: dict[str, Any] = {}
        for name in (*JOINT, *TIP):
            value = getattr(self, name)
            if value is not None:
                array = self.per_joint(name, joints) if joints and name in JOINT else np.asarray(value, float)
                record[name] = cast("NDArray[np.float64]", array).tolist()
        return record

    def over(self, other: JointLimits) -> JointLimits:
        """These limits, filled up from others where they say nothing."""
        return replace(self, **{f.name: getattr(other, f.name) for f in fields(self) if getattr(self, f.name) is None})

    @staticmethod
    def of(given: JointLimits | Mapping[str, Any] | None) -> JointLimits:
        """Limits from a record."""
        if given is None or isinstance(given, JointLimits):
            return given or JointLimits()
        unknown = [key for key in given if key not in (*JOINT, *TIP)]
        if unknown:
            raise BadParameter(f"limit {unknown[0]!r} is not known; allowed: {', '.join((*JOINT, *TIP))}")
        return JointLimits(**given)

    @staticmethod
    def of_arm(arm: Arm, torque: bool = False) -> JointLimits:
        """What the robot's description states: speeds, and with ``torque`` its torques; the acceleration is :data:`ACCELERATION`."""
        return JointLimits(speed=arm.speed_limits(), acceleration=ACCELERATION, torque=arm.torque_limits() if torque else None)


def _check(name: str, value: object, single: bool) -> None:
    array = np.asarray(value, float) if not isinstance(value, str) else np.array(math.nan)
    if array.ndim > (0 if single else 1) or not array.size or not (np.isfinite(array).all() and (array > 0).all()):
        shape = "a finite number above 0" if single else "a finite number above 0, or one per joint"
        raise BadParameter(f"limit {name} {value!r} is out of range: {shape}")


def load_limits(path: str | os.PathLike[str]) -> JointLimits:
    """Reads a limits file (TOML); raises :class:`guideway.errors.BadFile`."""
    from guideway.io.files import load, name
    from guideway.io.tables import Table, parse_toml, real

    where = name(path)
    table = Table(where, "", parse_toml(where, load(path).text()))
    found: dict[str, Any] = {}
    for key in (*JOINT, *TIP):
        value = table.raw(key)
        if value is None:
            continue
        numbers = [real(item) for item in cast("list[object]", value if isinstance(value, list) else [value])]
        if not numbers or any(number is None or number <= 0 for number in numbers) or (key in TIP and isinstance(value, list)):
            allowed = "a number above 0" if key in TIP else "a number above 0, or a list of one per joint"
            raise table.bad(key, allowed)
        found[key] = numbers if isinstance(value, list) else numbers[0]
    table.done()
    if not found:
        raise BadFile(where, "the file states no limit", ", ".join((*JOINT, *TIP)), "Add at least one")
    return JointLimits(**found)
