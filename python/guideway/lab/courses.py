"""Courses for timing: splines of joints to go along as fast as limits let, and states to go between; and what is measured of an answer.

Both are drawn from a seed alone. Answers of anybody come as samples, and are checked here against the limits, densely and between grid points.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

import guideway as gw

Floats = NDArray[np.float64]

PLACES = 20
"""Samples in each interval of a grid, and in each piece of a motion."""
SAMPLES = 2000
"""Samples of a motion between two states."""
SPLINE = {"points": 10, "joints": 6, "seed": 0}
AXES = {"axes": 7, "asymmetric": False, "share": 0.5, "wide": 0, "seed": 0}
MAKERS: dict[str, Mapping[str, Any]] = {"spline": SPLINE, "axes": AXES}
"""What a world's ``make`` may say, with its arguments and their defaults."""


class Along:
    """A not-a-knot spline through random way points (rad), uniform in (-1.5, 1.5), by its own parameter in (0, 1); ``path`` is the same as ours.

    Limits are a number for all joints: rad/s, rad/s2, rad/s3 or None.
    """

    def __init__(self, points: int, joints: int, seed: int, limits: Mapping[str, Any]) -> None:
        from scipy.interpolate import CubicSpline

        way = np.random.default_rng(seed).uniform(-1.5, 1.5, (points, joints))
        self.joints, self.knots = joints, np.linspace(0.0, 1.0, points)
        self.curve = CubicSpline(self.knots, way)
        self.path = gw.Path.through(way, parameters=self.knots)
        self.speed, self.acceleration = float(limits["speed"]), float(limits["acceleration"])
        self.jerk = float(limits["jerk"]) if limits.get("jerk") else None

    @property
    def limits(self) -> dict[str, float]:
        """As :func:`guideway.time_joints` takes them."""
        return {"speed": self.speed, "acceleration": self.acceleration} | ({} if self.jerk is None else {"jerk": self.jerk})


class Between:
    """Two random states of several axes. Goals that cannot be come from within the limits of velocity are not drawn; starts may be such.

    ``share``: how much of the limits velocities and accelerations at the ends take up; ``wide``: limits log-uniform over a ratio of 10 to this and
    distances over 1e-4 to 1e4; 0: narrow.
    """

    def __init__(self, axes: int, asymmetric: bool, share: float, wide: float, seed: int) -> None:
        rng = np.random.default_rng(seed)
        drawn = [self._axis(rng, asymmetric, share, wide) for _ in range(axes)]
        rows = {name: np.array([axis[name] for axis in drawn]) for name in drawn[0]}
        self.start, self.goal = rows["start"], rows["goal"]
        self.limits = {name: rows[name] for name in ("velocity", "acceleration", "jerk", "min_velocity", "min_acceleration")}
        self.ends = {name: rows[name] for name in ("start_velocity", "start_acceleration", "goal_velocity", "goal_acceleration")}

    @staticmethod
    def _axis(rng: np.random.Generator, asymmetric: bool, share: float, wide: float) -> dict[str, float]:
        half = wide / 2

        def limit(low: float, high: float) -> float:
            return float(10.0 ** rng.uniform(-half, half) if wide else rng.uniform(low, high))

        while True:
            vmax, amax, jerk = limit(0.5, 3), limit(1, 10), limit(5, 100)
            vmin, amin = (-limit(0.5, 3), -limit(1, 10)) if asymmetric else (-vmax, -amax)
            start = float(rng.uniform(-1, 1) if wide else rng.uniform(-3, 3))
            goal = start + float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-4, 4)) if wide else float(rng.uniform(-3, 3))
            axis = {
                "start": start,
                "goal": goal,
                "velocity": vmax,
                "acceleration": amax,
                "jerk": jerk,
                "min_velocity": vmin,
                "min_acceleration": amin,
            }
            for end in ("start", "goal"):
                axis[f"{end}_velocity"] = share * (vmin + (vmax - vmin) * float(rng.random()))
                axis[f"{end}_acceleration"] = share * (amin + (amax - amin) * float(rng.random()))
            v, a = axis["goal_velocity"], axis["goal_acceleration"]
            if vmin < v - a * abs(a) / (2 * jerk) < vmax:
                return axis

    @cached_property
    def outside(self) -> bool:
        """Does the start lead beyond a limit of velocity whatever is done?"""
        v, a, jerk = self.ends["start_velocity"], self.ends["start_acceleration"], self.limits["jerk"]
        after = v + a * np.abs(a) / (2 * jerk)
        return bool(((after > self.limits["velocity"]) | (after < self.limits["min_velocity"])).any())

    def times(self, duration: float) -> Floats:
        """Where an answer is sampled, s."""
        return np.linspace(0.0, duration, SAMPLES)


@dataclass(frozen=True)
class Timed:
    """An answer: its ``duration`` (s), the largest ``excess`` over any limit (%) and the ``excesses`` over each, how far it ends from the goal
    (``miss``, in units of the axes, as a share of distances above 1), and ``seconds`` of processor time that the call took."""

    duration: float
    excess: float
    excesses: Mapping[str, float]
    seconds: float
    miss: float = 0.0

    @staticmethod
    def along(course: Along, s: Floats, x: Floats, seconds: float) -> Timed:
        """Of squared path speeds on a grid, the path acceleration being constant in each interval."""
        step, speed = np.diff(s), np.sqrt(np.maximum(x, 0))
        duration = float(np.sum(2 * step / np.maximum(speed[:-1] + speed[1:], 1e-12)))
        tau = np.linspace(0, 1, PLACES + 1)
        inner = np.maximum(x[:-1, None] + np.diff(x)[:, None] * tau, 0).ravel()
        u = np.repeat(np.diff(x) / (2 * step), PLACES + 1)
        return Timed._checked(course, duration, ((s[:-1, None] + step[:, None] * tau).ravel(), np.sqrt(inner), u, None), seconds)

    @staticmethod
    def third(course: Along, s: Floats, x: Floats, u: Floats, duration: float, seconds: float) -> Timed:
        """Of squared path speeds and path accelerations on a grid, the accelerations linear in between; in the first and in the last interval ``s``
        grows with the cube of time."""
        tau, step = np.linspace(0, 1, PLACES + 1), np.diff(s)
        rise = np.diff(u) / step
        away = step[:, None] * tau
        at = s[:-1, None] + away
        inner = np.maximum(x[:-1, None] + 2 * u[:-1, None] * away + rise[:, None] * away**2, 0)
        speed, slope = np.sqrt(inner), u[:-1, None] + rise[:, None] * away
        jerk = rise[:, None] * speed
        for k, share, sign in ((0, tau, 1.0), (len(step) - 1, 1 - tau, -1.0)):
            top = 3 * step[k] / np.sqrt(x[1] if k == 0 else x[-2])  # how long the interval takes
            part = np.cbrt(share)
            speed[k], slope[k], jerk[k] = 3 * step[k] / top * part**2, sign * 6 * step[k] / top**2 * part, 6 * step[k] / top**3
        return Timed._checked(course, duration, (at.ravel(), speed.ravel(), slope.ravel(), jerk.ravel()), seconds)

    @staticmethod
    def ours(course: Along, motion: gw.JointMotion, seconds: float) -> Timed:
        """Of a motion of ours, sampled inside every piece."""
        share = (np.arange(PLACES) + 0.5) / PLACES
        times = np.concatenate([piece["t"] + piece["duration"] * share for piece in motion.pieces])
        rows = motion.sample(times=times)
        return Timed._excess(course, motion.duration, (rows["qd"], rows["qdd"], rows["qddd"]), seconds)

    @staticmethod
    def between(course: Between, duration: float, rows: tuple[Floats, Floats, Floats], seconds: float) -> Timed:
        """Of positions, velocities and accelerations (n, axes) at :meth:`Between.times`. Velocities count where the start can keep within them."""
        q, qd, qdd = rows
        found = {}
        for name, values in (("velocity", qd), ("acceleration", qdd)):
            over = np.where(values > 0, values / course.limits[name], values / course.limits[f"min_{name}"])
            found[name] = 100 * max(float(over.max()) - 1, 0.0)
        counted = {"acceleration": found["acceleration"]} if course.outside else found
        miss = np.abs(q[-1] - course.goal) / np.maximum(np.abs(course.goal - course.start), 1.0)
        return Timed(duration, max(counted.values()), found, seconds, float(miss.max()))

    @staticmethod
    def _checked(course: Along, duration: float, samples: tuple[Floats, Floats, Floats, Floats | None], seconds: float) -> Timed:
        s, v, u, w = samples
        s = np.minimum(s, 1.0)
        q1, q2, v, u = course.curve(s, 1), course.curve(s, 2), v[:, None], u[:, None]
        qddd = None
        if w is not None:
            qddd = q1 * w[:, None] + 3 * q2 * v * u + course.curve(s, 3) * v**3
        return Timed._excess(course, duration, (q1 * v, q1 * u + q2 * v**2, qddd), seconds)

    @staticmethod
    def _excess(course: Along, duration: float, rows: tuple[Floats, Floats, Floats | None], seconds: float) -> Timed:
        limits = {"speed": (rows[0], course.speed), "acceleration": (rows[1], course.acceleration)}
        if course.jerk is not None and rows[2] is not None:
            limits["jerk"] = (rows[2], course.jerk)
        found = {name: 100 * max(float(np.abs(values).max()) / limit - 1, 0.0) for name, (values, limit) in limits.items()}
        return Timed(duration, max(found.values()), found, seconds)
