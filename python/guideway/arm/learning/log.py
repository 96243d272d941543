"""What a trial leaves behind: the motion that was asked for, measured joint angles and measured torques."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.motion import Motion, Sampled

Floats = NDArray[np.float64]

WINDOW = 7
"""Samples of the centred moving average that violations are judged on."""
SIGMAS = 4.0
IN_A_ROW = 3
"""Filtered samples in a row that make a violation."""
LONGER = (15, 31, 61)
"""Samples of the longer averages, in which noise hides less."""


@dataclass(frozen=True)
class Log:
    """A measured trial: instants ``t`` (s, (n,)), joint angles ``q`` (rad, (n, joints)) and joint torques ``tau`` (N m, (n, joints)) as measured,
    and the ``motion`` that was asked for. ``stopped``: the trial was ended before the end of the path."""

    motion: Motion
    t: Floats
    q: Floats
    tau: Floats
    stopped: bool = False
    seen: Sampled | None = None

    @cached_property
    def reference(self) -> Sampled:
        """The motion along the path at the instants of the log: as it was asked for, or ``seen`` where only measured angles tell."""
        return self.motion.sample(times=self.t) if self.seen is None else self.seen

    @cached_property
    def filtered(self) -> Floats:
        """Torques after the centred moving average, (n, joints); shorter windows at the ends."""
        return smooth(self.tau, WINDOW)

    @cached_property
    def noise(self) -> Floats:
        """Standard deviation (joints,) of a torque sample's noise, N m, from the median size of its steps: motion changes little between samples."""
        steps = np.diff(self.tau, axis=0)
        return 1.4826 * np.median(np.abs(steps - np.median(steps, 0)), 0) / np.sqrt(2)

    def over(self, limit: Floats, margin: float = 0.0) -> NDArray[np.bool_]:
        """Where a joint's filtered torque is beyond ``limit * (1 - margin)`` for at least three samples in a row, (n, joints)."""
        return self._beyond(limit * (1 - margin))

    def violations(self, limit: Floats) -> NDArray[np.bool_]:
        """Where it is beyond the limit by more than its noise explains: four standard deviations of the filtered signal, three samples in a row."""
        return self._beyond(limit + SIGMAS * self.noise / np.sqrt(WINDOW))

    def excess(self, limit: Floats) -> float:
        """By how much longer averages of a joint's torque are beyond its limit, less four standard deviations of theirs: largest share of the
        limit, not above 0 where noise may be all there is."""
        worst = -1.0
        for window in LONGER:
            inner = np.abs(smooth(self.tau, window))[window // 2 : len(self.tau) - window // 2]
            if len(inner):
                worst = max(worst, float(((inner - SIGMAS * self.noise / np.sqrt(window)) / limit).max() - 1))
        return worst

    def _beyond(self, limit: Floats) -> NDArray[np.bool_]:
        beyond = np.abs(self.filtered) > limit
        return np.stack([_runs(column, IN_A_ROW) for column in beyond.T], 1)


def smooth(values: Floats, window: int) -> Floats:
    """Centred moving average over the first axis; near the ends the window is the part of it that is inside."""
    half = window // 2
    total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, 0)])
    k = np.arange(len(values))
    low, high = np.maximum(k - half, 0), np.minimum(k + half + 1, len(values))
    return (total[high] - total[low]) / (high - low).reshape(-1, *(1,) * (values.ndim - 1))


def _runs(flags: NDArray[np.bool_], least: int) -> NDArray[np.bool_]:
    """The flags that stand in runs of at least ``least``."""
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    kept = np.zeros_like(flags)
    for start, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        kept[start:end] = end - start >= least
    return kept
