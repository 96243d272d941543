"""The numbers that are not known of an arm, and how each of them enters its torques: payload, friction, motors; friction at low speeds; the ripple of
gears.

The first are those of :mod:`guideway.arm.learning.dynamics`. Friction near standstill follows no law that is linear in anything, so it is a curve
over speed, a number at each of a few speeds and for each direction. A gear's ripple multiplies the torque of its joint by a wave over the joint's
angle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.dynamics import OF_A_JOINT, PAYLOAD, Rows
from guideway.arm.model import direction

if TYPE_CHECKING:
    from guideway.arm.learning.task import Task

Floats = NDArray[np.float64]

SPEEDS = (0.0, 0.01, 0.02, 0.035, 0.06, 0.1)
"""Where the curve of friction has its numbers, rad/s: what it differs there from viscous and Coulomb friction."""
CREEPING = 3
"""The speeds from here on are those of creeping."""
END = 0.2
"""From here on it differs by nothing, rad/s."""
PLAIN = PAYLOAD + len(OF_A_JOINT)
COULOMB = PAYLOAD + OF_A_JOINT.index("coulomb")
RUBS = ("viscous", "coulomb", "offset", "viscous asymmetry")
CURVE = 2 * len(SPEEDS)
WAVES = 2


class Unknown:
    """Which numbers are sought for a task: ``index`` (joints, width) are those that each joint's torque depends on, of ``count`` in all; ``sizes``
    (count,) their standard deviations before the first trial, ``rubs`` (count,) whether they are friction. ``cycles`` (joints,): ripple in waves per
    rad of joint angle times 2 pi, 0 for none."""

    def __init__(self, task: Task, curves: bool = True, cycles: Floats | None = None) -> None:
        self.joints, self.curves = len(task.torque), curves
        self.cycles = np.zeros(self.joints) if cycles is None else cycles
        own = len(OF_A_JOINT) + (CURVE if curves else 0) + (WAVES if self.cycles.any() else 0)
        numbers = PAYLOAD + self.joints * np.arange(own) + np.arange(self.joints)[:, None]
        self.index = np.concatenate([np.broadcast_to(np.arange(PAYLOAD), (self.joints, PAYLOAD)), numbers], 1)
        self.count = PAYLOAD + own * self.joints
        friction = [name in RUBS for name in OF_A_JOINT] + [True] * (CURVE if curves else 0)
        self.rubs = np.zeros(self.count, bool)
        self.rubs[PAYLOAD : PAYLOAD + self.joints * len(friction)] = np.repeat(friction, self.joints)
        self.sizes = _sizes(task, curves, bool(self.cycles.any()))

    def effects(self, plain: Floats, qd: Floats, ways: Floats, q: Floats, tau: Floats) -> Floats:
        """How the numbers enter (n, joints, width): ``plain`` (n, joints, 15) those of :meth:`Dynamics.own_parameters`, at joint speeds ``qd`` in the
        directions ``ways``, angles ``q`` and torques ``tau``, all (n, joints)."""
        parts = [plain]
        if self.curves:
            parts.append(self.bends(qd, ways))
        if self.cycles.any():
            parts.append(self.waves(q) * tau[..., None])
        return np.concatenate(parts, -1)

    def bends(self, qd: Floats, ways: Floats) -> Floats:
        """Of the curve of friction (..., 12): linear between its speeds, forwards and backwards apart."""
        at = np.array([*SPEEDS, END])
        speed = np.abs(qd)[..., None]
        rising = np.concatenate([np.ones((*qd.shape, 1)), np.clip((speed - at[:-1]) / np.diff(at), 0.0, 1.0)], -1)
        hats = rising[..., :-1] - rising[..., 1:]
        way = np.sign(ways)[..., None]
        return np.concatenate([np.where(way > 0, hats, 0.0), np.where(way < 0, -hats, 0.0)], -1)

    def waves(self, q: Floats) -> Floats:
        """Of the ripple (..., 2)."""
        turn, there = self.cycles * q, (self.cycles > 0).astype(float)
        return np.stack([np.sin(turn) * there, np.cos(turn) * there], -1)

    def split(self, numbers: Floats) -> tuple[Floats, Floats, Floats]:
        """Numbers (count,) as those of each joint: plain ones (joints, 15), of the curve (joints, 12 or 0), of the ripple (joints, 2 or 0)."""
        own = numbers[self.index]
        bends = CURVE if self.curves else 0
        return own[:, :PLAIN], own[:, PLAIN : PLAIN + bends], own[:, PLAIN + bends :]


class Along:
    """The unknown numbers on a task's grid, for motions along it."""

    def __init__(self, task: Task, unknown: Unknown) -> None:
        self.task, self.unknown = task, unknown
        self.plain = task.dynamics.own_parameters(task.q, task.q1, task.q2)
        self.waves, self.ways = unknown.waves(task.q), direction(task.q1)

    def rows(self, numbers: Floats, x: Floats) -> tuple[Rows, Floats, Floats]:
        """Rows of the torque with these numbers, the curve of friction taken at squared speeds ``x``; and how far friction is below and above that
        within an interval of each point, both from 0 up."""
        plain, bends, ripple = self.unknown.split(numbers)
        rows = self.task.nominal + self.plain.times(plain)
        curve, below, above = self._curve(bends, plain[:, COULOMB], x)
        gain = 1 + (self.waves * ripple).sum(-1) if ripple.size else 1.0
        return Rows(gain * rows.a, gain * rows.b, gain * rows.d, gain * (rows.c + curve)), gain * below, gain * above

    def creeping(self, numbers: Floats) -> tuple[Rows, Floats]:
        """Rows without the curve of friction, and the torque (n, joints) that holding and rubbing take at low speed."""
        plain, bends, _ = self.unknown.split(numbers)
        rows = self.task.nominal + self.plain.times(plain)
        if not bends.size:
            return rows, np.abs(rows.c)
        least = bends.reshape(len(bends), 2, len(SPEEDS))[:, :, CREEPING:].min(2)
        curve = np.where(self.ways > 0, least[:, 0], 0.0) - np.where(self.ways < 0, least[:, 1], 0.0)
        return rows, np.abs(rows.c + curve)

    def effects(self, u: Floats, x: Floats, tau: Floats) -> Floats:
        """As :meth:`Unknown.effects`, for a motion with path acceleration ``u`` and squared speeds ``x`` and its torques ``tau``."""
        task = self.task
        return self.unknown.effects(self.plain.at(u, x), task.q1 * np.sqrt(x)[:, None], self.ways, task.q, tau)

    def _curve(self, bends: Floats, coulomb: Floats, x: Floats) -> tuple[Floats, Floats, Floats]:
        task = self.task
        still = np.zeros_like(task.q1)
        if not bends.size:
            return still, still, still

        def at(q1: Floats, squared: Floats) -> Floats:
            ways = direction(q1)
            return (self.unknown.bends(q1 * np.sqrt(squared)[:, None], ways) * bends).sum(-1) + coulomb * ways

        total = at(task.q1, x)
        low, high = total.copy(), total.copy()
        for share in BETWEEN:
            between = at((1 - share) * task.q1[:-1] + share * task.q1[1:], (1 - share) * x[:-1] + share * x[1:])
            for part in (slice(None, -1), slice(1, None)):
                low[part], high[part] = np.minimum(low[part], between), np.maximum(high[part], between)
        return total - coulomb * direction(task.q1), total - low, high - total


BETWEEN = (0.003, 0.02, 0.08, 0.2, 0.5, 0.8, 0.92, 0.98, 0.997)
"""Shares of an interval at which the curve of friction is looked at: squared speeds start from 0 and end there."""


def _sizes(task: Task, curves: bool, ripple: bool) -> Floats:
    """Standard deviations before the first trial: a payload as heavy as the arm could hold with nothing else to do, friction of half of each joint's
    torque, ripple of 2 %."""
    reach = np.abs(task.nominal.c).max() / max(9.81 * _moved_mass(task), 1e-9)
    mass = float(task.torque.max()) / (9.81 * max(reach, 0.05))
    arm = 0.3 * reach
    inertial = [mass, *[mass * arm] * 3, *[mass * arm * arm] * 6]
    half = 0.5 * task.torque
    plain = {
        "viscous": half / task.speed,
        "coulomb": half,
        "offset": 0.2 * half,
        "viscous asymmetry": 0.2 * half / task.speed,
        "rotor": 0.2 * half / task.acceleration,
    }
    parts = [np.array(inertial[:PAYLOAD]), *[plain[name] for name in OF_A_JOINT]]
    if curves:
        parts += ([half] + [0.3 * half] * (len(SPEEDS) - 1)) * 2
    if ripple:
        parts += [np.full(len(half), 0.02)] * WAVES
    return np.concatenate(parts)


def _moved_mass(task: Task) -> float:
    return float(sum(inertia.mass for inertia in list(task.arm.model.inertias)[2:]))
