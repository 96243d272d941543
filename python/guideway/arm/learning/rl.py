"""Reinforcement learning without a model: tabular Q(lambda) over segments of the path and bins of speed. Shown for the number of trials it takes.

Source: [watkins1989] (Q-learning; traces are cut where the choice was not the best one).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.task import Task

Floats = NDArray[np.float64]

ACTIONS = (-1, 0, 1)


@dataclass
class Tabular:
    """``segments`` of the path, ``bins`` of squared speed as shares of the kinematic optimum's; a choice moves one bin down, none, or up. Reward of a
    segment: minus its time, minus 100 where a limit was broken in it. Rates: ``alpha`` of learning, ``trace`` (lambda), ``explore`` (chance of a
    random choice, halved every ``trials`` / 6 trials)."""

    task: Task
    segments: int = 40
    bins: int = 20
    alpha: float = 0.3
    trace: float = 0.8
    explore: float = 0.3
    trials: int = 2000
    margin: float = 0.03
    seed: int = 0

    def __post_init__(self) -> None:
        self._random = np.random.default_rng(self.seed)
        self.table = np.zeros((self.segments, self.bins, len(ACTIONS)))
        self._kinematic = self.task.optimum()
        per = max(1, len(self.task.s) // self.segments)
        self._fine = np.linspace(0.0, self.task.s[-1], per * self.segments + 1)
        self._optimum = self._kinematic.squared(self._fine)
        self._steps: list[tuple[int, int, bool]] = []
        self._learned = 0

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """Learns from the last trial and chooses anew; the very last motion is chosen without exploring."""
        for log in logs[self._learned :]:
            self._learned += 1
            self._learn(log)
        if self._learned >= self.trials:
            return None
        explore = self.explore * 0.5 ** (6 * self._learned / self.trials) if self._learned < self.trials - 1 else 0.0
        return self._choose(explore)

    def accepts(self, log: Log) -> bool:
        """Was no torque beyond its limit less the margin?"""
        return not (log.stopped or log.over(self.task.torque, self.margin).any())

    def _choose(self, explore: float) -> Motion:
        level, self._steps = self.bins // 4, []
        levels = [level]
        for segment in range(self.segments):
            values = self.table[segment, level]
            best = int(self._random.choice(np.flatnonzero(values >= values.max() - 1e-12)))
            action = int(self._random.integers(len(ACTIONS))) if self._random.random() < explore else best
            self._steps.append((level, action, action == best))
            level = min(max(level + ACTIONS[action], 0), self.bins - 1)
            levels.append(level)
        share = (np.array(levels) + 1) / self.bins
        nodes = np.linspace(0.0, self.task.s[-1], self.segments + 1)
        return self.task.slowed(Motion(self.task.path, self._fine, self._optimum * np.interp(self._fine, nodes, share)))

    def _learn(self, log: Log) -> None:
        """One sweep backwards with eligibility: the return of each segment mixes what followed with what the table expected."""
        over = log.over(self.task.torque, self.margin).any(1)
        width = self.task.s[-1] / self.segments
        place = np.minimum((log.reference.s / width).astype(int), self.segments - 1)
        times = np.interp(np.arange(self.segments + 1) * width, log.motion.s, log.motion.times)
        broken = np.bincount(place, weights=over, minlength=self.segments) > 0
        if log.stopped:
            broken[place[-1] :] = True
        after = 0.0
        for segment in range(self.segments - 1, -1, -1):
            level, action, best = self._steps[segment]
            gain = times[segment] - times[segment + 1] - 100.0 * broken[segment]
            found = gain + after
            self.table[segment, level, action] += self.alpha * (found - self.table[segment, level, action])
            expected = float(self.table[segment, level].max())
            after = self.trace * found + (1 - self.trace) * expected if best else expected
