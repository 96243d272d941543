"""The torque of an arm along a path as coefficients: ``tau = a u + b x + d sqrt(x) + c``, and how each unknown number enters it.

What is known is the nominal model of the arm; what is not known is what it carries and how its joints rub and what their motors weigh. All enter
linearly: ten inertial numbers of the payload in the frame of the last link, and five of each joint.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from guideway.arm.extra import pinocchio
from guideway.arm.model import direction, frame_of
from guideway.arm.rows import coefficients_of

if TYPE_CHECKING:
    from guideway.arm.model import Arm

Floats = NDArray[np.float64]

PAYLOAD = 10
"""Mass, mass times centre (3), inertia about the origin of the last link (6)."""
OF_A_JOINT = ("viscous", "coulomb", "offset", "viscous asymmetry", "rotor")
"""Per joint: ``q' sqrt(x)``, ``sgn q'``, 1 and ``|q'| sqrt(x)`` (the last two are what differs between the directions), ``q' u + q'' x`` (the inertia
of its motor, which robot descriptions leave out)."""


@dataclass(frozen=True)
class Rows:
    """Coefficients of ``a u + b x + d sqrt(x) + c``, each (n, joints) or (n, joints, parameters); N m with u in rad/s2, x in rad2/s2."""

    a: Floats
    b: Floats
    d: Floats
    c: Floats

    def __add__(self, other: Rows) -> Rows:
        return Rows(self.a + other.a, self.b + other.b, self.d + other.d, self.c + other.c)

    def at(self, u: Floats, x: Floats) -> Floats:
        """Values at path accelerations and squared speeds, (n,) each."""
        shape = (-1,) + (1,) * (self.a.ndim - 1)
        u, x = u.reshape(shape), x.reshape(shape)
        return self.a * u + self.b * x + self.d * np.sqrt(x) + self.c

    def times(self, parameters: Floats) -> Rows:
        """The sum over the last axis, weighted by (parameters,), or by (joints, parameters) where each joint has its own."""
        if parameters.ndim == 1:
            return Rows(self.a @ parameters, self.b @ parameters, self.d @ parameters, self.c @ parameters)
        return Rows(*((part * parameters).sum(-1) for part in (self.a, self.b, self.d, self.c)))


class Dynamics:
    """Rows of the nominal arm, and of what is unknown about it."""

    def __init__(self, arm: Arm) -> None:
        arm.need_inertials()
        self.arm, self.joints, self._data = arm, arm.joints, arm.model.createData()
        carrier = arm.model.frames[frame_of(arm.model, arm.tip)].parentJoint
        self._columns = slice(PAYLOAD * (carrier - 1), PAYLOAD * carrier)

    @property
    def count(self) -> int:
        """How many numbers are unknown."""
        return PAYLOAD + len(OF_A_JOINT) * self.joints

    def nominal(self, q: Floats, q1: Floats, q2: Floats) -> Rows:
        """``a = M q'``, ``b = M q'' + C q'``, ``c = g``, and what friction the nominal arm has."""
        found = coefficients_of(self.arm, q, q1, q2)
        return Rows(found["a"], found["b"], found["d"], found["c"])

    def parameters(self, q: Floats, q1: Floats, q2: Floats) -> Rows:
        """How each of the ``10 + 5 joints`` unknown numbers enters: (n, joints, parameters)."""
        joints, compact = self.joints, self.own_parameters(q, q1, q2)
        where = np.arange(joints)

        def dense(part: Floats) -> Floats:
            found = np.zeros((len(q), joints, self.count))
            found[:, :, :PAYLOAD] = part[:, :, :PAYLOAD]
            for kind in range(len(OF_A_JOINT)):
                found[:, where, PAYLOAD + joints * kind + where] = part[:, :, PAYLOAD + kind]
            return found

        return Rows(dense(compact.a), dense(compact.b), dense(compact.d), dense(compact.c))

    def own_parameters(self, q: Floats, q1: Floats, q2: Floats) -> Rows:
        """The same for each joint without the numbers of the other joints: (n, joints, 15), those of the payload first."""
        still = np.zeros_like(q1)
        gravity = self._payload(q, still, still)
        a, b = self._payload(q, still, q1) - gravity, self._payload(q, q1, q2) - gravity

        def of(own: dict[str, Floats], payload: Floats) -> Floats:
            return np.concatenate([payload, np.stack([own.get(name, still) for name in OF_A_JOINT], 2)], 2)

        return Rows(
            of({"rotor": q1}, a),
            of({"rotor": q2}, b),
            of({"viscous": q1, "viscous asymmetry": np.abs(q1)}, np.zeros_like(a)),
            of({"coulomb": direction(q1), "offset": np.ones_like(q1)}, gravity),
        )

    def moving(self, q: Floats, qd: Floats, qdd: Floats, ways: Floats) -> tuple[Floats, Floats]:
        """Nominal torques (n, joints) of any motion, path or not, and how each joint's unknown numbers enter (n, joints, 15); ``ways`` (n, joints) is
        which way joints move."""
        viscous, coulomb = self.arm.friction.arrays(self.joints)
        nominal = self.arm.rnea(q, qd, qdd) + viscous * qd + coulomb * ways
        own = np.stack([qd, ways, np.ones_like(qd), np.abs(qd), qdd], 2)
        return nominal, np.concatenate([self._payload(q, qd, qdd), own], 2)

    def _payload(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Torques (n, joints, 10) of a unit of each inertial number of what the last joint carries."""
        arm, compute = self.arm, pinocchio().computeJointTorqueRegressor
        couple, offset = arm.coupling, arm.offset
        found = np.empty((len(q), arm.model.nv, PAYLOAD))
        for k, row in enumerate(zip(q @ couple.T + offset, qd @ couple.T, qdd @ couple.T, strict=True)):
            found[k] = compute(arm.model, self._data, *row)[:, self._columns]
        return np.einsum("fj,nfp->njp", couple, found)
