"""Learning with a worst-case bound: no trial after the first exceeds a limit, whatever the noise does within a bound that is stated.

As :mod:`guideway.arm.learning.structured`, but instead of a mean and a standard deviation it keeps the set of all numbers (payload, friction) that
explain every sample of every trial within ``bound``, and plans with the worst of them. Sets only shrink, so durations never rise. Slower to compute,
slower motions: a bound on noise says less than its distribution. What the structure cannot explain must fit into ``bound`` too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.polytope import upper_end
from guideway.arm.learning.regression import evidence, posterior, prior
from guideway.arm.learning.structured import BINS, Structured, sides
from guideway.arm.learning.task import Task
from guideway.errors import BadParameter, Infeasible

Floats = NDArray[np.float64]

KEPT = 150
"""Measurements on either side that bound the set; leaving out others only makes it larger."""
ROUNDS = 6
WIDEST = 4.0
"""Half width of the set before the first trial, in standard deviations of the structured learner's prior."""


@dataclass
class Guaranteed:
    """``bound``: largest error of a torque sample (N m, per joint or one for all; None: six times the noise seen in the first trial); ``scale`` of
    the first trial's speed, which must be safe; ``margin`` for what happens between grid points, share of the limit."""

    task: Task
    bound: float | Sequence[float] | None = None
    scale: float = 0.4
    margin: float = 0.003
    lower_bound: float | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self._start = Structured(self.task, scale=self.scale)
        self._effects, self._sizes = self._start.effects, prior(self.task)
        self._planned = self._start.next([])
        self._trials, self._samples = [], []
        self._lag: int | None = None
        self._error: Floats | None = None

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The next motion; the last one where nothing faster is safe."""
        for log in logs[len(self._trials) :]:
            self._remember(log)
        if not self._trials:
            self.lower_bound = self.task.optimum().duration
        elif self._planned is not None:
            self._planned = self._safe(self._planned)
        return self._planned

    def _remember(self, log: Log) -> None:
        joints = len(self.task.torque)
        if self._error is None:
            given = 6 * log.noise + 0.05 if self.bound is None else np.broadcast_to(np.asarray(self.bound, float), (joints,))
            if not (np.isfinite(given).all() and (given > 0).all()):
                raise BadParameter(f"bound {self.bound!r} is out of range: a number of N m above 0, or one per joint")
            self._error = given
        found, self._lag = evidence(self.task, log, self._lag, BINS)
        self._trials.append(found)
        seen, count = log.reference, len(log.t) - self._lag
        q, q1, q2 = self.task.path.eval(seen.s[:count], 2)
        u, x, dynamics = seen.u[:count], seen.speed[:count] ** 2, self.task.dynamics
        left = log.tau[self._lag :] - dynamics.nominal(q, q1, q2).at(u, x)
        scale = np.tile(self._error, count)
        self._samples.append((dynamics.parameters(q, q1, q2).at(u, x).reshape(len(scale), -1) / scale[:, None], left.ravel() / scale))

    def _safe(self, before: Motion) -> Motion:
        """The fastest motion that is safe for every member of the set, or the one before."""
        task, torque = self.task, self.task.torque
        believed = posterior(self._trials, self._sizes, 1.0, np.ones(len(torque)))
        turned = np.asarray(np.linalg.cholesky(believed.covariance + 1e-18 * np.diag(self._sizes**2)), np.float64)
        weight = (self._effects.at(before.u[np.minimum(np.arange(len(task.s)), len(task.s) - 2)], before.x) @ turned).reshape(-1, len(self._sizes))
        turned = np.asarray(turned @ np.linalg.eigh(weight.T @ weight)[1], np.float64)
        middle, half = self._box(believed.mean, turned)
        rows = task.nominal + self._effects.times(middle)

        def radius(motion: Motion) -> Floats:
            return np.maximum(*(np.abs(self._effects.at(u, motion.x) @ turned) @ half for u in sides(motion)))

        motion, doubt = before, radius(before)
        for _ in range(ROUNDS):
            room = torque * (1 - self.margin) - doubt
            if (np.abs(rows.c) >= room).any():
                break
            try:
                motion = task.optimum(rows, -room, room)
            except Infeasible:
                break
            now = radius(motion)
            inside = all((np.abs(rows.at(u, motion.x)) + now <= torque * (1 - 0.5 * self.margin)).all() for u in sides(motion))
            if inside:
                wide = torque + doubt
                self.lower_bound = max(task.optimum(rows, -wide, wide).duration, self.lower_bound or 0.0)
                return motion if motion.duration < before.duration else before
            doubt = np.maximum(doubt, now)
        return before

    def _box(self, centre: Floats, turned: Floats) -> tuple[Floats, Floats]:
        """Middle (p,) of a box around the set, in the unknown numbers, and its half widths along the columns of ``turned``."""
        back = np.linalg.inv(turned)
        width = np.abs(back) @ (WIDEST * self._sizes + np.abs(centre))
        rows = np.concatenate([part[0] for part in self._samples])
        left = np.concatenate([part[1] for part in self._samples]) - rows @ centre
        rows = rows @ turned
        size = np.linalg.norm(rows, axis=1) + 1e-12
        above, below = np.argsort((1 - left) / size)[:KEPT], np.argsort((1 + left) / size)[:KEPT]
        a, b = np.concatenate([rows[above], -rows[below]]), np.concatenate([1 - left[above], 1 + left[below]])
        unit = np.eye(len(centre))
        high = np.array([upper_end(c, a, b, width) for c in unit])
        low = -np.array([upper_end(-c, a, b, width) for c in unit])
        if (high < low - 1e-9).any():
            raise Infeasible(
                "no payload and friction explain the measured torques within the stated bound of the error: raise bound, or correct the nominal model"
            )
        return centre + turned @ (0.5 * (high + low)), np.maximum(0.5 * (high - low), 0.0)
