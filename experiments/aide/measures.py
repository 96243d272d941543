"""Metrics of a planned motion and of its drive: jerk, steps, tilt and stability, energies, separation over time, ROC with its interval.

Definitions are those of docs/driving.md where the record of a drive has them; the others stand here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import stats

import guideway as gw

CRITICAL = 25.0
"""Tilt at which the robot tips over, degrees."""
UNSMOOTHED = 12.81
"""Mean tilt that the plan of plain DE is calibrated to, degrees: that in print."""
GRAVITY, BUSY = 9.81, 65.0
"""m/s2; nominal power of a busy processor, W."""
SAFE = 0.3
"""Clearance that success asks for, m."""
PIECE = 0.25
"""Length of the path segments of the ROC, m."""


def jerks(trajectory: gw.Trajectory) -> dict[str, float]:
    """Of the commanded profile at 100 Hz: peak acceleration, peak and RMS jerk by differences, and runs of steps of speed and of acceleration.

    A run of speed steps has more than 0.6 of the acceleration limit (5 m/s2), one of acceleration steps more than 1.05 of the jerk limit (10 m/s3).
    """
    rows = trajectory.sample(100.0)
    speed, acceleration = rows[:, 4], rows[:, 5]
    rises, jerk = np.diff(speed) * 100, np.diff(acceleration) * 100
    return {
        "peak_acceleration": float(np.abs(acceleration).max()),
        "peak_jerk": float(np.abs(jerk).max()) if len(jerk) else 0.0,
        "rms_jerk": float(np.sqrt((jerk**2).mean())) if len(jerk) else 0.0,
        "ssf": runs(rises, 0.6 * 5.0),
        "asf": runs(jerk, 1.05 * 10.0),
    }


def runs(values: np.ndarray, limit: float) -> int:
    """Maximal runs of values whose size exceeds the limit."""
    over = np.abs(values) > limit
    return int(over[:1].sum() + (over[1:] & ~over[:-1]).sum())


def leaning(driven: Sequence[Sequence[float]]) -> tuple[float, float]:
    """Mean and RMS over time of the size of the acceleration over g, in degrees: the tilt of a robot whose c_t is 1."""
    rows = np.asarray(driven, float)
    dt = np.diff(rows[:, 0])
    kept = dt > 1e-9
    along = np.diff(rows[:, 4])[kept] / dt[kept]
    across = (0.5 * (rows[1:, 4] + rows[:-1, 4]) * 0.5 * (rows[1:, 5] + rows[:-1, 5]))[kept]
    size = np.degrees(np.hypot(along, across) / GRAVITY)
    weight = dt[kept] / dt[kept].sum()
    return float((size * weight).sum()), float(math.sqrt((size**2 * weight).sum()))


def stability(tilt: float) -> float:
    """How far a tilt (degrees) is from the critical one, %."""
    return float(np.clip(100 * (CRITICAL - tilt) / CRITICAL, 0, 100))


def energies(record: dict[str, Any], seconds: float) -> dict[str, float]:
    """J/m of the drive, W h of a mission of ten goals, W s of one plan at a nominal 65 W, kW h of a shift of 8 h with a plan for each goal."""
    mission, plan = 10 * record["energy"]["moec"], BUSY * seconds
    goals = 8 * 3600 / max(record["time"], 1e-9)
    return {"ttec": record["energy"]["ttec"], "moec": mission, "sptec": plan, "tsec": goals * (record["energy"]["moec"] + plan / 3600) / 1000}


class Moving:
    """Where a moving obstacle is, and how far a point is from it."""

    def __init__(self, mover: dict[str, Any]) -> None:
        track = np.asarray(mover["track"], float)
        self.times, self.places = track[:, 0], track[:, 1:]
        self.loop, self.phase, self.shape = mover["loop"], mover["phase"], mover["shape"]

    def at(self, t: float) -> np.ndarray:
        last, t = self.times[-1], t + self.phase
        if self.loop == "cycle":
            t %= last
        elif self.loop == "shuttle":
            t = last - abs(t % (2 * last) - last)
        return np.array([np.interp(t, self.times, self.places[:, k]) for k in (0, 1)])

    def distance(self, p: Sequence[float], t: float) -> float:
        d = np.asarray(p) - self.at(t)
        if "disc" in self.shape:
            return float(np.hypot(*d)) - self.shape["disc"]
        reach = np.abs(d) - 0.5 * np.asarray(self.shape["box"])
        return float(np.hypot(*np.maximum(reach, 0)) + min(reach.max(), 0.0))


def confidence(trajectory: gw.Trajectory, world: gw.World) -> list[tuple[float, bool]]:
    """For each segment of the planned path: the confidence that it stays free, and whether it does.

    Confidence: 1 - exp(-d / 0.3 m) with the least distance of the segment from what stands and from what moves where that is when the plan is made.
    Free: on the plan's own schedule nothing that moves comes nearer than 0.3 m while the segment is driven.
    """
    rows, movers = trajectory.sample(50.0), [Moving(mover) for mover in world.movers]
    if not len(rows) or not movers:
        return []
    points, times = rows[:, 1:3], rows[:, 0]
    still = world.clearance(points)
    seen = np.array([min(mover.distance(p, 0.0) for mover in movers) for p in points])
    met = np.array([min(mover.distance(p, t) for mover in movers) for p, t in zip(points, times, strict=True)])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    piece = np.minimum((along / PIECE).astype(int), int(along[-1] / PIECE))
    found = []
    for k in range(piece[-1] + 1):
        here = piece == k
        if here.any():
            nearest = max(0.0, float(np.minimum(still, seen)[here].min()))
            found.append((1 - math.exp(-nearest / SAFE), bool(met[here].min() >= SAFE)))
    return found


def auc(scores: Sequence[tuple[float, bool]]) -> tuple[float, float, float, int, int] | None:
    """Area under the ROC with the interval of DeLong, and how many positives and negatives; None where one of them is missing."""
    good = np.array([score for score, free in scores if free])
    bad = np.array([score for score, free in scores if not free])
    if not len(good) or not len(bad):
        return None
    wins = np.array([(np.sign(g - bad) + 1).mean() / 2 for g in good])
    lost = np.array([(np.sign(good - b) + 1).mean() / 2 for b in bad])
    area = float(wins.mean())
    variance = (wins.var(ddof=1) / len(good) if len(good) > 1 else 0.0) + (lost.var(ddof=1) / len(bad) if len(bad) > 1 else 0.0)
    half = stats.norm.ppf(0.975) * math.sqrt(variance)
    return area, max(0.0, area - half), min(1.0, area + half), len(good), len(bad)


def signature(points: np.ndarray, discs: Sequence[tuple[float, float, float]]) -> str:
    """Homotopy class of a path among discs: how often it goes round each, against the straight line; a digit and sign per disc."""
    way = np.vstack([points, points[:1]])
    words = []
    for x, y, _ in discs:
        angle = np.unwrap(np.arctan2(way[:, 1] - y, way[:, 0] - x))
        words.append(f"{round((angle[-1] - angle[0]) / (2 * math.pi)):+d}")
    return "".join(words)


def over_ceiling(trajectory: gw.Trajectory, limits: gw.Limits) -> int:
    """Samples at 1 kHz that break a limit of speed, acceleration, jerk, turn rate or lateral acceleration by more than 1e-6 of it (turns in place and
    curvature taken from the samples)."""
    rows = trajectory.sample(1000.0)
    speed, acceleration, jerk, curvature = rows[:, 4], rows[:, 5], rows[:, 6], rows[:, 7]
    tops = limits.to_dict()
    broken = speed > tops["speed"] * (1 + 1e-6)
    broken |= acceleration > tops["acceleration"] * (1 + 1e-6)
    broken |= -acceleration > tops["deceleration"] * (1 + 1e-6)
    broken |= np.abs(jerk) > tops["jerk"] * (1 + 1e-6)
    if tops["turn_rate"]:
        broken |= speed * np.abs(curvature) > tops["turn_rate"] * (1 + 1e-6)
    if tops["lateral_acceleration"]:
        broken |= speed**2 * np.abs(curvature) > tops["lateral_acceleration"] * (1 + 1e-6)
    return int(broken.sum())
