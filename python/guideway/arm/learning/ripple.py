"""The ripple of gears in what is left over of measured torques: waves over the joint's angle that are as large as its torque is.

A harmonic drive comes and goes twice in a turn of its fast side. How many turns that are is a matter of the gear, so it is looked for: in the
spectrum of residual times torque over the joint's angle, all trials added up with their phases, all joints together first (arms often have one
ratio throughout).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CELL = 0.002
"""Cells of the joint's angle, rad."""
CELLS = 8192
LOWEST, HIGHEST = 20.0, 600.0
"""Waves in a turn that are looked for."""
WITHIN = 6.0
"""Waves that a joint must have passed on its path for its ripple to be told from anything else."""
CERTAIN = 60.0
"""What a peak must exceed, all joints together; a joint alone: ``ALONE``. Noise alone has 2 per joint on average, and exceeds these once in 1e8."""
ALONE = 45.0
SAME = 0.005
"""Waves that differ by less than this share are the same."""


@dataclass
class Spectrum:
    """Of what every trial left over, added up. ``cycles`` (joints,) waves in 2 pi rad of each joint's angle, 0 where no ripple was found."""

    joints: int
    cycles: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.cycles = np.zeros(self.joints)
        self.waves = 2 * np.pi * np.fft.rfftfreq(CELLS, CELL)
        self._sum = np.zeros((self.joints, len(self.waves)), complex)
        self._size = np.full(self.joints, 1e-300)
        self._range = np.tile([np.inf, -np.inf], (self.joints, 1))

    def add(self, q: Floats, tau: Floats, left: Floats, sigma: Floats) -> bool:
        """Takes in a trial: angles, torques and what is left over of them without any ripple taken off (n, joints), noise (joints,). Does another
        ripple stand out now than before?"""
        for joint in range(self.joints):
            cell = np.round(q[:, joint] / CELL).astype(int) % CELLS
            weighted = np.bincount(cell, weights=left[:, joint] * tau[:, joint], minlength=CELLS)
            self._sum[joint] += np.fft.rfft(weighted) / sigma[joint] ** 2
            self._size[joint] += 0.5 * (tau[:, joint] ** 2).sum() / sigma[joint] ** 2
            low, high = self._range[joint]
            self._range[joint] = min(low, q[:, joint].min()), max(high, q[:, joint].max())
        found = self._peaks()
        new = (found > 0) & (np.abs(found - self.cycles) > SAME * found)
        self.cycles = np.where(new, found, self.cycles)
        return bool(new.any())

    def _peaks(self) -> Floats:
        span = (self._range[:, 1] - self._range[:, 0])[:, None]
        allowed = (self.waves >= LOWEST) & (self.waves <= HIGHEST) & (self.waves * span >= 2 * np.pi * WITHIN)
        power = np.where(allowed, np.abs(self._sum) ** 2 / self._size[:, None], 0.0)
        common = int(np.argmax(power.sum(0)))
        found = np.zeros(self.joints)
        if power[:, common].sum() > CERTAIN:
            found = np.where(allowed[:, common], self.waves[common], 0.0)
        for joint in range(self.joints):
            own = int(np.argmax(power[joint]))
            if power[joint, own] > max(ALONE, 1.5 * power[joint, common]):
                found[joint] = self.waves[own]
        return found
