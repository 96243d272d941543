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
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.dynamics import Rows
from guideway.arm.learning.expected import Expected
from guideway.arm.learning.log import WINDOW, Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.regression import Evidence, Posterior, Samples, evidence, posterior, predicted
from guideway.arm.learning.residual import Residual, amplitude, condition
from guideway.arm.learning.ripple import Spectrum
from guideway.arm.learning.task import Task
from guideway.arm.learning.unknown import WAVES, Along, Unknown
from guideway.errors import Infeasible

Floats = NDArray[np.float64]

BINS = 300
LENGTH = 8.0
"""Of the residual: bins of the path, and its correlation length in bins."""
HOPES = 2
"""Rounds of the lower bound."""
GRID = 0.998
"""Of an optimum on the grid: what is certainly less than the optimum between its points."""
ALIKE = 0.3
"""Torques that differ by this share of the limit say nothing about each other's residual."""
LEAST = 0.25
"""Share of the torque beside holding and rubbing that is planned with whatever the doubt: where even standing still may be too much, creeping does
not help."""
TRIED = 0.2
"""Share of the margin that is kept where a trial was run under the very conditions that are planned."""
WARMING = 0.01
"""Share by which friction may change from trial to trial, standard deviation."""
REMEMBERED = 3
"""Trials that a motion is compared with, the newest ones."""
ENOUGH = 2
"""Samples in a bin, at the least, that make a trial worth comparing with there."""
FADES = 0.6
"""What was felt beyond a limit is taken back by that share of what a later trial leaves unused there."""
LOUD = 2.0
"""Standard deviations of filtered noise by which the largest of a few dozen samples stands out."""
ASIDE = 3
"""Bins either side of a violation that share in it."""
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
        self._place = np.minimum((self.task.s / self.task.s[-1] * BINS).astype(int), BINS - 1)
        self._felt = np.zeros((2, BINS, len(self.task.torque)))
        self._lag: int | None = None
        self._spectrum = Spectrum(len(self.task.torque))
        self._along = Along(self.task, Unknown(self.task))
        self._kinematic = self.task.optimum()
        self._planned = self._first()

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The motion to try next, given the logs of all trials so far; None where there is nothing left to learn."""
        while len(self._trials) < len(logs):
            self._remember(logs[: len(self._trials) + 1])
        if not self._trials:
            self.lower_bound = GRID * self._kinematic.duration
            return self._planned
        self._plan()
        clean = not logs[-1].stopped and not logs[-1].violations(self.task.torque).any()
        if self.until and clean and self._planned.duration <= self.until * (self.lower_bound or 0.0):
            return None
        return self._planned

    def _remember(self, logs: Sequence[Log]) -> None:
        """Takes in the last of the logs; all of them again where it shows a ripple that was not known."""
        found, samples, self._lag = self._evidence(logs[-1])
        self._trials.append(found)
        if self._spectrum.add(samples.q, samples.tau, self._unrippled(samples), found.sigma):
            self._along = Along(self.task, Unknown(self.task, cycles=self._spectrum.cycles))
            self._trials = [self._evidence(log)[0] for log in logs[:-1]]
            found, samples, _ = self._evidence(logs[-1])
            self._trials.append(found)
        if logs[-1].motion.expected is not None or len(logs) > 1:
            self._feel(logs[-1])

    def _feel(self, log: Log) -> None:
        """Where torques were beyond their limits and the numbers do not say why (a controller that overshoots as a joint breaks loose), as much is
        kept away from the limits for the next trials."""
        torque = self.task.torque
        explained = Expected(self._along, self._belief()[0].before(1))(log.reference)
        lag, count = self._lag or 0, len(log.t) - (self._lag or 0)
        over, seen, explained = log.violations(torque)[lag:], log.filtered[lag:], explained[:count]
        place = np.minimum((log.reference.s[:count] / self.task.s[-1] * BINS).astype(int), BINS - 1)
        loud = LOUD * log.noise / np.sqrt(WINDOW)
        for side, sign in enumerate((-1.0, 1.0)):
            excess, peak = np.zeros(self._felt.shape[1:]), np.zeros(self._felt.shape[1:])
            np.maximum.at(excess, place, np.where(over, np.maximum(sign * seen - np.maximum(sign * explained, torque), 0.0), 0.0))
            np.maximum.at(peak, place, sign * seen)
            spare = np.maximum(torque * (1 - self.margin) - (_nearby(peak) - loud), 0.0)
            self._felt[side] = np.maximum(self._felt[side] - FADES * spare, 0.0) + _nearby(excess)

    def _evidence(self, log: Log) -> tuple[Evidence, Samples, int]:
        return evidence(self.task, log, self._along.unknown, self._lag, BINS)

    def _unrippled(self, samples: Samples) -> Floats:
        """What the numbers leave over of a trial, the ripple left in it."""
        unknown = self._along.unknown
        numbers = self._belief()[0].mean.copy()
        if unknown.cycles.any():
            numbers[-WAVES * unknown.joints :] = 0.0
        return samples.following * (samples.left - predicted(unknown, samples.effects, numbers))

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
        task = self.task
        belief, size = self._belief()
        self._holds(belief)
        motion = self._planned
        model = self._predicted(belief, size, motion)
        for step in range(ROUNDS):
            low, high = self._room(model)
            motion = task.optimum(model.rows, low, high, motion)
            if step < ROUNDS - 1:
                now = self._predicted(belief, size, motion)
                model = now if step < ROUNDS - 2 else now.wider(model)
        self.lower_bound = GRID * max(self._kinematic.duration, min(self._fastest(belief, size, model, motion), motion.duration))
        self._planned = replace(motion, expected=Expected(self._along, belief.mean))

    def _fastest(self, belief: Posterior, size: Floats, model: Model, motion: Motion) -> float:
        """Duration of the optimum of the optimistic model: limits widened by as much as the margin draws them in. Friction at low speed depends on
        the motion, so the optimum is found again under what it is along the first one; the shorter one counts."""
        found = motion
        durations = []
        for _ in range(HOPES):
            low, high = self._room(model)
            wide = self.task.torque + self.sigmas * model.spread
            found = self.task.optimum(model.rows, np.minimum(-wide - model.below, low), np.maximum(wide + model.above, high), found)
            durations.append(found.duration)
            model = self._predicted(belief, size, found)
        return min(durations)

    def _holds(self, belief: Posterior) -> None:
        """Raises where even creeping takes more torque than there is, beyond doubt."""
        task, along = self.task, self._along
        still = np.zeros(len(task.s))
        rows, need = along.creeping(belief.mean)
        doubt = self.sigmas * belief.spread(along.effects(still, still, rows.c))
        over = need - doubt - task.torque
        if over.max() > 0:
            place, joint = np.unravel_index(int(np.argmax(over)), over.shape)
            raise Infeasible(
                f"static overload: the trials show that {task.arm.names[joint]} needs {need[place, joint]:.2f} N m to hold and rub "
                f"at s = {task.s[place]:.4f} rad of the path, limit {task.torque[joint]:g} N m. A slower motion does not help: "
                "less payload, or another path"
            )

    def _belief(self) -> tuple[Posterior, Floats]:
        """The unknown numbers, and the size (bins, joints) of what they leave over: the more is left over, the less a sample says about them."""
        newest, unknown = self._trials[-1], self._along.unknown
        belief = posterior(self._trials, unknown, self.forget, np.ones(unknown.joints), WARMING)
        size = np.median(amplitude(self._trials, belief), 0)
        inflation = 1 + newest.samples / BINS * LENGTH * size**2 / newest.sigma**2
        belief = posterior(self._trials, unknown, self.forget, inflation, WARMING)
        return belief, np.maximum(amplitude(self._trials, belief), 1e-4 * self.task.torque)

    def _residual(self, belief: Posterior, size: Floats, rows: Rows, motion: Motion) -> tuple[Residual, Floats]:
        """The process, as far as past trials ran under the conditions that ``motion`` would run under, and the share (bins, joints) of those
        conditions that the trial that is most alike says nothing about."""
        task = self.task
        centre = (np.arange(BINS) + 0.5) / BINS * task.s[-1]
        nearest = np.clip(np.searchsorted(task.s, centre), 0, len(task.s) - 2)
        rows = Rows(*(part[nearest] for part in (rows.a, rows.b, rows.d, rows.c)))
        wanted = rows.at(motion.u[nearest], motion.squared(centre))
        age = []
        for back, trial in enumerate(reversed(self._trials)):
            other = (wanted - rows.at(trial.u, trial.x)) / (ALIKE * task.torque)
            age.append(np.minimum(other**2 + (1 - self.forget**back), 1e3))
        new = np.min([np.where(trial.counts > 0, np.minimum(old, 1.0), 1.0) for trial, old in zip(reversed(self._trials), age, strict=True)], 0)
        return condition(self._trials, belief, size, age[::-1], LENGTH), new

    def _predicted(self, belief: Posterior, size: Floats, motion: Motion) -> Model:
        """What the torque of ``motion`` will be, residual and all."""
        along = self._along
        rows, below, above = along.rows(belief.mean, motion.x)
        share = self.task.s / self.task.s[-1]
        residual, new = self._residual(belief, size, rows, motion)
        mean, own = residual.on(share)
        margin = self.margin * (TRIED + (1 - TRIED) * _nearby(new)[self._place])
        effects = [along.effects(u, motion.x, rows.at(u, motion.x)) for u in sides(motion)]
        both = [self._doubt(belief, part) for part in effects]
        wander = belief.unsure * predicted(along.unknown, effects[0], belief.rubbing)
        spread = np.sqrt(np.maximum(*both) ** 2 + own**2 + wander**2)
        below, above = below + self._felt[0][self._place], above + self._felt[1][self._place]
        return Model(Rows(rows.a, rows.b, rows.d, rows.c + mean), spread, below, above, margin)

    def _doubt(self, belief: Posterior, effects: Floats) -> Floats:
        """Standard deviation (n, joints) of a torque because the numbers are uncertain: of all of it, or of what is different from a trial where
        it was measured, whichever is less."""
        place, doubt = self._place, belief.spread(effects)
        for trial in self._trials[-REMEMBERED:]:
            there = trial.counts[place] >= ENOUGH
            doubt = np.where(there, np.minimum(doubt, belief.spread(effects - trial.effects[place])), doubt)
        return doubt

    def _room(self, model: Model) -> tuple[Floats, Floats]:
        """How much torque may be planned with, lowest and highest; always a little more than holding and rubbing take, or nothing could be
        planned."""
        torque, c = self.task.torque, model.rows.c
        room = torque * (1 - model.margin)
        least = np.abs(c) + np.maximum(LEAST * (room - np.abs(c)), 1e-3 * torque)
        room = room - self.sigmas * model.spread
        return -np.maximum(room - model.below, least), np.maximum(room - model.above, least)


@dataclass(frozen=True)
class Model:
    """What is predicted of a motion's torques: ``rows``, their standard deviation ``spread``, and how far friction may be ``below`` and ``above``
    them between grid points, all (n, joints), N m; and the ``margin`` that is kept beside them, share of the limit."""

    rows: Rows
    spread: Floats
    below: Floats
    above: Floats
    margin: Floats

    def wider(self, other: Model) -> Model:
        """With the larger ones of both spreads, ranges and margins."""
        parts = ((self.spread, other.spread), (self.below, other.below), (self.above, other.above), (self.margin, other.margin))
        return Model(self.rows, *(np.maximum(*pair) for pair in parts))


def _nearby(values: Floats) -> Floats:
    """The largest ones of the bins around (B, joints)."""
    padded = np.pad(values, ((ASIDE, ASIDE), (0, 0)), mode="edge")
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, 2 * ASIDE + 1, 0).max(-1))


def sides(motion: Motion) -> tuple[Floats, Floats]:
    """Path accelerations at the grid's points: of the interval before, and of the one after."""
    return np.concatenate([motion.u[:1], motion.u]), np.concatenate([motion.u, motion.u[-1:]])
