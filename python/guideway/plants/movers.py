"""Where moving obstacles are, by the clock of a run."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from typing import Any


def position(mover: Mapping[str, Any], t: float) -> tuple[float, float]:
    """Where a mover of ``World.movers`` is at time ``t`` (s), m; whether it has appeared does not matter to its motion."""
    track, period, repeat = mover["track"], mover["track"][-1][0], mover["loop"]
    tau = t + mover.get("phase", 0.0)
    if len(track) == 1 or period <= 0:
        return track[0][1], track[0][2]
    if repeat == "once":
        tau = min(max(tau, 0.0), period)
    elif repeat == "cycle":
        tau %= period
    else:
        tau %= 2 * period
        tau = min(tau, 2 * period - tau)
    after = min(max(bisect_right(track, tau, key=lambda row: row[0]), 1), len(track) - 1)
    (t0, x0, y0), (t1, x1, y1) = track[after - 1], track[after]
    share = (tau - t0) / (t1 - t0)
    return x0 + share * (x1 - x0), y0 + share * (y1 - y0)


class Stage:
    """Which movers have appeared: each by its own trigger, then for good."""

    def __init__(self, movers: Sequence[Mapping[str, Any]]) -> None:
        self.movers = movers
        self.present = [not mover.get("appears") for mover in movers]

    def trigger(self, t: float, x: float, y: float) -> None:
        """Fires the triggers for a robot at ``x``, ``y`` at time ``t``."""
        for number, mover in enumerate(self.movers):
            if not self.present[number]:
                appears = mover["appears"]
                at = position(mover, t)
                near = math.hypot(at[0] - x, at[1] - y) <= appears["within"] if "within" in appears else t >= appears["at"]
                self.present[number] = near
