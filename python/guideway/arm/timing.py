"""Time-optimal motion of an arm along a path: limits and rows in, a certified motion out. The solver is in the core."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway import _core
from guideway.arm import rows as rows_of
from guideway.arm.limits import JointLimits
from guideway.arm.model import Arm
from guideway.arm.motion import ArmMotion, pieces_of
from guideway.arm.nurbs import Nurbs
from guideway.arm.paths import JointPath, joint_path
from guideway.errors import BadParameter, CertificateFailed, Infeasible

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

METHODS = ("reachability", "bisection")


def time(
    path: JointPath | _core.Path | Nurbs | str | os.PathLike[str] | ArrayLike,
    limits: JointLimits | Mapping[str, Any] | None = None,
    arm: Arm | None = None,
    *,
    method: str = "reachability",
    torque: bool | None = None,
    jerk: bool | None = None,
    start_speed: float = 0.0,
    end_speed: float = 0.0,
    grid: int | None = None,
    windows: Sequence[Sequence[float]] = (),
    check: bool = True,
) -> ArmMotion:
    """The fastest motion along a path of joints under the limits.

    ``path``: a joint path, or with ``arm`` a tool path, a file of way points, way points (n, joints). ``limits`` are filled up from the robot's
    description, the acceleration by :data:`guideway.arm.limits.ACCELERATION`. ``torque``: whether torques count (default: where limits state
    them; with True the robot's own, where they do not). ``jerk``: whether jerk and torque rate count (default: where limits state them).
    ``start_speed`` and ``end_speed`` are path speeds, rad/s; the path acceleration there is free within the limits, so where motions are joined it
    may step, and limits of jerk hold inside, not across the joint. ``grid`` fixes the number of points (default: chosen by error); ``windows``,
    rows (s in rad, earliest in s) or (s, earliest, latest), say when places of the path may be passed. With ``check`` the result is certified
    against all limits.

    Raises ``BadParameter``, ``NoPath``, ``Infeasible`` (static overload, boundary speeds, windows), ``CertificateFailed``.
    """
    if method not in METHODS:
        raise BadParameter(f"method {method!r} is not known; allowed: {', '.join(METHODS)}")
    given, arm = _path(path, arm)
    asked = complete(JointLimits.of(limits), arm, torque)
    if asked.torque is not None:
        if arm is None:
            raise BadParameter("torque limits need an arm: give arm=, or leave torque out")
        rows_of.check_static(arm, given.path, asked)
    rows, names, ceiling = demands(arm, given.path, asked)
    smooth = (asked.jerk is not None or asked.torque_rate is not None) if jerk is None else jerk
    began = perf_counter()
    words = {"start_speed": start_speed, "end_speed": end_speed, "grid": grid, "windows": [list(row) for row in windows] or None}
    if smooth and asked.torque_rate is not None and arm is not None:
        words |= {"rates": rows_of.rate_rows(arm, given.path, asked), "rate_names": rows_of.rate_names(arm)}
    found, method = _solve(given, asked, method, smooth, (rows, names, ceiling), words)
    motion = _motion(found, given, asked, arm, method, smooth)
    motion.report["seconds"] = perf_counter() - began
    if smooth and asked.torque_rate is not None and arm is not None:
        motion = _within_rate(motion) if start_speed == end_speed == 0 else motion  # slowed down it would have other speeds at its ends
    if check and len(motion.pieces):
        certificate = motion.certify(collisions=False)
        motion.report["certificate"] = certificate
        if not certificate["ok"] and grid is None:
            raise CertificateFailed("timing: " + "; ".join(_failed(check) for check in certificate["checks"] if not check["ok"]))
    return motion


def _solve(path: JointPath, asked: JointLimits, method: str, smooth: bool, demanded: Any, words: dict[str, Any]) -> tuple[Any, str]:
    """The core's solver, and the method that found the motion."""
    core: Any = _core
    rows, names, ceiling = demanded
    counts = ("speed", "acceleration", "deceleration", *(("jerk",) if smooth else ()))
    limits = {key: value for key, value in asked.to_dict(len(path.names)).items() if key in counts}
    words = words | {"rows": rows, "row_names": names, "ceiling": ceiling, "jerk": smooth}
    try:
        return core.time_joints(path.path, limits, method=method, **words), method
    except Infeasible as first:
        if rows is None or method == "bisection":
            raise
        try:  # the other method may still find a way: it does not need intervals of speeds
            return core.time_joints(path.path, limits, method="bisection", **words), "bisection"
        except (Infeasible, CertificateFailed):
            raise first from None


def _within_rate(motion: ArmMotion) -> ArmMotion:
    """The last resort where the torques tell of steeper rates than the solver's: the motion slowed down as a whole until they are within their limit,
    ``report["rate_slowed"]`` times in all."""
    from guideway.arm.certificate import worst_rate

    slower = 1.0
    for _ in range(60):
        ratio = worst_rate(motion)
        if ratio <= 1:
            break
        share = max(0.5, ratio ** (-1 / 3) * (1 - 1e-7))
        slower /= share
        motion = motion.scaled(share)
    motion.report["rate_slowed"] = slower
    return motion


def _failed(check: dict[str, Any]) -> str:
    if "gap" in check:
        return f"{check['name']}: not so, by {check['gap']:.3g}"
    return f"{check['name']} reaches {check['ratio']:.9f} of its limit at t = {check['t']:.4f} s"


def _path(path: Any, arm: Arm | None) -> tuple[JointPath, Arm | None]:
    if isinstance(path, JointPath):
        if arm is not None and path.names != arm.names:
            raise BadParameter(f"the path's joints {', '.join(path.names)} are not those of {arm.name}: {', '.join(arm.names)}")
        return path, arm
    if isinstance(path, _core.Path):
        joints = path.control_points.shape[1]
        if arm is not None and arm.joints != joints:
            raise BadParameter(f"the path has {joints} joints, {arm.name} has {arm.joints}")
        return JointPath(path, arm.names if arm is not None else tuple(f"joint {k + 1}" for k in range(joints))), arm
    if arm is None:
        if isinstance(path, Nurbs | str | os.PathLike):
            raise BadParameter("a tool path and a file of way points need an arm: give arm=")
        points = np.atleast_2d(np.asarray(path, float))
        from guideway.arm.paths import path_through

        return path_through(points, tuple(f"joint {k + 1}" for k in range(points.shape[1]))), None
    return joint_path(arm, path), arm


def complete(limits: JointLimits, arm: Arm | None, torque: bool | None) -> JointLimits:
    """Limits with what the robot's description and the defaults add; without torques where they shall not count."""
    if torque is False:
        limits = replace(limits, torque=None, torque_rate=None)
    if arm is None:
        if limits.speed is None and limits.acceleration is None:
            raise BadParameter("no limits were given: at least speed or acceleration are needed")
        return limits
    own = JointLimits() if limits.speed is not None else JointLimits(speed=arm.speed_limits())
    if torque and limits.torque is None:
        own = own.over(JointLimits(torque=arm.torque_limits()))
    if limits.acceleration is None:
        from guideway.arm.limits import ACCELERATION

        own = own.over(JointLimits(acceleration=ACCELERATION))
    return limits.over(own)


def demands(arm: Arm | None, path: _core.Path, limits: JointLimits) -> tuple[Any, list[str] | None, Any]:
    """Rows, their names and the speed ceiling for the solver: torques, the tip's speed and acceleration; None where nothing is asked."""
    parts, names = [], []
    if limits.torque is not None and arm is not None:
        parts.append(rows_of.torque_rows(arm, path, limits))
        names += rows_of.torque_names(arm)
    if arm is None and (limits.tip_speed is not None or limits.tip_acceleration is not None):
        raise BadParameter("limits of the tip need an arm: give arm=")
    ceiling = None
    if arm is not None and limits.tip_acceleration is not None:
        parts.append(rows_of.tip_rows(arm, path, limits.tip_acceleration))
        names += ["acceleration of the tip"] * rows_of.DIRECTIONS
    if arm is not None and limits.tip_speed is not None:
        ceiling = rows_of.tip_ceiling(arm, path, limits.tip_speed)
    return (rows_of.joined(parts) if parts else None), (names or None), ceiling


def _motion(found: Any, path: JointPath, limits: JointLimits, arm: Arm | None, method: str, smooth: bool) -> ArmMotion:
    grid = {"s": np.asarray(found.s), "x": np.asarray(found.x), "mvc": np.asarray(found.mvc), "active": list(found.active)}
    report = {"method": method, "jerk": smooth, "solver": found.report, "price": [list(row) for row in getattr(found, "price", None) or []]}
    return ArmMotion(path, pieces_of(found.pieces), limits, arm, grid, report)
