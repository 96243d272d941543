"""Small value types of the public API."""

from __future__ import annotations

import math
import sys
import time
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Disc:
    """A round footprint. ``radius`` in m, 0 is a point."""

    radius: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """As in files: ``{"disc": radius}``."""
        return {"disc": self.radius}


@dataclass(frozen=True)
class Box:
    """A rectangular footprint centred on the reference point: ``length`` along x, ``width`` along y, m."""

    length: float
    width: float

    def to_dict(self) -> dict[str, Any]:
        """As in files: ``{"box": [length, width]}``."""
        return {"box": [self.length, self.width]}


@dataclass(frozen=True)
class Polygon:
    """A convex footprint that holds the reference point (0, 0); ``points`` in m, robot frame, x forward."""

    points: tuple[tuple[float, float], ...]

    def to_dict(self) -> dict[str, Any]:
        """As in files: ``{"polygon": [[x, y], ...]}``."""
        return {"polygon": [list(point) for point in self.points]}


@dataclass(frozen=True)
class Budget:
    """How much work a method may do. Results under a budget in ``seconds`` depend on the machine."""

    iterations: int | None = None
    evaluations: int | None = None
    seconds: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """As in files."""
        return asdict(self)


@dataclass(frozen=True)
class Limits:
    """Limits of a motion along a path, SI units; None is unlimited. A deceleration left out equals the acceleration."""

    speed: float = 1.0
    acceleration: float = 0.5
    deceleration: float | None = None
    jerk: float = 2.0
    turn_rate: float | None = None
    turn_acceleration: float | None = None
    lateral_acceleration: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """As in files, with the deceleration filled in."""
        return asdict(self) | {"deceleration": self.acceleration if self.deceleration is None else self.deceleration}


class Progress:
    """An observer for ``observe=`` that shows a progress bar on stderr, if that is a terminal; it never stops the work."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._shown = 0.0

    def __call__(self, seen: dict[str, Any]) -> bool:
        """Shows one state: share of the budget if there is one, best cost if there is one, and the time."""
        now = time.monotonic()
        if now - self._shown < 0.1 or not sys.stderr.isatty():
            return False
        self._shown = now
        if self._bar is None:
            from tqdm import tqdm

            self._bar = tqdm(total=100, leave=False, bar_format="{desc}")
        share = seen["share"]
        self._bar.bar_format = "{desc} {elapsed}" if share is None else "{desc} {bar} {percentage:3.0f} % {elapsed}"
        self._bar.n = 0 if share is None else round(100 * share)
        best = f"best {seen['best']:.4g}" if math.isfinite(seen["best"]) else "searching"
        self._bar.set_description_str(best if seen["iteration"] == 0 else f"iteration {seen['iteration']}, {best}")
        return False

    def close(self) -> None:
        """Removes the bar; the next call shows a new one."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


progress = Progress()
"""The observer to pass as ``observe=gw.progress``."""
