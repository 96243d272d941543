"""The compiled core. Arrays are NumPy float64 unless said otherwise; lengths m, times s, angles rad; cells have row 0 on top."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from guideway.records import Budget, Limits

__version__: str

_Floats = NDArray[np.float64]
_Observer = Callable[[dict[str, Any]], bool]

@final
class World:
    """What is blocked, where the robot may be, and how far away everything is. Immutable.

    ``blocked``: (height, width), true where blocked, row 0 on top; ``origin``: the lower-left corner (x, y, yaw) in m and rad,
    default (0, 0, 0); or ``bounds`` (x0, y0, x1, y1) in m with analytic ``shapes``.
    """

    def __new__(
        cls,
        blocked: ArrayLike | None = None,
        resolution: float = 1.0,
        origin: Sequence[float] = ...,
        *,
        unknown: ArrayLike | None = None,
        bounds: Sequence[float] | None = None,
        shapes: Sequence[Mapping[str, Any]] | None = None,
        movers: Sequence[Mapping[str, Any]] | None = None,
        source: str | None = None,
        sha256: str | None = None,
        files: Mapping[str, str] | None = None,
    ) -> World: ...
    @staticmethod
    def load(path: str | os.PathLike[str], **options: Any) -> World: ...
    def with_movers(self, movers: Sequence[Mapping[str, Any]]) -> World: ...
    def updated(self, blocked: ArrayLike, row: int = 0, column: int = 0) -> World: ...
    def with_keep_out(self, mask: str | os.PathLike[str] | ArrayLike) -> World: ...
    def forbidding(self, cells: ArrayLike | None = None, shapes: Sequence[Mapping[str, Any]] | None = None) -> World: ...
    def emptied(self) -> World: ...
    @property
    def solid(self) -> World: ...
    @property
    def source(self) -> str | None: ...
    @property
    def sha256(self) -> str | None: ...
    @property
    def files(self) -> dict[str, str]: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def resolution(self) -> float: ...
    @property
    def origin(self) -> list[float]: ...
    @property
    def bounds(self) -> list[float]: ...
    @property
    def shapes(self) -> list[dict[str, Any]]: ...
    @property
    def movers(self) -> list[dict[str, Any]]: ...
    def occupancy(self) -> NDArray[np.uint8] | None: ...
    def clearance_field(self) -> _Floats | None: ...
    def clearance(self, points: ArrayLike) -> _Floats: ...
    def segment_free(self, a: Sequence[float], b: Sequence[float], radius: float) -> bool: ...
    def cell_centers(self, cells: ArrayLike) -> _Floats: ...
    def shortest(self, start: Sequence[int], goal: Sequence[int], corners: str = "clear") -> tuple[float, list[tuple[int, int]]] | None: ...

@final
class Query:
    """From where to where, with which robot, how close to obstacles. ``start``, ``goal``: (x, y) or (x, y, yaw)."""

    def __new__(
        cls,
        world: World,
        start: Sequence[float],
        goal: Sequence[float],
        *,
        via: Sequence[Sequence[float]] | None = None,
        footprint: Any = None,
        clearance: float = 0.0,
        half_width: float = 0.0,
        soft_clearance: tuple[float, float] | None = None,
        corners: str | None = None,
        material: str = "standard",
        limits: Limits | None = None,
    ) -> Query: ...
    @property
    def world(self) -> World: ...
    @property
    def start(self) -> list[float]: ...
    @property
    def start_yaw(self) -> float | None: ...
    @property
    def goal(self) -> list[float]: ...
    @property
    def goal_yaw(self) -> float | None: ...
    @property
    def via(self) -> list[list[float]]: ...
    @property
    def clearance(self) -> float: ...
    @property
    def half_width(self) -> float: ...
    @property
    def soft_clearance(self) -> tuple[float, float] | None: ...
    @property
    def footprint(self) -> dict[str, Any]: ...
    @property
    def corners(self) -> str: ...
    @property
    def material(self) -> str: ...
    @property
    def limits(self) -> dict[str, Any]: ...
    @property
    def radius(self) -> float: ...
    def validate(self) -> None: ...

@final
class Path:
    """A clamped B-spline; a polyline is degree 1. Evaluated by arc length."""

    def __new__(cls, degree: int, knots: Sequence[float], control_points: Sequence[Sequence[float]]) -> Path: ...
    @staticmethod
    def polyline(points: ArrayLike) -> Path: ...
    @staticmethod
    def through(points: ArrayLike, parameters: ArrayLike | None = None) -> Path: ...
    @property
    def degree(self) -> int: ...
    @property
    def knots(self) -> _Floats: ...
    @property
    def control_points(self) -> _Floats: ...
    @property
    def length(self) -> float: ...
    def eval(self, s: ArrayLike, order: int = 0) -> _Floats: ...
    def planar(self, s: ArrayLike) -> _Floats: ...

@final
class JointMotion:
    """A timed motion of joints along a path."""

    @property
    def path(self) -> Path: ...
    @property
    def duration(self) -> float: ...
    @property
    def s(self) -> _Floats: ...
    @property
    def x(self) -> _Floats: ...
    @property
    def u(self) -> _Floats: ...
    @property
    def mvc(self) -> _Floats: ...
    @property
    def active(self) -> list[str]: ...
    @property
    def pieces(self) -> list[dict[str, float]]: ...
    @property
    def price(self) -> list[tuple[str, float]]: ...
    @property
    def report(self) -> dict[str, Any]: ...
    def at(self, t: float) -> dict[str, Any]: ...
    def sample(self, rate: float | None = None, *, times: ArrayLike | None = None) -> dict[str, _Floats]: ...

def time_joints(
    path: Path,
    limits: Mapping[str, Any],
    *,
    method: str = "reachability",
    rows: Callable[[_Floats], Mapping[str, Any]] | None = None,
    row_names: Sequence[str] | None = None,
    ceiling: Callable[[_Floats], ArrayLike] | None = None,
    rates: Callable[[_Floats], Mapping[str, Any]] | None = None,
    rate_names: Sequence[str] | None = None,
    start_speed: float = 0.0,
    end_speed: float = 0.0,
    grid: int | None = None,
    tolerance: float = ...,
    check: int = 20,
    windows: Sequence[Sequence[float]] | None = None,
    duration: float | None = None,
    jerk: bool = False,
    tighten: bool = True,
) -> JointMotion: ...
def topp_kernel(
    s: _Floats,
    x_max: _Floats,
    a: _Floats,
    b: _Floats,
    c: _Floats | None,
    low: ArrayLike,
    high: ArrayLike,
    d: _Floats | None = None,
    *,
    ends: tuple[float, float] = ...,
) -> _Floats: ...

@final
class Solution:
    """What a planner returned."""

    @property
    def query(self) -> Query: ...
    @property
    def planner(self) -> str: ...
    @property
    def seed(self) -> int: ...
    @property
    def fallback(self) -> bool: ...
    @property
    def heuristic(self) -> Solution | None: ...
    @property
    def path(self) -> Path: ...
    @property
    def trajectory(self) -> Trajectory | None: ...
    @property
    def cells(self) -> _Floats | None: ...
    @property
    def grid_path(self) -> _Floats | None: ...
    @property
    def length(self) -> float: ...
    @property
    def cost(self) -> float: ...
    @property
    def stop(self) -> str: ...
    @property
    def iterations(self) -> int: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def seconds(self) -> float: ...
    @property
    def history(self) -> _Floats: ...
    @property
    def trace(self) -> Any: ...

@final
class Refined:
    """A refined path and what could not be met."""

    @property
    def path(self) -> Path: ...
    @property
    def unmet(self) -> list[str]: ...

@final
class Trajectory:
    """A motion in time: pieces along a path with constant jerk, and turns in place."""

    def __new__(cls, path: Path, limits: Limits, pieces: Sequence[Mapping[str, Any]]) -> Trajectory: ...
    @property
    def path(self) -> Path: ...
    @property
    def duration(self) -> float: ...
    @property
    def energy(self) -> float: ...
    @property
    def among(self) -> dict[str, Any] | None: ...
    @property
    def pieces(self) -> list[dict[str, Any]]: ...
    @property
    def limits(self) -> dict[str, Any]: ...
    def at(self, t: float) -> dict[str, Any]: ...
    def sample(self, rate: float = 100.0) -> _Floats: ...

@final
class Profile:
    """A one-axis motion of phases of constant jerk."""

    @property
    def duration(self) -> float: ...
    @property
    def top_speed(self) -> float: ...
    @property
    def phases(self) -> list[tuple[float, float]]: ...
    def at(self, t: ArrayLike) -> _Floats: ...

def scurve(
    distance: float,
    *,
    speed: float,
    acceleration: float,
    jerk: float | Sequence[float],
    deceleration: float | None = None,
    start: tuple[float, float] = ...,
    end: tuple[float, float] = ...,
) -> Profile: ...

@final
class PointToPoint:
    """A problem of several axes that can be planned again and again."""

    def __new__(
        cls,
        start: ArrayLike,
        goal: ArrayLike | Sequence[float | None] | None,
        *,
        limits: Mapping[str, ArrayLike | None],
        start_velocity: ArrayLike | None = None,
        start_acceleration: ArrayLike | None = None,
        goal_velocity: ArrayLike | None = None,
        goal_acceleration: ArrayLike | None = None,
        sync: Literal["time", "phase", "none"] = "time",
        minimum_duration: float = 0.0,
        cycle: float | None = None,
        enabled: Sequence[bool] | None = None,
    ) -> PointToPoint: ...
    def plan(self) -> PointToPointMotion: ...

@final
class PointToPointMotion:
    """A motion of several axes in pieces of constant jerk."""

    @property
    def duration(self) -> float: ...
    @property
    def durations(self) -> _Floats: ...
    @property
    def straight(self) -> bool: ...
    @property
    def phases(self) -> list[_Floats]: ...
    def at(self, t: float) -> dict[str, Any]: ...
    def sample(self, rate: float | None = None, *, times: ArrayLike | None = None) -> dict[str, _Floats]: ...

def point_to_point(
    start: ArrayLike,
    goal: ArrayLike | Sequence[float | None] | None,
    *,
    limits: Mapping[str, ArrayLike | None],
    start_velocity: ArrayLike | None = None,
    start_acceleration: ArrayLike | None = None,
    goal_velocity: ArrayLike | None = None,
    goal_acceleration: ArrayLike | None = None,
    sync: Literal["time", "phase", "none"] = "time",
    minimum_duration: float = 0.0,
    cycle: float | None = None,
    enabled: Sequence[bool] | None = None,
) -> PointToPointMotion: ...

@final
class Minimum:
    """What an optimizer found."""

    @property
    def method(self) -> str: ...
    @property
    def seed(self) -> int: ...
    @property
    def x(self) -> _Floats: ...
    @property
    def value(self) -> float: ...
    @property
    def violation(self) -> float: ...
    @property
    def history(self) -> _Floats: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def iterations(self) -> int: ...
    @property
    def stop(self) -> str: ...
    @property
    def population(self) -> _Floats: ...
    @property
    def costs(self) -> _Floats: ...

def minimize(
    f: Callable[[_Floats], Any] | str,
    bounds: ArrayLike,
    method: str = "l-shade",
    *,
    seed: int = 0,
    budget: Budget | Mapping[str, Any] | int | None = None,
    set: Mapping[str, Any] | None = None,
    vectorized: bool = False,
    hints: ArrayLike | None = None,
    observe: _Observer | None = None,
    threads: int = 1,
) -> Minimum: ...
def optimizers() -> list[dict[str, Any]]: ...
def plan(
    query: Query,
    planner: str = "visibility",
    *,
    seed: int = 0,
    budget: Budget | None = None,
    set: Mapping[str, Any] | None = None,
    observe: _Observer | None = None,
    threads: int = 1,
    previous: Solution | None = None,
    exact_fallback: bool = False,
) -> Solution: ...
def parameters(planner: str, set: dict[str, Any] | None = None, query: Query | None = None) -> dict[str, Any]: ...
def recommended(planner: str, query: Query) -> dict[str, Any]: ...
def advice() -> list[dict[str, Any]]: ...
def planners() -> list[dict[str, Any]]: ...
def refine(
    path: Path,
    query: Query,
    method: str = "smooth",
    *,
    max_curvature: float | None = None,
    stretch: float | None = None,
    spacing: float = 1.0,
) -> Refined: ...
def polyline(path: Path, query: Query) -> _Floats: ...
def measure(path: Path, query: Query) -> dict[str, Any]: ...
def time(
    path: Path,
    limits: Limits,
    *,
    start_yaw: float | None = None,
    goal_yaw: float | None = None,
    method: str = "time-optimal",
    start_speed: float = 0.0,
    end_speed: float = 0.0,
    among: Query | None = None,
    passive: bool = True,
    latency: float = 0.1,
    speed_map: SpeedMap | None = None,
) -> Trajectory: ...
def correct(path: Path, limits: Limits) -> dict[str, Any]: ...
def ceiling(path: Path, limits: Limits) -> _Floats: ...
def certify(
    path: Path,
    query: Query,
    trajectory: Trajectory | None = None,
    *,
    max_curvature: float | None = None,
    step: float | None = None,
    speed_map: SpeedMap | None = None,
) -> dict[str, Any]: ...
def reference(query: Query, solution: Solution, *, observe: _Observer | None = None) -> dict[str, Any]: ...
def controllers() -> list[dict[str, Any]]: ...
def drive(
    query: Query,
    trajectory: Trajectory,
    controller: str,
    *,
    planner: str = "visibility",
    seed: int = 0,
    set: Mapping[str, Any] | None = None,
    arrival: float = 0.1,
    stop_at_goal: bool = True,
    time_limit: float | None = None,
    sense: str = "truth",
    lidar: Mapping[str, Any] | None = None,
    map: str = "known",
    plant: object | None = None,
    observe: _Observer | None = None,
    trace: bool = False,
    speed_map: SpeedMap | None = None,
    mover_speed: float | None = None,
    plan_time: float = 0.0,
) -> dict[str, Any]: ...

@final
class SpeedMap:
    """How fast may be driven where: ``limits`` in m/s, infinite without one, (height, width), row 0 on top; outside its map there is no limit."""

    def __new__(cls, limits: ArrayLike, resolution: float = 1.0, origin: Sequence[float] = ..., *, source: str | None = None) -> SpeedMap: ...
    @staticmethod
    def load(path: str | os.PathLike[str], speed: float, **options: Any) -> SpeedMap: ...
    def at(self, x: float, y: float) -> float: ...
    @property
    def source(self) -> str | None: ...

@final
class Pilot:
    """Drives a robot along a motion in a control loop of your own: perception, planning and control behind :meth:`step`.

    A step that needs a plan makes it. With ``wait=False`` no step does: where ``plan_due`` is true another thread is to call :meth:`plan`.
    """

    def __new__(
        cls,
        query: Query,
        trajectory: Trajectory,
        controller: str,
        *,
        planner: str = "visibility",
        set: Mapping[str, Any] | None = None,
        seed: int = 0,
        lidar: Mapping[str, Any] | None = None,
        map: str = "known",
        speed_map: SpeedMap | None = None,
        mover_speed: float | None = None,
        wait: bool = True,
    ) -> Pilot: ...
    @property
    def plan_due(self) -> bool:
        """Does the last step ask for a plan that nobody has begun with? Only with ``wait=False``."""

    def plan(self) -> bool:
        """Makes the plan that is due, if one is, in the thread that calls; steps go on meanwhile. True if one was made, whatever came of it."""

    def step(
        self,
        time: float,
        pose: Sequence[float],
        v: float,
        w: float,
        *,
        tracks: Sequence[Mapping[str, Any]] | None = None,
        scan: ArrayLike | None = None,
        scan_time: float | None = None,
    ) -> dict[str, Any]: ...
    def stop(self) -> None: ...
    def go(self) -> None: ...
    override: float
    @property
    def replans(self) -> int: ...
    @property
    def path(self) -> _Floats: ...
    @property
    def sub_goals(self) -> _Floats: ...

def tour(query: Query) -> dict[str, Any]: ...
def distance_transform(blocked: ArrayLike) -> _Floats: ...
def lattice_optimum(
    world: World,
    start_cell: Sequence[int],
    goal_cell: Sequence[int],
    corners: str = "touch",
    radius: float = 0.0,
    aim: str = "length",
) -> dict[str, Any] | None: ...
def pareto(
    query: Query,
    *,
    seconds: float | None = None,
    searches: int | None = None,
    labels: int | None = None,
    observe: _Observer | None = None,
) -> dict[str, Any]: ...
