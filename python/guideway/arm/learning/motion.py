"""A motion along a path as learners make it and plants run it: the square of the path speed on a grid, linear between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from guideway.errors import BadParameter

if TYPE_CHECKING:
    from guideway.arm.limits import JointLimits
    from guideway.arm.model import Arm
    from guideway.arm.motion import ArmMotion
    from guideway.arm.paths import JointPath

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Sampled:
    """A motion at n instants: ``t`` (s), ``s`` (rad), ``speed`` (rad/s) and ``u`` (rad/s2) along the path, all (n,); ``q, qd, qdd`` (n, joints) and
    the direction of the path ``q1 = dq/ds`` (n, joints)."""

    t: Floats
    s: Floats
    speed: Floats
    u: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    q1: Floats

    def to_dict(self) -> dict[str, Any]:
        """``t, q, qd, qdd`` as arrays."""
        return {"t": self.t, "q": self.q, "qd": self.qd, "qdd": self.qdd}


@dataclass(frozen=True)
class Motion:
    """Speed squared ``x`` (rad2/s2, (n,)) at the places ``s`` (rad, (n,), increasing, from 0 to the end) of ``path``, linear between: the path
    acceleration is constant on each interval. ``expected``: torques (n, joints), N m, that its learner expects at a sample of it, where it can say;
    a controller may feed them forward."""

    path: Any
    s: Floats
    x: Floats
    expected: Callable[[Sampled], Floats] | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        s, x = np.asarray(self.s, float), np.asarray(self.x, float)
        object.__setattr__(self, "s", s)
        object.__setattr__(self, "x", x)
        if not (np.isfinite(s).all() and np.isfinite(x).all() and (np.diff(s) > 0).all() and (x >= 0).all()):
            raise BadParameter("a motion needs finite, increasing places and finite squares of speed, none below 0")
        if ((x[1:] <= 0) & (x[:-1] <= 0)).any():
            at = s[int(np.argmax((x[1:] <= 0) & (x[:-1] <= 0)))]
            raise BadParameter(f"the motion stands still at s = {at:.4f} rad of the path: its speed is 0 over a whole interval")

    @cached_property
    def u(self) -> Floats:
        """Path acceleration on each interval, rad/s2, (n - 1,)."""
        return np.diff(self.x) / (2 * np.diff(self.s))

    @cached_property
    def times(self) -> Floats:
        """When the places of the grid are passed, s, (n,): ``dt = 2 ds / (v + v')`` is exact."""
        v = np.sqrt(self.x)
        return np.concatenate([[0.0], np.cumsum(2 * np.diff(self.s) / (v[1:] + v[:-1]))])

    @property
    def duration(self) -> float:
        """Of the whole motion, s."""
        return float(self.times[-1])

    def at_rest(self) -> Sampled:
        """The start of the path, standing still, as one sample."""
        zero, (q, q1) = np.zeros(1), self.path.eval(np.zeros(1), 1)
        return Sampled(zero, zero, zero, zero, q, np.zeros_like(q), np.zeros_like(q), q1)

    def slower(self, factor: float) -> Motion:
        """The same motion with every speed times ``factor``."""
        return Motion(self.path, self.s, self.x * factor * factor, self.expected)

    def profile(self, points: int = 250) -> dict[str, list[float]]:
        """Places ``s`` (rad) and squares ``x`` of the speed there (rad2/s2), at about so many of the grid's places, for pictures."""
        kept = np.unique(np.linspace(0, len(self.s) - 1, min(points, len(self.s))).round().astype(int))
        return {"s": np.round(self.s[kept], 6).tolist(), "x": np.round(self.x[kept], 6).tolist()}

    def squared(self, s: ArrayLike) -> Floats:
        """Speed squared at places of the path."""
        return np.interp(np.asarray(s, float), self.s, self.x)

    def sample(self, rate: float | None = None, times: ArrayLike | None = None) -> Sampled:
        """The motion at ``times`` (s), or ``rate`` times a second from 0 to its end; the end itself is always among the latter."""
        if times is None:
            steps = int(np.floor(self.duration * (rate or 500.0) + 1e-9))
            t = np.arange(steps + 1) / (rate or 500.0)
            if self.duration - t[-1] > 1e-9:
                t = np.append(t, self.duration)
        else:
            t = np.asarray(times, float)
        k = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.s) - 2)
        u, v, dt = self.u[k], np.sqrt(self.x[k]), np.clip(t, 0.0, self.duration) - self.times[k]
        s = np.minimum(self.s[k] + v * dt + 0.5 * u * dt * dt, self.s[-1])
        return self._along(t, s, np.maximum(v + u * dt, 0.0), u)

    def timed(self, path: JointPath, limits: JointLimits, arm: Arm | None = None) -> ArmMotion:
        """The same as the motion that :func:`guideway.arm.time` makes, for its outputs."""
        from guideway.arm.motion import ArmMotion, pieces_of

        speed = np.sqrt(self.x)
        table = np.column_stack([self.times[:-1], self.s[:-1], speed[:-1], self.u, np.zeros_like(self.u), np.diff(self.times)])
        grid = {"s": self.s, "x": self.x, "mvc": np.full_like(self.s, np.nan), "active": [None] * len(self.s)}
        return ArmMotion(path, pieces_of(table), limits, arm, grid, {"method": "learned"})

    def dense(self, per_interval: int = 4) -> Sampled:
        """Places all along the path, both ends of each interval among them with the acceleration of that interval: what a check must look at."""
        share = np.linspace(0.0, 1.0, per_interval + 1)
        h = np.diff(self.s)[:, None]
        s = self.s[:-1, None] + share * h
        x = self.x[:-1, None] + share * np.diff(self.x)[:, None]
        u = np.repeat(self.u, per_interval + 1)
        speed = np.sqrt(np.maximum(x, 0.0))
        v0 = np.sqrt(self.x[:-1, None])
        t = self.times[:-1, None] + 2 * (s - self.s[:-1, None]) / np.maximum(v0 + speed, 1e-12)
        return self._along(t.ravel(), np.minimum(s.ravel(), self.s[-1]), speed.ravel(), u)

    def _along(self, t: Floats, s: Floats, speed: Floats, u: Floats) -> Sampled:
        q, q1, q2 = self.path.eval(s, 2)
        return Sampled(t, s, speed, u, q, q1 * speed[:, None], q1 * u[:, None] + q2 * (speed * speed)[:, None], q1)
