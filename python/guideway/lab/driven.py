"""What is measured of a planned motion and of its drive, beyond what the record of a drive has: jerk, steps, tilt and stability, energies, deviation
after avoidance, smoothness, and how well a plan foretells where it is hindered."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import guideway as gw
from guideway.lab.movers import Moving

CRITICAL = 25.0
"""Tilt at which the robot tips over, degrees (zhang2025)."""
TILT = 1.321
"""c_t: with it the drives of plain DE among the standing obstacles of w0 (10 seeds) tilt by 12.81 degrees on average, which is in print."""
GRAVITY, BUSY = 9.81, 65.0
"""m/s2; nominal power of a busy processor, W."""
GOALS, SHIFT = 10, 8 * 3600.0
"""Goals of a mission; a shift, s."""
SAFE, NEARLY = 0.3, 0.25
"""Clearance that success asks for, and a little less of it, m."""
PIECE = 0.25
"""Length of the path segments of the ROC, m."""
NEAR = 1.5
"""A mover nearer than this, m, is avoided."""

Row = dict[str, Any]


def jerks(trajectory: gw.Trajectory) -> Row:
    """Of the commanded profile at 100 Hz: peak acceleration, peak and RMS jerk by differences, and runs of steps of speed and of acceleration.

    A run of speed steps has more than 0.6 of the acceleration limit (5 m/s2), one of acceleration steps more than 1.05 of the jerk limit (10 m/s3).
    """
    rows = trajectory.sample(100.0)
    speed, acceleration = rows[:, 4], rows[:, 5]
    rises, jerk = np.diff(speed) * 100, np.diff(acceleration) * 100
    return {
        "peak_acceleration": float(np.abs(acceleration).max()) if len(rows) else 0.0,
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
    if len(rows) < 2:
        return 0.0, 0.0
    dt = np.diff(rows[:, 0])
    kept = dt > 1e-9
    along = np.diff(rows[:, 4])[kept] / dt[kept]
    across = (0.5 * (rows[1:, 4] + rows[:-1, 4]) * 0.5 * (rows[1:, 5] + rows[:-1, 5]))[kept]
    size = np.degrees(np.hypot(along, across) / GRAVITY)
    weight = dt[kept] / max(dt[kept].sum(), 1e-9)
    return float((size * weight).sum()), float(math.sqrt((size**2 * weight).sum()))


def stability(tilt: float) -> float:
    """How far a tilt (degrees) is from the critical one, %."""
    return float(np.clip(100 * (CRITICAL - tilt) / CRITICAL, 0, 100))


def tilts(driven: Sequence[Sequence[float]]) -> Row:
    """Mean tilt (degrees), motion stability of it and posture stability of the RMS tilt (%)."""
    mean, rms = (TILT * size for size in leaning(driven))
    return {"tilt": mean, "ms": stability(mean), "psi": stability(rms)}


def energies(record: Mapping[str, Any]) -> Row:
    """J/m of the drive, W h of a mission of ten goals."""
    return {"ttec": record["energy"]["ttec"], "moec": GOALS * record["energy"]["moec"]}


def plan_energies(record: Mapping[str, Any], seconds: float) -> dict[str, float]:
    """What depends on the machine: W s of one plan at a nominal 65 W, kW h of a shift of 8 h with a plan for each goal."""
    plan = BUSY * seconds
    goals = SHIFT / max(record["time"], 1e-9)
    return {"sptec": plan, "tsec": goals * (record["energy"]["moec"] + plan / 3600) / 1000}


def smoothness(points: np.ndarray) -> float:
    """1 minus the mean turn between headings 1 m apart as a share of a half turn, the path (n, 2) sampled every 0.1 m."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    s = np.concatenate([[0.0], np.cumsum(steps)])
    keep = np.concatenate([[True], steps > 0])
    even = np.stack([np.interp(np.arange(0, s[-1], 0.1), s[keep], points[keep, k]) for k in (0, 1)], axis=1)
    if len(even) < 12:
        return 1.0
    headings = np.arctan2(*np.diff(even, axis=0).T[::-1])[::10]
    turns = np.abs((np.diff(headings) + math.pi) % (2 * math.pi) - math.pi)
    return 1.0 - float(turns.mean()) / math.pi


def deviation(record: Mapping[str, Any], query: gw.Query) -> float | None:
    """Mean distance (m) of the driven path from the first plan, from the nearest approach to the first avoided mover on; None where none came near.

    What appears does not count as avoided.
    """
    line, driven = np.array(record["plan"]["polyline"]), np.array(record["driven"])[::5]
    movers = [mover for mover in map(Moving, query.world.movers) if not mover.appears]
    if not movers or len(driven) < 3:
        return None
    robot = query.radius - query.clearance
    gaps = [min(mover.distance((x, y), t) - robot for mover in movers) for t, x, y in driven[:, :3]]
    met = [i for i in range(1, len(gaps) - 1) if gaps[i] < NEAR and gaps[i] <= gaps[i - 1] and gaps[i] <= gaps[i + 1]]
    return _off(driven[met[0] :, 1:3], line) if met else None


def accuracy(record: Mapping[str, Any]) -> float:
    """100 % less the mean distance of the driven path, every 0.05 m, from the first plan in cells of 1 m; at least 0."""
    driven, line = np.asarray(record["driven"], float)[:, 1:3], np.asarray(record["plan"]["polyline"], float)
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(driven, axis=0).T))])
    keep = np.concatenate([[True], np.diff(s) > 0])
    even = np.stack([np.interp(np.arange(0, s[-1] + 1e-9, 0.05), s[keep], driven[keep, k]) for k in (0, 1)], axis=1)
    return 100 * max(0.0, 1 - _off(even, line))


def _off(points: np.ndarray, line: np.ndarray) -> float:
    """Mean distance of points from a polyline."""
    p, a, b = points[:, None], line[None, :-1], line[None, 1:]
    e = b - a
    r = np.clip(((p - a) * e).sum(-1) / np.maximum((e * e).sum(-1), 1e-12), 0, 1)
    return float(np.hypot(*np.moveaxis(p - a - r[..., None] * e, -1, 0)).min(1).mean())


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
    from scipy import stats

    good = np.array([score for score, free in scores if free])
    bad = np.array([score for score, free in scores if not free])
    if not len(good) or not len(bad):
        return None
    wins = np.array([(np.sign(g - bad) + 1).mean() / 2 for g in good])
    lost = np.array([(np.sign(good - b) + 1).mean() / 2 for b in bad])
    area = float(wins.mean())
    variance = (wins.var(ddof=1) / len(good) if len(good) > 1 else 0.0) + (lost.var(ddof=1) / len(bad) if len(bad) > 1 else 0.0)
    half = float(stats.norm.ppf(0.975)) * math.sqrt(variance)
    return area, max(0.0, area - half), min(1.0, area + half), len(good), len(bad)


def over_ceiling(trajectory: gw.Trajectory, limits: gw.Limits) -> int:
    """Samples at 1 kHz that break a limit of speed, acceleration, jerk, turn rate or lateral acceleration by more than 1e-6 of it (turns in place and
    curvature taken from the samples)."""
    rows = trajectory.sample(1000.0)
    speed, acceleration, jerk, curvature = rows[:, 4], rows[:, 5], rows[:, 6], rows[:, 7]
    tops, more = limits.to_dict(), 1 + 1e-6
    broken = (speed > tops["speed"] * more) | (acceleration > tops["acceleration"] * more) | (-acceleration > tops["deceleration"] * more)
    broken |= np.abs(jerk) > tops["jerk"] * more
    if tops["turn_rate"]:
        broken |= speed * np.abs(curvature) > tops["turn_rate"] * more
    if tops["lateral_acceleration"]:
        broken |= speed**2 * np.abs(curvature) > tops["lateral_acceleration"] * more
    return int(broken.sum())


def hindrance(trajectory: gw.Trajectory, world: gw.World) -> Row:
    """AUC of the plan's confidence over its segments (None where all are free, or none is), and how many are free and hindered."""
    scores = confidence(trajectory, world)
    found = auc(scores)
    free = sum(free for _, free in scores)
    return {"auc": None if found is None else found[0], "free": free, "hindered": len(scores) - free}
