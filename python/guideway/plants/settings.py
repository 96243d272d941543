"""What a simulated mobile base is like."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from guideway.errors import BadParameter

RANGES = {
    "mass": (1.0, 5000.0),
    "height": (0.05, 3.0),
    "wheel": (0.02, 0.5),
    "point": (0.05, 2.0),
    "friction": (0.01, 3.0),
    "frequency": (1.0, 30.0),
    "damping": (0.05, 3.0),
    "rolling": (0.0, 0.3),
    "lag_speed": (0.0, 10.0),
    "lag_turn": (0.0, 10.0),
    "noise_position": (0.0, 10.0),
    "noise_heading": (0.0, 3.2),
    "odometry_scale": (0.0, 0.5),
    "timestep": (0.0002, 0.004),
    "margin": (0.0, 1.0),
}


@dataclass(frozen=True)
class Settings:
    """A differential base: two driven wheels beside the reference point, a caster before and one behind, each on a spring of its own.

    The springs carry the weight with the same deflection, so ``frequency`` (Hz) and ``damping`` (ratio) of the vertical motion set them all. Lags and
    noise are those of the unicycle; 0 switches each off.
    """

    mass: float = 40.0
    """All of it, kg."""
    height: float = 0.2
    """Of the centre of gravity above the floor, above the reference point, m."""
    wheel: float = 0.08
    """Radius of a driven wheel, m."""
    point: float = 0.25
    """Radius of the body that stands for a footprint of radius 0, m."""
    friction: float = 1.0
    """Of the driven wheels on the floor, 1."""
    frequency: float = 5.0
    """Of the body on its springs, up and down, Hz."""
    damping: float = 0.4
    """Of the same motion, share of the critical one."""
    rolling: float = 0.015
    """Rolling resistance, share of the weight."""
    lag_speed: float = 0.08
    """Time constant with which the wheel servos follow the commanded speed, s."""
    lag_turn: float = 0.06
    """The same for the turn rate, s."""
    noise_position: float = 0.005
    """Standard deviation of each observed coordinate, m."""
    noise_heading: float = math.radians(0.2)
    """Standard deviation of the observed heading, rad."""
    odometry_scale: float = 0.005
    """Relative error of both observed speeds, 1."""
    timestep: float = 0.001
    """Of the simulator, s."""
    margin: float = 0.65
    """Share of what wheels and centre of gravity can hold that is driven with; 0: drives are as they are asked for, whatever the base can hold."""

    def __post_init__(self) -> None:
        for name, (low, high) in RANGES.items():
            value = getattr(self, name)
            if not (isinstance(value, int | float) and not isinstance(value, bool) and low <= value <= high):
                raise BadParameter(f"setting {name} = {value!r} of the plant is out of range: a number from {low:g} to {high:g}")
        if self.height <= self.wheel:
            raise BadParameter(f"setting height = {self.height!r} of the plant is out of range: above the axle, wheel = {self.wheel:g} m")

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Settings:
        """From named values; raises :class:`guideway.errors.BadParameter` for names that are none."""
        names = [field.name for field in fields(cls)]
        for name in values:
            if name not in names:
                raise BadParameter(f"the plant has no setting {name!r}: one of {', '.join(names)}")
        return cls(**values)
