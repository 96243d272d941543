"""What is driven: the built-in unicycle, a mobile base in MuJoCo, or an object of your own.

A plant is any object with the three methods of :class:`Plant`; give it as ``gw.drive(..., plant=...)``, or ``plant="mujoco"`` for
:class:`MobileBase` with its defaults (needs ``pip install 'guideway[mujoco]'``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from guideway.errors import BadParameter
from guideway.plants.settings import Settings

if TYPE_CHECKING:
    from guideway._core import Query, Trajectory
    from guideway.plants.mujoco import MobileBase

__all__ = ["PLANTS", "MobileBase", "Plant", "Settings", "make"]

PLANTS = {
    "unicycle": "first-order lags, limits of acceleration, noisy estimates (the default)",
    "mujoco": "a mobile base on sprung wheels in a room of the same world, by the MuJoCo simulator: tilt, slip, contacts, energy are measured",
}
"""What :func:`make` makes, with a line each."""


@runtime_checkable
class Plant(Protocol):
    """A mobile base, simulated or real. SI units, radians, the map's frame.

    It may say more of itself: ``error``, the default of the controller's parameter of that name, m; ``limits``, what it can hold of the limits of
    :class:`guideway.Limits` by their names (a motion that asks for more is timed anew); ``footprint``, the body that it has in place of a point;
    ``extras()``, what ``run.json`` tells of it.
    """

    def observe(self) -> Mapping[str, Any]:
        """What its sensors say: ``time`` (s since the start of the run), ``pose`` (x, y in m, yaw in rad), ``v`` (m/s), ``w`` (rad/s)."""
        ...

    def step(self, v: float, w: float, dt: float) -> None:
        """Moves for ``dt`` s under a commanded speed ``v`` (m/s) and turn rate ``w`` (rad/s)."""
        ...

    def motion(self) -> Mapping[str, Any]:
        """The true state, for judging the run: ``pose``, ``v``, ``w`` as in :meth:`observe`. It need not be known to the base itself."""
        ...


def make(plant: str | Plant, query: Query, trajectory: Trajectory, seed: int = 0, settings: Mapping[str, Any] | None = None) -> Plant | None:
    """The plant that a name means, at rest at the start of the motion; None is the unicycle. An object stays what it is.

    ``settings`` are fields of :class:`Settings`. Raises :class:`guideway.errors.BadParameter` for unknown names and settings, ``ImportError``
    with what to install where MuJoCo is missing.
    """
    if not isinstance(plant, str):
        if settings:
            raise BadParameter("settings belong to the plant 'mujoco'; an object of your own has them already")
        return plant
    if plant not in PLANTS:
        raise BadParameter(f"plant {plant!r} is not known: one of {', '.join(PLANTS)}, or an object with observe(), step(v, w, dt) and motion()")
    if plant == "unicycle":
        if settings:
            raise BadParameter(f"the plant 'unicycle' has no setting {next(iter(settings))!r}")
        return None
    from guideway.plants.mujoco import MobileBase

    return MobileBase(query, trajectory, seed=seed, settings=Settings.of(settings or {}))


def report_of(plant: object) -> dict[str, Any]:
    """What ``run.json`` says of a plant: its name and what its method ``extras``, if it has one, measured."""
    if plant is None:
        return {"name": "unicycle"}
    extras: Callable[[], Mapping[str, Any]] | None = getattr(plant, "extras", None)
    return {"name": getattr(plant, "name", type(plant).__name__), **(extras() if extras else {})}


def __getattr__(name: str) -> Any:
    """Loads the simulator when it is first asked for."""
    if name == "MobileBase":
        from guideway.plants.mujoco import MobileBase

        return MobileBase
    raise AttributeError(f"module 'guideway.plants' has no attribute {name!r}")
