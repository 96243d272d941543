"""Plain data between files and the core: what a map file or a scene file says, checked but not interpreted.

Lengths are in m, times in s, angles in rad, y up. Arrays of cells are ``(height, width)`` with row 0 at the *top*, as the image or text has it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    BoolGrid = NDArray[np.bool_]

MAX_CELLS = 1 << 28
"""Largest number of cells of a map, the same as in the core."""

Point = tuple[float, float]
Loop = Literal["once", "cycle", "shuttle"]
Material = Literal["standard", "long", "heavy"]
Corners = Literal["touch", "clear", "squeeze"]
Unknown = Literal["blocked", "free"]
Thresholds = Literal["inclusive", "strict"]


@dataclass(frozen=True, eq=False)
class GridMap:
    """An occupancy grid and where it lies.

    ``blocked`` and ``unknown`` are bool arrays of shape (height, width), row 0 at the top; ``unknown`` marks cells that nobody has seen (they are
    in ``blocked`` unless the map was loaded with ``unknown="free"``) and is None where there are none. ``resolution`` is the side of a cell in m,
    ``origin`` x, y (m) and yaw (rad) of the lower-left corner of the lower-left cell. ``sha256`` is that of the file ``source`` alone; ``files``
    has that of every file that was read, by the name used in the source. ``thresholds`` is the reading that was used (map_server only).
    """

    blocked: BoolGrid
    unknown: BoolGrid | None
    resolution: float
    origin: tuple[float, float, float]
    source: Path
    sha256: str
    files: dict[str, str]
    kind: str
    thresholds: Thresholds = "inclusive"

    @property
    def width(self) -> int:
        """Columns."""
        return int(self.blocked.shape[1])

    @property
    def height(self) -> int:
        """Rows."""
        return int(self.blocked.shape[0])

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x0, y0, x1, y1 of the (possibly turned) grid in the map frame, m."""
        from math import cos, sin

        x, y, yaw = self.origin
        w, h = self.width * self.resolution, self.height * self.resolution
        c, s = cos(yaw), sin(yaw)
        xs = [x, x + c * w, x - s * h, x + c * w - s * h]
        ys = [y, y + s * w, y + c * h, y + s * w + c * h]
        return min(xs), min(ys), max(xs), max(ys)


@dataclass(frozen=True)
class Disc:
    """A solid disc: ``center`` and ``radius`` in m."""

    center: Point
    radius: float

    def to_dict(self) -> dict[str, object]:
        """As the core and ``run.json`` have it."""
        return {"disc": {"center": list(self.center), "radius": self.radius}}


@dataclass(frozen=True)
class Polygon:
    """A solid convex polygon: at least three corners in m, in either sense."""

    points: tuple[Point, ...]

    def to_dict(self) -> dict[str, object]:
        """As the core and ``run.json`` have it."""
        return {"polygon": {"points": [list(p) for p in self.points]}}


@dataclass(frozen=True)
class Footprint:
    """What a robot or a mover covers in its own frame (x forward, y left, reference point at the origin), m; exactly one field is not None.

    ``disc`` is a radius (0 is a point), ``box`` length along x and width along y, ``polygon`` the corners of a convex polygon.
    """

    disc: float | None = None
    box: tuple[float, float] | None = None
    polygon: tuple[Point, ...] | None = None

    def to_dict(self) -> dict[str, object]:
        """As the core and ``plan.json`` have it: ``{"disc": r}``, ``{"box": [l, w]}`` or ``{"polygon": [[x, y], ...]}``."""
        if self.disc is not None:
            return {"disc": self.disc}
        if self.box is not None:
            return {"box": list(self.box)}
        return {"polygon": [list(p) for p in self.polygon or ()]}


@dataclass(frozen=True)
class Appears:
    """When a mover becomes real: once the robot is ``within`` m, or ``at`` a time in s; exactly one is not None."""

    within: float | None = None
    at: float | None = None

    def to_dict(self) -> dict[str, object]:
        """``{"within": m}`` or ``{"at": s}``."""
        return {"within": self.within} if self.within is not None else {"at": self.at}


@dataclass(frozen=True)
class Mover:
    """A moving obstacle whose motion is known.

    ``track`` has rows (t in s, x, y in m), times strictly increasing from 0; one row is a parked obstacle. ``phase`` is the time along its motion at
    t = 0, s. ``path`` and ``speed`` (m/s) are kept when the motion was given so.
    """

    shape: Footprint
    track: tuple[tuple[float, float, float], ...]
    loop: Loop = "once"
    phase: float = 0.0
    appears: Appears | None = None
    path: tuple[Point, ...] | None = None
    speed: float | None = None

    def to_dict(self) -> dict[str, object]:
        """As the core has it: shape, track, loop, phase, appears."""
        appears = self.appears.to_dict() if self.appears else None
        track = [list(row) for row in self.track]
        return {"shape": self.shape.to_dict(), "track": track, "loop": self.loop, "phase": self.phase, "appears": appears}


@dataclass(frozen=True)
class Robot:
    """A robot: footprint (m) and limits in m/s, m/s2, m/s3, rad/s, rad/s2, m/s2; None is unlimited."""

    footprint: Footprint = Footprint(disc=0.0)
    speed: float = 1.0
    acceleration: float = 0.5
    deceleration: float = 0.5
    jerk: float = 2.0
    turn_rate: float | None = None
    turn_acceleration: float | None = None
    lateral_acceleration: float | None = None

    def limits(self) -> dict[str, float | None]:
        """The limits of the motion, as the core has them."""
        return {
            "speed": self.speed,
            "acceleration": self.acceleration,
            "deceleration": self.deceleration,
            "jerk": self.jerk,
            "turn_rate": self.turn_rate,
            "turn_acceleration": self.turn_acceleration,
            "lateral_acceleration": self.lateral_acceleration,
        }


@dataclass(frozen=True)
class Lidar:
    """A planar range sensor: ``field_of_view`` in rad centred forward, ``range`` and ``noise`` (sigma) in m, ``rate`` in Hz."""

    beams: int = 360
    field_of_view: float = 6.283185307
    range: float = 10.0
    noise: float = 0.01
    rate: float = 20.0

    def to_dict(self) -> dict[str, float]:
        """As the core has it."""
        return {"beams": self.beams, "field_of_view": self.field_of_view, "range": self.range, "noise": self.noise, "rate": self.rate}


SOFT_WEIGHT = 2.0
"""What a metre costs more where the hard clearance is only just kept, if a soft one is asked for without a weight."""


@dataclass(frozen=True)
class Query:
    """What is asked: points, ``clearance``, ``half_width``, ``arrival`` in m, headings in rad, ``time_limit`` in s (None: the default).

    ``soft_clearance`` is (m, weight): a metre nearer to obstacles than that beyond ``clearance`` costs up to 1 + weight times.
    """

    start: Point | None = None
    goal: Point | None = None
    start_yaw: float | None = None
    goal_yaw: float | None = None
    via: tuple[Point, ...] = ()
    clearance: float = 0.0
    half_width: float = 0.0
    soft_clearance: tuple[float, float] | None = None
    arrival: float = 0.1
    material: Material = "standard"
    time_limit: float | None = None
    stop: bool = True
    """Does arrival ask for rest?"""
    order: Literal["given", "best"] = "given"


@dataclass(frozen=True)
class Plan:
    """The ``[plan]`` table of a job; None where the job does not say. ``seconds`` in s; ``out`` and ``report`` are relative to the working folder."""

    planner: str | None = None
    set: dict[str, object] = field(default_factory=dict)
    seed: int | None = None
    iterations: int | None = None
    evaluations: int | None = None
    seconds: float | None = None
    refine: str | None = None
    corners: Corners | None = None
    exact_fallback: bool = False
    pareto: bool = False
    out: str | None = None
    report: str | None = None


@dataclass(frozen=True, eq=False)
class Scene:
    """A continuous world, what moves in it, the robot and the query.

    ``bounds`` is x0, y0, x1, y1 in m; ``resolution`` the side in m of the cells of grid planners; ``map`` the grid the scene stands on, or None;
    ``files`` the sha256 of every file that was read, by the name used in the source; ``mover_speed`` the top speed in m/s of whatever moves here.
    """

    bounds: tuple[float, float, float, float]
    resolution: float
    source: Path
    sha256: str
    map: GridMap | None = None
    shapes: tuple[Disc | Polygon, ...] = ()
    movers: tuple[Mover, ...] = ()
    robot: Robot = Robot()
    has_robot: bool = False
    lidar: Lidar | None = None
    query: Query | None = None
    plan: Plan | None = None
    files: dict[str, str] = field(default_factory=dict)
    kind: str = "scene"
    keep_out: tuple[Path, ...] = ()
    speed_mask: Path | None = None
    mover_speed: float | None = None
