"""What is measured of a simulated base: tilt, slip, contacts, energy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

TIPPING = 25.0
"""Tilt at which a base is taken to tip over, deg."""
MOST_ROWS = 2000
"""Most rows of tilt over time in a record."""


@dataclass
class Gauge:
    """Collects what the simulator says, one row per step."""

    rows: list[tuple[float, float, float]] = field(default_factory=list)
    """t (s), pitch and roll (deg)."""
    slips: list[tuple[float, float]] = field(default_factory=list)
    """Largest slip of the two wheels along and across, m/s."""
    touched: list[dict[str, Any]] = field(default_factory=list)
    work: float = 0.0
    """Put into the wheels, J."""
    braked: float = 0.0
    """Taken out of the wheels, J."""
    span: tuple[float, float] = (0.0, 0.0)
    """From the first motion to half a second after the last, s: what stands does not count."""
    _touching: dict[str, float] = field(default_factory=dict)

    def move(self, t: float) -> None:
        """The base moves now."""
        self.span = (self.span[0] or t, t + 0.5)

    def touch(self, t: float, names: set[str]) -> None:
        """Obstacles in touch now; one that was free for 0.2 s counts again."""
        for name in sorted(names):
            if t - self._touching.get(name, -1.0) > 0.2:
                self.touched.append({"t": round(t, 4), "with": name})
            self._touching[name] = t

    def drive(self, power: float, dt: float) -> None:
        """Mechanical power (W) of the wheels for ``dt`` s."""
        self.work += max(power, 0.0) * dt
        self.braked += max(-power, 0.0) * dt

    def record(self) -> dict[str, Any]:
        """For ``run.json``."""
        slips = np.asarray(self.slips or [(0.0, 0.0)])
        along, across = np.abs(slips).T
        return {
            "tilt": stability(np.asarray(self.rows or [(0.0, 0.0, 0.0)]), self.span),
            "slip": {
                "rms": float(np.sqrt(np.mean(along**2))),
                "max": float(along.max()),
                "lateral_rms": float(np.sqrt(np.mean(across**2))),
                "lateral_max": float(across.max()),
            },
            "contacts": len(self.touched),
            "touched": self.touched,
            "energy": {"work": self.work, "braked": self.braked},
        }


def stability(rows: np.ndarray, span: tuple[float, float]) -> dict[str, Any]:
    """Tilt, its indices and its course from rows (t in s, pitch, roll in deg), shape (n, 3); the figures are those of the time ``span``.

    ``max``, ``mean``, ``rms`` of the tilt, the root of the squares of pitch and roll, deg; ``psi``, the posture stability index of the root mean
    square, and ``ms``, the mean motion stability, both in % of :data:`TIPPING`; ``rows`` thinned.
    """
    inside = rows[(rows[:, 0] >= span[0]) & (rows[:, 0] <= span[1])]
    tilt = np.hypot(*(inside if len(inside) else rows)[:, 1:].T)
    rms = float(np.sqrt(np.mean(tilt**2)))
    every = -(-len(rows) // MOST_ROWS)
    return {
        "max": float(tilt.max()),
        "mean": float(tilt.mean()),
        "rms": rms,
        "psi": float(np.clip(100 * (1 - rms / TIPPING), 0, 100)),
        "ms": float(np.clip(100 * (TIPPING - tilt) / TIPPING, 0, 100).mean()),
        "rows": np.round(rows[::every], 4).tolist(),
    }
