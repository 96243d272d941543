"""Coefficient rows of the timing solver: torques from recursive Newton-Euler, speed and acceleration of the tip.

At a place s of the path every demand is ``a*u + b*x + d*sqrt(x) + c`` with ``u`` the path acceleration (rad/s2) and ``x`` the squared path speed
(rad2/s2). With unit speed along the path, ``q'`` and ``q''`` by arc length, three evaluations of the inverse dynamics at rest give the
coefficients of all joints: ``g = id(q, 0, 0)``, ``a = M q' = id(q, 0, q') - g``, ``b = M q'' + C(q, q') q' = id(q, q', q'') - g``; friction adds
``d = f_v q'`` and ``c = g + f_c sgn(q')``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from guideway.arm.extra import pinocchio
from guideway.arm.limits import JointLimits
from guideway.arm.model import Arm, direction, frame_of
from guideway.errors import BadParameter, Infeasible

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from guideway._core import Path

    Floats = NDArray[np.float64]
    Rows = dict[str, Floats]
    RowsOf = Callable[[Floats], Rows]

DIRECTIONS = 12
"""Directions in which the tip's acceleration is bounded, in the plane it can lie in: the bound that results is a regular polygon inside the circle,
so it is kept exactly and 0.9 % of it is given away at most."""


RATE_ROOM = 1e-6
"""Share of a limit of torque rate that is left for rounding: the certificate takes differences of torques."""


def torque_coefficients(arm: Arm, path: Path, s: Floats) -> Rows:
    """Coefficients ``a, b, d, c`` (and ``g``, the part of gravity in ``c``) of the joint torques at places ``s`` (n,),
    each (n, joints), payload and friction included, N m."""
    arm.need_inertials()
    q, first, second = path.eval(s, 2)
    return coefficients_of(arm, q, first, second)


def coefficients_of(arm: Arm, q: Floats, first: Floats, second: Floats) -> Rows:
    """The same from postures and their derivatives by arc length, each (n, joints)."""
    still = np.zeros_like(q)
    gravity = arm.rnea(q, still, still)
    viscous, coulomb = arm.friction.arrays(arm.joints)
    return {
        "a": arm.rnea(q, still, first) - gravity,
        "b": arm.rnea(q, first, second) - gravity,
        "d": viscous * first,
        "c": gravity + coulomb * direction(first),
        "g": gravity,
    }


def torque_rows(arm: Arm, path: Path, limits: JointLimits) -> RowsOf:
    """A callable ``rows(s)`` for the solver: torques of all joints within ``limits.torque`` (default the robot's own), either way.

    Raises ``BadParameter`` without inertials or torque limits.
    """
    arm.need_inertials()
    bound = limits.per_joint("torque", arm.joints)
    if bound is None:
        bound = np.array(arm.torque_limits())

    def rows(s: Floats) -> Rows:
        q, first, second = path.eval(np.asarray(s, float), 2)
        found = coefficients_of(arm, q, first, second)
        return {key: found[key] for key in "abdc"} | {"low": -bound, "high": bound}

    return rows


def rate_rows(arm: Arm, path: Path, limits: JointLimits) -> RowsOf:
    """A callable ``rates(s)`` for the solver: the torques whose rate by time ``limits.torque_rate`` bounds, viscous friction and payload included;
    Coulomb friction steps where a joint turns round, which no motion avoids, and is constant elsewhere, so it is left out."""
    arm.need_inertials()
    bound = limits.per_joint("torque_rate", arm.joints)
    if bound is None:
        raise BadParameter("limits.torque_rate is missing: N m/s, one value or one per joint")
    bound = bound * (1 - RATE_ROOM)

    def rates(s: Floats) -> Rows:
        q, first, second = path.eval(np.asarray(s, float), 2)
        found = coefficients_of(arm, q, first, second)
        return {key: found[key] for key in "abd"} | {"c": found["g"], "low": -bound, "high": bound}

    return rates


def rate_names(arm: Arm) -> list[str]:
    """Names of the rates of torque."""
    return [f"torque rate of {name}" for name in arm.names]


def torque_names(arm: Arm) -> list[str]:
    """Names of the torque rows."""
    return [f"torque of {name}" for name in arm.names]


def check_static(arm: Arm, path: Path, limits: JointLimits, count: int = 400) -> None:
    """Raises ``Infeasible`` where the arm cannot even hold itself still on the path: the worst joint and place."""
    bound = limits.per_joint("torque", arm.joints)
    if bound is None:
        return
    s = np.linspace(0.0, path.length, count)
    load = np.abs(torque_coefficients(arm, path, s)["c"])
    worst = np.unravel_index(np.argmax(load / bound), load.shape)
    if load[worst] > bound[worst[1]]:
        raise Infeasible(
            f"static overload: at s = {s[worst[0]]:.4g} rad of {path.length:.4g} rad, gravity and friction alone ask {load[worst]:.4g} N m of "
            f"{arm.names[worst[1]]}, its limit is {bound[worst[1]]:.4g} N m. Carry less, take another posture or raise the limit"
        )


def tip_derivatives(arm: Arm, path: Path, s: Floats) -> tuple[Floats, Floats]:
    """First and second derivative of the tip's position by the path's arc length at places ``s`` (n,), each (n, 3), m/rad and m/rad2."""
    pin, model, data, couple = pinocchio(), arm.model, arm._data, arm.coupling
    index = frame_of(model, arm.tip)
    q, first, second = path.eval(s, 2)
    one, two = np.empty((len(s), 3)), np.empty((len(s), 3))
    frame = pin.LOCAL_WORLD_ALIGNED
    for k, row in enumerate(zip(q @ couple.T + arm.offset, first @ couple.T, second @ couple.T, strict=True)):
        pin.forwardKinematics(model, data, *row)
        one[k] = pin.getFrameVelocity(model, data, index, frame).linear
        two[k] = pin.getFrameClassicalAcceleration(model, data, index, frame).linear
    return one, two


def tip_ceiling(arm: Arm, path: Path, speed: float) -> Callable[[Floats], Floats]:
    """A callable ``ceiling(s)``: the largest squared path speed with the tip at ``speed`` (m/s); infinite where the tip stands still."""

    def ceiling(s: Floats) -> Floats:
        reach = np.linalg.norm(tip_derivatives(arm, path, np.asarray(s, float))[0], axis=1)
        return np.divide(speed, reach, out=np.full(len(reach), math.inf), where=reach > 1e-12) ** 2

    return ceiling


def tip_rows(arm: Arm, path: Path, acceleration: float) -> RowsOf:
    """A callable ``rows(s)`` that keeps the tip's acceleration vector below ``acceleration`` (m/s2) by :data:`DIRECTIONS` rows."""
    angles = np.arange(DIRECTIONS) * math.pi / DIRECTIONS
    bound = np.full(DIRECTIONS, acceleration * math.cos(math.pi / (2 * DIRECTIONS)))
    normals = np.cross(*tip_derivatives(arm, path, np.linspace(0.0, path.length, 200)))
    # the side from which the plane of the acceleration is seen: rows must not change places along the path
    above = np.linalg.eigh(normals.T @ normals)[1][:, -1]

    def rows(s: Floats) -> Rows:
        first, second = tip_derivatives(arm, path, np.asarray(s, float))
        along = first / np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-300)
        normal = np.cross(along, second)
        normal *= np.where(normal @ above < 0, -1.0, 1.0)[:, None]
        across = np.cross(normal, along)
        across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
        still = np.zeros((len(first), DIRECTIONS))
        one, two = (
            np.outer(np.sum(v * along, axis=1), np.cos(angles)) + np.outer(np.sum(v * across, axis=1), np.sin(angles)) for v in (first, second)
        )
        return {"a": one, "b": two, "d": still, "c": still, "low": -bound, "high": bound}

    return rows


def joined(parts: list[RowsOf]) -> RowsOf:
    """Several sets of rows as one."""
    if not parts:
        raise BadParameter("no rows were given")

    def rows(s: Floats) -> Rows:
        found = [part(s) for part in parts]
        return {key: np.concatenate([part[key] for part in found], axis=-1) for key in ("a", "b", "d", "c", "low", "high")}

    return rows
