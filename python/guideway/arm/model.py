"""A robot arm: kinematics and dynamics of a serial chain, by Pinocchio."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway.arm import urdf
from guideway.arm.extra import pinocchio
from guideway.errors import BadParameter

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

STILL = 1e-9
"""A joint whose share of the path is below this does not move: Coulomb friction has no direction there."""


def direction(first: Floats) -> Floats:
    """Which way joints move along a path, by their shares ``first`` of it: -1, 1, or 0 where they stand."""
    return np.where(np.abs(first) > STILL, np.sign(first), 0.0)


@dataclass(frozen=True)
class Friction:
    """Friction of joints: ``viscous`` (N m s/rad) and ``coulomb`` (N m), a number or one per joint."""

    viscous: float | Sequence[float] = 0.0
    coulomb: float | Sequence[float] = 0.0

    def arrays(self, joints: int) -> tuple[Floats, Floats]:
        """Both as arrays of one number per joint; raises ``BadParameter`` for other counts and negative numbers."""
        found: list[Floats] = []
        for name in ("viscous", "coulomb"):
            array = np.asarray(getattr(self, name), float)
            if array.shape not in ((), (joints,)) or not (np.isfinite(array).all() and (array >= 0).all()):
                raise BadParameter(f"{name} friction {getattr(self, name)!r} cannot be used: a number from 0, or one for each of the {joints} joints")
            found.append(np.broadcast_to(array, (joints,)).copy())
        return found[0], found[1]


REFERENCE_FRICTION = Friction(viscous=(8, 8, 8, 2, 2, 2), coulomb=(7, 7, 7, 2, 2, 2))
"""Friction of the reference plant (UR5e)."""


@dataclass(frozen=True)
class Payload:
    """What the tip carries: ``mass`` (kg), its centre ``at`` (m, in the tip's frame), ``inertia`` about that centre (kg m2): one number for a body
    that is alike in all directions, or a symmetric 3 x 3 matrix."""

    mass: float = 0.0
    at: tuple[float, float, float] = (0.0, 0.0, 0.08)
    inertia: float | Sequence[Sequence[float]] | None = None

    def matrix(self) -> Floats:
        """The inertia as a matrix; left out it is 0.0017 m2 times the mass."""
        given = np.asarray(0.0017 * self.mass if self.inertia is None else self.inertia, float)
        matrix = given * np.eye(3) if given.ndim == 0 else given
        if not (np.isfinite([self.mass, *self.at]).all() and self.mass >= 0 and len(self.at) == 3):
            raise BadParameter(f"payload {self.mass!r} kg at {self.at!r} cannot be used: a mass from 0, three finite numbers in m")
        if matrix.shape != (3, 3) or not np.isfinite(matrix).all() or not np.allclose(matrix, matrix.T) or np.linalg.eigvalsh(matrix).min() < -1e-12:
            raise BadParameter(f"payload inertia {self.inertia!r} cannot be used: a number from 0, or a symmetric, positive 3 x 3 matrix, kg m2")
        return matrix


@dataclass(frozen=True)
class Arm:
    """A robot arm of ``n`` driven joints, in the order of ``names`` from its root to its tip. SI units, radians, gravity along -z of the root.

    Arrays of joints have shape (n,) or (m, n) for m postures, results then (...) or (m, ...). Made by :meth:`load`, :meth:`from_dh` and
    :func:`guideway.arm.robot`; immutable.
    """

    name: str
    names: tuple[str, ...]
    lower: Floats
    upper: Floats
    speed: tuple[float | None, ...]
    effort: tuple[float | None, ...]
    tip: str
    base: str
    inertials: str
    payload: Payload
    friction: Friction
    model: Any = field(repr=False)
    coupling: Floats = field(repr=False)
    offset: Floats = field(repr=False)
    source: str | None = None
    _bare: Any = field(repr=False, default=None)
    _data: Any = field(repr=False, default=None, compare=False)

    @staticmethod
    def load(
        path: str | os.PathLike[str],
        *,
        tip: str | None = None,
        base: str | None = None,
        payload: float | Payload = 0.0,
        payload_at: Sequence[float] = (0.0, 0.0, 0.08),
        payload_inertia: float | Sequence[Sequence[float]] | None = None,
        friction: Friction | Mapping[str, Any] | None = None,
    ) -> Arm:
        """Reads a URDF file: the chain from the root to ``tip`` (default ``tool0``, else the longest chain); joints beside it stand still at 0.

        ``base`` is the link in whose frame poses are given (default the root). ``payload`` in kg sits at ``payload_at`` (m, in the tip's frame)
        with ``payload_inertia`` about that point. Raises :class:`guideway.errors.BadFile` and ``BadParameter``.
        """
        from guideway.arm.build import from_description

        arm = from_description(urdf.read(path), tip, base)
        load = payload if isinstance(payload, Payload) else Payload(payload, _triple(payload_at), payload_inertia)
        return arm.with_payload(load).with_friction(friction)

    @staticmethod
    def from_dh(rows: Sequence[Mapping[str, Any]], *, name: str = "dh", **limits: Any) -> Arm:
        """An arm from standard Denavit-Hartenberg rows; see :func:`guideway.arm.build.from_rows`."""
        from guideway.arm.build import from_rows

        return from_rows(rows, name=name, **limits)

    @property
    def followers(self) -> dict[str, tuple[str, ...]]:
        """Joints that follow a driven one (mimic joints), by its name."""
        found: dict[str, tuple[str, ...]] = {}
        for column, name in enumerate(self.names):
            moved = [
                str(title) for title in list(self.model.names)[1:] if self.coupling[self.model.joints[self.model.getJointId(title)].idx_v, column]
            ]
            found[name] = tuple(title for title in moved if title != name)
        return found

    @property
    def joints(self) -> int:
        """How many joints are driven."""
        return len(self.names)

    def with_payload(self, mass: float | Payload, at: Sequence[float] = (0.0, 0.0, 0.08), inertia: float | None = None) -> Arm:
        """The same arm with another payload."""
        load = mass if isinstance(mass, Payload) else Payload(mass, _triple(at), inertia)
        pin, matrix = pinocchio(), load.matrix()
        model = self._bare.copy()
        if load.mass > 0:
            frame = model.frames[frame_of(model, self.tip)]
            model.appendBodyToJoint(frame.parentJoint, pin.Inertia(load.mass, np.asarray(load.at, float), matrix), frame.placement)
        return replace(self, payload=load, model=model, _data=model.createData())

    def with_friction(self, friction: Friction | Mapping[str, Any] | None) -> Arm:
        """The same arm with other friction: ``viscous`` and ``coulomb``, or None for none."""
        if isinstance(friction, Mapping):
            if unknown := [key for key in friction if key not in ("viscous", "coulomb")]:
                raise BadParameter(f"friction {unknown[0]!r} is not known; allowed: viscous, coulomb")
            friction = Friction(**friction)
        friction = friction or Friction()
        friction.arrays(self.joints)
        return replace(self, friction=friction)

    def forward(self, q: ArrayLike, frame: str | None = None) -> Floats:
        """Poses (..., 4, 4) of a link (default the tip) in the frame of the base."""
        postures, single = self._rows(q)
        index, data, model = self._index(frame), self._data, self.model
        pin = pinocchio()
        poses = np.empty((len(postures), 4, 4))
        base = frame_of(model, self.base)
        for k, full in enumerate(self._full(postures)):
            pin.forwardKinematics(model, data, full)
            pin.updateFramePlacement(model, data, base)
            pose = pin.updateFramePlacement(model, data, index)
            poses[k] = data.oMf[base].actInv(pose).homogeneous
        return poses[0] if single else poses

    def jacobian(self, q: ArrayLike, frame: str | None = None) -> Floats:
        """Jacobians (..., 6, n) of a link's origin (default the tip), linear over angular part, along the axes of the base."""
        return self.kinematics(q, frame)[1]

    def kinematics(self, q: ArrayLike, frame: str | None = None) -> tuple[Floats, Floats]:
        """Poses as of :meth:`forward` and Jacobians as of :meth:`jacobian` at once."""
        postures, single = self._rows(q)
        index, data, model, couple = self._index(frame), self._data, self.model, self.coupling
        pin = pinocchio()
        base, axes = frame_of(model, self.base), pin.LOCAL_WORLD_ALIGNED
        poses, found = np.empty((len(postures), 4, 4)), np.empty((len(postures), 6, self.joints))
        turns = np.empty((len(postures), 3, 3))
        for k, full in enumerate(self._full(postures)):
            pin.computeJointJacobians(model, data, full)
            ground = pin.updateFramePlacement(model, data, base)
            poses[k] = ground.actInv(pin.updateFramePlacement(model, data, index)).homogeneous
            turns[k] = ground.rotation
            found[k] = pin.getFrameJacobian(model, data, index, axes) @ couple
        found = np.concatenate([np.einsum("kji,kjm->kim", turns, found[:, :3]), np.einsum("kji,kjm->kim", turns, found[:, 3:])], axis=1)
        return (poses[0], found[0]) if single else (poses, found)

    def torques(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Floats:
        """Joint torques (..., n) in N m of a motion, payload and friction included; the sign of Coulomb friction is that of the joint's speed."""
        self.need_inertials()
        postures, single = self._rows(q)
        speeds, accelerations = (np.broadcast_to(self._rows(x)[0], postures.shape) for x in (qd, qdd))
        viscous, coulomb = self.friction.arrays(self.joints)
        found = self.rnea(postures, speeds, accelerations) + viscous * speeds + coulomb * np.sign(speeds)
        return found[0] if single else found

    def rnea(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Rigid-body torques (m, n) of m postures, without friction."""
        rnea, model, data = pinocchio().rnea, self.model, self._data
        couple = self.coupling
        found = np.empty((len(q), model.nv))
        for k, row in enumerate(zip(self._full(q), qd @ couple.T, qdd @ couple.T, strict=True)):
            found[k] = rnea(model, data, *row)
        return found @ couple

    def need_inertials(self) -> None:
        """Raises ``BadParameter`` where the description states no inertials: torques cannot be computed then."""
        if self.inertials == "none":
            raise BadParameter(
                f"{self.name}: torques were asked for, but {self.source or 'its description'} states no masses and inertias for some driven links. "
                "Add <inertial> to them, or leave out torque limits"
            )

    def speed_limits(self) -> tuple[float, ...]:
        """Joint speeds of the description; raises ``BadParameter`` where one is not given."""
        return self._given(self.speed, "speed", "velocity", "rad/s")

    def torque_limits(self) -> tuple[float, ...]:
        """Joint torques of the description; raises ``BadParameter`` where one is not given (an effort of 0 in a URDF means that)."""
        return self._given(self.effort, "torque", "effort", "N m")

    def _given(self, values: tuple[float | None, ...], what: str, key: str, unit: str) -> tuple[float, ...]:
        missing = [name for name, value in zip(self.names, values, strict=True) if value is None]
        if missing:
            raise BadParameter(
                f"{self.name}: no {what} limit is given for {', '.join(missing)} ({key} 0 or missing in {self.source or 'its description'}). "
                f"State {what} in {unit} in a limits file"
            )
        return tuple(value for value in values if value is not None)

    def _rows(self, q: ArrayLike) -> tuple[Floats, bool]:
        array = np.asarray(q, float)
        if array.ndim not in (1, 2) or array.shape[-1] != self.joints or not np.isfinite(array).all():
            raise BadParameter(f"joint values of shape {array.shape} cannot be used: finite numbers of shape (m, {self.joints}) or ({self.joints},)")
        return np.atleast_2d(array), array.ndim == 1

    def _full(self, q: Floats) -> Floats:
        """The model's own joints, those that follow others included."""
        return q @ self.coupling.T + self.offset

    def _index(self, frame: str | None) -> int:
        return frame_of(self.model, frame or self.tip)


def frame_of(model: Any, link: str) -> int:
    """The number of a link's frame in the model, which may have a joint of the same name; raises ``BadParameter`` for a link that is not there."""
    pin = pinocchio()
    if not model.existFrame(link, pin.BODY):
        known = [frame.name for frame in model.frames if frame.type == pin.BODY]
        raise BadParameter(f"link {link!r} is not part of this robot; allowed: {', '.join(known)}")
    return model.getFrameId(link, pin.BODY)


def _triple(values: Sequence[float]) -> tuple[float, float, float]:
    if len(values) != 3:
        raise BadParameter(f"{tuple(values)!r} is not a point: three numbers x, y, z in m")
    return float(values[0]), float(values[1]), float(values[2])
