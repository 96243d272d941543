"""The default learner: what the arm carries and how it rubs is learned from measured torques, the motion is the exact optimum of what was learned.

The nominal model plus ten numbers of the payload and four of friction for each joint explain the torque anywhere on the path; they are estimated by
Bayesian least squares over all samples of all trials. What they leave over is learned as a Gaussian process over the path. Every motion keeps a
distance from the torque limits of so many standard deviations of the prediction, and a fixed margin; as the prediction gets sharper, motions get
faster.

Departures: [steinhauser2018] corrects the model by a function of the path alone; here corrections scale with speed and acceleration, so they stay
right for a motion that was never run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.dynamics import Rows
from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.regression import Evidence, Posterior, evidence, posterior, prior
from guideway.arm.learning.residual import Residual, amplitude, condition
from guideway.arm.learning.task import Task
from guideway.errors import Infeasible

Floats = NDArray[np.float64]

BINS = 300
LENGTH = 8.0
"""Of the residual: bins of the path, and its correlation length in bins."""
ALIKE = 0.3
"""Torques that differ by this share of the limit say nothing about each other's residual."""
ROUNDS = 4
"""Of planning: the margin depends on the motion, the motion on the margin."""


@dataclass
class Structured:
    """Learns ``task``. ``scale``: speed of the first trial, share of the kinematic optimum's. ``sigmas``: distance from the limits in standard
    deviations of the prediction; ``margin``: what is kept beside it, share of the limit. ``forget``: weight of a trial against the next one.
    ``until``: done where the motion is within this factor of the lower bound and the last trial broke no limit (None: never)."""

    task: Task
    scale: float = 0.4
    sigmas: float = 3.0
    margin: float = 0.005
    forget: float = 0.95
    until: float | None = None
    lower_bound: float | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self._trials: list[Evidence] = []
        self._lag: int | None = None
        self._sizes = prior(self.task)
        self.effects = self.task.dynamics.parameters(self.task.q, self.task.q1, self.task.q2)
        self._kinematic = self.task.optimum()
        self._planned = self._first()

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The motion to try next, given the logs of all trials so far; None where there is nothing left to learn."""
        new = logs[len(self._trials) :]
        for log in new:
            found, self._lag = evidence(self.task, log, self._lag, BINS)
            self._trials.append(found)
        if not self._trials:
            self.lower_bound = self._kinematic.duration
            return self._planned
        self._plan()
        clean = not logs[-1].stopped and not logs[-1].violations(self.task.torque).any()
        if self.until and clean and self._planned.duration <= self.until * (self.lower_bound or 0.0):
            return None
        return self._planned

    def _first(self) -> Motion:
        """The kinematic optimum at ``scale`` of its speed, slower where even the nominal arm would need more than 0.9 of a limit."""
        task, motion = self.task, self._kinematic.slower(self.scale)
        still = float(np.abs(task.nominal.c / task.torque).max())
        for _ in range(20):
            most = max(float(np.abs(task.nominal.at(u, motion.x) / task.torque).max()) for u in sides(motion))
            if most <= max(0.9, still + 0.01):
                break
            motion = motion.slower(0.8)
        return motion

    def _plan(self) -> None:
        """A new motion and a new lower bound from everything that was seen."""
        task, torque = self.task, self.task.torque
        belief, size = self._belief()
        structure = task.nominal + self.effects.times(belief.mean)
        motion = self._planned
        rows, spread = self._predicted(belief, size, structure, motion)
        for step in range(ROUNDS):
            room = self._room(rows, spread)
            motion = task.optimum(rows, -room, room, motion)
            if step < ROUNDS - 1:
                rows, now = self._predicted(belief, size, structure, motion)
                spread = now if step < ROUNDS - 2 else np.maximum(now, spread)
        wide = np.maximum(torque + self.sigmas * spread, self._room(rows, spread))
        fastest = task.optimum(rows, -wide, wide, motion)
        self.lower_bound = max(self._kinematic.duration, min(fastest.duration, motion.duration))
        self._planned = motion

    def _belief(self) -> tuple[Posterior, Floats]:
        """The unknown numbers, and the size (joints,) of what they leave over: the more is left over, the less a sample says about them."""
        newest = self._trials[-1]
        belief = posterior(self._trials, self._sizes, self.forget, np.ones(len(self.task.torque)))
        size = amplitude(self._trials, belief.mean)
        inflation = 1 + newest.samples / BINS * LENGTH * size**2 / newest.sigma**2
        belief = posterior(self._trials, self._sizes, self.forget, inflation)
        return belief, np.maximum(amplitude(self._trials, belief.mean), 1e-4 * self.task.torque)

    def _residual(self, belief: Posterior, size: Floats, structure: Rows, motion: Motion) -> Residual:
        """The process, as far as past trials ran under the conditions that ``motion`` would run under."""
        task = self.task
        centre = (np.arange(BINS) + 0.5) / BINS * task.s[-1]
        nearest = np.clip(np.searchsorted(task.s, centre), 0, len(task.s) - 2)
        rows = Rows(*(part[nearest] for part in (structure.a, structure.b, structure.d, structure.c)))
        wanted = rows.at(motion.u[nearest], motion.squared(centre))
        age = []
        for back, trial in enumerate(reversed(self._trials)):
            other = (wanted - rows.at(trial.u, trial.x)) / (ALIKE * task.torque)
            age.append(np.minimum(other**2 + (1 - self.forget**back), 1e3))
        return condition(self._trials, belief.mean, size, age[::-1], LENGTH)

    def _predicted(self, belief: Posterior, size: Floats, structure: Rows, motion: Motion) -> tuple[Rows, Floats]:
        """Rows with the residual for conditions as in ``motion``, and the standard deviation of the torque they predict for it: the larger one of
        both sides of each grid point."""
        mean, own = self._residual(belief, size, structure, motion).on(self.task.s / self.task.s[-1])
        both = [belief.spread(self.effects.at(u, motion.x)) for u in sides(motion)]
        return Rows(structure.a, structure.b, structure.d, structure.c + mean), np.sqrt(np.maximum(*both) ** 2 + own**2)

    def _room(self, rows: Rows, spread: Floats) -> Floats:
        """How much torque may be planned with; never less than standing still takes, or nothing could be planned."""
        torque = self.task.torque
        still = np.abs(rows.c)
        if (still > torque + self.sigmas * spread).any():
            place, joint = np.unravel_index(int(np.argmax(still - torque)), still.shape)
            raise Infeasible(
                f"static overload: the trials show that {self.task.arm.names[joint]} needs {still[place, joint]:.2f} N m to hold and rub "
                f"at s = {self.task.s[place]:.4f} rad of the path, limit {torque[joint]:g} N m. A slower motion does not help: "
                "less payload, or another path"
            )
        return np.maximum(torque * (1 - self.margin) - self.sigmas * spread, 1.001 * still + 1e-3 * torque)


def sides(motion: Motion) -> tuple[Floats, Floats]:
    """Path accelerations at the grid's points: of the interval before, and of the one after."""
    return np.concatenate([motion.u[:1], motion.u]), np.concatenate([motion.u, motion.u[-1:]])
