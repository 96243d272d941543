"""Velocity self-learning as its source has it: lower the nodes of a speed spline where the measured torque was over its limit, trial by trial.

Source: [nan2025], sections 3.1 to 3.3.

| symbol | field |
|---|---|
| c | ``segments`` |
| d, delta | ``step``, share of the kinematic optimum's largest speed |
| lambda | ``fine``, the same for the interpolation limiting |
| Z_max | ``trials`` |

Departures: loop conditions, indices and limits are read as the text means them (table 1 loops while the speed is *inside* its limits; equations 20
and 21 share one index). Violations are judged on filtered torques, three samples in a row, with a ``margin``: otherwise one noisy sample goes on for
ever. Where a segment still violates at the lowest node speeds, standing still is too much: that is reported, not lowered for ever.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.between import Grid
from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.spline import FLOOR, SpeedSpline
from guideway.arm.learning.task import Task
from guideway.arm.rows import tip_derivatives
from guideway.errors import Infeasible

Floats = NDArray[np.float64]

PER_SEGMENT = 40
"""Grid intervals of a segment of the spline, at the least."""


@dataclass
class Source:
    """Learns ``task`` by lowering node speeds. Ends with success, a static overload, or after ``trials``."""

    task: Task
    segments: int = 40
    step: float = 0.03
    fine: float = 0.01
    margin: float = 0.03
    trials: int = 40
    reading: str = "corrected"
    success: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        task, self.kinematic = self.task, self.task.optimum()
        per = max(PER_SEGMENT, -(-len(task.s) // self.segments))
        self.s = np.linspace(0.0, task.s[-1], per * self.segments + 1)
        _, self.q1, self.q2 = task.path.eval(self.s, 2)
        limits = task.limits
        asked = limits.tip_speed is not None or limits.tip_acceleration is not None
        self._tip = tip_derivatives(task.arm, task.path, self.s) if asked else None
        self._bounds = Grid(task, self.s).bounds
        self.spline = SpeedSpline(task.s[-1], self.segments, self.s, self.reading)
        self.fastest = np.sqrt(self.kinematic.squared(np.linspace(0.0, task.s[-1], self.segments + 1)))
        self.size = float(np.sqrt(self.kinematic.x.max()))
        self.nodes = self.limited(self.fastest.copy())
        self._judged = 0

    def next(self, logs: Sequence[Log]) -> Motion | None:
        """The motion to try next; None where learning has ended."""
        for log in logs[self._judged :]:
            self._judged += 1
            over = self.violated(log)
            if not over.any():
                self.success = not log.stopped
            if self.success or self._judged >= self.trials:
                return None
            self.nodes = self.corrected(self.nodes, over, log)
        return self.motion(self.nodes)

    def accepts(self, log: Log) -> bool:
        """Was no torque beyond its limit less the margin?"""
        return not (log.stopped or log.over(self.task.torque, self.margin).any())

    def motion(self, nodes: Floats) -> Motion:
        """The motion of node speeds; slower by what limits are exceeded between the places that are looked at."""
        x = self.spline.squared(nodes)
        if self.reading == "corrected":
            x[[0, -1]] = 0.0
        return self.task.slowed(Motion(self.task.path, self.s, x))

    def violated(self, log: Log) -> NDArray[np.bool_]:
        """Segments (c,) with a torque over its limit."""
        over = np.asarray(log.over(self.task.torque, self.margin).any(1))
        if log.stopped:
            over[-1] = True  # whatever ended the trial, it was here
        found = np.zeros(self.segments, bool)
        width = self.task.s[-1] / self.segments
        found[np.minimum((log.reference.s[over] / width).astype(int), self.segments - 1)] = True
        return found

    def corrected(self, nodes: Floats, over: NDArray[np.bool_], log: Log) -> Floats:
        """Node speeds after the torque step and the acceleration step."""
        lowest = FLOOR
        stuck = [i for i in np.flatnonzero(over) if max(nodes[i], nodes[i + 1]) <= lowest]
        if stuck:
            self._static(int(stuck[0]), log)
        nodes = self._lowered(nodes, over, self.step * self.size, lowest)  # (20)
        while (bad := self.too_hard(nodes)).any():
            lower = self._lowered(nodes, bad, self.step * self.size, lowest)  # (21)
            if (lower == nodes).all():
                break
            nodes = lower
        return nodes

    def limited(self, nodes: Floats) -> Floats:
        """Interpolation limiting (table 1): nodes are lowered until speeds and accelerations hold. No separate look at the kinematic optimum is
        needed: it is the largest of all speeds that keep these limits, at every place."""
        nodes[[0, -1]] = 0.0
        while (bad := self.too_hard(nodes)).any():
            lower = self._lowered(nodes, bad, self.fine * self.size, 0.0)
            if (lower == nodes).all():
                break
            nodes = lower
        return nodes

    def too_hard(self, nodes: Floats) -> NDArray[np.bool_]:
        """Segments (c,) in which a speed or an acceleration, of a joint or of the tip, is exceeded."""
        task, x = self.task, self.spline.squared(nodes)
        u = np.diff(x) / (2 * np.diff(self.s))
        low, high = self._bounds
        bad = np.zeros(len(u), bool)
        for end in (slice(None, -1), slice(1, None)):
            acceleration = self.q1[end] * u[:, None] + self.q2[end] * x[end][:, None]
            bad |= ((acceleration > high[end] * (1 + 1e-9)) | (acceleration < low[end] * (1 + 1e-9))).any(1)
            bad |= (np.abs(self.q1[end]) * np.sqrt(x[end])[:, None] > task.speed).any(1) | self._tip_too_hard(u, x[end], end)
        return bad.reshape(self.segments, -1).any(1)

    def _tip_too_hard(self, u: Floats, x: Floats, end: slice) -> NDArray[np.bool_]:
        """Intervals (n - 1,) at one end of which the tip is too fast or accelerates too hard."""
        if self._tip is None:
            return np.zeros(len(u), bool)
        fast, hard = self.task.limits.tip_speed, self.task.limits.tip_acceleration
        one, two = (part[end] for part in self._tip)
        speed = np.linalg.norm(one, axis=1) * np.sqrt(x)
        acceleration = np.linalg.norm(one * u[:, None] + two * x[:, None], axis=1)
        return np.asarray((speed > (fast or np.inf) * (1 + 1e-9)) | (acceleration > (hard or np.inf) * (1 + 1e-9)))

    def _lowered(self, nodes: Floats, bad: NDArray[np.bool_], step: float, lowest: float) -> Floats:
        """The larger node of every bad segment lowered, from the end of the path backwards."""
        nodes = nodes.copy()
        for i in np.flatnonzero(bad)[::-1] + 1:
            at = i if nodes[i] >= nodes[i - 1] else i - 1
            nodes[at] = max(nodes[at] - step, min(lowest, nodes[at]))
        nodes[[0, -1]] = 0.0
        return nodes

    def _static(self, segment: int, log: Log) -> None:
        over = log.over(self.task.torque, self.margin)
        where = np.floor(log.reference.s / self.task.s[-1] * self.segments).astype(int) == segment
        joint = int(np.argmax((np.abs(log.filtered) / self.task.torque * over)[where].max(0))) if (where & over.any(1)).any() else 0
        place, limit = segment / self.segments * self.task.s[-1], self.task.torque[joint]
        raise Infeasible(
            f"static overload: {self.task.arm.names[joint]} is over its limit of {limit:g} N m in segment {segment + 1} of {self.segments} "
            f"(s = {place:.3f} rad) though the path is passed at the lowest speed: a slower motion does not help"
        )
