"""Learning with a worst-case bound: no trial after the first exceeds a limit, whatever the noise does within a bound that is stated.

As :mod:`guideway.arm.learning.structured`, but instead of a mean and a standard deviation it keeps the set of all numbers (payload, friction) that
explain every sample of every trial within ``bound``, and plans with the worst of them. Sets only shrink, so durations never rise. Slower to compute,
slower motions: a bound on noise says less than its distribution. What the structure cannot explain must fit into ``bound`` too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.dynamics import Rows
from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.polytope import upper_end
from guideway.arm.learning.regression import evidence, posterior
from guideway.arm.learning.structured import BINS, GRID, Structured, sides
from guideway.arm.learning.task import Task
from guideway.arm.learning.unknown import Unknown
from guideway.errors import BadParameter, Infeasible

Floats = NDArray[np.float64]

PLACES = 30
"""Stretches of the path; of each, the two measurements per joint and trial that bound the set most are kept: others would only make it smaller."""
ROUNDS = 16
HOPES = 3
"""Rounds of the lower bound."""
FASTER = (1.02, 1.05, 1.1, 1.2, 1.3, 1.45, 1.6, 1.8, 2.0)
"""Speeds of the motion before that are tried, should no optimum be safe."""
SLOWER = (0.995, 0.99, 0.98, 0.96, 0.94, 0.91, 0.88, 0.84, 0.8)
"""Speeds of the last optimum that are tried."""
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
        if self.bound is not None:
            self._stated()
        self._start = Structured(self.task, scale=self.scale)
        self._effects = self.task.dynamics.parameters(self.task.q, self.task.q1, self.task.q2)
        self._unknown = Unknown(self.task, curves=False)
        self._sizes = self._unknown.sizes
        self._planned, self._kinematic = self._start.next([]), self.task.optimum()
        self._trials, self._samples = [], []
        self._lag: int | None = None
        self._error: Floats | None = None

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The next motion; the last one where nothing faster is safe."""
        for log in logs[len(self._trials) :]:
            self._remember(log)
        if not self._trials:
            self.lower_bound = GRID * self._kinematic.duration
        elif self._planned is not None:
            self._planned = self._safe(self._planned)
        return self._planned

    def _stated(self) -> Floats:
        """The bound that was asked for, one per joint."""
        joints = len(self.task.torque)
        try:
            given = np.broadcast_to(np.asarray(self.bound, float), (joints,))
        except (ValueError, TypeError):
            given = np.zeros(joints)
        if not (np.isfinite(given).all() and (given > 0).all()):
            raise BadParameter(f"setting bound = {self.bound!r} is out of range: a number of N m above 0, or one for each of the {joints} joints")
        return np.asarray(given, float)

    def _remember(self, log: Log) -> None:
        joints = len(self.task.torque)
        if self._error is None:
            self._error = 6 * log.noise + 0.05 if self.bound is None else self._stated()
        found, _, self._lag = evidence(self.task, log, self._unknown, self._lag, BINS)
        self._trials.append(found)
        seen, count = log.reference, len(log.t) - self._lag
        q, q1, q2 = self.task.path.eval(seen.s[:count], 2)
        u, x, dynamics = seen.u[:count], seen.speed[:count] ** 2, self.task.dynamics
        left = log.tau[self._lag :] - dynamics.nominal(q, q1, q2).at(u, x)
        scale = np.tile(self._error, count)
        place = np.minimum((seen.s[:count] / self.task.s[-1] * PLACES).astype(int), PLACES - 1)
        groups = (place[:, None] * joints + np.arange(joints)).ravel()
        self._samples.append((dynamics.parameters(q, q1, q2).at(u, x).reshape(len(scale), -1) / scale[:, None], left.ravel() / scale, groups))

    def _safe(self, before: Motion) -> Motion:
        """The fastest motion that is safe for every member of the set, or the one before."""
        task, torque = self.task, self.task.torque
        believed = posterior(self._trials, self._unknown, 1.0, np.ones(len(torque)))
        turned = np.asarray(np.linalg.cholesky(believed.covariance + 1e-18 * np.diag(self._sizes**2)), np.float64)
        weight = (self._effects.at(before.u[np.minimum(np.arange(len(task.s)), len(task.s) - 2)], before.x) @ turned).reshape(-1, len(self._sizes))
        turned = np.asarray(turned @ np.linalg.eigh(weight.T @ weight)[1], np.float64)
        middle, half = self._box(believed.mean, turned)
        rows = task.nominal + self._effects.times(middle)
        self.lower_bound = max(self.lower_bound or 0.0, GRID * self._hopeful(rows, turned, half))

        def radius(motion: Motion) -> Floats:
            return np.maximum(*(np.abs(self._effects.at(u, motion.x) @ turned) @ half for u in sides(motion)))

        def safe(motion: Motion) -> bool:
            most = torque * (1 - 0.5 * self.margin)
            return all((np.abs(rows.at(u, motion.x)) + radius(motion) <= most).all() for u in sides(motion))

        tried = [motion for motion in self._candidates(rows, radius, before) if motion.duration < before.duration and safe(motion)]
        return min(tried, key=lambda motion: motion.duration, default=before)

    def _hopeful(self, rows: Rows, turned: Floats, half: Floats) -> float:
        """Duration of the optimum under ``|middle| <= limit + radius``, which every member of the set fulfils wherever its own torques are inside: no
        member's optimum is faster. The radius is taken at speeds and accelerations that no motion exceeds: those of the optimum of the round before,
        which is the fastest at every place."""
        task, effects = self.task, self._effects
        a, b, d, c = (np.abs(part @ turned) @ half for part in (effects.a, effects.b, effects.d, effects.c))
        motion = self._kinematic
        slowest, fastest = task.bounds(task.q1)
        for _ in range(HOPES):
            x = motion.x
            reach = (np.maximum(-slowest, fastest) + np.abs(task.q2) * x[:, None]) / np.maximum(np.abs(task.q1), 1e-9)
            wide = task.torque + a * reach.min(1)[:, None] + b * x[:, None] + d * np.sqrt(x)[:, None] + c
            found = task.optimum(rows, -wide, wide)
            motion = found if found.duration > motion.duration else motion
        return motion.duration

    def _candidates(self, rows: Rows, radius: Callable[[Motion], Floats], before: Motion) -> list[Motion]:
        """Motions that may be safe: the motion before, faster; optima with less and less torque; the last of them, slower."""
        task, torque = self.task, self.task.torque
        found = [task.slowed(before.slower(faster)) for faster in FASTER]
        motion, still = before, 1.001 * np.abs(rows.c) + 1e-3 * torque
        room = torque * (1 - self.margin) - radius(before)
        for _ in range(ROUNDS):
            try:
                motion = task.optimum(rows, -np.maximum(room, still), np.maximum(room, still), motion)
            except (Infeasible, BadParameter):
                break
            found.append(motion)
            # what this motion has too much is taken off at its place
            worst = np.maximum(*(np.abs(rows.at(u, motion.x)) for u in sides(motion))) + radius(motion)
            room = np.minimum(room, np.maximum(room, still) - np.maximum(worst - torque * (1 - self.margin), 0.0))
        return found + [motion.slower(share) for share in SLOWER]

    def _box(self, centre: Floats, turned: Floats) -> tuple[Floats, Floats]:
        """Middle (p,) of a box around the set, in the unknown numbers, and its half widths along the columns of ``turned``."""
        back = np.linalg.inv(turned)
        width = np.abs(back) @ (WIDEST * self._sizes + np.abs(centre))
        rows = np.concatenate([part[0] for part in self._samples])
        left = np.concatenate([part[1] for part in self._samples]) - rows @ centre
        rows = rows @ turned
        groups = np.concatenate([part[2] + 1000 * number for number, part in enumerate(self._samples)])
        above, below = _tightest(1 - left, groups), _tightest(1 + left, groups)
        a, b = np.concatenate([rows[above], -rows[below]]), np.concatenate([1 - left[above], 1 + left[below]])
        unit = np.eye(len(centre))
        high = np.array([upper_end(c, a, b, width) for c in unit])
        low = -np.array([upper_end(-c, a, b, width) for c in unit])
        if (high < low - 1e-9).any():
            raise Infeasible(
                "no payload and friction explain the measured torques within the stated bound of the error: raise bound, or correct the nominal model"
            )
        return centre + turned @ (0.5 * (high + low)), np.maximum(0.5 * (high - low), 0.0)


def _tightest(slack: Floats, groups: NDArray[np.intp]) -> NDArray[np.intp]:
    """Index of the smallest slack in each group."""
    order = np.lexsort((slack, groups))
    first = np.ones(len(order), bool)
    first[1:] = groups[order[1:]] != groups[order[:-1]]
    return order[first]
