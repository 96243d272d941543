"""A timed motion of an arm: pieces of constant jerk along a joint path, sampled, slowed down, stopped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway.arm.limits import JointLimits
from guideway.arm.model import Arm, direction
from guideway.arm.paths import JointPath
from guideway.errors import BadParameter, Infeasible

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

RATE = 500.0
"""Samples per second of files, Hz."""


@dataclass(frozen=True)
class ArmMotion:
    """A motion of joints in time.

    ``pieces`` (m, 6): start time t (s), place s (rad), path speed (rad/s), acceleration (rad/s2), jerk (rad/s3) and duration (s) of pieces
    of constant jerk along ``path``. ``grid`` holds ``s``, the squared path speed ``x``, the maximum velocity curve ``mvc`` (as squared speed) and
    the name of the ``active`` constraint at the solver's points. ``report``: how it came about; ``arm`` is None where only joint limits counted.
    """

    path: JointPath
    pieces: Floats
    limits: JointLimits
    arm: Arm | None = None
    grid: dict[str, Any] = field(default_factory=dict, repr=False)
    report: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def duration(self) -> float:
        """From start to end, s."""
        return float(self.pieces[-1, 0] + self.pieces[-1, 5]) if len(self.pieces) else 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """The joints."""
        return self.path.names

    def along(self, t: ArrayLike) -> Floats:
        """Place, path speed, acceleration and jerk (n, 4) at times ``t`` (n,); before the start and after the end it stands still there."""
        times = np.atleast_1d(np.asarray(t, float))
        if not np.isfinite(times).all():
            raise BadParameter("times must be finite numbers, s")
        if not len(self.pieces):
            return np.zeros((len(times), 4))
        inside = np.clip(times, 0.0, self.duration)
        k = np.clip(np.searchsorted(self.pieces[:, 0], inside, "right") - 1, 0, len(self.pieces) - 1)
        start, s, v, a, j, length = self.pieces[k].T
        d = np.minimum(inside - start, length)
        found = np.stack([s + d * (v + d * (a / 2 + d * j / 6)), v + d * (a + d * j / 2), a + d * j, j], axis=1)
        found[(times < 0) | (times > self.duration), 1:] = 0.0
        found[:, 0] = np.clip(found[:, 0], 0.0, self.path.path.length)
        return found

    def at(self, t: float) -> dict[str, Any]:
        """The state at one time: ``t, s, speed, acceleration, jerk`` of the path, ``q, qd, qdd, qddd`` (joints,)."""
        found = self.sample(times=[t])
        return {key: value[0] for key, value in found.items()}

    def sample(self, rate: float = RATE, times: ArrayLike | None = None) -> dict[str, Floats]:
        """States at a rate (Hz; the last one is the end) or at given times.

        ``t, s, speed, acceleration, jerk`` (n,) of the path, ``q, qd, qdd, qddd`` (n, joints).
        """
        if times is None:
            if not 0 < rate < 1e6:
                raise BadParameter(f"rate {rate!r} is out of range: above 0 and below 1e6 Hz")
            moments = np.append(np.arange(int(np.ceil(self.duration * rate - 1e-9))) / rate, self.duration)
        else:
            moments = np.atleast_1d(np.asarray(times, float))
        along = self.along(moments)
        v, a, j = (column[:, None] for column in along.T[1:])
        q, one, two, three = self.path.path.eval(along[:, 0], 3)
        return {
            "t": moments,
            **dict(zip(("s", "speed", "acceleration", "jerk"), along.T, strict=True)),
            "q": q,
            "qd": one * v,
            "qdd": one * a + two * v**2,
            "qddd": one * j + 3 * two * v * a + three * v**3,
        }

    def torques(self, sample: dict[str, Floats]) -> Floats:
        """Torques (n, joints) in N m that the arm's model asks for along a sample; Coulomb friction acts along the path, at its ends too."""
        if self.arm is None:
            raise BadParameter("torques need an arm: give arm= when timing the path")
        way = sample["direction"] if "direction" in sample else direction(self.path.path.eval(sample["s"], 1)[1])
        viscous, coulomb = self.arm.friction.arrays(self.arm.joints)
        self.arm.need_inertials()
        return self.arm.rnea(sample["q"], sample["qd"], sample["qdd"]) + viscous * sample["qd"] + coulomb * way

    def times_at(self, s: ArrayLike) -> Floats:
        """When the motion is at places ``s`` (n,) of its path (rad), s."""
        places = np.atleast_1d(np.asarray(s, float))
        start, at, v, a, j, length = self.pieces[np.clip(np.searchsorted(self.pieces[:, 1], places, "right") - 1, 0, len(self.pieces) - 1)].T
        low, high = np.zeros(len(places)), length.copy()
        for _ in range(60):
            d = 0.5 * (low + high)
            before = at + d * (v + d * (a / 2 + d * j / 6)) < places
            low, high = np.where(before, d, low), np.where(before, high, d)
        return start + high

    def time_at(self, s: float) -> float:
        """When the motion is at a place ``s`` (rad) of its path, s."""
        return float(self.times_at(s)[0])

    def override(self, factor: float, at: float = 0.0) -> ArmMotion:
        """The same motion at ``factor`` (above 0, at most 1) of its speed, from time ``at`` (s) on.

        From the start that is the whole motion slowed down; from a later time on, it brakes along the path as hard as the limits allow until it
        has the lower speed. It stays on the path.

        Slower, a motion keeps every limit but, maybe, one of torque rate: where gravity and inertia change a torque in opposite ways. Raises
        ``Infeasible`` for that; a brake says what it uses of it in ``report["brake"]``.
        """
        if not 0 < factor <= 1:
            raise BadParameter(f"override {factor!r} is out of range: above 0 and at most 1. To go faster, raise the limits and time the path again")
        if at <= 0:
            from guideway.arm.certificate import TOLERANCE, worst_rate

            whole = self.scaled(factor)
            ratio = worst_rate(whole) if self.arm is not None and "brake" not in self.report else 0.0
            if ratio > max(1.0, worst_rate(self) if ratio > 1 else 1.0) + TOLERANCE:
                raise Infeasible(f"at {factor:g} of its speed the motion would use {ratio:.4f} of its limit of torque rate: choose another override")
            return whole
        from guideway.arm.brake import slowed

        return slowed(self, at, factor)

    def scaled(self, factor: float) -> ArmMotion:
        """The whole motion at ``factor`` (above 0) of its speed, no limit checked."""
        scaled = self.pieces * np.array([1 / factor, 1, factor, factor**2, factor**3, 1 / factor])
        grid = self.grid | ({"x": np.asarray(self.grid["x"], float) * factor**2} if len(self.grid.get("x", ())) else {})
        return replace(self, pieces=scaled, grid=grid, report=self.report | {"override": factor * self.report.get("override", 1.0)})

    def stop_from(self, t: float) -> ArmMotion:
        """The motion that goes like this one until ``t`` (s) and then stops on the path as soon as the limits allow."""
        from guideway.arm.brake import slowed

        return slowed(self, t, 0.0)

    def certify(self, **options: Any) -> dict[str, Any]:
        """The certificate of this motion; see :func:`guideway.arm.certificate.certify`."""
        from guideway.arm.certificate import certify

        return certify(self, **options)

    def cut(self, t: float) -> Floats:
        """The pieces up to time ``t`` (s)."""
        kept = self.pieces[self.pieces[:, 0] < t].copy()
        if len(kept):
            kept[-1, 5] = min(kept[-1, 5], t - kept[-1, 0])
        return kept

    def rest(self, t: float) -> Floats:
        """The pieces from time ``t`` (s) on, their times as they are."""
        later = self.pieces[self.pieces[:, 0] + self.pieces[:, 5] > t].copy()
        if len(later) and later[0, 0] < t:
            s, v, a, j = self.along(t)[0]
            later[0] = [t, s, v, a, j, later[0, 0] + later[0, 5] - t]
        return later


def pieces_of(rows: Sequence[Any] | Floats) -> Floats:
    """Pieces as an array (m, 6) from records with ``t, s, speed, acceleration, jerk, duration``; empty ones are left out."""
    keys = ("t", "s", "speed", "acceleration", "jerk", "duration")
    table = np.array([[row[key] for key in keys] for row in rows] if not isinstance(rows, np.ndarray) else rows, float).reshape(-1, 6)
    return table[table[:, 5] > 0]
